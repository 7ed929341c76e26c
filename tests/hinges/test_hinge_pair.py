"""Two hinges in series with a bar: optimality, admissibility, tangents, limits of the surface."""

from __future__ import annotations

import numpy as np
import pytest
from builders import examples
from generalized_hinge import GeneralizedHinge
from hypothesis import given
from hypothesis import strategies as st

from workbench.steel.hinges import YieldSurface, kernels, panel_kernels

NP, MP = 3133230.0, 284720.0
KN, KT = 4.7775e9, 1.2743325e8
ELASTIC, CURVE, APEX, AXIS = kernels.ELASTIC, kernels.CURVE, kernels.APEX, kernels.AXIS


class Pair:
    """Two hinges and a bar; `solve` gives forces, tangent, plastic flow (2, 2) and branch."""

    def __init__(self, flexibility, bounds, exponents, pinned=(False, False)) -> None:
        self.flexibility = np.array(flexibility, float)
        self.bounds = np.array(bounds, float)
        self.exponents = np.array(exponents, float)
        self.pinned = np.array(pinned)

    @property
    def matrix(self) -> np.ndarray:
        f_n, f11, f14, f44 = self.flexibility
        return np.array([[f_n, 0.0, 0.0], [0.0, f11, f14], [0.0, f14, f44]])

    @property
    def scale(self) -> np.ndarray:
        """Elastic stiffness of each direction, to compare entries of tangents."""
        return 1.0 / np.sqrt(self.flexibility[[0, 1, 3]])

    def solve(self, elastic):
        forces, tangent, flow = np.empty(3), np.empty((3, 3)), np.empty(4)
        pair = panel_kernels.HingePair(self.flexibility, self.bounds, self.exponents, self.pinned)
        branch = panel_kernels.project_pair(pair, np.array(elastic), forces, tangent, flow)
        return forces, tangent, flow.reshape(2, 2), branch

    def used(self, forces) -> np.ndarray:
        """Left side of the yield condition of both hinges."""
        side = 0 if forces[0] >= 0.0 else 1
        n = np.abs(forces[0]) / self.bounds[:, side]
        m = np.abs(forces[1:]) / np.where(forces[1:] >= 0.0, self.bounds[:, 2], self.bounds[:, 3])
        return m ** self.exponents[:, 0] + n ** self.exponents[:, 1]

    def admissible(self, hinge: int, rng, count: int) -> np.ndarray:
        """Random (N, M) that a hinge admits (count, 2), many of them on its surface."""
        n = rng.choice([-1.0, 1.0], count) * rng.random(count) ** rng.choice([0.1, 1.0, 3.0], count)
        alpha, beta = self.exponents[hinge]
        m = np.clip(rng.uniform(-1.5, 1.5, count), -1.0, 1.0)
        m *= (1.0 - np.abs(n) ** beta) ** (1.0 / alpha) * (not self.pinned[hinge])
        tension, compression, positive, negative = self.bounds[hinge]
        return np.stack(
            [
                n * np.where(n > 0.0, tension, compression),
                m * np.where(m > 0.0, positive, negative),
            ],
            axis=1,
        )


@st.composite
def pairs(draw: st.DrawFn) -> tuple[Pair, np.ndarray]:
    """Two hinges of any kind and elastic trial deformations, up to 1e5 times those of yield."""
    exponent = st.one_of(st.sampled_from([1.0, 1.3, 1.5, 2.0, 3.0]), st.floats(1.0, 6.0))
    one = np.array([NP, NP, MP, MP])
    kind = draw(st.sampled_from(["alike", "weak end", "asymmetric"]))
    first = [draw(exponent), draw(exponent)]
    if kind == "alike":
        bounds, exponents = [one, one], [first, first]
    else:
        ratio = st.floats(0.2, 2.0)
        exponents = [first, [draw(exponent), draw(exponent)]]
        if kind == "weak end":
            bounds = [one, one * np.repeat([draw(ratio), draw(ratio)], 2)]
        else:
            bounds = [one * [draw(ratio) for _ in range(4)] for _ in range(2)]
    bar = draw(st.sampled_from([0.0, 0.05, 1.0])) / KT
    soft = st.floats(0.05, 2.0)
    flexibility = [
        draw(soft) / KN, draw(soft) / KT + 2.0 * bar, -bar, draw(soft) / KT + 2.0 * bar
    ]  # fmt: skip
    pinned = draw(st.sampled_from([(False, False)] * 4 + [(True, False), (False, True)]))
    far = 10.0 ** draw(st.floats(-0.5, 5.0))
    unit = st.one_of(st.just(0.0), st.floats(-1.0, 1.0))
    trial = np.array([NP, MP, MP]) * far * [draw(unit) for _ in range(3)]
    pair = Pair(flexibility, bounds, exponents, pinned)
    return pair, pair.matrix @ trial


