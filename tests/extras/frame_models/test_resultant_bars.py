"""Sections known by N and M: rate equations, closed forms, brute force, tangents, dissipation."""

from __future__ import annotations

from itertools import pairwise
from math import exp

import numpy as np
import pytest
from assembly_cases import alone
from hypothesis import given
from hypothesis import strategies as st
from superelement_cases import EA, EI, MP, NP
from test_fiber_bars import law

from workbench.extras.frame_models.bars import (
    Bar,
    BarElements,
    PlasticEnd,
    fiber_bars,
    lobatto_rule,
)
from workbench.extras.frame_models.bars import fiber_kernels as kernels
from workbench.extras.frame_models.bars.resultant_kernels import STATES, modulus
from workbench.mechanics.structures.fibers import BeamSection, section_fibers
from workbench.mechanics.structures.fibers.section import LinearHardening, yielding_in_bending
from workbench.steel.hinges.interaction import polyline
from workbench.steel.sections import find, square

LENGTH, POINTS = 3.0, 5
SIZE, YIELD = np.array([NP, MP]), np.array([NP / EA, MP / EI])
ENERGY = MP * MP / EI  # J/m


def group(
    inner: float = 0.7,
    lag: float = 0.05,
    exponents: tuple[float, float] = (1.0, 1.3),
    weight: float = 0.0,
    softens: bool = False,
    beside: float = 0.0,
) -> BarElements:
    """One element along x; `lag` over M_p^2 / EI."""
    end = PlasticEnd((NP, NP), (MP, MP), polyline("exact", square(0.2)))
    bar = Bar(end, end, EA, EI, 71.0, second_order=False)
    law = LinearHardening(210e9, 355e6)
    radius = np.sqrt(EI / EA)
    fibers = BeamSection(radius * np.array([-1.0, 1.0]), np.full(2, 0.5 * EA / 210e9), law, 71.0)
    row = (EA, EI, NP, MP, *exponents, beside, inner, lag * ENERGY, weight, softens)
    made = fiber_bars([[0, 1]], [bar], [lobatto_rule(POINTS)], [fibers], False, resultants=[row])
    return alone(made, LENGTH)


