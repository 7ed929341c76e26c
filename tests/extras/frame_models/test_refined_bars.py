"""Refined plastic hinges: elastic buckling, column curve, matrix of the thesis, surface."""

from __future__ import annotations

from math import log, pi

import numpy as np
import pytest
from assembly_cases import alone
from scipy.optimize import brentq
from superelement_cases import EA, EI, MP, NP

from workbench.extras.frame_models.bars import Bar, PlasticEnd, beam_kernels, refined_bars
from workbench.extras.frame_models.bars.kinds import RefinedState, RefinedTables
from workbench.steel.hinges.interaction import polyline
from workbench.steel.sections import find


def refined(length: float, moment: float = MP) -> RefinedTables:
    """Tables of one bar; moments so large that ends stay elastic on demand."""
    end = PlasticEnd((NP, NP), (moment, moment), polyline("aisc", find("HEB 220")))
    bars = refined_bars([[0, 1]], [Bar(end, end, EA, EI, 71.0)], regularisation=0.0)
    alone(bars, length)
    (tables,) = bars.tables
    return tables


def law(tables: RefinedTables, start, end, moment=(0.0, 0.0), turn=(0.0, 0.0)) -> np.ndarray:
    """N, M_1, M_4 and rotations (5,) at deformations `end`, from `start` without plastic part."""
    rows = (np.array([row]) for row in (np.zeros(3), start, 0.0, moment, turn))
    out = np.empty(5)
    beam_kernels.refined_law(tables, 0, RefinedState(*rows), end, out)
    return out


def critical(length: float, reduction: float, mode: str) -> float:
    """Compression at which the stiffness of a mode vanishes."""
    tables = refined(length)
    bar = tables.rows[0]

    def stiffness(force: float) -> float:
        share = reduction * beam_kernels.modulus(force / tables.squash[0, 1])
        k1, k, _ = beam_kernels.stiffness(bar, -force, share)
        return {"pinned": k1 - k, "propped": k1}[mode]

    high = (2.2 if mode == "propped" else 1.2) * pi**2 * EI / length**2
    return float(brentq(stiffness, 1.0, min(high, (1.0 - 1e-9) * NP)))


@pytest.mark.parametrize(("mode", "factor"), [("pinned", 1.0), ("propped", 1.0 / 0.699156**2)])
def test_elastic_buckling(mode: str, factor: float) -> None:
    length = 30.0
    exact = factor * pi**2 * EI / length**2
    assert exact < 0.39 * NP
    assert critical(length, 1.0, mode) == pytest.approx(exact, rel=1e-5)


@pytest.mark.parametrize("slenderness", [0.3, 0.6, 0.9, 1.2, 1.45, 1.8])
def test_column_curve_of_aisc(slenderness: float) -> None:
    length = slenderness * pi * np.sqrt(EI / NP)
    curve = 0.658**slenderness**2 if slenderness <= 1.5 else 0.877 / slenderness**2
    assert critical(length, 0.877, "pinned") / NP == pytest.approx(curve, rel=0.002)
    # as printed the modulus is that of the curve over 0.877: above it in every inelastic column
    printed = np.exp(-(slenderness**2) / 2.7243) if slenderness <= 1.6 else 1.0 / slenderness**2
    assert critical(length, 1.0, "pinned") / NP == pytest.approx(printed, rel=0.002)


def test_tangent_modulus_continues_the_elastic_one() -> None:
    assert beam_kernels.modulus(0.39) == 1.0
    assert -2.7243 * 0.39 * log(0.39) == pytest.approx(1.0005, abs=1e-4)
    assert beam_kernels.modulus(0.7) == pytest.approx(-2.7243 * 0.7 * log(0.7))
    assert beam_kernels.modulus(0.999) < 0.004


@pytest.mark.parametrize("moment", [(0.6, -0.75), (0.8, 0.7), (0.3, 0.9)])
def test_rates_are_those_of_the_thesis(moment: tuple[float, float]) -> None:
    """Equation 2.9: M' = EI/L [phi_A (S1 - S2^2/S1 (1 - phi_B)), phi_A phi_B S2; ...] theta'."""
    length, axial = 4.0, -0.1 * NP
    tables = refined(length)
    k1, k, _ = beam_kernels.stiffness(tables.rows[0], axial, 1.0)
    moments = MP * np.array(moment)
    turn = np.linalg.solve([[k1, k], [k, k1]], moments)
    start = np.array([axial * length / EA, 0.0, 0.0])
    state = 0.5 * 0.1 + np.abs(moments) / MP
    phi = np.where(state > 0.5, 4.0 * state * (1.0 - state), 1.0)
    a, b = phi
    first, last = a * (k1 - k**2 / k1 * (1.0 - b)), b * (k1 - k**2 / k1 * (1.0 - a))
    matrix = np.array([[first, a * b * k], [a * b * k, last]])
    # an increment that raises the force state of both ends
    step = 1e-6 * np.linalg.solve([[k1, k], [k, k1]], np.sign(moments) * MP)
    step = np.array([0.0, *step])
    out = law(tables, start, start + step, moments, turn)
    assert out[1:3] - moments == pytest.approx(matrix @ step[1:], rel=1e-4)
    # and back: an end whose force state falls is elastic
    out = law(tables, start, start - step, moments, turn)
    elastic = np.array([[k1, k], [k, k1]]) @ -step[1:]
    assert out[1:3] - moments == pytest.approx(elastic, rel=1e-6)


def test_tangent_modulus_acts_on_increments() -> None:
    """A bent bar under growing compression: what it carries is not softened, what is added is."""
    length = 2.0
    tables = refined(length, moment=100.0 * MP)  # ends elastic, N l^2 / EI = 0.6 at most
    bar = tables.rows[0]
    at = [np.array([-share * NP * length / EA, 0.0, 0.0]) for share in (0.3, 0.8)]
    moments = np.array([0.2, -0.2]) * MP
    k1, k, _ = beam_kernels.stiffness(bar, -0.3 * NP, 1.0)
    turn = moments / (k1 - k)
    out = law(tables, *at, moments, turn)
    # P-delta of a uniformly bent bar takes N l / 6 of each rotation (Przemieniecki 1968)
    assert moments[0] - out[1] == pytest.approx(0.5 * NP * length / 6.0 * turn[0], rel=0.02)
    bent, more = out[1:3], np.array([0.0, 1e-6, -1e-6])
    out = law(tables, at[1], at[1] + more, bent, out[3:])
    k1, k, _ = beam_kernels.stiffness(bar, -0.8 * NP, -2.7243 * 0.8 * log(0.8))
    state = 0.8 + 8.0 / 9.0 * bent[0] / (100.0 * MP)
    phi = 4.0 * state * (1.0 - state)
    added = phi * (k1 - k**2 / k1 * (1.0 - phi) - phi * k)  # equation 2.9, both ends alike
    assert out[1] - bent[0] == pytest.approx(1e-6 * added, rel=1e-4)
    assert np.all(law(tables, at[0], at[0])[1:] == 0.0)


def test_forces_stay_on_the_surface() -> None:
    tables, rng = refined(4.0), np.random.default_rng(5)
    for _ in range(200):
        end = rng.standard_normal(3) * np.array([0.02, 0.1, 0.1])
        out = law(tables, np.zeros(3), end)
        n, m = abs(out[0]) / NP, np.abs(out[1:3]).max() / MP
        assert max(n + 8.0 / 9.0 * m, 0.5 * n + m) <= 1.0 + 1e-6
