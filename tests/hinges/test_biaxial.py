"""The hinge in space: its exact domain and the projection of two hinges onto it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.base.arrays import Array
from workbench.steel.hinges import BiaxialSurface
from workbench.steel.hinges import biaxial_kernels as kernels
from workbench.steel.sections import Section, find, section_from

HEB = find("HEB 220").without_fillets()
SHS = section_from({"height": 0.2, "width": 0.2, "wall": 0.01})
SECTIONS = {
    "HEB 220": HEB,
    "with fillets": find("HEB 220"),
    "IPE 300": find("IPE 300").without_fillets(),
    "SHS": SHS,
    "RHS": section_from({"height": 0.3, "width": 0.2, "wall": 0.01}),
    "square": section_from({"side": 0.2}),
    "CHS": section_from({"diameter": 0.2191, "wall": 0.01}),
}
# flow, D and its gradient: integrated independently of the closed forms
GOLDEN = (
    (HEB, (0, 1, 1), 1.29721870, (0.0, 0.51032496, 0.78689374)),
    (HEB, (0.2, 1, 1), 1.30756314, (0.10344437, 0.50641257, 0.78046169)),
    (HEB, (1, 1, 1), 1.55577123, (0.51481111, 0.41506738, 0.62589274)),
    (HEB, (0.5, 1, 0.2), 1.02446739, (0.09780973, 0.97553261, 0.00014959)),
    (HEB, (0.1, 0.2, 1), 1.02658546, (0.12996986, 0.15206848, 0.98317478)),
    (HEB, (1, 0, 1), 1.35232165, (0.52395907, 0.0, 0.82836258)),
    (SHS, (0, 1, 1), 4.0 / 3.0, (0.0, 2.0 / 3.0, 2.0 / 3.0)),
    (SHS, (0.5, 1, 0.5), 1.13025162, (0.18767313, 0.86974838, 1.0 / 3.0)),
)
# trial and projected N, My1, Mz1, My2, Mz2 over the plastic forces
PROJECTED = (
    ((-0.5, 1.5, 0, 0.5, 0), (-0.37036917, 0.71842251, 0, 0.5, 0)),
    ((-0.5, 0, 1.5, 0, 0.5), (-0.45080827, 0, 0.89319404, 0, 0.5)),
    ((0.3, 1, 1, -1, 0.5), (0.26121617, 0.62541653, 0.58316408, -0.78411313, 0.34076198)),
    ((2, 0.5, 0.5, 0.5, 0.5), (1, 0, 0, 0, 0)),
    ((-0.16, 3, 3, -3, -3), (-0.07601132, 0.67764, 0.57887105, -0.67764, -0.57887105)),
    ((0, 10, 5, 1, 8), (0, 0.99994696, 0.00028168, 0.16397013, 0.98713925)),
)
each_section = pytest.mark.parametrize("section", SECTIONS.values(), ids=SECTIONS)


def stiffness(section: Section, rigid: bool = True, length: float = 0.8) -> Array:
    """Stiffness over the plastic forces of a bar of HEB 220's ratios, rigid or flexible."""
    E, f_y, area = 210e9, 355e6, 0.0091
    seconds = np.array([8.091e-5, 2.843e-5] * 2)
    F = np.diag([length / (E * area), *(length / (6.0 * E * seconds))])
    if not rigid:
        for i in (1, 2):
            F[i, i] = F[i + 2, i + 2] = 0.35 * length / (E * seconds[i - 1])
            F[i, i + 2] = F[i + 2, i] = -length / (6.0 * E * seconds[i - 1])
    plastic = f_y * np.array([8.826e-3, *[8.02022e-4, 3.9144175e-4] * 2])
    K: Array = np.linalg.inv(F) / np.outer(plastic, plastic)
    return K


class Hinges:
    """Two hinges on a bar, with the room of their projection."""

    def __init__(self, section: Section, K: Array) -> None:
        self.surface, self.K = BiaxialSurface(section), K
        self.room = np.zeros(1, kernels.ROOM)[0]

    def project(self, E: Array) -> int:
        """Project elastic deformations, from a cold start."""
        self.room["aim"] = 0.0
        return int(kernels.project(self.surface.record, self.K, E, self.room))


@pytest.mark.parametrize(("section", "flow", "dissipation", "forces"), GOLDEN)
def test_golden_dissipation(
    section: Section, flow: tuple[float, ...], dissipation: float, forces: tuple[float, ...]
) -> None:
    D, g, _ = BiaxialSurface(section).support(flow)
    assert pytest.approx(dissipation, abs=1e-8) == D
    assert g == pytest.approx(forces, abs=1e-8)


@each_section
def test_gradient_and_hessian_are_those_of_differences(section: Section) -> None:
    surface, rng = BiaxialSurface(section), np.random.default_rng(1)
    for _ in range(100):
        d = rng.normal(size=3) * 10.0 ** rng.uniform(-3, 0, 3)
        D, g, H = surface.support(d)
        assert g @ d == pytest.approx(D, rel=1e-12)  # Euler: homogeneous of degree one
        assert H @ d == pytest.approx(np.zeros(3), abs=1e-9)
        h = 1e-6 * np.linalg.norm(d) * np.eye(3)
        ahead, behind = ([surface.support(d + s * one) for one in h] for s in (1.0, -1.0))
        slope = [(a[0] - b[0]) / (2.0 * h[0, 0]) for a, b in zip(ahead, behind, strict=True)]
        assert slope == pytest.approx(g, abs=1e-8)
        bend = np.array([a[1] - b[1] for a, b in zip(ahead, behind, strict=True)]) / (2 * h[0, 0])
        scale = np.abs(H).max() + 1.0 / np.linalg.norm(d)
        assert np.abs(bend - H).max() < 2e-4 * scale


