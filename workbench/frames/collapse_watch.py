"""When a frame has collapsed, so that its models mean nothing any more."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from workbench.arrays import Array, Indices
from workbench.errors import Collapse, CollapseError, CrumpledError, Mechanism
from workbench.frames.chains import chains, named
from workbench.frames.structure import FrameStructure, upright_names
from workbench.scenarios import Frame
from workbench.structures.assembly import PlanarAssembly

COLLAPSE_SIDEWAYS = 0.9  # movement of a member's ends across its axis, over its length
COLLAPSE_CONTRACTION = 0.1  # of the length of a straight chain of members: squashed
LEAST_LENGTH = 0.05  # of an element; plastic strains have lost all meaning long before


class Lines(NamedTuple):
    """What displacements (dofs,) do to the members of a frame, in rows, and to its lines of them.

    Dofs u, v of both ends of each member, its `corners` (members, 4); what of the movement of its
    end from its start is `across` its axis and `along` it (members, 2), over its length; names of
    the members of each straight line, its `chains`, and `chained` (chains, members), 1 over its
    length; the dofs of upright members that are `swaying`, and what of that is drift of the line of
    each, `sway` (swaying, uprights).
    """

    corners: Indices
    across: Array
    along: Array
    chains: list[tuple[str, ...]]
    chained: Array
    swaying: Indices
    sway: Array


def _lines(frame: Frame, assembly: PlanarAssembly) -> Lines:
    """The lines of a frame and of the dofs of its assembly."""
    lengths: Array = np.array([frame.length(member) for member in frame.members])
    number = {node.name: i for i, node in enumerate(frame.nodes)}
    ends = np.array([(number[member.start], number[member.end]) for member in frame.members])
    corners = np.array([[assembly.dof(n, c) for n in pair for c in "uv"] for pair in ends])
    points = np.array([(node.x, node.y) for node in frame.nodes])
    along = (points[ends[:, 1]] - points[ends[:, 0]]) / lengths[:, None] ** 2
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    moved, rows = np.zeros((len(lengths), assembly.size)), np.arange(len(lengths))[:, None]
    moved[rows, corners] = np.concatenate([-across, across], axis=1)
    place = {member.name: i for i, member in enumerate(frame.members)}
    straight = [chain.members for chain in chains(frame)]
    members = np.zeros((len(straight), len(place)))
    for row, names in zip(members, straight, strict=True):
        row[[place[name] for name in names]] = 1.0
    chained = members / (members @ lengths)[:, None]
    lines = ((chained * lengths) @ moved)[members.argmax(axis=0)]
    drifting = lines[[place[name] for name in upright_names(frame)]]
    swaying = np.flatnonzero(drifting.any(axis=0))
    return Lines(corners, across, along, straight, chained, swaying, drifting[:, swaying].T.copy())


class CollapseWatch:
    """Checks the committed state of a `structure` after every step."""

    def __init__(self, structure: FrameStructure) -> None:
        self._structure = structure
        if "lines" not in structure.found:
            structure.found["lines"] = _lines(structure.frame, structure.assembly)
        self.lines: Lines = structure.found["lines"]

    def check(self, displacement: float, time: float | None) -> None:
        """Raise `CollapseError` when the frame has collapsed, with the `displacement` (m) so far.

        Without a `time` (s), on a static path, nothing collapses.
        Raises `CrumpledError` where an element crumples: that depends on its length, and other
        meshes may go on and survive.
        """
        left, across = self._structure.members.lengths_left(), self._apart(now=True)
        lost = self._structure.members.contractions() @ self.lines.chained.T
        turned, squashed = across.max() > COLLAPSE_SIDEWAYS, lost.max() > COLLAPSE_CONTRACTION
        if left.min() < LEAST_LENGTH or (time is not None and (turned or squashed)):
            self._tell(left, across, lost, float(displacement), time)

    def _tell(
        self, left: Array, across: Array, lost: Array, displacement: float, time: float | None
    ) -> None:
        """Raise what the numbers of a state say."""
        names = [member.name for member in self._structure.frame.members]

        def fallen(mechanism: Mechanism, parts: Sequence[str], reason: str) -> CollapseError:
            collapse = Collapse(mechanism, tuple(parts), displacement, time)
            return CollapseError(collapse, f"{named(parts)} {reason}")

        if left.min() < LEAST_LENGTH:
            raise CrumpledError(
                f"member {names[int(left.argmin())]} crumples at {displacement:.4g} m: a plastic "
                f"hinge under compression has shortened its element to less than {LEAST_LENGTH:g} "
                "of its length; take fiber-reissner, or a larger smallest_element, which puts this "
                "off"
            )
        worst = int(across.argmax())
        if across[worst] > COLLAPSE_SIDEWAYS:
            reason = (
                f"has turned: its ends have moved {across[worst]:.2f} of its length apart across "
                "its axis"
            )
            raise fallen(Mechanism.GEOMETRY, [names[worst]], reason)
        worst = int(lost.argmax())
        reason = (
            f"has been squashed by {100.0 * lost[worst]:.3g} % of the length, more than "
            f"{100.0 * COLLAPSE_CONTRACTION:g} %"
        )
        raise fallen(Mechanism.SQUASH, self.lines.chains[worst], reason)

    def drifts(self, moved: Array) -> Array:
        """Drift of the straight line of members that each upright one belongs to (uprights,).

        Of displacements `moved` (dofs,): movement of the line's ends across it over its length.
        """
        return np.asarray(np.abs(moved[..., self.lines.swaying] @ self.lines.sway))

    def sideways(self) -> tuple[float, int]:
        """Largest movement of a member's ends across its axis over its length; which member."""
        moved = self._apart(now=False)
        worst = int(moved.argmax())
        return float(moved[worst]), worst

    def _apart(self, *, now: bool) -> Array:
        """Movement of each member's ends across its axis over its length (members,).

        `now`, also over the distance that is left between its ends: a chord that turns over passes
        all of that, and may be too short to reach its first length.
        """
        lines, at = self.lines, self._structure.assembly.displacement[..., self.lines.corners]
        apart = at[..., 2:] - at[..., :2]
        moved = np.abs(np.sum(apart * lines.across, axis=-1))
        if now:
            left = 1.0 + np.sum(apart * lines.along, axis=-1)
            moved /= np.minimum(1.0, np.hypot(moved, left))
        return np.asarray(moved)
