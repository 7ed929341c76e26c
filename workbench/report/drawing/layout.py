"""A frame and where its parts stand on paper: inches, free sides, levels.

Points and directions are complex numbers, x + iy.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from workbench.report.page.formatting import Unit, unit_of
from workbench.scenarios import Frame, FrameScenario, Member, Scenario, frame_scenario

_LEAST_DEPTH = 0.035  # inches that a member takes at least, so that it can be seen
_WIDE, _HIGH, _UPRIGHT = 4.2, 2.9, 2.4  # inches that a frame, and a single column, may take
_SAME = 1e-6  # m


@dataclass(frozen=True)
class Layout:
    """A `frame` drawn at `scale` (inches per m), its node of least x and y at the origin."""

    frame: Frame

    @cached_property
    def origin(self) -> complex:
        """Least x and y of all nodes, in m."""
        return complex(min(n.x for n in self.frame.nodes), min(n.y for n in self.frame.nodes))

    @cached_property
    def extent(self) -> complex:
        """Width and height between nodes, in m."""
        nodes = self.frame.nodes
        return complex(max(n.x for n in nodes), max(n.y for n in nodes)) - self.origin

    @cached_property
    def scale(self) -> float:
        """Inches per metre."""
        wide, high = max(self.extent.real, _SAME), max(self.extent.imag, _SAME)
        return min(_WIDE / wide, (_HIGH if wide > _SAME else _UPRIGHT) / high)

    @cached_property
    def small(self) -> float:
        """Factor on symbols that stand at every node: below 1 where members are short."""
        lengths = sorted(self.frame.length(member) * self.scale for member in self.frame.members)
        return min(1.0, lengths[len(lengths) // 2] / 0.6)

    def at(self, node: str) -> complex:
        """Position of a node, in inches."""
        place = self.frame.node(node)
        return (complex(place.x, place.y) - self.origin) * self.scale

    def depth(self, member: Member) -> float:
        """Depth of a member as drawn, in inches."""
        return max(float(member.section.height) * self.scale, _LEAST_DEPTH)

    @property
    def deepened(self) -> bool:
        """Whether a member is drawn deeper than it is."""
        depths = [float(member.section.height) * self.scale for member in self.frame.members]
        return min(depths) * 1.001 < _LEAST_DEPTH

    def along(self, member: Member) -> complex:
        """Unit vector from a member's start to its end."""
        run = self.at(member.end) - self.at(member.start)
        return run / abs(run)

    @cached_property
    def members_at(self) -> dict[str, list[tuple[Member, complex]]]:
        """Members that end at each node, with the unit vector that leads away from it."""
        members: dict[str, list[tuple[Member, complex]]] = {n.name: [] for n in self.frame.nodes}
        for member in self.frame.members:
            members[member.start].append((member, self.along(member)))
            members[member.end].append((member, -self.along(member)))
        return members

    def half_depth(self, node: str, direction: complex) -> float:
        """Half the drawn depth of the members at a node, measured along `direction`."""
        reach = [
            0.5 * self.depth(member) * abs((away.conjugate() * direction).imag)
            for member, away in self.members_at[node]
        ]
        return max(reach)

    def edge(self, node: str, direction: complex, beyond: float = 0.0) -> complex:
        """The point at which the members of a node end along `direction`, or `beyond` it."""
        return self.at(node) + (self.half_depth(node, direction) + beyond) * direction

    def outward(self, node: str, axis: str = "") -> complex:
        """The axis direction that leads away from the members at a node.

        `axis`: x or y to choose among its two directions only.
        """
        free = -sum(away for _, away in self.members_at[node])
        if axis == "x" or (axis != "y" and abs(free.real) > abs(free.imag) + _SAME):
            return 1.0 + 0j if free.real > _SAME else -1.0 + 0j
        return 1j if free.imag > _SAME else -1j

    def levels(self, axis: str, further: Iterable[str] = ()) -> list[float]:
        """Different coordinates (m) of joints and ends, and of `further` nodes, rising."""
        names = {n.name for n in self.frame.nodes if not self._only_divides(n.name)} | {*further}
        values = np.sort([float(getattr(self.frame.node(name), axis)) for name in names])
        return [float(v) for v in values[np.diff(values, prepend=-np.inf) > _SAME]]

    def _only_divides(self, node: str) -> bool:
        """Whether a node only divides a straight member."""
        away = [away for _, away in self.members_at[node]]
        if len(away) != 2 or self.frame.node(node).support != "free":
            return False
        return (away[0].conjugate() * away[1]).real < -1.0 + _SAME


def frame_scenario_of(scenario: Scenario) -> FrameScenario | None:
    """Return the frame scenario; a column becomes its two-member frame. None without a frame.

    A scenario that is no single event, such as one with uncertain inputs, may have a `structure`.
    """
    if scenario.STATIC is not None:
        return frame_scenario(scenario)
    structure = getattr(scenario, "structure", None)
    return None if structure is None else frame_scenario_of(structure)


def displacement_unit(scenario: FrameScenario) -> Unit:
    """Return the display unit of the displacement that a scenario follows."""
    rotation = getattr(scenario, "direction", "").endswith("rotation")
    return Unit("rad", 1.0) if rotation else unit_of("displacement")