@each_section
def test_plane_cut_is_the_exact_envelope(section: Section) -> None:
    n, m = section.interaction_envelope(19)
    points = np.stack([n, m, np.zeros_like(n)], axis=1)
    # fillets are squares of their area here: their first moments are a little off
    allowed = 5e-4 if section is SECTIONS["with fillets"] else 1e-7
    assert BiaxialSurface(section).gauge(points) == pytest.approx(np.ones(19), abs=allowed)


def test_round_tube_is_isotropic_and_a_square_has_four_sides() -> None:
    angle = np.linspace(0.0, 0.5 * np.pi, 7)
    for name, same in (("CHS", True), ("square", False)):
        points = np.stack([0.3 * np.ones(7), 0.6 * np.cos(angle), 0.6 * np.sin(angle)], axis=1)
        gauges = BiaxialSurface(SECTIONS[name]).gauge(points)
        assert gauges == pytest.approx(gauges[::-1], abs=1e-9)
        assert (np.ptp(gauges) < 1e-9) == same


@each_section
def test_midpoints_of_the_surface_are_inside(section: Section) -> None:
    surface, rays = BiaxialSurface(section), np.random.default_rng(5).normal(size=(600, 3))
    points = rays / surface.gauge(rays)[:, None]
    assert surface.gauge(0.5 * (points[:300] + points[300:])).max() <= 1.0 + 1e-9


@pytest.mark.parametrize(("trial", "projected"), PROJECTED)
def test_golden_projection(trial: tuple[float, ...], projected: tuple[float, ...]) -> None:
    hinges = Hinges(HEB, stiffness(HEB))
    assert hinges.project(np.linalg.solve(hinges.K, trial)) > 0
    assert hinges.room["force"] == pytest.approx(projected, abs=2e-8)


@settings(max_examples=150, deadline=None)
@given(
    st.sampled_from(sorted(SECTIONS)),
    st.booleans(),
    st.lists(st.floats(-3.0, 3.0), min_size=5, max_size=5),
    st.floats(-0.5, 2.0),
)
def test_flow_dissipates_and_forces_stay_inside(
    name: str, rigid: bool, direction: list[float], size: float
) -> None:
    section = SECTIONS[name]
    hinges = Hinges(section, stiffness(section, rigid))
    branch = hinges.project(np.linalg.solve(hinges.K, 10.0**size * np.array(direction)))
    force, flow = hinges.room["force"], hinges.room["flow"].reshape(2, 3)
    assert branch != kernels.FAILED
    for hinge, at in enumerate(([0, 1, 2], [0, 3, 4])):
        assert hinges.surface.gauge(force[at]) <= 1.0 + 1e-6
        if branch & (1 << hinge):
            D, work = hinges.surface.support(flow[hinge])[0], force[at] @ flow[hinge]
            assert work >= 0.0
            assert work == pytest.approx(D, rel=1e-6)
        else:
            assert not flow[hinge].any()


@each_section
def test_tangent_is_that_of_differences_symmetric_and_not_negative(section: Section) -> None:
    rng, errors = np.random.default_rng(2), []
    for i in range(60):
        hinges = Hinges(section, stiffness(section, rigid=i % 2 == 0))
        flexibility = np.linalg.inv(hinges.K)
        scale = np.sqrt(np.outer(flexibility.diagonal(), flexibility.diagonal()))
        E = flexibility @ (rng.normal(size=5) * 10.0 ** rng.uniform(0.0, 1.0))
        branch, C = hinges.project(E), hinges.room["tangent"].copy()
        assert np.abs(C - C.T).max() < 1e-13 * hinges.K.max()
        assert np.linalg.eigvalsh(C * scale).min() > -1e-10
        h = 1e-6 * np.sqrt(E @ hinges.K @ E * flexibility.diagonal())
        different, same = np.empty((5, 5)), True
        for j in range(5):
            ends = []
            for sign in (1.0, -1.0):
                same &= hinges.project(E + sign * h[j] * np.eye(5)[j]) == branch
                ends.append(hinges.room["force"].copy())
            different[:, j] = (ends[0] - ends[1]) / (2.0 * h[j])
        if same:
            errors.append(np.abs((different - C) * scale).max())
    assert np.median(errors) < 2e-7
    assert np.quantile(errors, 0.9) < 1e-5


def test_a_pin_turns_without_a_moment() -> None:
    K = stiffness(HEB)
    K[2, :] = K[:, 2] = 0.0  # about the weak axis, at the first hinge
    hinges = Hinges(HEB, K)
    elastic = np.append(np.array([-0.2, 1.3]) / K.diagonal()[:2], [0.3, 0.2, 0.1] / K[3, 3])
    assert hinges.project(elastic) == 1
    assert hinges.room["force"][2] == hinges.room["flow"][2] == 0.0
    assert hinges.surface.gauge(hinges.room["force"][:3]) == pytest.approx(1.0, abs=1e-9)
    K[1, :] = K[:, 1] = 0.0  # a pin about both axes does not flow
    assert hinges.project(elastic) == 0
