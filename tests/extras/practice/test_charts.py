"""Charts of pulses: asymptotes, closed forms, an independent integration, and the command."""

from __future__ import annotations

import json
from itertools import pairwise
from math import inf, pi, sqrt
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from workbench.cli import run
from workbench.extras.practice.biggs import Biggs
from workbench.extras.practice.charts import (
    ductility,
    impulse_asymptote,
    pressure_impulse,
    step_ductility,
    step_force,
)
from workbench.scenarios import Column, MemberPulse, Pulse, to_toml
from workbench.steel.sections import find
from workbench.study.limit import pressure_impulse_curve

SHAPES = ("rectangular", "triangular", "exponential", "friedlander")


@pytest.mark.parametrize("wanted", [0.5, 1.0, 5.0])
def test_curves_go_to_their_asymptotes(wanted) -> None:
    assert step_ductility(step_force(wanted)) == pytest.approx(wanted)
    for shape in SHAPES:
        short, long = pressure_impulse(shape, wanted, (1e-3, 60.0 * max(1.0, wanted)))
        assert short.impulse == pytest.approx(impulse_asymptote(wanted), rel=5e-3), shape
        assert long.force == pytest.approx(step_force(wanted), rel=2e-2), shape
    assert step_ductility(1.0) == ductility("ramp", 1.0, 1.0) == inf


def test_a_long_rectangle_is_a_step_and_a_short_ramp_too() -> None:
    for strength in (1.1, 1.25, 1.7, 2.5):
        expected = step_ductility(1.0 / strength)
        for shape, length in (("rectangular", 20.0), ("ramp", 1e-3)):
            assert ductility(shape, length, strength) == pytest.approx(expected, rel=3e-3)


@pytest.mark.parametrize("shape", SHAPES)
def test_ductility_against_another_integration(shape) -> None:
    length, strength = 0.8, 0.6
    pulse = Pulse(shape, 1.0 / strength, 2.0 * pi * length)

    def rate(t, state):
        v, w, plastic = state
        force = v - plastic
        flows = force >= 1.0 and w > 0.0
        return [w, float(pulse.force(t)) - min(force, 1.0), w if flows else 0.0]

    span = pulse.end + pulse.whole + 7.0
    result = solve_ivp(rate, (0.0, span), np.zeros(3), max_step=0.02, rtol=1e-7, atol=1e-9)
    assert ductility(shape, length, strength) == pytest.approx(result.y[0].max(), rel=4e-3)


def member(load: str = "uniform") -> MemberPulse:
    column = Column(find("HEB 220"), 2.0, 2.0, fillets=False)
    return MemberPulse("blast", column, Pulse("triangular", 4e5, 0.01), load, 0.05)


def test_pulses_that_take_a_member_to_one_displacement() -> None:
    scenario, model = member("point"), Biggs()
    stages = model.stages(scenario.column)
    wanted = 0.05
    work = float(model.curve(scenario.column).work(wanted))
    mass = scenario.column.properties.mass_per_length * 4.0 * stages[0].mass_factor
    short, long = pressure_impulse_curve(model, scenario, wanted, (1e-4, 2.0))
    assert long.peak == pytest.approx(work / wanted, rel=0.02)  # its work is that of R
    # all of the impulse is in the mass of the elastic stage, which then gives some of it away
    plastic = stages[1].mass_factor / stages[0].mass_factor
    first = float(model.curve(scenario.column).work(stages[1].start))
    needed = (work - first) / plastic + first
    assert short.impulse == pytest.approx(sqrt(2.0 * mass * needed), rel=0.01)


def test_a_curve_says_where_there_is_none() -> None:
    scenario = member()
    far = pressure_impulse_curve(Biggs(), scenario, 1e-12, (0.01,))
    assert far[0].peak is None
    assert "no peak" in far[0].reason


@pytest.mark.thorough
def test_the_command_prints_draws_and_refuses(tmp_path: Path, capsys) -> None:
    picture = tmp_path / "chart.svg"
    assert run(["chart", "ductility", "--json", "--figure", str(picture)]) == 0
    answer = json.loads(capsys.readouterr().out)
    place = answer["lengths"].index(1.0), answer["strengths"].index(1.0)
    assert answer["ductility"][place[0]][place[1]] == pytest.approx(ductility("triangular", 1, 1))
    assert picture.read_text().startswith("<svg")
    assert run(["chart", "iso-ductility", "--json", "--shape", "exponential"]) == 0
    curves = json.loads(capsys.readouterr().out)["curves"]
    assert [curve["ductility"] for curve in curves] == [1.0, 2.0, 5.0, 10.0, 20.0]
    file = tmp_path / "blast.toml"
    file.write_text(to_toml(member()))
    assert run(["chart", "pressure-impulse", str(file), "--displacement", "0.04", "--json"]) == 0
    points = json.loads(capsys.readouterr().out)["curves"]["biggs"]
    assert all(a["peak"] > b["peak"] for a, b in pairwise(points))
    weak = file.read_text().replace('shape = "triangular"', 'shape = "ramp"')
    file.write_text(weak)
    ends = ["--over", "pulse.peak", "--from", "1e5", "--to", "5e5", "--json"]
    assert run(["limit", str(file), "--model", "single-dof", *ends]) == 0
    limit = json.loads(capsys.readouterr().out)["limits"][0]
    strength = 16.0 * member().column.properties.plastic_moment / 4.0**2  # q L = 16 M / L
    assert limit["collapses_at"] == pytest.approx(strength, rel=0.01)
    for wrong in (
        ["chart", "ductility", "--shape", "table"],
        ["chart", "pressure-impulse", str(file), "--displacement", "-1"],
        ["chart", "pressure-impulse", str(file), "--displacement", "0.1", "--model", "bigs"],
    ):
        assert run(wrong) == 2
        assert len(capsys.readouterr().err.splitlines()) == 1
