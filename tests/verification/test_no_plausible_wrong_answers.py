"""Coarse meshes, coarse steps, speeds up to 40 m/s: right, warned about, or a typed failure."""

from __future__ import annotations

from functools import cache
from itertools import product

import pytest

from workbench.models.references.fiber_beams import FiberCorotational, FiberReissner
from workbench.responses import warnings_of

MESHES = (None, 0.05, 0.1, 0.2, 0.4, 0.8)  # m
STEPS = (None, 1e-4, 3e-4, 1e-3, 3e-3)  # s
SPEEDS = (10.0, 20.0, 30.0, 40.0)  # m/s
ACCURACY = ("mesh", "yield-ratio", "time-step", "damping", "no-peak")
TYPED = ("not-converged", "out-of-domain")
ALLOWED = 0.05  # of the fine answer


def peak(response) -> float | None:
    return float(response["peak_displacement"]) if "peak_displacement" in response else None


@cache
def fine_answer(scenario):
    """Answer of default meshes and steps."""
    return FiberReissner(levels=1).simulate(scenario)


def offenders(model, scenario, meshes, steps, speeds) -> list[str]:
    """What is off by more than 5 % without a word, in sentences."""
    values = []
    for speed in speeds:
        hit = scenario.at_velocity(speed)
        best = fine_answer(hit)
        fine, falls = peak(best), best.attrs["outcome"] == "collapse"
        for size, step in product(meshes, steps):
            tried = model(
                levels=1, smallest_element=size, largest_element=size, time_step=step, refinement=0
            )
            response = tried.simulate(hit)
            outcome = response.attrs["outcome"]
            text = f"{scenario.name}, {speed} m/s, elements {size} m, steps {step} s: "
            if outcome != "ok":
                if outcome not in TYPED and not (falls and outcome == "collapse"):
                    values.append(text + outcome)
                continue
            if any(finding.subject in ACCURACY for finding in warnings_of(response)):
                continue
            reached = peak(response)
            if reached is None or fine is None or abs(reached / fine - 1.0) > ALLOWED:
                values.append(text + f"{reached} m against {fine} m")
    return values


@pytest.mark.slow
@pytest.mark.parametrize("model", [FiberReissner, FiberCorotational], ids=lambda m: m.name)
@pytest.mark.parametrize("column", ["thesis_impact", "clamped_impact"])
def test_sweep(model, column, request) -> None:
    assert offenders(model, request.getfixturevalue(column), MESHES, STEPS, SPEEDS) == []


@pytest.mark.thorough
@pytest.mark.parametrize("model", [FiberReissner, FiberCorotational], ids=lambda m: m.name)
def test_coarsest_corner(model, thesis_impact) -> None:
    assert offenders(model, thesis_impact, (0.4, 0.8), (1e-4, 3e-3), (10.0,)) == []
