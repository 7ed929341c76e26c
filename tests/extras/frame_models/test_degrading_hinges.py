"""Hinges that wear by the energy they dissipate: closed form, excursions, energy, bad input."""

from __future__ import annotations

from dataclasses import replace
from math import exp, log

import numpy as np
import pytest
from scipy.optimize import brentq
from test_hinged_frames import HEB, cantilever

from workbench.base.errors import InputError
from workbench.extras.frame_models.hinged_frames import PlasticHinge, QuasiPlasticHinge
from workbench.responses import findings_of
from workbench.scenarios import FrameImpact, FrameStatic, FrameStriker, Load, regular_frame
from workbench.steel.sections import find, square

pytestmark = pytest.mark.usefixtures("few_load_steps")
LENGTH, CAPACITY, AMPLITUDE = 4.0, 0.5, 0.25
PATH = (AMPLITUDE, -AMPLITUDE) * 3
PLAIN = {"geometry": "linear", "shear_flexible": False}
WORN = PlasticHinge(degradation="energy", rotation_capacity=CAPACITY, **PLAIN)


def turning_points(moment: float, bending: float) -> tuple[list[float], list[float]]:
    """Moments of the clamp at the reversals of `PATH`, and what is left of the strength there.

    M = M_p s, s = exp(-R / capacity) after an accumulated plastic rotation R; the elastic rotation
    of the chord is M (L / 3 + L / 6 (1 / s - 1)) / EI.
    """
    left, plastic, result, shares = 1.0, 0.0, [], []
    for moved in PATH:
        turn, sign, before = moved / LENGTH, 1.0 if moved > 0.0 else -1.0, left

        def gap(s: float, before: float = before, sign: float = sign, turn: float = turn) -> float:
            elastic = moment * s * LENGTH * (1.0 / 3.0 + (1.0 / s - 1.0) / 6.0) / bending
            return sign * (turn - plastic) + CAPACITY * log(s / before) - elastic  # noqa: B023

        left = brentq(gap, 1e-6, before, xtol=1e-15)
        plastic -= sign * CAPACITY * log(left / before)
        result.append(sign * moment * left)
        shares.append(left)
    return result, shares


def test_cyclic_cantilever_is_the_closed_form() -> None:
    scenario = replace(cantilever(LENGTH, 0.0, 0.1), path=PATH)
    properties = scenario.frame.properties("leg")
    response = WORN.simulate(scenario)
    moved, force = response["displacement"].values, response["force"].values
    turns = [i for i in range(1, len(moved) - 1) if (np.diff(moved)[i - 1 : i + 1] > 0).sum() == 1]
    bending = scenario.frame.steel.elastic_modulus * properties.second_moment
    moments, shares = turning_points(properties.plastic_moment, bending)
    at = [*turns, len(moved) - 1]
    assert len(at) == len(PATH)
    # strength lags by a step: 0.4 % with 100 steps in all, 0.1 % with 400, 0.025 % with 1600
    assert force[at] * LENGTH == pytest.approx(np.array(moments), rel=5e-3)
    assert response.attrs["least_strength"] == pytest.approx(shares[-1], rel=2e-3)
    # unloading: all is elastic and as soft as the energy has made it
    i = turns[3]
    slope = (force[i + 3] - force[i + 1]) / (moved[i + 3] - moved[i + 1])
    soft = LENGTH / 3.0 + (1.0 / shares[3] - 1.0) * LENGTH / 6.0
    assert slope * LENGTH**2 == pytest.approx(bending / soft, rel=1e-3)
    # dissipated: M_p times the capacity for all that the strength lost, and M_p^2 L / 12 EI of it
    # for the elastic spring that softens under the moment
    lost = (1.0 - response.attrs["least_strength"]) * properties.plastic_moment
    spring = properties.plastic_moment * LENGTH / 12.0 / bending
    assert response["dissipated"].values[-1] == pytest.approx(lost * (CAPACITY + spring), rel=3e-3)