class Point:
    """A section that is led from strain to strain."""

    def __init__(self, bars: BarElements) -> None:
        (self.tables,) = bars.tables
        self.row = self.tables.resultants[0]
        self.state = np.zeros((POINTS, STATES, 2))
        self.strain = np.zeros(2)

    def try_(self, strain: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Forces, tangent and state at a strain."""
        new = np.zeros_like(self.state)
        n, m, *k = kernels.respond(
            self.tables, 0, 0, np.inf, np.ascontiguousarray(strain), self.state, new
        )
        return np.array([n, m]), np.array([[k[0], k[1]], [k[1], k[2]]]), new

    def go(self, strain: np.ndarray) -> np.ndarray:
        """Commit a strain; forces there."""
        forces, _, self.state = self.try_(strain)
        self.strain = np.array(strain)
        return forces

    def differences(self, strain: np.ndarray) -> np.ndarray:
        """Tangent by central differences."""
        steps = np.diag(1e-6 * YIELD)
        columns = [self.try_(strain + h)[0] - self.try_(strain - h)[0] for h in steps]
        return np.stack(columns, axis=1) / (2e-6 * YIELD)


def outside(forces: np.ndarray, row) -> float:
    """Left side of the condition of the bounding surface, less one."""
    n, m = np.abs(forces) / SIZE
    return float(m ** row["alpha"] + n ** row["beta"] - 1.0)


strains = st.lists(
    st.tuples(*[st.floats(-3.0, 3.0)] * 2, st.floats(-2.0, 1.0)), min_size=2, max_size=12
)


@given(strains, st.floats(0.5, 0.99), st.floats(-3.0, 0.0), st.booleans())
def test_surfaces_are_nested_and_nothing_is_gained(path, inner, lag, softens) -> None:
    """Whatever the path: no force outside, the surfaces do not cross, plastic work not negative."""
    bars = group(inner, 10.0**lag, softens=softens, weight=0.65)
    point = Point(bars)
    for n, m, scale in path:
        before = point.state[0].copy()
        forces = point.go(point.strain + 10.0**scale * YIELD * np.array([n, m]))
        assert outside(forces, point.row) < 1e-9
        centre = point.state[0, 1]
        assert outside(centre / (1.0 - inner), point.row) < 1e-9
        assert outside((forces - centre) / inner, point.row) < 1e-9
        work = point.state[0, 2] @ (point.state[0, 0] - before[0])
        assert work >= -1e-14 * NP * YIELD[0]


@pytest.mark.parametrize("softens", [False, True])
@pytest.mark.parametrize("exponents", [(1.0, 1.3), (1.7, 2.0), (1.0, 1.0)])
def test_tangent_is_symmetric_and_equals_differences(exponents, softens) -> None:
    rng, off, cases = np.random.default_rng(5), 0, 0
    for _ in range(25):
        point = Point(
            group(rng.uniform(0.5, 1.0), 10.0 ** rng.uniform(-3, 0), exponents, 0.3, softens)
        )
        for _ in range(8):
            strain = point.strain + 10.0 ** rng.uniform(-2, 0.7) * YIELD * rng.standard_normal(2)
            _, tangent, _ = point.try_(strain)
            error = (tangent - point.differences(strain)) / np.sqrt(np.outer([EA, EI], [EA, EI]))
            off += np.abs(error).max() > 1e-4
            assert np.linalg.eigvalsh(tangent / np.sqrt(np.outer([EA, EI], [EA, EI]))).min() > -1e-9
            cases += 1
            point.go(strain)
    assert off <= cases // 100  # differences across a corner


def gradient(s: np.ndarray, alpha: float, beta: float) -> np.ndarray:
    """Normal of the bounding surface at s, whose product with s is one."""
    n, m = s / SIZE
    normal = np.array(
        [
            beta * abs(n) ** (beta - 1.0) * np.sign(n) / NP,
            alpha * abs(m) ** (alpha - 1.0) * np.sign(m) / MP,
        ]
    )
    return normal / (normal @ s)


def rates(path: np.ndarray, inner: float, lag: float, exponents: tuple[float, float]) -> np.ndarray:
    """Forces at the end of a path of strains (n, 2), by explicit steps of the rate equations."""
    stiffness, s, a = np.array([EA, EI]), np.zeros(2), np.zeros(2)
    for step in np.diff(path, axis=0):
        on = (s - a) / inner
        inside = (np.abs(on / SIZE) ** np.array(exponents[::-1])).sum() < 1.0
        change = stiffness * step
        if not inside:
            normal = gradient(on, *exponents)
            if normal @ change > 0.0:
                apart = (1.0 - inner) - normal @ a
                modulus = apart**2 / lag
                multiplier = normal @ change / (normal @ (stiffness * normal) + modulus)
                change -= multiplier * stiffness * normal
                a = a + multiplier * apart / lag * ((1.0 - inner) * on - a)
        s = s + change
        grown = (np.abs((s - a) / inner / SIZE) ** np.array(exponents[::-1])).sum()
        if grown > 1.0:  # back along the ray: explicit steps drift off
            s = a + (s - a) / grown ** (1.0 / max(exponents))
    return s


@pytest.mark.thorough
def test_steps_converge_to_the_rate_equations() -> None:
    """Normal flow, movement after Mroz, modulus by the distance squared: order one in the step."""
    inner, lag, exponents = 0.6, 0.05 * ENERGY, (1.4, 1.8)
    corners = np.array([[0.0, 0.0], [0.5, 1.0], [1.2, 2.5], [1.0, 5.0]]) * YIELD

    def along(count: int) -> np.ndarray:
        parts = [np.linspace(a, b, count, endpoint=False) for a, b in pairwise(corners)]
        return np.concatenate([*parts, corners[-1:]])

    exact = rates(along(20_000), inner, lag, exponents)
    errors = []
    for count in (10, 20, 40):
        point = Point(group(inner, 0.05, exponents))
        for strain in along(count)[1:]:
            forces = point.go(strain)
        errors.append(np.abs((forces - exact) / SIZE).max())
    assert errors[2] < 4e-3
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.35)
    assert errors[1] / errors[2] == pytest.approx(2.0, rel=0.35)


def energy(s: np.ndarray, trial: np.ndarray, slow: float, t: float) -> np.ndarray:
    """What a step makes least; `slow` is g in J/m."""
    gap = (s - trial) ** 2 / np.array([EA, EI])
    return 0.5 * gap.sum(axis=-1) + slow * (-t - np.log1p(-t))


def test_a_step_is_the_minimum_found_by_brute_force() -> None:
    rng, angle = np.random.default_rng(2), np.linspace(0.0, 2.0 * np.pi, 721)
    shares = 1.0 - np.geomspace(1.0, 1e-4, 200)
    for _ in range(20):
        inner, lag, exponents = rng.uniform(0.5, 0.95), 10.0 ** rng.uniform(-2, 0), (1.0, 1.3)
        point = Point(group(inner, lag, exponents))
        point.go(3.0 * YIELD * rng.standard_normal(2))
        strain = point.strain + 3.0 * YIELD * rng.standard_normal(2)
        before, (forces, _, new) = point.state[0], point.try_(strain)
        trial = np.array([EA, EI]) * (strain - before[0])
        if np.array_equal(forces, trial):
            continue
        slow = lag * ENERGY * (1.0 + before[4, 1] / (1.0 - inner)) ** 2
        curve = np.stack([np.sin(angle), np.cos(angle)], axis=-1)
        exponent = np.array(exponents[::-1])
        curve = np.sign(curve) * np.abs(curve) ** (2.0 / exponent) * SIZE
        sampled = [
            energy((1 - t) * before[1] + (inner + t * (1 - inner)) * curve, trial, slow, t).min()
            for t in shares
        ]
        # the share that the centre has gone, from where it is now
        way = (1.0 - inner) * (forces - new[0, 1]) / inner - before[1]
        share = float((new[0, 1] - before[1]) @ (way / SIZE**2) / (way @ (way / SIZE**2)))
        least = float(energy(forces, trial, slow, share))
        assert least <= min(sampled) + 1e-9 * ENERGY
        assert least == pytest.approx(min(sampled), rel=5e-3)


def test_bending_in_closed_form_and_half_cycles_twice_as_large() -> None:
    """1 - m = d / (1 + d k), and from the other side the same curve in twice the size (Masing)."""
    inner, lag, count = 0.7, 0.05, 4000
    apart, point = 1.0 - inner, Point(group(inner, lag))
    for curvature in np.linspace(0.0, 40.0, count):
        moment = point.go(np.array([0.0, curvature * YIELD[1]]))[1]
    plastic = point.state[0, 0, 1] / YIELD[1]
    assert 1.0 - moment / MP == pytest.approx(apart / (1.0 + apart * plastic / lag), rel=0.02)
    top, held = point.strain[1], point.state[0, 0, 1]
    reverse = []
    for back in np.concatenate([[0.5], np.linspace(2.0 * inner, 6.0, count)]):
        moment = point.go(np.array([0.0, top - back * YIELD[1]]))[1]
        reverse.append((1.0 + moment / MP, (held - point.state[0, 0, 1]) / YIELD[1]))
    left, plastic = np.array(reverse)[-1]
    start = float(2.0 - 2.0 * inner)
    assert left == pytest.approx(start / (1.0 + start * plastic / (4.0 * lag)), rel=0.02)


def test_one_surface_is_the_sharp_hinge() -> None:
    """As the inner surface becomes the outer one, forces go to the closest point of it."""
    rng = np.random.default_rng(8)
    sharp, errors = group(1.0, 0.0), []
    for inner in (0.9, 0.99, 0.999):
        worst = 0.0
        for _ in range(40):
            strain = 3.0 * YIELD * rng.standard_normal(2)
            forces = [
                Point(bars).try_(strain)[0] for bars in (sharp, group(inner, 0.1 * (1 - inner)))
            ]
            worst = max(worst, float(np.abs((forces[1] - forces[0]) / SIZE).max()))
        errors.append(worst)
    assert errors[0] < 0.1
    assert errors[1] < 0.12 * errors[0]
    assert errors[2] < 0.12 * errors[1]


def test_tangent_modulus_under_axial_force_in_closed_form() -> None:
    """dp = (1 + 2 p)(1 - p) dx from p = 1/2 on: (1 + 2 p) / (1 - p) = 4 exp(3 x - 3 / 2)."""
    ratio = 4.0 * exp(3.0 * 1.2 - 1.5)
    exact, errors = (ratio - 1.0) / (ratio + 2.0), []
    for count in (30, 60, 120):
        point = Point(group(1.0, 0.0, softens=True))
        for strain in np.linspace(0.0, -1.2, count + 1)[1:]:
            forces = point.go(np.array([strain * YIELD[0], 0.0]))
        errors.append(-forces[0] / NP - exact)
    assert errors[2] < 3e-3
    assert errors[0] / errors[2] == pytest.approx(4.0, rel=0.25)  # modulus of the last step


@pytest.mark.parametrize(
    ("p", "m", "weight"), [(0.3, 0.0, 0.0), (0.6, -0.2, 0.0), (0.5, 0.3, 0.65)]
)
def test_stiffness_is_the_relation_and_unloading_elastic(p, m, weight) -> None:
    bars = group(1.0, 0.0, softens=True, weight=weight)
    point = Point(bars)
    for _ in range(400):  # to p, then to m
        forces, tangent, _ = point.try_(point.strain)
        axial = -p * NP - forces[0]
        point.go(point.strain + np.array([axial / EA, 0.0]))
    for _ in range(400):
        forces, tangent, _ = point.try_(point.strain)
        point.go(point.strain + np.array([0.0, (m * MP - forces[1]) / EI]))
    share = min(1.0, (1.0 + 2.0 * p) * (1.0 - p - weight * m))
    _, tangent, _ = point.try_(point.strain)
    assert tangent[1, 1] / EI == pytest.approx(share, rel=1e-3)
    assert tangent[0, 0] / EA == pytest.approx(share, rel=1e-3)
    off = np.array([1e-3, -np.copysign(1e-3, m)]) * YIELD
    _, tangent, _ = point.try_(point.strain + off)
    if m:
        assert tangent == pytest.approx(np.diag([EA, EI]), rel=1e-12)


@pytest.mark.parametrize("softens", [False, True])
def test_equilibrium_and_tangent_of_an_element(softens: bool) -> None:
    bars = group(1.0 if softens else 0.7, softens=softens, beside=1e-6)
    rng, rule = np.random.default_rng(4), lobatto_rule(POINTS)
    size = np.array([NP, MP, MP])
    scale = np.array([YIELD[0] * LENGTH, *[YIELD[1] * LENGTH / 3.0] * 2])

    off = lost = 0
    for _ in range(40):
        q, state = np.zeros(3), None
        for _ in range(4):
            q = q + 10.0 ** rng.uniform(-1, 0.7) * scale * rng.standard_normal(3)
            new, k = law(bars, q, state)
            forces, strains, sections = new.local[0], new.strains[0], new.fibers[0]
            if not np.isfinite(forces).all():
                lost += 1
                break
            total = np.zeros(3)
            for x, w, e, section in zip(rule.xi, rule.weights, strains, sections, strict=True):
                n, m = section[2] + 1e-6 * np.array([EA, EI]) * (e - section[2] / [EA, EI])
                assert n == pytest.approx(forces[0], abs=1e-6 * NP)
                assert m == pytest.approx((x - 1) * forces[1] + x * forces[2], abs=1e-6 * MP)
                total += w * LENGTH * np.array([1.0, x - 1.0, x]) * e[[0, 1, 1]]
            assert total / scale == pytest.approx(q / scale, abs=1e-8)
            differences = np.empty((3, 3))
            for j, h in enumerate(np.diag(1e-6 * scale)):
                plus, minus = (law(bars, q + s * h, state)[0].local[0] for s in (1.0, -1.0))
                differences[:, j] = (plus - minus) / 2e-6
            off += np.abs((k * scale - differences) / size[:, None]).max() > 1e-3
            state = new
    assert off <= 4  # differences across a corner
    assert lost <= 1  # steps of up to five times yield in one


@pytest.mark.parametrize("pattern", ["none", "triangular", "parabolic"])
@pytest.mark.parametrize(("axial", "most"), [(0.0, 0.025), (0.3, 0.06), (0.6, 0.05)])
def test_moments_are_those_of_fibers(pattern: str, axial: float, most: float) -> None:
    """HEB 220 at constant N, curvature up to ten times that at yield: within 2.5 to 6 % of M_p."""
    section = find("HEB 220").without_fillets()
    fibers = section_fibers(section, 40, pattern)
    limit, modulus = 355e6, 210e9
    residual = limit * fibers.residual
    law = LinearHardening(modulus, limit)
    strips = BeamSection(fibers.y, fibers.area, law, 71.0, initial_stress=residual)
    inner, slowness = yielding_in_bending(strips)
    point = Point(group(inner, slowness * EI / MP, section.interaction_fit()))
    full = limit * np.sum(np.abs(fibers.y) * fibers.area)
    bending = modulus * np.sum(fibers.y**2 * fibers.area)
    squash = limit * fibers.area.sum()

    def moment(curvature: float) -> float:
        low, high = -0.05, 0.05
        for _ in range(50):
            strain = 0.5 * (low + high)
            stress = np.clip(modulus * (strain + fibers.y * curvature) + residual, -limit, limit)
            low, high = (strain, high) if stress @ fibers.area < axial * squash else (low, strain)
        return float(stress @ (fibers.y * fibers.area)) / full

    strain = 0.0
    for k in np.concatenate([[0.0], np.linspace(0.05, 3.0, 60), np.linspace(3.2, 10.0, 15)]):
        low, high = strain - 20.0 * YIELD[0], strain + 20.0 * YIELD[0]
        for _ in range(40):
            strain = 0.5 * (low + high)
            forces = point.try_(np.array([strain, k * YIELD[1]]))[0]
            low, high = (strain, high) if forces[0] < axial * NP else (low, strain)
        forces = point.go(np.array([strain, k * YIELD[1]]))
        if k > 0.0:
            assert forces[1] / MP == pytest.approx(moment(k * full / bending), abs=most)


def test_sizes_of_the_surfaces_by_hand() -> None:
    """A rectangle yields at 2/3 of M_p and has gone half of the way at m = 5/6, k = sqrt 2."""
    y, area = square(0.2).fibers(400)
    law = LinearHardening(210e9, 355e6)
    inner, slowness = yielding_in_bending(BeamSection(y, area, law, 1.0))
    first = 355e6 / 210e9 / 0.1
    assert inner == pytest.approx(2.0 / 3.0, rel=0.01)
    assert slowness == pytest.approx((np.sqrt(2.0) - 1.25) * first / 3.0, rel=0.05)
    sharp, none = yielding_in_bending(BeamSection(y, area, law, 1.0), 1.0)
    assert (sharp, none) == (1.0, 0.0)


def tangents_of_fibers(minor: bool, p: float, moments: list[float]) -> list[float]:
    """Bending stiffness over EI of HEB 220 plates with ECCS residual stress, at N and moments.

    Over p = N / N_p and M / M_p, cut into fibers both ways: dM / d(curvature) at constant N.
    """
    shape, limit, modulus, n = find("HEB 220").without_fillets().shape, 235e6, 205e9, 32

    def middles(parts: int, width: float) -> np.ndarray:
        edges = np.linspace(-0.5, 0.5, parts + 1) * width
        return 0.5 * (edges[1:] + edges[:-1])

    b, h, tw, tf = shape.width, shape.height, shape.web, shape.flange
    flange, web = middles(n, b), middles(n, h - 2.0 * tf)
    plates = [
        (
            flange,
            np.full(n, side * (h - tf) / 2.0 + y),
            b * tf / 4.0 / n,
            1.0 - 4.0 * np.abs(flange) / b,
        )
        for side in (1.0, -1.0)
        for y in middles(4, tf)
    ]
    plates += [
        (
            np.full(n, x),
            web,
            (h - 2.0 * tf) * tw / 4.0 / n,
            4.0 * np.abs(web) / (h - 2.0 * tf) - 1.0,
        )
        for x in middles(4, tw)
    ]
    z = np.concatenate([plate[0 if minor else 1] for plate in plates])
    area = np.concatenate([np.full(n, plate[2]) for plate in plates])
    residual = 0.5 * limit * np.concatenate([plate[3] for plate in plates])
    full, bent, left = limit * np.abs(z) @ area, [], []
    for k in np.concatenate([np.linspace(0.0, 2.0, 40), np.geomspace(2.1, 10.0, 15)]):
        curvature, low, high = k * limit / modulus / z.max(), -0.03, 0.03
        for _ in range(30):
            strain = 0.5 * (low + high)
            stress = np.clip(modulus * (z * curvature - strain) + residual, -limit, limit)
            low, high = (strain, high) if -stress @ area < p * limit * area.sum() else (low, strain)
        elastic = (np.abs(stress) < limit) * area
        bent.append(stress @ (z * area) / full)
        rest = elastic @ z**2 - (elastic @ z) ** 2 / max(elastic.sum(), 1e-12)
        left.append(rest / (area @ z**2))
    return [float(np.interp(m, bent, left)) if m < bent[-1] else 0.0 for m in moments]


def test_the_relation_is_near_fibers_with_residual_stress() -> None:
    """Its 0.65 is that of the minor axis: off by 0.07 in the mean, by 0.37 without it."""
    moments, errors = [0.0, 0.2, 0.4, 0.6, 0.8], {0.65: [], 0.0: []}
    for p in (0.0, 0.2, 0.4, 0.6, 0.8):
        fibers = tangents_of_fibers(True, p, moments)
        for weight, gaps in errors.items():
            gaps += [modulus(p, 1.0 - weight * m) - t for m, t in zip(moments, fibers, strict=True)]
    mean = {weight: float(np.mean(np.abs(gaps))) for weight, gaps in errors.items()}
    assert mean[0.65] < 0.1
    assert mean[0.0] > 2.0 * mean[0.65]
    major = [tangents_of_fibers(False, p, [0.0])[0] - modulus(p, 1.0) for p in (0.4, 0.6, 0.7, 0.8)]
    assert 0.0 <= min(major) <= max(major) < 0.16  # residual stress alone, without crookedness
