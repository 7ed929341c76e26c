"""When a frame has collapsed, so that its models mean nothing any more."""

import numpy as np

from workbench.arrays import Array
from workbench.errors import OutOfDomainError
from workbench.frames.chains import chains, named
from workbench.frames.structure import FrameStructure

COLLAPSE_SIDEWAYS = 0.9  # movement of a member's ends across its axis, over its length
COLLAPSE_CONTRACTION = 0.1  # of the length of a straight chain of members: squashed
LEAST_LENGTH = 0.05  # of an element; plastic strains have lost all meaning long before


class CollapseWatch:
    """Checks the committed state of a `structure` after every step."""

    def __init__(self, structure: FrameStructure) -> None:
        frame = structure.frame
        self._structure = structure
        self._lengths: Array = np.array([frame.length(member) for member in frame.members])
        # what displacements (dofs,) move the ends of each member apart across its axis, in rows
        self._across: Array = np.zeros((len(self._lengths), structure.assembly.size))
        for row, member in zip(self._across, frame.members, strict=True):
            start, end = frame.node(member.start), frame.node(member.end)
            for axis, part in (("x", start.y - end.y), ("y", end.x - start.x)):
                row[structure.dof(start.name, axis)[0]] -= part / frame.length(member)
                row[structure.dof(end.name, axis)[0]] += part / frame.length(member)
        self._across /= self._lengths[:, None]
        place = {member.name: i for i, member in enumerate(frame.members)}
        self._chains = [chain.members for chain in chains(frame)]
        chained = np.zeros((len(self._chains), len(place)))
        for row, names in zip(chained, self._chains, strict=True):
            row[[place[name] for name in names]] = 1.0
        self._chained = chained / (chained @ self._lengths)[:, None]

    def check(self, when: str, standing: bool = True) -> None:
        """Raise `OutOfDomainError` when the frame has collapsed; `when` tells time or step.

        Without `standing` only what the elements cannot follow counts.
        """
        structure = self._structure
        if structure.members.slightest() < LEAST_LENGTH:
            raise OutOfDomainError(
                f"collapse at {when}: a plastic hinge under compression has shortened its element "
                f"to less than {LEAST_LENGTH:g} of its length; the member crumples (a larger "
                "smallest_element puts this off)"
            )
        if not standing:
            return
        share, worst = self.sideways()
        if share > COLLAPSE_SIDEWAYS:
            raise OutOfDomainError(
                f"collapse at {when}: the ends of member {structure.frame.members[worst].name} "
                f"have moved {share * self._lengths[worst]:.3g} m apart across its axis, "
                f"more than {COLLAPSE_SIDEWAYS:g} of its length; the model means nothing beyond"
            )
        loss = self._chained @ structure.members.contractions()
        worst = int(loss.argmax())
        if loss[worst] > COLLAPSE_CONTRACTION:
            raise OutOfDomainError(
                f"collapse at {when}: {named(self._chains[worst])} has been squashed by "
                f"{100.0 * loss[worst]:.3g} % of the length, more than "
                f"{100.0 * COLLAPSE_CONTRACTION:g} %; the model means nothing beyond"
            )

    def sideways(self) -> tuple[float, int]:
        """Largest movement of a member's ends across its axis over its length; which member."""
        moved = np.abs(self._across @ self._structure.assembly.displacement)
        worst = int(moved.argmax())
        return float(moved[worst]), worst
