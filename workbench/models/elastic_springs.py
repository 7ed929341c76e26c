"""Springs with which two rigid bars are the elastic column under a force or a line load.

The moments of a straight elastic bar of length l and its rotations against its own chord are, with
M_end behind, M_hit at the impact point, both positive in double curvature, and the axial load P,

  t_end = f1 M_end - f2 M_hit + s V,   t_hit = f1 M_hit - f2 M_end + s V,   V = (M_end + M_hit) / l

where, with u^2 = P l^2 / EI, f1 = (1 - u cot u) / u^2 and f2 = (u / sin u - 1) / u^2, times l / EI
(1/3 and 1/6 without load: Timoshenko and Gere, Theory of elastic stability, 1961), and s = 1 / GA_v
is the shear strain. Both bars meet the displacement v = 1 with one slope and one moment at the
impact point; ends are clamped or free to turn. The moments M at v = 1 follow from four linear
equations.

A hinge of two rigid bars that takes M while its bar turns by 1 / l has the secant stiffness M l:
displacement and all moments are then those of the elastic column, axial load and shear included.
Without both and with clamped ends that is 3 EI L / (L_a L_b) at the ends and 6 EI / L at the impact
point; 6 EI / l of each bar, as Heng 2017 has it, is the same only in the middle. The slope at the
impact point is none of the unknowns of the column that an observer sees: the two hinges there
share their flexibility by the lengths of their bars.
"""

from cmath import sin, sqrt, tan
from typing import NamedTuple

import numpy as np

from workbench.base.arrays import Array
from workbench.base.compiled import njit
from workbench.mechanics.structures.kernels import solve_dense
from workbench.scenarios import Column


class Springs(NamedTuple):
    """Flexibilities (rad/(N m)) of the hinges at `base`, impact point (`below`, `above`), `head`.

    Infinite at a pinned end; of a stack of columns arrays.
    """

    base: float
    below: float
    above: float
    head: float


@njit(cache=True, error_model="numpy")
def bar_functions(load: float) -> tuple[float, float]:
    """f1 and f2 of a bar with P l^2 / EI = `load`."""
    if abs(load) < 1e-3:  # series, whose next term is below 1e-8
        return 1.0 / 3.0 + load / 45.0, 1.0 / 6.0 + 7.0 * load / 360.0
    u = sqrt(complex(load))
    return ((1.0 - u / tan(u)) / load).real, ((u / sin(u) - 1.0) / load).real


@njit(cache=True, error_model="numpy")
def line_function(load: float) -> float:
    """f3: rotation at the ends of a bar under a line load q, times EI / q l^3; as above."""
    if abs(load) < 1e-3:
        return (1.0 + load / 10.0) / 24.0
    w = 0.5 * sqrt(complex(load))
    return ((tan(w) - w) / (8.0 * w**3)).real


def thesis_springs(column: Column, factor: float) -> Springs:
    """Springs c EI / l, c the `factor`; half of it at the impact point if the far end is pinned."""
    bending = factor * column.steel.elastic_modulus * column.properties.second_moment
    inf = float("inf")
    turned = [
        (length / bending if clamped else inf, (1.0 if clamped else 2.0) * length / bending)
        for length, clamped in column.bars.values()
    ]
    return Springs(turned[0][0], turned[0][1], turned[1][1], turned[1][0])


def beam_springs(
    column: Column, shear_stiffness: float, sliding: bool = False, uniform: bool = False
) -> Springs:
    """Springs of the elastic column of the shear stiffness GA_v (N), or of each of a stack.

    `sliding`: its shear strain is not in the hinges but in the bars; `uniform`: under a line load
    instead of a force at the impact point. A load so near to buckling that it turns the sense of an
    end moment has no such springs; it is then left out of them. So is a line load that turns it.
    """
    bending = column.steel.elastic_modulus * column.properties.second_moment
    (below, base), (above, head) = column.bars.values()
    numbers = np.broadcast_arrays(below, above, bending, column.axial_load, shear_stiffness)
    springs = np.empty((4, numbers[0].size))
    beams = np.array([each.ravel() for each in numbers], dtype=float)
    springs_of(beams, (base, head), sliding, uniform, springs)
    return Springs(*springs.reshape(4, *numbers[0].shape))


