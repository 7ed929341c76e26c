"""Members that continue each other straight on: one physical member drawn in several parts."""

from collections.abc import Collection, Sequence
from typing import NamedTuple

import numpy as np

from workbench.scenarios import Frame, FrameImpact, FramePulse, FrameScenario, FrameStatic

STRAIGHT = 1e-6  # sine of the largest kink
NAMED = 4  # members that a sentence names

End = tuple[str, bool]  # name of a member, and whether it is its start


class Chain(NamedTuple):
    """Names of the `members` and `nodes` in their order from one end of the chain to the other.

    `ends`: the outermost members, and whether that end is the member's own start.
    """

    members: tuple[str, ...]
    nodes: tuple[str, ...]
    ends: tuple[End, End]

    def joints(self, frame: Frame) -> tuple[str, str]:
        """Names of the joints at both ends."""
        first, last = (_joint(frame, end) for end in self.ends)
        return first, last


def chains(frame: Frame, kept: Collection[str] = ()) -> list[Chain]:
    """All chains of a frame.

    Two members continue each other at a free node where only they meet, rigidly and in one line.
    Argument: `kept`, names of nodes that end a chain all the same.
    """
    ends: dict[str, list[End]] = {}
    for member in frame.members:
        ends.setdefault(member.start, []).append((member.name, True))
        ends.setdefault(member.end, []).append((member.name, False))
    follows: dict[End, End] = {}
    for node in frame.nodes:
        pair = ends.get(node.name, [])
        if len(pair) == 2 and node.name not in kept and _straight_on(frame, node.name, pair):
            follows[pair[0]], follows[pair[1]] = pair[1], pair[0]
    lines: list[Chain] = []
    done: set[str] = set()
    for member in frame.members:
        if member.name in done:
            continue
        names, nodes = [member.name], [member.start, member.end]
        outer = {True: (member.name, True), False: (member.name, False)}
        for at_start, end in outer.items():
            while end in follows and follows[end][0] not in names:
                name, came_in = follows[end]
                end = (name, not came_in)
                names.insert(0 if at_start else len(names), name)
                far = frame.member(name)
                nodes.insert(0 if at_start else len(nodes), far.end if came_in else far.start)
            outer[at_start] = end
        done.update(names)
        lines.append(Chain(tuple(names), tuple(nodes), (outer[True], outer[False])))
    return lines


def eventful(scenario: FrameScenario) -> set[str]:
    """Names of the nodes that are loaded, struck or driven, where a hinge may form."""
    nodes = {load.node for load in scenario.frame.loads}
    if isinstance(scenario, FrameStatic):
        return nodes | {scenario.node} | {load.node for load in scenario.loads}
    if isinstance(scenario, FramePulse):
        return nodes | {load.node for load in scenario.loads}
    return nodes | ({scenario.striker.node} if isinstance(scenario, FrameImpact) else set())


def _joint(frame: Frame, end: End) -> str:
    member = frame.member(end[0])
    return member.joint_start if end[1] else member.joint_end


def _straight_on(frame: Frame, node: str, pair: list[End]) -> bool:
    """Whether the two members that meet at a node continue each other."""
    at = frame.node(node)
    if at.held or max(at.spring_x, at.spring_y, at.spring_rotation) > 0.0 or at.locked != "none":
        return False
    directions = []
    for name, starts_here in pair:
        member = frame.member(name)
        if _joint(frame, (name, starts_here)) != "rigid":
            return False
        far = frame.node(member.end if starts_here else member.start)
        direction = np.array([far.x - at.x, far.y - at.y])
        directions.append(direction / np.hypot(*direction))
    (ax, ay), (bx, by) = directions
    return bool(ax * bx + ay * by < 0.0 and abs(ax * by - ay * bx) < STRAIGHT)


def named(members: Sequence[str]) -> str:
    """Names of members for a sentence, the first few of many."""
    more = f" and {len(members) - NAMED} more" if len(members) > NAMED else ""
    return ("member " if len(members) == 1 else "members ") + ", ".join(members[:NAMED]) + more
