"""Statics: closed forms, roll-up, collapse loads, a published program's numbers."""

from math import pi

import numpy as np
import pytest
from beam_cases import E_STEEL, KINDS, YIELD, chain, clamp, of_kind, plates, rectangle

from workbench.base.errors import SolverError
from workbench.mechanics.structures.assembly import graded_lengths
from workbench.mechanics.structures.paths import apply_loads, push

ELASTIC = 1e12  # yield stress that is never reached, Pa
INERTIA = 2 * np.sum(rectangle(layers=20).y[10:] ** 2 * rectangle(layers=20).area[10:])


@pytest.mark.parametrize("kind", ["interpolated", "balanced"])
def test_roll_up_of_a_cantilever_closes(kind):
    """M = 2 pi EI / L bends the beam into a circle (Simo and Vu-Quoc 1986)."""
    slim = rectangle(height=0.01, width=1.0, yield_stress=1e15)
    assembly, _ = chain(np.full(8, 0.5), slim, balanced=kind == "balanced")
    clamp(assembly, 0)
    bending = E_STEEL * np.sum(slim.y**2 * slim.area)
    assembly.load[assembly.dof(8, "rotation")] = 2 * pi * bending / 4.0
    apply_loads(assembly, steps=20, tolerance=1e-13)
    tip = assembly.coordinates[8] + assembly.displacement[24:26]
    assert np.linalg.norm(tip) <= 1e-10 * 4.0
    assert assembly.displacement[26] == pytest.approx(2 * pi, rel=1e-10)


@pytest.mark.parametrize("kind", KINDS)
def test_cantilever_deflection(kind):
    """v = F L^3 / 3EI, plus F L / GA with shear strain; small load."""
    assembly, _ = of_kind(kind, np.full(6, 0.5), yield_stress=ELASTIC)
    clamp(assembly, 0)
    tip = assembly.dof(6, "v")
    assembly.load[tip] = 1000.0
    apply_loads(assembly)
    expected = 1000.0 * 27.0 / (3 * E_STEEL * INERTIA)
    if "sheared" in kind:
        expected += 1000.0 * 3.0 / 8e8
    assert assembly.displacement[tip] == pytest.approx(expected, rel=2.4e-8)  # measured 1.2e-8


@pytest.mark.parametrize("kind", KINDS)
def test_clamped_beam_under_an_eccentric_load(kind):
    """Stiffness 3 EI L^3 / (a^3 b^3) of a clamped beam at a point, in series with shear."""
    assembly, _ = of_kind(kind, [0.4, 0.4, 1.0, 1.0, 1.2], yield_stress=ELASTIC)
    clamp(assembly, 0)
    assembly.hold([assembly.dof(5, name) for name in ("v", "rotation")])
    hit = assembly.dof(2, "v")
    step = next(push(assembly, hit, np.array([1e-5])))
    bending = 3 * E_STEEL * INERTIA * (1 / 0.8 + 1 / 3.2) ** 3
    assert step.factor == pytest.approx(
        # measured 1.1e-10
        bending * 1e-5 if "sheared" not in kind else _sheared_stiffness(0.8, 3.2) * 1e-5,
        rel=1e-8,
    )


def _sheared_stiffness(a: float, b: float) -> float:
    """The same with Timoshenko's stiffness of both segments, assembled by hand."""
    total = np.zeros((2, 2))
    for length, side in ((a, 1.0), (b, -1.0)):
        ratio = 12 * E_STEEL * INERTIA / (8e8 * length**2)
        factor = E_STEEL * INERTIA / (length**3 * (1 + ratio))
        total += factor * np.array(
            [[12, -side * 6 * length], [-side * 6 * length, (4 + ratio) * length**2]]
        )
    return total[0, 0] - total[0, 1] ** 2 / total[1, 1]