@njit(cache=True, error_model="numpy", nogil=True)
def springs_of(
    beams: Array, clamped: tuple[bool, bool], sliding: bool, uniform: bool, springs: Array
) -> None:
    """Write the `springs` (4, n) of columns, see `beam_springs`.

    Arguments: `beams` (5, n), lengths of both bars (m), bending stiffness (N m2), axial load and
    shear stiffness (N); whether base and head are `clamped`.
    """
    A, loads = np.empty((4, 4)), np.empty((2, 4))
    for i in range(beams.shape[1]):
        lengths, bending = (beams[0, i], beams[1, i]), beams[2, i]
        for line in (uniform, False):
            for load in (beams[3, i], 0.0):
                numbers = (bending, load, beams[4, i])
                _secants(lengths, clamped, numbers, sliding, line, A, loads, springs[:, i])
                if springs[:, i].min() > 0.0:
                    break
            if springs[:, i].min() > 0.0:
                break


@njit(cache=True, error_model="numpy")
def _secants(
    lengths: tuple[float, float],
    clamped: tuple[bool, bool],
    numbers: tuple[float, float, float],
    sliding: bool,
    line: bool,
    A: Array,
    moments: Array,
    springs: Array,
) -> None:
    """Rotations of the bars over the moments of a column, into its `springs` (4,).

    Arguments: `numbers`, bending stiffness, axial load, shear stiffness; whether there is a force
    at the impact point or a `line` load, v = 1 there either way; scratch `A` (4, 4), `moments` (2,
    4).
    """
    bending, load, shear_stiffness = numbers
    A[:], moments[:] = (
        0.0,
        0.0,
    )  # M_base, M_hit, M_head, slope at the impact point; over the rotations
    by_v, by_line = moments[0], moments[1]  # turned by v = 1, and by a line load of 1 N/m
    for bar in range(2):
        length = lengths[bar]
        end, turned, hit = 2 * bar, 2 * bar, 2 * bar + 1  # moment of the bar, its rotations
        one, two = bar_functions(load * length**2 / bending)
        shear = 1.0 / (shear_stiffness * length)
        one, two = one * length / bending + shear, shear - two * length / bending
        A[turned, end], A[turned, 1] = one, two
        A[hit, end], A[hit, 1] = two, one
        A[hit, 3] = 1.0 if bar == 0 else -1.0
        by_v[turned] = by_v[hit] = 1.0 / length
        sagged = line_function(load * length**2 / bending) * length**3 / bending
        by_line[turned], by_line[hit] = sagged, -sagged
        if not clamped[bar]:
            A[turned] = 0.0
            A[turned, end] = 1.0
            by_v[turned] = by_line[turned] = 0.0
    solved = solve_dense(A.copy(), by_v) and (not line or solve_dense(A, by_line))
    if not solved:
        springs[:] = -1.0
        return
    first, last = 1.0 / lengths[0], 1.0 / lengths[1]
    whole = first + last
    if line:  # its half at the impact point does the work of the moments and of the axial load
        needed = first * by_v[0] + whole * by_v[1] + last * by_v[2] - whole * load
        done = first * by_line[0] + whole * by_line[1] + last * by_line[2]
        factor = needed / (0.5 * (lengths[0] + lengths[1]) - done)
        for i in range(4):
            by_v[i] += factor * by_line[i]
    chords, hit_moment = 0.0, by_v[1]
    for bar in range(2):
        chord, moment, spring = 1.0 / lengths[bar], by_v[2 * bar], 3 * bar
        if sliding:
            chord -= (moment + hit_moment) / (shear_stiffness * lengths[bar])
        chords += chord
        springs[spring] = np.inf
        if clamped[bar]:
            springs[spring] = chord / moment if moment != 0.0 else -1.0
    middle = chords / hit_moment / (lengths[0] + lengths[1])
    springs[1], springs[2] = middle * lengths[0], middle * lengths[1]
