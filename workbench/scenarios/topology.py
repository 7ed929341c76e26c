"""Whether the parts of a frame hang together and whether its supports hold it as a whole."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from math import hypot

import numpy as np
from numpy.typing import NDArray

from workbench.errors import InputError
from workbench.scenarios.frame_parts import COMPONENT, Member, Node

APART = 1e-6  # m; nodes closer than this are in one place
FREE = 1e-6  # singular value of the support conditions below which a motion is free


def extent(nodes: Sequence[Node]) -> float:
    """Diagonal of the box around the nodes, in m."""
    x, y = [node.x for node in nodes], [node.y for node in nodes]
    return hypot(max(x) - min(x), max(y) - min(y))


def check_places(nodes: Sequence[Node], members: Sequence[Member]) -> None:
    """Refuse two nodes in one place and two members between the same nodes (`InputError`)."""
    places: dict[tuple[int, int], str] = {}
    for node in nodes:
        place = (round(node.x / APART), round(node.y / APART))
        if place in places:
            raise InputError(
                f"node.{node.name}",
                None,
                f"lies where node {places[place]} lies",
                "join the members at one node; joints make pins",
            )
        places[place] = node.name
    pairs: dict[frozenset[str], str] = {}
    for member in members:
        pair = frozenset((member.start, member.end))
        if pair in pairs:
            raise InputError(
                f"member.{member.name}",
                None,
                f"joins the same nodes as member {pairs[pair]}",
                "drop one of them",
            )
        pairs[pair] = member.name


def check_connected(nodes: Sequence[Node], members: Sequence[Member]) -> None:
    """Refuse nodes that no chain of members joins to the first one (`InputError`)."""
    neighbours: dict[str, list[str]] = {node.name: [] for node in nodes}
    for member in members:
        neighbours[member.start].append(member.end)
        neighbours[member.end].append(member.start)
    for name, near in neighbours.items():
        if not near:
            raise InputError(f"node.{name}", None, "no member ends there", "drop the node")
    reached, waiting = {nodes[0].name}, [nodes[0].name]
    while waiting:
        for name in neighbours[waiting.pop()]:
            if name not in reached:
                reached.add(name)
                waiting.append(name)
    apart = [node.name for node in nodes if node.name not in reached]
    if apart:
        raise InputError(
            "frame.members",
            None,
            f"the frame falls apart: no chain of members joins node {apart[0]} to node "
            f"{nodes[0].name}",
            "add a member or make it a scenario of its own",
        )


def check_supported(nodes: Sequence[Node], turned: Collection[str], loaded: bool) -> None:
    """Refuse a frame that can move as a rigid body (`InputError`).

    Arguments: `turned`, names of nodes that cannot turn without a member; `loaded`, whether there
    are dead loads, which the supports must carry before springs and locks act.
    """
    places = np.array([[node.x, node.y] for node in nodes])
    centre, size = places.mean(axis=0), extent(nodes)
    rows = [
        _condition(component, (node.x - centre[0]) / size, (node.y - centre[1]) / size)
        for node in nodes
        for component in _conditions(node, loaded)
        if component != "rotation" or node.name in turned
    ]
    # motion of the whole: displacement of the centre along x and y, rotation times extent
    _, values, motions = np.linalg.svd(np.array([*rows, *np.zeros((3, 3))]))
    free = motions[values < FREE]
    if len(free):
        motion = free[0] / np.array([1.0, 1.0, size])
        how = "nothing holds it" if len(free) == 3 else f"it can {_words(motion, centre, size)}"
        when = " under its dead loads, before springs and locks act" if loaded else ""
        raise InputError(
            "node.support", None, f"the frame is not supported{when}: {how}", "add supports"
        )


def _conditions(node: Node, loaded: bool) -> set[str]:
    held = set(node.held)
    if not loaded:
        held |= {c for name, c in COMPONENT.items() if getattr(node, f"spring_{name}") > 0.0}
        held |= {COMPONENT[node.locked]} if node.locked != "none" else set()
    return held


def _condition(component: str, x: float, y: float) -> tuple[float, float, float]:
    """What a motion of the whole does to a displacement at (x, y) from the centre."""
    if component == "u":
        return (1.0, 0.0, -y)
    return (0.0, 1.0, x) if component == "v" else (0.0, 0.0, 1.0)


def _words(motion: NDArray[np.float64], centre: NDArray[np.float64], size: float) -> str:
    along_x, along_y, turn = (float(value) for value in motion)
    if abs(turn) * size > FREE:
        x, y = centre + np.array([-along_y, along_x]) / turn
        return f"turn about x = {round(x, 3) + 0.0:g} m, y = {round(y, 3) + 0.0:g} m"
    if abs(along_y) < FREE:
        return "slide along x"
    return "slide along y" if abs(along_x) < FREE else "slide"
