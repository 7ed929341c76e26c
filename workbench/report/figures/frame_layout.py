"""Where the parts of a frame stand on paper: positions in inches, free sides, levels."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

from workbench.scenarios import Frame, Member

Point = tuple[float, float]

_LEAST_DEPTH = 0.035  # inches that a member takes at least, so that it can be seen
_WIDE, _HIGH, _UPRIGHT = 4.2, 2.9, 2.4  # inches that a frame, and a single column, may take
_SAME = 1e-6  # m


@dataclass(frozen=True)
class Layout:
    """A `frame` drawn at `scale` (inches per m), its node of least x and y at the origin."""

    frame: Frame

    @cached_property
    def origin(self) -> Point:
        """Least x and y of all nodes, in m."""
        return min(n.x for n in self.frame.nodes), min(n.y for n in self.frame.nodes)

    @cached_property
    def extent(self) -> Point:
        """Width and height between nodes, in m."""
        return (
            max(n.x for n in self.frame.nodes) - self.origin[0],
            max(n.y for n in self.frame.nodes) - self.origin[1],
        )

    @cached_property
    def scale(self) -> float:
        """Inches per metre."""
        wide, high = self.extent
        room = _HIGH if wide > _SAME else _UPRIGHT
        return min(_WIDE / max(wide, _SAME), room / max(high, _SAME))

    @cached_property
    def small(self) -> float:
        """Factor on symbols that stand at every node: below 1 where members are short."""
        lengths = sorted(self.frame.length(member) * self.scale for member in self.frame.members)
        return min(1.0, lengths[len(lengths) // 2] / 0.6)

    def at(self, node: str) -> Point:
        """Position of a node, in inches."""
        found = self.frame.node(node)
        return (found.x - self.origin[0]) * self.scale, (found.y - self.origin[1]) * self.scale

    def true_depth(self, member: Member) -> float:
        """Depth of a member to scale, in inches."""
        return float(member.section.height) * self.scale

    def depth(self, member: Member) -> float:
        """Depth of a member as drawn, in inches."""
        return max(self.true_depth(member), _LEAST_DEPTH)

    def along(self, member: Member) -> Point:
        """Unit vector from a member's start to its end."""
        (x0, y0), (x1, y1) = self.at(member.start), self.at(member.end)
        length = math.hypot(x1 - x0, y1 - y0)
        return (x1 - x0) / length, (y1 - y0) / length

    @cached_property
    def members_at(self) -> dict[str, list[tuple[Member, Point]]]:
        """Members that end at each node, with the unit vector that leads away from it."""
        found: dict[str, list[tuple[Member, Point]]] = {n.name: [] for n in self.frame.nodes}
        for member in self.frame.members:
            x, y = self.along(member)
            found[member.start].append((member, (x, y)))
            found[member.end].append((member, (-x, -y)))
        return found

    def half_depth(self, node: str, direction: Point) -> float:
        """How far members reach from a node along `direction`, across their own axes."""
        reach = [
            0.5 * self.depth(member) * abs(x * direction[1] - y * direction[0])
            for member, (x, y) in self.members_at[node]
        ]
        return max(reach, default=0.0)

    def outward(self, node: str, axis: str = "") -> Point:
        """The axis direction that leads away from the members at a node.

        `axis`: x or y to choose among its two directions only.
        """
        x = -sum(away[0] for _, away in self.members_at[node])
        y = -sum(away[1] for _, away in self.members_at[node])
        if axis == "x" or (axis != "y" and abs(x) > abs(y) + _SAME):
            return (1.0, 0.0) if x > _SAME else (-1.0, 0.0)
        return (0.0, 1.0) if y > _SAME else (0.0, -1.0)

    def passed(self, node: str) -> bool:
        """Whether a node only divides a straight member."""
        ends = self.members_at[node]
        if len(ends) != 2 or self.frame.node(node).support != "free":
            return False
        (_, (x0, y0)), (_, (x1, y1)) = ends
        return x0 * x1 + y0 * y1 < -1.0 + _SAME

    def levels(self, axis: str, further: Iterable[str] = ()) -> list[float]:
        """Different coordinates (m) of joints and ends, and of `further` nodes, rising."""
        names = {n.name for n in self.frame.nodes if not self.passed(n.name)} | set(further)
        found: list[float] = []
        for value in sorted(float(getattr(self.frame.node(name), axis)) for name in names):
            if not found or value - found[-1] > _SAME:
                found.append(value)
        return found