@examples(600)
@given(pairs(), st.integers(0, 1000))
def test_forces_are_admissible_and_flow_is_normal(case, seed) -> None:
    """Variational inequality (P - Q) . flow <= 0 for all admissible P, in each hinge by itself."""
    pair, elastic = case
    forces, tangent, flow, _ = pair.solve(elastic)
    assert np.all(np.isfinite(forces))
    assert np.all(np.isfinite(tangent))
    assert np.max(pair.used(forces)[~pair.pinned], initial=0.0) <= 1.0 + 1e-13
    assert np.all(forces[1:][pair.pinned] == 0.0)
    # flows and elastic deformations add up
    rebuilt = pair.matrix @ forces + [flow[:, 0].sum(), flow[0, 1], flow[1, 1]]
    largest = max(np.abs(elastic).max(), np.abs(pair.matrix @ forces).max())
    assert rebuilt == pytest.approx(elastic, abs=1e-14 * largest + 1e-300)
    rng = np.random.default_rng(seed)
    for h in range(2):
        state = forces[[0, 1 + h]]
        increment = flow[h] * [1.0, not pair.pinned[h]]
        works = (pair.admissible(h, rng, 300) - state) @ increment
        scale = np.abs(forces[0] * flow[:, 0]).sum() + np.abs(forces[1:] * flow[:, 1]).sum()
        assert works.max() <= 2e-14 * scale + 1e-14 * abs(state) @ abs(increment)


@examples(400)
@given(pairs())
def test_tangent_is_symmetric_semi_definite_and_the_derivative(case) -> None:
    pair, elastic = case
    _, tangent, _, branch = pair.solve(elastic)
    scale = np.outer(pair.scale, pair.scale)
    assert np.array_equal(tangent, tangent.T)
    free = ~np.concatenate([[False], pair.pinned])
    assert np.linalg.eigvalsh((tangent / scale)[np.ix_(free, free)]).min() >= -1e-14
    yields = np.array([NP, MP, MP]) * pair.flexibility[[0, 1, 3]]
    trial = np.linalg.solve(pair.matrix, elastic) * pair.flexibility[[0, 1, 3]]
    if np.any(np.abs(trial)[free] <= 1e-5 * (yields + np.abs(elastic).max())[free]):
        return  # a plane of symmetry of the surfaces may be a kink
    for j in range(3):
        slopes, curved = [], []
        for length in (1e-6, 2e-6):
            step = np.zeros(3)
            step[j] = length * max(yields[j], abs(elastic[j]))
            more, less = pair.solve(elastic + step), pair.solve(elastic - step)
            slopes.append((more[0] - less[0]) / (2.0 * step[j]))
            curved.append(more[1] - less[1])
            if {more[3], less[3]} != {branch}:
                return  # next to a kink
        # a jump of the tangent within the steps is a kink as well
        if np.abs(curved[1] / scale).max() > 1e-3:
            return
        assert slopes[0] / scale[j] == pytest.approx(tangent[j] / scale[j], abs=1e-7)


