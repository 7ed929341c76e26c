"""Whether the parts of a frame hang together and whether its supports hold it as a whole."""

from collections.abc import Collection, Hashable, Iterable, Sequence
from math import hypot
from typing import TypeVar

import numpy as np

from workbench.arrays import Array
from workbench.errors import InputError
from workbench.scenarios.frame_parts import Joint, Member, Node

Part = TypeVar("Part", Node, Member, Joint)

APART = 1e-6  # m; nodes closer than this are in one place
FREE = 1e-6  # singular value of the support conditions below which a motion is free


def extent(nodes: Sequence[Node]) -> float:
    """Diagonal of the box around the nodes, in m."""
    x, y = [node.x for node in nodes], [node.y for node in nodes]
    return hypot(max(x) - min(x), max(y) - min(y))


def check_unique(parts: Sequence[Part], keys: Iterable[Hashable], text: str, advice: str) -> None:
    """Refuse parts with equal keys (`InputError`); `text` names the earlier one as ``{}``."""
    seen: dict[Hashable, Part] = {}
    for part, key in zip(parts, keys, strict=True):
        if key in seen:
            raise part.refusal("", text.format(seen[key].name), advice)
        seen[key] = part


def check_places(nodes: Sequence[Node], members: Sequence[Member]) -> None:
    """Refuse two nodes in one place and two members between the same nodes (`InputError`)."""
    places = [(round(node.x / APART), round(node.y / APART)) for node in nodes]
    advice = "join the members at one node; joints make pins"
    check_unique(nodes, places, "lies where node {} lies", advice)
    pairs = [frozenset((member.start, member.end)) for member in members]
    check_unique(members, pairs, "joins the same nodes as member {}", "drop one of them")


def check_connected(nodes: Sequence[Node], members: Sequence[Member]) -> None:
    """Refuse nodes that no chain of members joins to the first one (`InputError`)."""
    beside: dict[str, list[str]] = {node.name: [] for node in nodes}
    for member in members:
        beside[member.start].append(member.end)
        beside[member.end].append(member.start)
    for node in nodes:
        if not beside[node.name]:
            raise node.refusal("", "no member ends there", "drop the node")
    reached, ahead = {nodes[0].name}, [nodes[0].name]
    while ahead:
        found = set(beside[ahead.pop()]) - reached
        reached |= found
        ahead += found
    apart = [node.name for node in nodes if node.name not in reached]
    if apart:
        chain = f"no chain of members joins node {apart[0]} to node {nodes[0].name}"
        advice = "add a member or make it a scenario of its own"
        raise InputError("frame.members", None, f"the frame falls apart: {chain}", advice)


def check_supported(nodes: Sequence[Node], turned: Collection[str], loaded: bool) -> None:
    """Refuse a frame that can move as a rigid body (`InputError`).

    Arguments: `turned`, names of nodes that cannot turn without a member; `loaded`, whether there
    are dead loads, which the supports must carry before springs and locks act.
    """
    places = np.array([[node.x, node.y] for node in nodes])
    centre, size = places.mean(axis=0), extent(nodes)
    rows = []
    for node in nodes:
        x, y = (node.x - centre[0]) / size, (node.y - centre[1]) / size
        # what a motion of the whole does to each displacement of the node
        motion = {"u": (1.0, 0.0, -y), "v": (0.0, 1.0, x), "rotation": (0.0, 0.0, 1.0)}
        held = set(node.held) if loaded else node.resisted
        held -= set() if node.name in turned else {"rotation"}
        rows += [row for component, row in motion.items() if component in held]
    # motion of the whole: displacement of the centre along x and y, rotation times extent
    _, values, motions = np.linalg.svd(np.array([*rows, *np.zeros((3, 3))]))
    free = motions[values < FREE]
    if len(free):
        can = _words(free[0] / np.array([1.0, 1.0, size]), centre, size)
        how = "nothing holds it" if len(free) == 3 else f"it can {can}"
        when = " under its dead loads, before springs and locks act" if loaded else ""
        text = f"the frame is not supported{when}: {how}"
        raise InputError("node.support", None, text, "add supports")


def _words(motion: Array, centre: Array, size: float) -> str:
    along_x, along_y, turn = (float(value) for value in motion)
    if abs(turn) * size > FREE:
        x, y = centre + np.array([-along_y, along_x]) / turn
        return f"turn about x = {round(x, 3) + 0.0:g} m, y = {round(y, 3) + 0.0:g} m"
    if abs(along_y) < FREE:
        return "slide along x"
    return "slide along y" if abs(along_x) < FREE else "slide"
