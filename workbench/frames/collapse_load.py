"""Collapse load of a rigid-plastic frame on its undeformed shape, by the static theorem.

End forces (N and both end moments) of every member and the load factor are the unknowns of a
linear programme: equilibrium is an equality, yielding bounds N and M apart, without interaction.
The largest factor is the collapse load (Livesley 1975, chapter 3).
"""

from collections.abc import Collection, Sequence
from math import inf

import numpy as np
from scipy.optimize import linprog

from workbench.arrays import Array
from workbench.scenarios import Frame, Joint, Load, Member
from workbench.scenarios.frame_parts import COMPONENT

UNBOUNDED = 3  # status of `linprog`


def collapse_factor(
    frame: Frame,
    pattern: Sequence[Load],
    dead: Sequence[Load] = (),
    members: Collection[str] | None = None,
) -> float | None:
    """Largest factor on a `pattern` of loads that the strength of the members allows.

    Arguments: `dead` loads, not multiplied; names of the `members` that count (None: all).
    Springs to the ground and locks never yield. Infinite if nothing that yields is in the way;
    None if the strength does not reach for the dead loads alone.
    """
    counted = [m for m in frame.members if members is None or m.name in members]
    first = {node.name: 3 * i for i, node in enumerate(frame.nodes)}
    strengths = [_strength(frame, member) for member in counted]
    moment = max((m for _, positive, negative in strengths for m in positive + negative), default=1)
    force = moment / max((frame.length(member) for member in counted), default=1.0)
    unknowns = 3 * len(counted) + 1
    balance = np.zeros((3 * len(frame.nodes), unknowns))
    bounds: list[tuple[float | None, float | None]] = []
    for number, (member, (squash, positive, negative)) in enumerate(
        zip(counted, strengths, strict=True)
    ):
        unit = np.array([squash[0], moment, moment])
        dofs = np.concatenate([first[n] + np.arange(3) for n in (member.start, member.end)])
        balance[dofs, 3 * number : 3 * number + 3] = _equilibrium(frame, member) * unit
        bounds.append((-squash[1] / squash[0], 1.0))
        # the internal moment is -M1 at the start and +M4 at the end
        bounds.append((-positive[0] / moment, negative[0] / moment))
        bounds.append((-negative[1] / moment, positive[1] / moment))
    bounds.append((None, None))
    balance[:, -1] = -force * _forces(first, pattern)
    units = np.resize([force, force, moment], len(balance))
    free = _free(frame)
    found = linprog(
        np.append(np.zeros(unknowns - 1), -1.0),
        A_eq=(balance / units[:, None])[free],
        b_eq=(_forces(first, dead) / units)[free],
        bounds=bounds,
        method="highs",
    )
    if found.status == UNBOUNDED:
        return inf
    return float(found.x[-1] * force) if found.success and found.x[-1] >= 0.0 else None


def _free(frame: Frame) -> list[int]:
    """Dofs that nothing but members holds."""
    free = []
    for i, node in enumerate(frame.nodes):
        held = set(node.held)
        held |= {c for name, c in COMPONENT.items() if getattr(node, f"spring_{name}") > 0.0}
        held |= {COMPONENT[node.locked]} if node.locked != "none" else set()
        free += [3 * i + k for k, c in enumerate(COMPONENT.values()) if c not in held]
    return free


def _forces(first: dict[str, int], loads: Sequence[Load]) -> Array:
    forces = np.zeros(3 * len(first))
    for load in loads:
        forces[first[load.node] : first[load.node] + 3] += load.x, load.y, load.moment
    return forces


def _equilibrium(frame: Frame, member: Member) -> Array:
    """Nodal forces (6, 3) of a unit tension and unit end moments."""
    start, end = frame.node(member.start), frame.node(member.end)
    length = frame.length(member)
    c, s = (end.x - start.x) / length, (end.y - start.y) / length
    e, n = np.array([c, s, 0.0]), np.array([-s, c, 0.0]) / length
    turn = np.array([0.0, 0.0, 1.0])
    rows = [np.append(-e, e), np.append(turn - n, n), np.append(-n, turn + n)]
    return np.array(rows).T


Pair = tuple[float, float]


def _strength(frame: Frame, member: Member) -> tuple[Pair, Pair, Pair]:
    """Tension and compression resistance; sagging and hogging plastic moments at both ends."""
    properties = frame.properties(member)
    joints = [frame.joint(name) for name in (member.joint_start, member.joint_end)]
    tension = [properties.squash_load, *(_given(j.tension_resistance) for j in joints)]
    compression = [properties.squash_load, *(_given(j.compression_resistance) for j in joints)]
    own = properties.plastic_moment
    positive = [_moment(joint, joint.plastic_moment, own) for joint in joints]
    negative = [_moment(joint, joint.plastic_moment_negative, own) for joint in joints]
    return (
        (min(tension), min(compression)),
        (positive[0], positive[1]),
        (negative[0], negative[1]),
    )


def _given(resistance: float | None) -> float:
    return inf if resistance is None else resistance


def _moment(joint: Joint, given: float | None, own: float) -> float:
    if joint.rotational_stiffness == 0.0:
        return 0.0
    return min(own, _given(given))