@examples(300)
@given(
    st.sampled_from([1.0, 1.3, 2.0, 4.5]),
    st.sampled_from([1.0, 1.3, 2.0, 4.5]),
    st.floats(-1.0, 4.0),
    st.tuples(*[st.one_of(st.just(0.0), st.floats(-1.0, 1.0))] * 3),
)
def test_a_rigid_bar_with_like_hinges_is_the_diagonal_projection(alpha, beta, far, unit) -> None:
    """Two formulations: rotation by rotation along one curve, and pairs in a box."""
    stiffness = np.array([KN, KT, 2.0 * KT])
    elastic = np.array([NP, MP, MP]) * 10.0**far * unit / stiffness
    pair = Pair([1.0 / KN, 1.0 / KT, 0.0, 0.5 / KT], [[NP, NP, MP, MP]] * 2, [[alpha, beta]] * 2)
    forces, tangent, flow, branch = pair.solve(elastic)
    hinge = GeneralizedHinge(YieldSurface(NP, MP, alpha, beta), KN, (KT, 2.0 * KT))
    update = hinge.return_mapping(elastic, np.zeros(3))
    far_away = 1e-15 * np.max(np.abs(elastic * stiffness))
    assert forces == pytest.approx(update.forces, rel=1e-11, abs=1e-9 + far_away)
    total = np.array([flow[:, 0].sum(), *flow[:, 1]])
    assert total == pytest.approx(update.plastic, rel=1e-9, abs=1e-14 * np.abs(elastic).max())
    if branch == CURVE and update.branch == "curve":
        scale = np.sqrt(np.outer(stiffness, stiffness))
        assert tangent / scale == pytest.approx(update.tangent / scale, abs=1e-8)


def heb(alpha: float, beta: float, coupled: bool = True) -> Pair:
    bar = 1.0 / KT if coupled else 0.0
    flexibility = [1.0 / KN, 2.1 * bar + 0.1 / KT, -bar, 2.1 * bar + 0.1 / KT]
    return Pair(flexibility, [[NP, NP, MP, MP]] * 2, [[alpha, beta]] * 2)


def test_elastic_forces_are_those_of_the_flexible_bar() -> None:
    pair = heb(1.0, 1.3)
    elastic = pair.matrix @ [0.2 * NP, 0.3 * MP, -0.4 * MP]
    forces, tangent, flow, branch = pair.solve(elastic)
    assert branch == ELASTIC
    assert forces == pytest.approx([0.2 * NP, 0.3 * MP, -0.4 * MP], rel=1e-12)
    assert tangent == pytest.approx(np.linalg.inv(pair.matrix), rel=1e-12)
    assert not flow.any()


def test_a_bar_that_bends_is_relieved_by_the_far_hinge() -> None:
    """Only end 1 is turned: its hinge yields, and the moment at end 4 follows elastically."""
    pair = heb(1.0, 1.3)
    elastic = np.array([0.0, 1.5 * MP * pair.flexibility[1], 0.0])
    forces, tangent, flow, branch = pair.solve(elastic)
    assert branch == AXIS
    carried = -pair.flexibility[2] / pair.flexibility[3] * MP
    assert forces == pytest.approx([0.0, MP, carried], rel=1e-12)
    assert flow[1] == pytest.approx([0.0, 0.0])
    assert tangent[1] == pytest.approx([0.0, 0.0, 0.0])
    assert tangent[2, 2] == pytest.approx(1.0 / pair.flexibility[3])


@pytest.mark.parametrize("far", [1.5, 100.0])
def test_pure_axial_corner_carries_no_moment(far: float) -> None:
    """alpha = 1: a cone of deformations ends at N = N_p, M = 0, where the tangent vanishes."""
    pair = heb(1.0, 1.3)
    elastic = pair.matrix @ [-far * NP, 0.05 * (far - 1.0) * MP, -0.02 * (far - 1.0) * MP]
    forces, tangent, flow, branch = pair.solve(elastic)
    assert branch == APEX
    assert forces == pytest.approx([-NP, 0.0, 0.0], abs=1e-9)
    assert not tangent.any()
    assert flow[:, 0].sum() == pytest.approx(-(far - 1.0) * NP / KN)
    assert np.all(flow[:, 0] <= -np.abs(flow[:, 1]) * 1.3 * MP / NP)  # inside each normal cone


def test_pure_moment_corner_carries_no_axial_force() -> None:
    """beta = 1: a cone of deformations ends at N = 0, M = M_p."""
    pair = heb(2.0, 1.0)
    elastic = pair.matrix @ [0.1 * NP, 3.0 * MP, 3.0 * MP]
    forces, tangent, flow, branch = pair.solve(elastic)
    assert branch == AXIS
    assert forces == pytest.approx([0.0, MP, MP], abs=1e-9)
    assert not tangent.any()
    assert flow[0] == pytest.approx(flow[1])


