"""First-order forces of a frame under its dead loads, and the factor on them at which it buckles.

Linear elastic frame of Bernoulli beams with the consistent geometric stiffness of cubic deflection
(Przemieniecki 1968), two elements per member: the buckling load of a member with pinned ends is
0.8 % too large, with clamped ends 1.3 %.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh, eigvalsh, solve

from workbench.scenarios import Frame

Array = NDArray[np.float64]
HALVES = 2
NO_STIFFNESS = 1e-11  # eigenvalue of the scaled stiffness of a mechanism
LEAST_SOFTENING = 1e-9  # share of the stiffness; what is less is rounding


class DeadLoadState(NamedTuple):
    """Axial forces (members,) in N, tension positive, and the critical factor on the dead loads.

    The factor is infinite without compression, and None for a mechanism.
    """

    axial: Array
    factor: float | None


def dead_load_state(frame: Frame) -> DeadLoadState:
    """First-order axial forces and buckling factor under the dead loads of a frame."""
    node = {n.name: i for i, n in enumerate(frame.nodes)}
    count = 3 * len(frame.nodes)
    blocks: list[tuple[Array, Array, list[int], float, float, float]] = []
    springs: list[tuple[int, int, float]] = []
    for member in frame.members:
        ends = [[3 * node[name] + k for k in range(3)] for name in (member.start, member.end)]
        for end, joint in zip(ends, (member.joint_start, member.joint_end), strict=True):
            stiffness = frame.joint(joint).rotational_stiffness
            if stiffness is not None:
                springs.append((end[2], count, stiffness))
                end[2] = count
                count += 1
        middle = list(range(count, count + 3))
        count += 3
        start, stop = frame.node(member.start), frame.node(member.end)
        chord = np.array([stop.x - start.x, stop.y - start.y])
        half = float(np.hypot(*chord)) / HALVES
        properties = frame.properties(member)
        modulus = frame.steel.elastic_modulus
        axial, bending = modulus * properties.area, modulus * properties.second_moment
        turn = _turn(chord / np.hypot(*chord))
        elastic = turn.T @ _elastic(axial, bending, half) @ turn
        bow = turn.T @ _geometric(half) @ turn
        for dofs in ([*ends[0], *middle], [*middle, *ends[1]]):
            blocks.append((elastic, bow, dofs, axial / half, *chord / np.hypot(*chord)))
    stiffness_matrix = np.zeros((count, count))
    for elastic, _, dofs, *_ in blocks:
        stiffness_matrix[np.ix_(dofs, dofs)] += elastic
    for a, b, k in springs:
        stiffness_matrix[np.ix_([a, b], [a, b])] += k * np.array([[1.0, -1.0], [-1.0, 1.0]])
    load = np.zeros(count)
    for given in frame.loads:
        load[3 * node[given.node] : 3 * node[given.node] + 3] += given.x, given.y, given.moment
    held = {3 * i + "uvr".index(c[0]) for i, n in enumerate(frame.nodes) for c in n.held}
    held |= set(np.flatnonzero(np.abs(stiffness_matrix).max(axis=1) == 0.0).tolist())
    free = np.setdiff1d(np.arange(count), sorted(held))
    grid = np.ix_(free, free)
    moved = np.zeros(count)
    scale = 1.0 / np.sqrt(np.diag(stiffness_matrix)[free])
    if eigvalsh(stiffness_matrix[grid] * np.outer(scale, scale))[0] < NO_STIFFNESS:
        return DeadLoadState(np.zeros(len(frame.members)), None)
    moved[free] = solve(stiffness_matrix[grid], load[free], assume_a="sym")
    geometric = np.zeros((count, count))
    axial_forces = []
    for _, bow, dofs, k, c, s in blocks:
        ends_moved = moved[dofs]
        force = k * float(c * (ends_moved[3] - ends_moved[0]) + s * (ends_moved[4] - ends_moved[1]))
        axial_forces.append(force)
        geometric[np.ix_(dofs, dofs)] += force * bow
    lowest = eigh(
        geometric[grid], stiffness_matrix[grid], eigvals_only=True, subset_by_index=[0, 0]
    )[0]
    factor = np.inf if lowest > -LEAST_SOFTENING else -1.0 / float(lowest)
    return DeadLoadState(np.array(axial_forces[::HALVES]), factor)


def _turn(direction: Array) -> Array:
    """Rotation of element dofs from global to local axes (6, 6)."""
    c, s = direction
    turn = np.zeros((6, 6))
    turn[:2, :2] = turn[3:5, 3:5] = [[c, s], [-s, c]]
    turn[2, 2] = turn[5, 5] = 1.0
    return turn


def _elastic(axial: float, bending: float, length: float) -> Array:
    """Elastic stiffness of a Bernoulli beam in local axes (6, 6) from EA, EI and length."""
    k = np.zeros((6, 6))
    k[np.ix_([0, 3], [0, 3])] = axial / length * np.array([[1.0, -1.0], [-1.0, 1.0]])
    a, b, c = 12.0 / length**2, 6.0 / length, 4.0
    rows = [[a, b, -a, b], [b, c, -b, 0.5 * c], [-a, -b, a, -b], [b, 0.5 * c, -b, c]]
    k[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] = bending / length * np.array(rows)
    return k


def _geometric(length: float) -> Array:
    """Geometric stiffness of a beam under unit tension in local axes (6, 6)."""
    k = np.zeros((6, 6))
    a, b, c, d = 36.0, 3.0 * length, 4.0 * length**2, -(length**2)
    rows = [[a, b, -a, b], [b, c, -b, d], [-a, -b, a, -b], [b, d, -b, c]]
    k[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] = np.array(rows) / (30.0 * length)
    return k
