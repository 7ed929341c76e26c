"""Kinds of bars: hinges of zero length, refined plastic hinges, fiber sections along the bar."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from workbench.base.arrays import Array, Flags, Indices
from workbench.extras.frame_models.bars import (
    beam_kernels,
    fiber_kernels,
    kernels,
    resultant_kernels,
)
from workbench.extras.frame_models.bars.group import Bar, BarElements, first_order_stiffness
from workbench.mechanics.structures.fibers.section import (
    BeamSection,
    SectionTables,
    lobatto,
    section_tables,
)


class BarState(NamedTuple):
    """State of all bars.

    `local` (e, 3): N, M_1, M_4; `deformation` (e, 3): elongation and end rotations against the
    chord; `plastic` (e, 3) parts of these; `back` (e, 2): backstresses of the hinges; `spread`
    (e, 2): their accumulated plastic rotations; shares of their strength (e, 2): the `strength`
    that the forces met, and what is `left` of it for the next step.
    """

    local: Array
    deformation: Array
    plastic: Array
    back: Array
    spread: Array
    strength: Array
    left: Array


class BarTables(NamedTuple):
    """Bars as arrays for the kernels.

    `rows` (e,), records of BAR; `corners` (e, 2, corners, 3) and `counts` (e, 2), see `hinged_law`;
    elastic `stiffness` (e, 3, 3) of first order, of which the share `eta` always acts beside the
    hinges; `rotation` and `softness` (e, 2) of hinges that wear, see `PlasticEnd`; if `gradual`,
    shares of both moments at `first` yield (e, 2, corners, 2) and `curves` (e, 2, 2, points).
    """

    rows: Any
    corners: Array
    counts: Indices
    stiffness: Array
    eta: float
    rotation: Array
    softness: Array
    gradual: bool
    first: Array
    curves: Array


def _elastic(rows: Any, state: Any) -> tuple[Array, float]:
    """Elastic deformations (elements, 3) under the forces of a state, and their energy in J."""
    deformation, stored = np.empty_like(state.local), np.empty(len(state.local))
    kernels.elastic(rows, state.local, deformation, stored)
    return deformation, float(stored.sum())


def hinged_bars(
    nodes: ArrayLike, bars: Sequence[Bar], regularisation: float = 1e-6, first_order: bool = False
) -> BarElements:
    """Bars with plastic hinges of zero length at both ends.

    `regularisation`, the share of the elastic stiffness beside the hinges.
    """
    softness = np.array([[end.softness for end in (bar.start, bar.end)] for bar in bars])

    def elastic(rows: Any, state: BarState) -> tuple[Array, float]:
        if softness.any():
            springs = softness * (1.0 / state.strength - 1.0)
            rows = rows.copy()
            rows["spring1"] += springs[:, 0]
            rows["spring4"] += springs[:, 1]
        return _elastic(rows, state)

    def tables(rows: Any, _lengths: Array) -> BarTables:
        sides = [side for bar in bars for side in bar.corners()]
        corners = np.zeros((len(sides), max(len(side) for side in sides), 3))
        for row, side in zip(corners, sides, strict=True):
            row[: len(side)] = side
        both = corners.reshape(len(bars), 2, -1, 3)
        ends = [(bar.start, bar.end) for bar in bars]
        axial = np.array([[end.axial for end in pair] for pair in ends]).swapaxes(1, 2)
        share = np.array([[end.first_yield for end in pair] for pair in ends])
        reach = np.maximum(1.0 - both[..., :1] / axial[:, :, None], 0.0)
        gradual = all(end.spread is not None for pair in ends for end in pair)
        at_once = np.array([[0.0, 1.0], [1.0, 1.0]])
        curves = [[at_once if end.spread is None else end.spread for end in pair] for pair in ends]
        return BarTables(
            rows,
            both,
            np.array([len(side) for side in sides]).reshape(-1, 2),
            np.stack([first_order_stiffness(row) for row in rows]),
            regularisation,
            np.array([[end.rotation for end in pair] for pair in ends]),
            softness,
            gradual,
            share[:, None, None] * reach,
            np.array(curves) if gradual else np.tile(at_once, (len(ends), 2, 1, 1)),
        )

    empty = (3, 0.0), (3, 0.0), (3, 0.0), (2, 0.0), (2, 0.0), (2, 1.0), (2, 1.0)
    state = BarState(*(np.full((len(bars), width), value) for width, value in empty))
    return BarElements(nodes, bars, kernels, state, tables, elastic, first_order)


class RefinedState(NamedTuple):
    """State of refined plastic hinges.

    `local` and `deformation` (e, 3) as of `BarState`; `plastic` elongation (e,); end moments
    `moment` and the rotations that bend it, `turn` (e, 2).
    """

    local: Array
    deformation: Array
    plastic: Array
    moment: Array
    turn: Array


class RefinedTables(NamedTuple):
    """Bars as arrays for the kernels.

    `rows`, `stiffness` and `eta` as of `BarTables`; `squash` loads (e, 2) in tension and
    compression; `reduction` of E; `radius` (e,) of gyration for the double modulus (0: tangent
    modulus); `scale` (e, 3), deformations at yield.
    """

    rows: Any
    squash: Array
    reduction: float
    radius: Array
    scale: Array
    stiffness: Array
    eta: float


def refined_bars(
    nodes: ArrayLike,
    bars: Sequence[Bar],
    reduction: float = 1.0,
    double: bool = False,
    regularisation: float = 1e-6,
    first_order: bool = False,
) -> BarElements:
    """Bars with stability functions, tangent modulus and gradual hinges at both ends.

    `reduction` of the elastic modulus; `double` instead of tangent modulus where the compression of
    a flange falls; `regularisation` as of `hinged_bars`.
    """
    stiffness = [(bar.bending_stiffness, bar.axial_stiffness) for bar in bars]
    radius = np.array([np.sqrt(bending / axial) if double else 0.0 for bending, axial in stiffness])

    def tables(rows: Any, _lengths: Array) -> RefinedTables:
        ends = [(bar.start, bar.end) for bar in bars]
        squash = np.array([np.min([end.axial for end in pair], axis=0) for pair in ends])
        turn = np.array([max(*a.moments, *b.moments) for a, b in ends]) * rows["bending"]
        return RefinedTables(
            rows,
            squash,
            reduction,
            radius,
            np.stack([squash.max(axis=1) * rows["axial"], turn, turn], axis=1),
            np.stack([first_order_stiffness(row) for row in rows]),
            regularisation,
        )

    def elastic(rows: Any, state: RefinedState) -> tuple[Array, float]:  # with E_t
        stretch = state.local[:, :1] * rows["axial"][:, None]
        deformation = np.concatenate([stretch, state.turn], axis=1)
        return deformation, 0.5 * float(np.sum(state.local * deformation))

    widths = ((3,), (3,), (), (2,), (2,))
    state = RefinedState(*(np.zeros((len(bars), *width)) for width in widths))
    return BarElements(nodes, bars, beam_kernels, state, tables, elastic, first_order, False)


class Quadrature(NamedTuple):
    """Rule along one element: points `xi` in 0..1, `weights`, which are `elastic`."""

    xi: Array
    weights: Array
    elastic: Flags


def lobatto_rule(points: int) -> Quadrature:
    """Gauss-Lobatto points, fibers at all."""
    return Quadrature(*lobatto(points), np.zeros(points, dtype=bool))


def hinge_rule(share: float) -> Quadrature:
    """Fibers at both ends, over a `share` of the length each; elastic points between.

    Two-point Gauss-Radau over four hinge lengths at each end, of which the inner point is elastic,
    and two Gauss points between: exact while all is elastic (Scott and Fenves 2006).
    """
    s = min(share, 0.125)
    half, root = 0.5 - 4.0 * s, 1.0 / np.sqrt(3.0)
    side = [0.0, 8.0 / 3.0 * s, 0.5 - half * root]
    weights = [s, 3.0 * s, half]
    elastic = [False, True, True]
    return Quadrature(
        np.array([*side, *(1.0 - x for x in reversed(side))]),
        np.array([*weights, *reversed(weights)]),
        np.array([*elastic, *reversed(elastic)]),
    )


class FiberBarState(NamedTuple):
    """State of all elements.

    `local` and `deformation` (e, 3) as of `BarState`; `strains` (e, points, 2), axial strain and
    curvature; `fibers` (e, points, states, f).
    """

    local: Array
    deformation: Array
    strains: Array
    fibers: Array


class FiberBarTables(NamedTuple):
    """Tables for the kernels besides bars and states.

    `xi`, `weights` and `elastic` (e, points) of the rule; `lengths` (e,); `rest` (e, 3, 3),
    flexibility of joints and shear; `pinned` (e, 2); `scale` (e, 2) of N and M; `modulus`, `area`,
    `second` moment (e,) of the elastic points; `sections` of fibers, or `resultants` (e,), records
    of RESULTANT in their place.
    """

    xi: Array
    weights: Array
    elastic: Flags
    lengths: Array
    rest: Array
    pinned: Flags
    scale: Array
    modulus: Array
    area: Array
    second: Array
    sections: SectionTables
    resultants: Any


def fiber_bars(
    nodes: ArrayLike,
    bars: Sequence[Bar],
    rules: Sequence[Quadrature],
    sections: Sequence[BeamSection],
    first_order: bool = False,
    resultants: Sequence[tuple[Any, ...]] = (),
) -> BarElements:
    """Force-based beams: fiber sections at the points of `rules`, as many in all of them.

    `resultants`, entries of RESULTANT of every bar: sections known by N and M; `sections` then give
    elastic stiffness and mass alone.
    """
    count, points = len(bars), len(rules[0].xi)
    fibers = section_tables(np.arange(count), sections)
    state_of_fibers = max(section.law.states for section in sections), fibers.y.shape[1]
    shape = (resultant_kernels.STATES, 2) if resultants else state_of_fibers
    modulus = np.array([section.law.elastic_modulus for section in sections])

    def tables(rows: Any, lengths: Array) -> FiberBarTables:
        area = np.sum(fibers.area, axis=1)
        rest = np.zeros((count, 3, 3))
        rest[:, 0, 0] = [bar.axial_springs for bar in bars]
        rest[:, 1:, 1:] = rows["shear"][:, None, None]
        rest[:, 1, 1] += rows["spring1"]
        rest[:, 2, 2] += rows["spring4"]
        force = modulus * area * 1e-3
        return FiberBarTables(
            np.stack([rule.xi for rule in rules]),
            np.stack([rule.weights for rule in rules]),
            np.stack([rule.elastic for rule in rules]),
            lengths,
            rest,
            np.stack([rows["pinned1"], rows["pinned4"]], axis=1),
            np.stack([force, force * 2.0 * np.max(np.abs(fibers.y), axis=1)], axis=1),
            modulus,
            area,
            fibers.second,
            fibers,
            np.array(list(resultants), dtype=resultant_kernels.RESULTANT),
        )

    state = FiberBarState(
        np.zeros((count, 3)),
        np.zeros((count, 3)),
        np.zeros((count, points, 2)),
        np.zeros((count, points, *shape)),
    )
    return BarElements(nodes, bars, fiber_kernels, state, tables, _elastic, first_order)