@pytest.mark.parametrize("alpha", [1.3, 2.0, 3.0])
def test_a_straight_pull_reaches_the_smooth_apex(alpha: float) -> None:
    forces, tangent, flow, branch = heb(alpha, 2.0).solve([3.0 * NP / KN, 0.0, 0.0])
    assert branch == APEX
    assert forces == pytest.approx([NP, 0.0, 0.0])
    assert flow == pytest.approx(np.array([[NP / KN, 0.0], [NP / KN, 0.0]]))
    assert tangent[0] == pytest.approx([0.0, 0.0, 0.0])
    assert (tangent[1, 1] > 0.0) == (alpha >= 2.0)


@pytest.mark.parametrize("beta", [1.3, 2.0])
def test_a_round_apex_gives_way_to_moments_as_its_curvature_says(beta: float) -> None:
    """alpha = 2: of one apex the tangent is a derivative (of two it is not: the weaker leads)."""
    bar, far = 1.0 / KT, 2.5 * NP / KN
    soft = (far - NP / KN) * 2.0 * NP / (beta * MP**2)  # d2N / dM2 times what is stretched
    flexibility = [1.0 / KN, 2.1 * bar, -bar, 2.1 * bar]
    stronger = [3.0 * NP, 3.0 * NP, MP, MP]
    for bounds, at in (([[NP, NP, MP, MP], stronger], 0), ([stronger, [NP, NP, MP, MP]], 1)):
        pair, e = Pair(flexibility, bounds, [[2.0, beta]] * 2), np.array([far, 0.0, 0.0])
        _, tangent, _, branch = pair.solve(e)
        assert branch == APEX
        expected = pair.matrix[1:, 1:] + soft * np.outer(np.eye(2)[at], np.eye(2)[at])
        np.testing.assert_allclose(tangent[1:, 1:], np.linalg.inv(expected), rtol=1e-9)
        for j in (1, 2):
            away = 1e-7 * np.eye(3)[j]
            slope = (pair.solve(e + away)[0] - pair.solve(e - away)[0]) / 2e-7
            np.testing.assert_allclose(slope[1:], tangent[1:, j], rtol=1e-5)


def test_the_weaker_end_limits_the_axial_force() -> None:
    pair = Pair(
        [1.0 / KN, 1.0 / KT, -0.3 / KT, 1.0 / KT],
        [[NP, 0.5 * NP, MP, MP], [0.8 * NP, NP, 0.5 * MP, 0.2 * MP]],
        [[1.0, 1.3], [1.0, 2.0]],
    )
    pulled = pair.solve([50.0 * NP / KN, 0.0, 0.0])
    assert pulled[0][0] == pytest.approx(0.8 * NP)
    assert pulled[2][:, 0] == pytest.approx([0.0, 49.2 * NP / KN])
    pressed = pair.solve([-50.0 * NP / KN, 0.0, 0.0])
    assert pressed[0][0] == pytest.approx(-0.5 * NP)
    assert pressed[2][:, 0] == pytest.approx([-49.5 * NP / KN, 0.0])
    turned = pair.solve([0.0, 0.1, -0.1])
    assert turned[0] == pytest.approx([0.0, MP, -0.2 * MP], rel=1e-12)


def test_a_pin_carries_no_moment_and_turns_with_the_bar() -> None:
    pair = Pair(heb(1.0, 1.3).flexibility, [[NP, NP, MP, MP]] * 2, [[1.0, 1.3]] * 2, (True, False))
    forces, tangent, flow, branch = pair.solve([1e-5, 0.7, 1e-4])
    assert branch == ELASTIC
    moment = 1e-4 / pair.flexibility[3]
    assert forces == pytest.approx([1e-5 * KN, 0.0, moment])
    assert flow[0, 1] == pytest.approx(0.7 - pair.flexibility[2] * moment)
    assert not tangent[1].any()
    single = Pair([1.0 / KN, 1.0 / KT, 0.0, pair.flexibility[3]], pair.bounds, pair.exponents)
    far, alone = pair.solve([-4e-4, 0.3, 9e-3]), single.solve([-4e-4, 0.0, 9e-3])
    assert far[0] == pytest.approx(alone[0], rel=1e-12)


def test_deformations_that_are_not_finite_give_forces_that_are_not() -> None:
    forces, *_ = heb(1.0, 1.3).solve([np.nan, 0.0, 0.0])
    assert not np.all(np.isfinite(forces))
