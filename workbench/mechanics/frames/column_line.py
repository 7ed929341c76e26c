"""The column that is hit in a frame, the line of members through the struck node; its head mass."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.base.arrays import Array
from workbench.mechanics.frames import out_of_domain
from workbench.mechanics.frames.elastic import ElasticFrame
from workbench.mechanics.frames.members import chains
from workbench.mechanics.frames.superelements import series
from workbench.scenarios import Frame, FrameImpact, Load, Member, Node
from workbench.scenarios.parts import OVERRIDES

OBLIQUE = 0.02  # sine of the largest angle between the strike and the normal of the column
RIGID, PINNED = 8.0, 0.5  # stiffness of a joint over EI/L: EN 1993-1-8, 5.2.2.5 (braced frames)
HEAD_MASSES = ("column-line", "joint", "deflected-shape", "none")
STRAIGHT_ON = 0.02  # sine of the largest kink in the line above the head


@dataclass(frozen=True)
class ColumnLine:
    """The line of `members` (names) from node `base` to node `head` through the struck one.

    `axis` (2,) points from base to head; lengths `below` and `above` the struck node in m;
    `fixed`, whether the rotations of base and head are held; `softness`, flexibility in m/N of
    joints along the line.
    """

    frame: Frame
    members: tuple[str, ...]
    base: str
    head: str
    axis: tuple[float, float]
    below: float
    above: float
    fixed: tuple[bool, bool]
    softness: float

    @property
    def rest(self) -> tuple[str, ...]:
        """Names of all other members."""
        return tuple(m.name for m in self.frame.members if m.name not in self.members)

    def pull(self, force: float) -> tuple[Load, Load]:
        """Forces (N) on both ends that draw them together."""
        x, y = force * self.axis[0], force * self.axis[1]
        return Load(self.head, x=-x, y=-y), Load(self.base, x=x, y=y)

    def turned(self) -> ColumnLine:
        """Line with base and head exchanged."""
        return replace(
            self,
            members=self.members[::-1],
            base=self.head,
            head=self.base,
            axis=(-self.axis[0], -self.axis[1]),
            below=self.above,
            above=self.below,
            fixed=self.fixed[::-1],
        )


def column_line(scenario: FrameImpact) -> ColumnLine:
    """The column that a striker hits.

    The base is the end that a support holds against all translation; of two such ends, or none,
    the lower one. Raises `OutOfDomainError` where what is hit is no column between two joints.
    """
    frame, struck = scenario.frame, scenario.striker.node
    chain = next((each for each in chains(frame) if struck in each.nodes[1:-1]), None)
    if chain is None:
        raise out_of_domain("hit-at-joint", node=struck)
    members, line = [frame.member(name) for name in chain.members], chain.nodes
    ends = frame.node(line[0]), frame.node(line[-1])
    chord = np.array([ends[1].x - ends[0].x, ends[1].y - ends[0].y])
    axis, joints = chord / np.hypot(*chord), [end.joint for end in chain.ends]
    _refuse_what_no_column_has(scenario, members, line, axis)
    lengths, at = [frame.length(member) for member in members], line.index(struck)
    properties = frame.properties(members[0])
    unit = frame.steel.elastic_modulus * properties.second_moment / sum(lengths)
    fixed = [
        _is_fixed(frame, end, chain.members, joint, unit)
        for end, joint in zip(ends, joints, strict=True)
    ]
    for name in joints:
        if frame.joint(name).weaker(properties.strength) != properties.strength:
            raise out_of_domain("weak-joint", joint=name)
    column = ColumnLine(
        frame,
        chain.members,
        line[0],
        line[-1],
        (float(axis[0]), float(axis[1])),
        sum(lengths[:at]),
        sum(lengths[at:]),
        (fixed[0], fixed[1]),
        sum(1.0 / k for name in joints if (k := frame.joint(name).axial_stiffness) is not None),
    )
    ranks = [(not {"u", "v"} <= set(node.held), node.y, node.x) for node in ends]
    return column if ranks[0] <= ranks[1] else column.turned()


def _refuse_what_no_column_has(
    scenario: FrameImpact, members: list[Member], line: Sequence[str], axis: Array
) -> None:
    """Raise `OutOfDomainError` for changing sections, loads between the ends, oblique strikes."""
    frame, striker = scenario.frame, scenario.striker
    kinds = {(m.section, *(getattr(m, key) for key in OVERRIDES)) for m in members}
    if len(kinds) > 1:
        raise out_of_domain("changing-section", members=", ".join(m.name for m in members))
    for name in line[1:-1]:
        node = frame.node(name)
        loaded = any(load.node == name for load in frame.loads)
        if loaded or node.rotary_inertia > 0.0 or (node.mass > 0.0 and name != striker.node):
            raise out_of_domain("loaded-inside", node=name)
    lengthwise = abs(float(axis[0 if striker.direction.endswith("x") else 1]))
    if lengthwise > OBLIQUE:
        how = "along" if lengthwise > 1.0 - OBLIQUE else "obliquely to"
        raise out_of_domain("oblique-strike", direction=striker.direction, how=how)


def _is_fixed(frame: Frame, node: Node, chain: Sequence[str], joint: str, unit: float) -> bool:
    """Whether the rotation at an end is held; `unit` is EI/L in N m/rad.

    Raises `OutOfDomainError` for free ends, and for joints neither stiff nor soft.
    """
    alone = all(end.member.name in chain for end in frame.meeting(node.name))
    if alone and not node.resisted - {"rotation"}:
        raise out_of_domain("loose-end", node=node.name)
    turning = frame.turns(node.name, chain) or "rotation" in node.held
    rigid = None if turning else node.spring_rotation
    share = series(frame.joint(joint).rotational_stiffness, rigid) / unit
    if PINNED < share < RIGID:
        limits = {"rigid": RIGID, "pinned": PINNED}
        raise out_of_domain("semi-rigid-end", node=node.name, share=share, **limits)
    return share >= RIGID


def mass_of_head(rule: str, line: ColumnLine, shape: Array | None) -> float:
    """Mass (kg) at the head by a rule of `HEAD_MASSES`.

    Joint: point mass of the head and half of the other members that meet there. Column line: the
    same for all joints of the line that goes on beyond the head, its members whole; that line is
    far stiffer along its axis than the beams that hold it, and moves with the head. Deflected
    shape: generalised mass of the frame without the column in the deflection that its spring has.
    """
    frame = line.frame
    if rule == "none":
        return 0.0
    if rule == "deflected-shape":
        if shape is None:
            raise out_of_domain("no-deflected-shape")
        return float(shape @ ElasticFrame(frame, line.rest).mass @ shape)
    nodes = [line.head] if rule == "joint" else _line_above(line)
    total = sum(frame.node(name).mass for name in nodes)
    for member in frame.members:
        if member.name not in line.members:
            ends = (member.start in nodes) + (member.end in nodes)
            mass = frame.properties(member).mass_per_length * frame.length(member)
            total += 0.5 * ends * mass
    return total


def _line_above(line: ColumnLine) -> list[str]:
    """Names of the nodes from the head on along the axis of the column."""
    frame, nodes = line.frame, [line.head]
    axis = np.array(line.axis)
    while True:
        at = frame.node(nodes[-1])
        if at.held:
            return nodes
        for end in frame.meeting(at.name):
            far = frame.node(end.other.node)
            chord = np.array([far.x - at.x, far.y - at.y])
            across = abs(float(axis[0] * chord[1] - axis[1] * chord[0]))
            if axis @ chord > 0.0 and across < STRAIGHT_ON * float(np.hypot(*chord)):
                nodes.append(far.name)
                break
        else:
            return nodes
