"""Like for like: the beam of record in Bernoulli's limit against graded meshes in OpenSeesPy."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import opensees_columns as opensees
import pytest
from threadpoolctl import threadpool_limits

from workbench.mechanics.structures.fibers import BeamSection
from workbench.models.references.fiber_beams import FiberReissner
from workbench.scenarios import Column, ColumnImpact, Frame, Member, Striker
from workbench.steel.sections import find

STEP = 4e-6  # s, of OpenSees; half of it changes the finer mesh of "slower" by 0.03 %
FINE = 0.01  # m, elements of OpenSees at hinges; with half of it three columns fail
HALF = ("slender",)  # half steps and elements change it by 0.2 and 0.6 %, half again by 0.03 %
INNER = 1.0 / 120.0  # elements of OpenSees between the hinges over the column: waves of the impact


@dataclass(frozen=True)
class Bernoulli(FiberReissner):
    """The geometrically exact beam whose sections hardly shear: 1000 times the stiffness."""

    def section(self, frame: Frame, member: Member) -> BeamSection:
        section = super().section(frame, member)
        return replace(section, shear_stiffness=1000.0 * section.shear_stiffness)


def column(name: str, below: float, above: float, base: str, head: str, load: float, spring: float):
    return Column(
        find(name),
        below,
        above,
        fillets=False,
        base=base,
        head=head,
        axial_load=load,
        restraint_stiffness=spring,
    )


COLUMNS = {
    "restrained": (column("HEB 220", 0.8, 3.2, "clamped", "guided", 5e5, 1e7), 1500.0, 15.0, 0.04),
    "slower": (column("HEB 220", 0.8, 3.2, "clamped", "guided", 5e5, 1e7), 1500.0, 10.0, 0.03),
    "fixed": (column("HEB 220", 2.0, 2.0, "clamped", "fixed", 0.0, 0.0), 1500.0, 25.0, 0.045),
    "pinned": (column("HEB 220", 2.0, 2.0, "pinned", "pinned", 5e5, 1e7), 1500.0, 10.0, 0.07),
    "slender": (column("HEA 160", 3.0, 4.0, "clamped", "guided", 1e5, 2e6), 500.0, 8.0, 0.065),
    "short": (column("HEB 200", 1.0, 2.0, "clamped", "fixed", 2e5, 0.0), 2000.0, 8.0, 0.035),
}


def hit(name: str) -> ColumnImpact:
    given, mass, velocity, duration = COLUMNS[name]
    return ColumnImpact(name, given, Striker(mass, velocity), duration)


def inner(scenario: ColumnImpact) -> float:
    """Length (m) of OpenSees' elements between the hinges."""
    return INNER * (scenario.column.length_below + scenario.column.length_above)


def opensees_peak(scenario: ColumnImpact, smallest: float) -> float:
    """Peak (m) in OpenSeesPy on a mesh graded from its `smallest` elements (m) at the hinges."""
    model = Bernoulli(levels=1, smallest_element=smallest, largest_element=inner(scenario))
    lengths = model.lengths(scenario)
    opensees.stand(scenario.column, np.concatenate(lengths), model.hardening_ratio)
    return opensees.peak_under(scenario, len(lengths[0]) + 1, STEP * share(scenario.name))


def share(name: str) -> float:
    """Of OpenSees' steps and elements at hinges that a column needs."""
    return 0.5 if name in HALF else 1.0


@cache
def converged(name: str) -> float:
    """Peak (m) in OpenSeesPy with elements of no length at the hinges."""
    with threadpool_limits(1, user_api="blas"):
        smallest = share(name) * FINE
        coarse, fine = (opensees_peak(hit(name), times * smallest) for times in (2.0, 1.0))
    return 2.0 * fine - coarse  # first order in the smallest element, which is halved


@cache
def bias_of(name: str) -> tuple[float, float]:
    """Relative bias of the peak, and the stated relative half-width."""
    response = Bernoulli().simulate(hit(name))
    peak = float(response["peak_displacement"])
    width = json.loads(response.attrs["numerical_uncertainty"])["peak_displacement"] / peak
    bias = peak / converged(name) - 1.0
    print(f"{name}: {peak:.5f} m, OpenSees {converged(name):.5f} m, {bias:+.2%}, {width:.2%}")
    return bias, width


@pytest.mark.slow
@pytest.mark.parametrize("name", COLUMNS)
def test_peak_is_inside_the_stated_uncertainty(name) -> None:
    bias, width = bias_of(name)
    assert abs(bias) <= width


@pytest.mark.slow
@pytest.mark.parametrize("name", COLUMNS)
def test_peak_is_within_what_is_asked_for(name) -> None:
    bias, _ = bias_of(name)
    assert abs(bias) <= 0.004
