"""Springs with which two rigid bars are the elastic column under a force or a line load.

The moments of a straight elastic bar of length l and its rotations against its own chord are, with
M_end behind, M_hit at the hit point, both positive in double curvature, and the axial load P,

  t_end = f1 M_end - f2 M_hit + s V,   t_hit = f1 M_hit - f2 M_end + s V,   V = (M_end + M_hit) / l

where, with u^2 = P l^2 / EI, f1 = (1 - u cot u) / u^2 and f2 = (u / sin u - 1) / u^2, times l / EI
(1/3 and 1/6 without load: Timoshenko and Gere, Theory of elastic stability, 1961), and s = 1 / GA_v
is the shear strain. Both bars meet the displacement v = 1 with one slope and one moment at the hit
point; ends are clamped or free to turn. The moments M at v = 1 follow from four linear equations.

A hinge of two rigid bars that takes M while its bar turns by 1 / l has the secant stiffness M l:
displacement and all moments are then those of the elastic column, axial load and shear included.
Without both and with clamped ends that is 3 EI L / (L_a L_b) at the ends and 6 EI / L at the hit
point; 6 EI / l of each bar, as Heng 2017 has it, is the same only in the middle. The slope at the
hit point is none of the unknowns of the column that an observer sees: the two hinges there
share their flexibility by the lengths of their bars.
"""

from cmath import sin, sqrt, tan
from typing import NamedTuple

import numpy as np

from workbench.scenarios import Column


class Springs(NamedTuple):
    """Flexibilities (rad/(N m)) of the hinges at `base`, hit point (`below`, `above`), `head`.

    Infinite at a pinned end.
    """

    base: float
    below: float
    above: float
    head: float


def bar_functions(load: float) -> tuple[float, float]:
    """f1 and f2 of a bar with P l^2 / EI = `load`."""
    if abs(load) < 1e-3:  # series, whose next term is below 1e-8
        return 1.0 / 3.0 + load / 45.0, 1.0 / 6.0 + 7.0 * load / 360.0
    u = sqrt(load)
    return ((1.0 - u / tan(u)) / load).real, ((u / sin(u) - 1.0) / load).real


def line_function(load: float) -> float:
    """f3: rotation at the ends of a bar under a line load q, times EI / q l^3; as above."""
    if abs(load) < 1e-3:
        return (1.0 + load / 10.0) / 24.0
    w = 0.5 * sqrt(load)
    return float(((tan(w) - w) / (8.0 * w**3)).real)


def thesis_springs(column: Column, factor: float) -> Springs:
    """Those of c EI / l, c the `factor`; half of it at the hit point if the far end is pinned."""
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
    """Those of the elastic column of the shear stiffness GA_v (N).

    `sliding`: its shear strain is not in the hinges but in the bars; `uniform`: under a line load
    instead of a force at the hit point. A load so near to buckling that it turns the sense of an
    end moment has no such springs; it is then left out of them. So is a line load that turns it.
    """
    for line in (uniform, False)[not uniform :]:
        for load in (column.axial_load, 0.0):
            springs = _secants(column, load, shear_stiffness, sliding, line)
            if min(springs) > 0.0:
                return springs
    return springs


def _secants(
    column: Column, load: float, shear_stiffness: float, sliding: bool, line: bool
) -> Springs:
    """Rotations of the bars over the moments of the column under an axial `load` (N).

    And under a force at the hit point or a `line` load, v = 1 there either way.
    """
    bending = column.steel.elastic_modulus * column.properties.second_moment
    bars = column.bars.values()
    lengths = [length for length, _ in bars]
    A = np.zeros((4, 4))  # M_base, M_hit, M_head, slope at the hit point; over the rotations
    turned = np.zeros((4, 2))  # by v = 1, and by a line load of 1 N/m
    for bar, (length, clamped) in enumerate(bars):
        columns, rows = [2 * bar, 1], (2 * bar, 2 * bar + 1)  # moments of the bar, its rotations
        one, two = bar_functions(load * length**2 / bending)
        shear = 1.0 / (shear_stiffness * length)
        one, two = one * length / bending + shear, shear - two * length / bending
        A[rows[0], columns] = one, two
        A[rows[1], columns] = two, one
        A[rows[1], 3] = 1.0 if bar == 0 else -1.0
        turned[rows, 0] = 1.0 / length
        sagged = line_function(load * length**2 / bending) * length**3 / bending
        turned[rows, 1] = sagged, -sagged
        if not clamped:
            A[rows[0]] = 0.0
            A[rows[0], columns[0]] = 1.0
            turned[rows[0]] = 0.0
    by_v, by_line = np.linalg.solve(A, turned).T
    if line:  # its half at the hit point does the work of the moments and of the axial load
        rates = np.array([1.0 / lengths[0], sum(1.0 / x for x in lengths), 1.0 / lengths[1]])
        needed = rates @ by_v[:3] - rates[1] * load
        by_v = by_v + needed / (0.5 * column.length - rates @ by_line[:3]) * by_line
    base, hit, head, _ = (float(m) for m in by_v)
    chords = [1.0 / length for length in lengths]
    if sliding:
        for bar, end in enumerate((base, head)):
            chords[bar] -= (end + hit) / (shear_stiffness * lengths[bar])
    ends = [
        float("inf") if not clamped else chord / moment if moment != 0.0 else -1.0
        for chord, moment, (_, clamped) in zip(chords, (base, head), bars, strict=True)
    ]
    middle = sum(chords) / hit / column.length
    return Springs(ends[0], middle * lengths[0], middle * lengths[1], ends[1])