@pytest.mark.parametrize("kind", KINDS)
def test_plastic_collapse_load_of_a_clamped_beam(kind):
    """F = 2 Mp (1/a + 1/b) for a beam whose head may slide along it, small deflection."""
    segments = [graded_lengths(length, 0.02, 0.4) for length in (1.6, 2.4)]
    assembly, _ = of_kind(kind, np.concatenate(segments), hardening=1e-7 * E_STEEL)
    last = sum(map(len, segments))
    clamp(assembly, 0)
    assembly.hold([assembly.dof(last, name) for name in ("v", "rotation")])
    hit = assembly.dof(len(segments[0]), "v")
    *_, step = push(assembly, hit, np.linspace(0.0, 0.06, 61)[1:])
    collapse = 2 * (YIELD * 0.2**3 / 4.0) * (1 / 1.6 + 1 / 2.4)
    # Gauss points lie 0.2 h from the hinges, Radau points at them
    assert step.factor == pytest.approx(collapse, rel=0.0015 if "balanced" in kind else 0.008)


def opensees_column(size: float):
    """HEB 220 without fillets, uniform mesh, guided head with spring and 0.5 MN."""
    assembly, _ = chain(np.full(round(4.0 / size), size), plates(4, 16))
    last = round(4.0 / size)
    clamp(assembly, 0)
    assembly.hold([assembly.dof(last, name) for name in ("v", "rotation")])
    assembly.load[assembly.dof(last, "u")] = -0.5e6
    apply_loads(assembly)
    assembly.add_spring(assembly.dof(last, "u"), 1e7)
    return assembly, assembly.dof(round(0.8 / size), "v")


@pytest.mark.parametrize(("size", "force"), [(0.2, 1.425e6), (0.1, 1.306e6)])
def test_column_against_opensees(size, force):
    """F(0.4 m) of dispBeamColumn, corotational, two Legendre points, hardening 1e-4."""
    assembly, hit = opensees_column(size)
    *_, step = push(assembly, hit, np.linspace(0.0, 0.4, 141)[1:])
    assert step.factor == pytest.approx(force, abs=600.0)


def test_static_work_balance():
    assembly, hit = opensees_column(0.1)
    start, loaded = assembly.stored, assembly.displacement.copy()
    steps = list(push(assembly, hit, np.linspace(0.0, 0.3, 301)[1:]))
    force = np.array([0.0] + [s.factor for s in steps])
    at = np.array([0.0] + [s.displacement for s in steps])
    work = np.trapezoid(force, at) + assembly.load @ (assembly.displacement - loaded)
    spent = steps[-1].energies.stored - start + sum(s.energies.plastic for s in steps)
    assert spent == pytest.approx(work, rel=2.4e-6)  # measured 1.2e-6
    assert min(s.energies.plastic for s in steps) >= 0.0


def test_path_is_met_and_continues_from_where_it_is():
    assembly, hit = opensees_column(0.2)
    path = np.array([0.01, 0.02, 0.25])  # the last increment has to be cut
    steps = list(push(assembly, hit, path))
    assert [s.displacement for s in steps] == pytest.approx(path, rel=1e-12)
    again = list(push(assembly, hit, np.array([-0.001])))
    assert assembly.displacement[hit] == pytest.approx(0.249, rel=1e-12)
    assert again[0].factor < steps[-1].factor


def test_failures_name_displacement_and_remedies():
    assembly, hit = opensees_column(0.2)
    assembly.load[assembly.dof(5, "u")] = np.nan
    with pytest.raises(SolverError, match=r"displacement 9\.7\S* m: .*increments down to 1/1024"):
        list(push(assembly, hit, np.array([0.1])))


def test_loads_beyond_the_capacity_are_refused():
    assembly, _ = chain(np.full(4, 0.5), rectangle())
    clamp(assembly, 0)
    assembly.load[assembly.dof(4, "rotation")] = 2 * YIELD * 0.002
    with pytest.raises(SolverError, match=r"dead load, share 0\.5"):
        apply_loads(assembly)
