"""What a frame is said to be after a hit: how near its fall, and where it comes to rest."""

from __future__ import annotations

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest
from builders import SQUARE

from workbench.mechanics.frames.collapse import sway_collapse, sway_findings
from workbench.mechanics.frames.elastic import slowest_period
from workbench.models.superelements import FlexibleSuperelement, RigidSuperelement
from workbench.responses import Outcome, Response, outcome_of, warnings_of
from workbench.responses.histories import residual_over
from workbench.scenarios import (
    Column,
    ColumnImpact,
    FrameImpact,
    FrameStriker,
    Load,
    Node,
    Striker,
    regular_frame,
)
from workbench.steel.sections import find

HEIGHT, DEAD = 4.0, 5.5e5


def portal_on_pins(velocity: float, duration: float = 0.9, dead: float = DEAD) -> FrameImpact:
    """Near its sway collapse: HEA 220 under 550 kN each, IPE 360, hit half-way up."""
    bare = regular_frame((5.0,), (HEIGHT,), find("HEA 220"), find("IPE 360"), "pinned")
    loads = tuple(Load(name, y=-dead) for name in ("A1", "B1")) if dead else ()
    frame = replace(bare, loads=loads, fillets=False).split("A0-A1", 0.5 * HEIGHT, "hit")
    return FrameImpact("hit", frame, FrameStriker(500.0, velocity, node="hit"), duration)


def subjects(response: Response) -> dict[str, float | None]:
    return {finding.subject: finding.number for finding in warnings_of(response)}


# -- how near it is to its fall ----------------------------------------------------------------


def test_the_way_to_the_fall_is_that_of_a_rigid_plastic_portal() -> None:
    """Two hinges under the beam resist 2 M / h; two columns under P take 2 P w / h of it."""
    hit = portal_on_pins(7.0)
    sway, moment = sway_collapse(hit), hit.frame.properties("B0-B1").plastic_moment
    assert sway is not None
    falling = moment / (DEAD * HEIGHT)  # drift
    assert sway @ np.full(3, falling) == pytest.approx(1.0, rel=1e-4)
    assert sway_collapse(portal_on_pins(7.0, dead=0.0)) is None
    # energies: with a tenth less resistance the way to the fall takes what half of it took
    reached = 1.0 - sqrt(1.0 - 0.9**2)
    assert sway_findings(sway, np.full(3, 0.99 * reached * falling)) == []
    (finding,) = sway_findings(sway, np.full(3, 1.01 * reached * falling))
    assert finding.number == pytest.approx(1.01 * reached, rel=1e-4)
    assert finding.remedy


@pytest.mark.thorough
@pytest.mark.parametrize("model", [RigidSuperelement(), FlexibleSuperelement()])
def test_a_frame_that_just_stands_is_told(model: FlexibleSuperelement) -> None:
    """Of 7 m/s fibers say that it falls; these models by a few percent more."""
    stands = model.simulate(portal_on_pins(7.0))
    assert outcome_of(stands) is Outcome.OK
    assert 0.55 < subjects(stands)["near-collapse"] < 0.9
    falls = model.simulate(portal_on_pins(7.5))
    assert outcome_of(falls) is Outcome.COLLAPSE
    assert "near-collapse" not in subjects(model.simulate(portal_on_pins(4.0, 0.3)))
    assert "near-collapse" not in subjects(model.simulate(portal_on_pins(7.0, 0.3, 5e4)))


# -- where it comes to rest --------------------------------------------------------------------


def test_the_slowest_period_is_that_of_a_mass_on_a_cantilever() -> None:
    """Dead loads make it slower; a blow along the column does not feel it."""
    bare = regular_frame((5.0,), (HEIGHT,), SQUARE, SQUARE)
    column = bare.member("A0-A1")
    nodes = (Node("A0", 0.0, 0.0, support="clamped"), Node("A1", 0.0, HEIGHT, mass=1e5))
    frame = replace(bare, nodes=nodes, members=(column,), loads=())
    bending, axial = 210e9 * SQUARE.second_moment, 210e9 * SQUARE.area
    sway = 2.0 * pi * sqrt(1e5 * HEIGHT**3 / (3.0 * bending))
    assert slowest_period(frame, "A1", "+x") == pytest.approx(sway, rel=0.01)
    along = 2.0 * pi * sqrt(1e5 * HEIGHT / axial)
    assert slowest_period(frame, "A1", "-y") == pytest.approx(along, rel=0.01)
    euler = pi**2 * bending / (2.0 * HEIGHT) ** 2
    heavy = replace(frame, loads=(Load("A1", y=-0.5 * euler),))
    assert slowest_period(heavy, "A1", "+x") == pytest.approx(sway * sqrt(2.0), rel=0.01)


def test_a_part_of_a_slow_cycle_is_no_residual_displacement() -> None:
    """A fast cycle on a slow one about 20 mm: told as soon as the slow one has a mean."""
    time = np.linspace(0.0, 1.0, 4001)
    moved = 0.02 - 0.01 * np.cos(2.0 * pi * time / 0.2) - 0.012 * np.cos(2.0 * pi * time / 0.021)
    start = 0.1
    for end in np.arange(0.2, 1.0, 0.05):
        until = time <= end
        value, statements = residual_over(time[until], moved[until], start, 0.2)
        assert bool(statements) == (end < start + 0.3)
        if value is not None:
            assert value == pytest.approx(0.02, abs=5e-4)
    short = time <= start + 0.29
    value, (result,) = residual_over(time[short], moved[short], start, 0.2)
    assert value is None
    assert "set time.duration to" in result.remedy
    assert float(result.remedy.split(" to ")[1].split()[0]) > start + 0.3


def test_a_short_record_of_a_frame_has_no_residual_but_a_duration_to_set() -> None:
    """An elastic hit comes to rest where it was; a sixth of a cycle said something else."""
    hit = portal_on_pins(1.0, 0.1, dead=0.0)
    short = FlexibleSuperelement().simulate(hit)
    assert "residual_displacement" not in short
    (finding,) = (f for f in warnings_of(short) if f.subject == "no-residual")
    assert not finding.outside
    needed = float(finding.remedy.split(" to ")[1].split()[0])
    whole = FlexibleSuperelement().simulate(replace(hit, duration=1.5 * needed))
    peak, rest = (float(whole[name]) for name in ("peak_displacement", "residual_displacement"))
    assert abs(rest) < 0.1 * peak


def test_columns_do_not_drift() -> None:
    """What is zero by construction is no quantity of a response."""
    column = ColumnImpact("c", Column(find("HEB 220"), 0.8, 3.2), Striker(500.0, 2.0), 0.02)
    response = FlexibleSuperelement().simulate(column)
    assert "drift" not in response
    assert "largest_drift" not in response
