"""Mesh, supports and assembly of the solid: exact areas, patch tests, tangent, rigid plates."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.sparse import eye_array

from workbench.base.errors import SolverError
from workbench.mechanics.structures.equilibrium import equilibrium
from workbench.mechanics.structures.paths import apply_loads, push
from workbench.models.references.solid.kernels import SolidAssembly
from workbench.models.references.solid.mesh import (
    SolidMesh,
    Supports,
    axial_positions,
    row_edges,
    solid_mesh,
    supports_of,
)
from workbench.scenarios import Column
from workbench.steel.materials import Steel
from workbench.steel.sections import (
    Section,
    circular_tube,
    find,
    rectangle,
    rectangular_tube,
    square,
)

Array = NDArray[np.float64]
STEEL = Steel()
SECTIONS = [
    find("HEB 220"),
    find("HEB 220").without_fillets(),
    find("IPE 300"),
    square(0.2),
    rectangular_tube(0.2, 0.1, 0.01),
    circular_tube(0.2, 0.01),
]


def column(section: Section, **changes) -> Column:
    return Column(section, **{"length_below": 0.8, "length_above": 1.6, **changes})


def assembly_of(case: Column, hardening: float = 1e-6, refinement: int = 0) -> SolidAssembly:
    mesh = solid_mesh(case, refinement=refinement)
    supports = supports_of(mesh, case.base, case.head)
    return SolidAssembly(mesh, supports, case.steel, hardening)


@pytest.mark.parametrize("section", SECTIONS, ids=lambda s: s.name)
def test_weights_hold_the_exact_area_and_inertia(section: Section) -> None:
    mesh = solid_mesh(column(section))
    assert mesh.weights.sum() == pytest.approx(section.area * 2.4, rel=1e-12)
    nodes = mesh.places[0, mesh.dofs[:, 0::2]]
    # x of the quadrature points as d(x^2/2)/dx, exact for quadratic shape functions
    x = np.einsum("egn,en->eg", mesh.gradients[:, :, 0], 0.5 * nodes**2)
    inertia = np.sum(mesh.weights * x**2) / 2.4
    assert inertia == pytest.approx(section.second_moment, rel=6e-3)  # arcs; measured 0.0048
    if not any(band.arc for band in section.shape.bands):
        assert inertia == pytest.approx(section.second_moment, rel=1e-12)


def test_rows_end_at_the_faces_of_plates_and_refine_by_halves() -> None:
    edges = row_edges(SECTIONS[0])
    for face in (0.0, 0.11 - 0.016 - 0.018, 0.11 - 0.016, 0.11):
        assert np.min(np.abs(edges - face)) < 1e-15
        assert np.min(np.abs(edges + face)) < 1e-15
    for lines in (
        [row_edges(SECTIONS[0], r) for r in range(3)],
        [axial_positions(column(square(0.2)), None, r) for r in range(3)],
    ):
        for coarse, fine in pairwise(lines):
            np.testing.assert_allclose(fine[::2], coarse, atol=1e-12)
            np.testing.assert_allclose(fine[1::2], 0.5 * (coarse[1:] + coarse[:-1]), atol=1e-12)


def test_mesh_is_finest_at_ends_and_hit_section() -> None:
    at = axial_positions(column(square(0.2)))
    sizes = np.diff(at)
    hit = int(np.argmin(np.abs(at - 0.8)))
    assert at[hit] == pytest.approx(0.8, abs=1e-12)
    for place in (0, hit - 1, hit, -1):
        assert sizes[place] == pytest.approx(0.2 / 6.0, rel=0.12)  # measured 0.059
    assert sizes.max() > 2.0 * sizes.min()


def forces_under(mesh: SolidMesh, gradient: Array) -> tuple[Array, Array]:
    """Internal forces (size,) and Biot stress (elements, points, 3) under u = (F - I) X."""
    moved = (gradient - np.eye(2)) @ mesh.places
    sideways = np.isin(np.arange(mesh.size), mesh.dofs[:, 0::2])
    loose = SolidAssembly(mesh, Supports(eye_array(mesh.size, format="csr")), STEEL, 1e-6)
    loose.assemble(np.where(sideways, moved[0], moved[1]))
    return loose.force, loose.stress


CASE = column(find("HEB 220"), fillets=False)


def test_patch_of_uniform_axial_stress_in_an_i_section() -> None:
    mesh = solid_mesh(CASE)
    strain = 0.8 * STEEL.yield_stress / STEEL.elastic_modulus
    angle = 0.9
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    force, stress = forces_under(mesh, turn @ np.diag([1.0 - 0.3 * strain, 1.0 + strain]))
    expected = [0.0, 0.8 * STEEL.yield_stress, 0.0]
    # Pa, round-off
    np.testing.assert_allclose(stress, np.broadcast_to(expected, stress.shape), atol=1.0)
    ends = np.concatenate([*mesh.base, *mesh.head])
    inside = np.setdiff1d(np.arange(mesh.size), ends)
    scale = np.max(np.abs(force[ends]))
    assert np.max(np.abs(force[inside])) < 1e-9 * scale
    # the resultant at the base turns with the body and is 0.8 of the squash load
    base = np.array([force[mesh.base[0]].sum(), force[mesh.base[1]].sum()])
    squash = CASE.strength_section.squash_load(STEEL)
    np.testing.assert_allclose(base, -0.8 * squash * turn[:, 1], rtol=1e-9)


def test_patch_of_any_uniform_plastic_strain_in_a_rectangle() -> None:
    mesh = solid_mesh(column(rectangle(0.2, 0.1)))
    force, stress = forces_under(mesh, np.array([[1.05, 0.2], [-0.1, 0.9]]))
    assert np.ptp(stress.reshape(-1, 3), axis=0).max() < 1e-4
    on_edge = np.abs(np.abs(mesh.places[0]) - 0.1) < 1e-12
    edge = np.concatenate([np.flatnonzero(on_edge), *mesh.base, *mesh.head])
    inside = np.setdiff1d(np.arange(mesh.size), edge)
    assert np.max(np.abs(force[inside])) < 1e-9 * np.max(np.abs(force[edge]))


def test_rigid_turn_costs_nothing() -> None:
    mesh = solid_mesh(CASE)
    turn = np.array([[np.cos(2.5), -np.sin(2.5)], [np.sin(2.5), np.cos(2.5)]])
    force, _ = forces_under(mesh, turn)
    assert np.max(np.abs(force)) < 1e-9 * CASE.strength_section.squash_load(STEEL)


@pytest.mark.parametrize("ends", [("clamped", "guided"), ("pinned", "pinned")])
def test_tangent_of_the_assembly_with_rigid_plates(ends: tuple[str, str]) -> None:
    case = assembly_of(column(square(0.2), base=ends[0], head=ends[1]), hardening=0.01)
    case.spring = (3e8, 1e-3)
    random = np.random.default_rng(1)
    for _ in range(2):  # elastic-plastic, from a state that is already plastic and turned
        q = case.displacement + 1e-4 * random.uniform(-1.0, 1.0, len(case.displacement))
        for plate in case.supports.plates:
            q[plate.turn] += 0.01
        case.assemble(q)
        case.commit(q)
    q = case.displacement + 1e-5 * random.uniform(-1.0, 1.0, len(case.displacement))
    direction = random.uniform(-1.0, 1.0, len(q))
    case.assemble(q)
    exact = case.tangent @ direction
    step = 1e-9
    measured = (case.assemble(q + step * direction) - case.assemble(q - step * direction)) / (
        2.0 * step
    )
    # measured 1.6e-9
    np.testing.assert_allclose(measured, exact, atol=1e-8 * np.max(np.abs(exact)))
    # symmetric: a . K b = b . K a
    other = random.uniform(-1.0, 1.0, len(q))
    case.assemble(q)
    one, two = other @ (case.tangent @ direction), direction @ (case.tangent @ other)
    assert one == pytest.approx(two, rel=1e-11, abs=1e-11 * np.max(np.abs(exact)))


def test_plates_at_large_turns_have_exact_derivatives() -> None:
    mesh = solid_mesh(column(square(0.2), base="pinned", head="pinned"))
    supports = supports_of(mesh, "pinned", "pinned")
    random = np.random.default_rng(3)
    q, force = random.uniform(-1.0, 1.0, supports.unknowns), random.uniform(-1.0, 1.0, mesh.size)

    def pulled(q: Array) -> Array:
        return supports.derivative(q).T @ force

    step, exact = 1e-6, pulled(q)
    curvature = supports.curvature(q, force)
    for plate in supports.plates:
        d = np.zeros(len(q))
        d[plate.turn] = step
        slope = force @ (supports.expand(q + d) - supports.expand(q - d)) / (2.0 * step)
        assert slope == pytest.approx(exact[plate.turn], abs=1e-9)
        bend = (pulled(q + d) - pulled(q - d))[plate.turn] / (2.0 * step)
        assert bend == pytest.approx(curvature[plate.turn], abs=1e-9)


def test_pinned_plate_moves_rigidly_about_the_centroid() -> None:
    mesh = solid_mesh(column(square(0.2), base="pinned", head="pinned"))
    supports = supports_of(mesh, "pinned", "pinned")
    q = np.zeros(supports.unknowns)
    q[[plate.turn for plate in supports.plates]] = [1.1, -0.7]
    q[supports.head] = -0.05
    u = supports.expand(q)
    for (x, y), shift, turn in ((mesh.base, 0.0, 1.1), (mesh.head, -0.05, -0.7)):
        place = mesh.places[0, x]
        np.testing.assert_allclose(place + u[x], place * np.cos(turn), atol=1e-15)
        np.testing.assert_allclose(u[y], shift + place * np.sin(turn), atol=1e-15)
        assert abs(u[x][len(place) // 2]) < 1e-15


def test_axial_load_shortens_the_column_and_stops_at_the_squash_load() -> None:
    case = column(find("HEB 220"), fillets=False, length_below=1.6)
    squash = case.properties.squash_load

    def under(load: float, hardening: float = 1e-6) -> SolidAssembly:
        """The column, held straight, under an axial load."""
        solid = assembly_of(case, hardening=hardening)
        solid.load[solid.supports.head], solid.held = -load, np.array([solid.supports.hit])
        apply_loads(solid, most_cuts=0, name="axial load")
        return solid

    elastic = under(0.4 * squash)
    axial = STEEL.elastic_modulus * case.strength_section.area / case.length
    shortening = -elastic.displacement[elastic.supports.head]
    # end plates keep the section from widening: slightly stiffer than the bar
    assert shortening == pytest.approx(0.4 * squash / axial, rel=2e-3)  # measured 1.8e-3
    assert shortening < 0.4 * squash / axial
    # measured 2.9e-6
    assert elastic.stored == pytest.approx(0.5 * 0.4 * squash * shortening, rel=6e-6)
    under(0.998 * squash)
    with pytest.raises(SolverError, match="axial load, share"):
        under(1.005 * squash, hardening=0.0)


def test_failed_push_says_where_and_what_was_tried(monkeypatch) -> None:
    monkeypatch.setattr("workbench.mechanics.structures.equilibrium.ITERATIONS", 1)
    case = assembly_of(column(square(0.2)))
    with pytest.raises(SolverError, match=r"displacement .* m: residual .*1/256"):
        list(push(case, case.supports.hit, np.array([0.05]), most_cuts=8))


def test_held_unknowns_stay_and_reactions_balance() -> None:
    case = assembly_of(column(square(0.2)))
    start = case.displacement.copy()
    start[case.supports.hit] = 1e-3
    held = np.array([case.supports.hit])
    result, reactions = equilibrium(case, case.load, start, held, 1e-8)
    assert result.converged
    mesh = case.mesh
    ends = case.force[mesh.base[0]].sum() + case.force[mesh.head[0]].sum()
    assert result.x[case.supports.hit] == 1e-3
    assert reactions[case.supports.hit] == pytest.approx(-ends, rel=1e-8)  # measured 1.4e-9
