"""Pulses: impulses against quadrature, files there and back, what is refused."""

from __future__ import annotations

import tomllib
from dataclasses import replace

import numpy as np
import pytest
from builders import portal
from scipy.integrate import quad

from workbench.base.errors import InputError
from workbench.scenarios import (
    ColumnImpact,
    FramePulse,
    Load,
    MemberPulse,
    Pulse,
    frame_scenario,
    scenario_from,
    scenario_hash,
    to_toml,
)

ALL = (
    Pulse("rectangular", 3.0, 0.02),
    Pulse("triangular", 3.0, 0.02),
    Pulse("exponential", 3.0, 0.02),
    Pulse("friedlander", 3.0, 0.02, 1.7),
    Pulse("ramp", 3.0, 0.02),
    Pulse("table", 3.0, times=(0.0, 0.01, 0.03), factors=(0.5, 1.0, -0.2)),
)


@pytest.mark.parametrize("pulse", ALL, ids=lambda pulse: pulse.shape)
def test_impulses_are_the_integrals_of_forces(pulse) -> None:
    kinks = [0.01, 0.02, 0.03]
    for end in (0.004, 0.02, 0.05):
        inner = [k for k in kinks if k < end]
        exact = quad(lambda t: float(pulse.force(t)), 0.0, end, points=inner or None)[0]
        assert float(pulse.impulse(end)) == pytest.approx(exact, rel=1e-6)
    times = np.array([0.0, 0.004, 0.02, 0.05])
    assert float(np.sum(pulse.means(times) * np.diff(times))) == pytest.approx(exact, rel=1e-6)


def test_pulses_that_are_none_are_refused() -> None:
    for given, path in (
        ({"shape": "square"}, "pulse.shape"),
        ({"peak": 0.0}, "pulse.peak"),
        ({"length": None}, "pulse.length"),
        ({"factors": (1.0, 2.0)}, "pulse.factors"),
        ({"shape": "table"}, "pulse.times"),
        ({"shape": "table", "times": (0.0, 1.0)}, "pulse.factors"),
        ({"shape": "table", "times": (0.0, 1.0), "factors": (1.0,) * 3}, "pulse.factors"),
        ({"shape": "table", "times": (0.1, 1.0), "factors": (1.0, 0.0)}, "pulse.times"),
        ({"shape": "table", "times": (0.0, 1.0), "factors": (0.0, 0.0)}, "pulse.factors"),
        ({"shape": "table", "times": (0.0, 1.0), "factors": (1e-300, 0.0)}, "pulse.factors"),
        ({"peak": 1e-300}, "pulse.peak"),
    ):
        with pytest.raises(InputError) as error:
            Pulse(**{"shape": "triangular", "peak": 1.0, "length": 0.1, **given})
        assert error.value.field == path


def member(impact: ColumnImpact, load: str, pulse: Pulse = ALL[1]) -> MemberPulse:
    return MemberPulse("blast", impact.column, pulse, load, 0.05)


@pytest.mark.parametrize("pulse", ALL, ids=lambda pulse: pulse.shape)
def test_files_hold_pulses(thesis_impact, pulse) -> None:
    for load in ("point", "uniform"):
        scenario = member(thesis_impact, load, pulse)
        tables = tomllib.loads(to_toml(scenario))
        assert tables["pulse"]["load"] == load
        assert scenario_from(tables) == scenario
        framed = frame_scenario(scenario)
        assert scenario_from(tomllib.loads(to_toml(framed))) == framed
    assert scenario_hash(scenario) != scenario_hash(replace(scenario, load="point"))


def test_a_pulse_on_a_frame_acts_on_something() -> None:
    frame = portal()
    given = {"frame": frame, "pulse": ALL[0], "node": "A1"}
    assert FramePulse("ok", **given, loads=(Load("A1", x=1.0),)).direction == "+x"
    for wrong, path in (
        ({}, "pulse.members"),
        ({"members": ("roof",)}, "pulse.members"),
        ({"members": ("A0-A1",), "node": "Z"}, "pulse.node"),
        ({"members": ("A0-A1",), "node": "A0"}, "pulse.direction"),
        ({"loads": (Load("Z", x=1.0),)}, "pattern.Z.node"),
    ):
        with pytest.raises(InputError) as error:
            FramePulse("no", **{**given, **wrong})
        assert error.value.field == path
