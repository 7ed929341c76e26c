"""Members that continue each other straight on: one physical member drawn in several parts."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from workbench.scenarios import Frame

STRAIGHT = 1e-6  # sine of the largest kink
NAMED = 4  # members that a sentence names


def chains(frame: Frame, kept: Collection[str] = ()) -> list[list[str]]:
    """Names of the members of every chain, from one end to the other.

    Two members continue each other at a free node where only they meet, rigidly and in one line.
    Argument: `kept`, names of nodes that end a chain all the same.
    """
    ends: dict[str, list[tuple[str, bool]]] = {}
    for member in frame.members:
        ends.setdefault(member.start, []).append((member.name, True))
        ends.setdefault(member.end, []).append((member.name, False))
    follows: dict[tuple[str, bool], tuple[str, bool]] = {}
    for node in frame.nodes:
        pair = ends.get(node.name, [])
        if len(pair) == 2 and node.name not in kept and _straight_on(frame, node.name, pair):
            follows[pair[0]], follows[pair[1]] = pair[1], pair[0]
    found: list[list[str]] = []
    done: set[str] = set()
    for member in frame.members:
        if member.name in done:
            continue
        chain = [member.name]
        for at_start in (True, False):
            end = (member.name, at_start)
            while end in follows and follows[end][0] not in chain:
                name, came_in = follows[end]
                chain.insert(0 if at_start else len(chain), name)
                end = (name, not came_in)
        done.update(chain)
        found.append(chain)
    return found


def _straight_on(frame: Frame, node: str, pair: list[tuple[str, bool]]) -> bool:
    """Whether the two members that meet at a node continue each other."""
    at = frame.node(node)
    if at.held or max(at.spring_x, at.spring_y, at.spring_rotation) > 0.0 or at.locked != "none":
        return False
    directions = []
    for name, starts_here in pair:
        member = frame.member(name)
        if (member.joint_start if starts_here else member.joint_end) != "rigid":
            return False
        far = frame.node(member.end if starts_here else member.start)
        direction = np.array([far.x - at.x, far.y - at.y])
        directions.append(direction / np.hypot(*direction))
    (ax, ay), (bx, by) = directions
    return bool(ax * bx + ay * by < 0.0 and abs(ax * by - ay * bx) < STRAIGHT)


def named(members: list[str]) -> str:
    """Names of members for a sentence, the first few of many."""
    more = f" and {len(members) - NAMED} more" if len(members) > NAMED else ""
    return ("member " if len(members) == 1 else "members ") + ", ".join(members[:NAMED]) + more