def test_strength_is_the_product_over_excursions() -> None:
    """Rahnama and Krawinkler: 1 - E_i / (E_t - sum of all before) for every excursion of energy."""
    scenario = replace(cantilever(LENGTH, 0.0, 0.1), path=PATH)
    response = WORN.simulate(scenario)
    moment = response["moment"].values[0]
    turned = response["plastic_rotation"].values[0]
    work = 0.5 * (moment[1:] + moment[:-1]) * np.diff(turned)
    excursion = np.cumsum(np.diff(np.sign(moment[1:]), prepend=1.0) != 0.0)
    total = scenario.frame.properties("leg").plastic_moment * CAPACITY
    spent, left = 0.0, 1.0
    for number in np.unique(excursion):
        energy = float(np.sum(work[excursion == number]))
        left *= 1.0 - energy / (total - spent)
        spent += energy
    assert left == pytest.approx(1.0 - spent / total)  # it telescopes
    assert response.attrs["least_strength"] == pytest.approx(left, rel=4e-3)


@pytest.mark.thorough
@pytest.mark.parametrize("kind", [PlasticHinge, QuasiPlasticHinge])
def test_a_hit_goes_further_where_hinges_wear(kind: type[PlasticHinge]) -> None:
    frame = regular_frame((5.0,), (4.0,), HEB, find("IPE 300")).split("A0-A1", 2.0, "hit")
    hit = FrameImpact("hit", frame, FrameStriker(1500.0, 8.0, node="hit"), 0.1)
    peaks = []
    for model in (kind(), kind(degradation="energy", rotation_capacity=0.2)):
        response = model.simulate(hit)
        assert response.attrs["outcome"] == "ok", response.attrs["message"]
        error = np.abs(response["balance_error"].values).max()
        assert error < 1e-8 * float(response["input_energy"])
        spent = response["dissipated"].values
        assert np.diff(spent).min() > -1e-6 * spent[-1]  # the elastic share beside the hinges
        peaks.append(float(response["peak_displacement"]))
    assert peaks[1] > 1.05 * peaks[0]
    assert response.attrs["least_strength"] == pytest.approx(exp(-0.32), abs=0.05)


def test_where_wear_is_not_known() -> None:
    def subjects(model: PlasticHinge, section, *more: str) -> dict[str, bool]:
        frame = regular_frame((5.0,), (4.0,), section, section).split("A0-A1", 2.0, "hit")
        hit = FrameImpact("hit", frame, FrameStriker(2000.0, 20.0, node="hit"))
        kept = {"degradation", "catenary"}
        return {f.subject: f.refusal for f in model.domain(hit) if f.subject in kept}

    by_tests = PlasticHinge(degradation="energy")
    assert subjects(by_tests, find("IPE 300")) == {"catenary": False}
    assert subjects(by_tests, HEB) == {"catenary": False, "degradation": False}  # h / t_w = 16
    assert subjects(by_tests, square(0.2))["degradation"] is True
    assert "degradation" not in subjects(WORN, square(0.2))
    assert not subjects(PlasticHinge(), HEB)
    (refused,) = (
        f for f in by_tests.domain(cantilever(4.0, 0.0, 0.1)) if f.subject == "degradation"
    )
    assert "h/t_w = 16 (20 to 55)" in refused.text
    two = regular_frame((5.0,), (4.0,), HEB, find("IPE 300"))
    push = FrameStatic("push", two, (Load("A1", x=1e3),), "A1", "x", (0.1,))
    (warned,) = by_tests.domain(push)
    assert warned.text.count("h/t_w") == 1
    assert "members A0-A1, B0-B1" in warned.text
    for options in ({"rotation_capacity": 0.5}, {"degradation": "drift"}):
        with pytest.raises(InputError, match=next(iter(options))):
            PlasticHinge(**options)
    assert not findings_of(WORN.simulate(cantilever(4.0, 0.0, 0.1)))
