"""Frames whose steel has a rate: superelements with one factor against fibers with the law."""

from dataclasses import replace
from pathlib import Path

import pytest

from workbench.models.references.fiber_beams import FiberShear
from workbench.models.superelements import FlexibleSuperelement
from workbench.responses import outcome_of
from workbench.steel.materials import CowperSymonds
from workbench.study import load_study

STUDY = Path(__file__).parents[2] / "studies" / "drawn_frames.py"
LAWS = tuple(CowperSymonds(D, 5.0) for D in (40.4, 500.0, 3000.0))


@pytest.mark.slow
def test_eight_of_ten_frames_are_within_a_tenth() -> None:
    """The first ten drawn frames that have a peak by both."""
    errors: list[float] = []
    for number, case in enumerate(load_study(str(STUDY)).study.cases[:14]):
        frame = case.scenario.frame
        steel = replace(frame.steel, rate=LAWS[number % len(LAWS)])
        scenario = replace(case.scenario, frame=replace(frame, steel=steel))
        model, fibers = FlexibleSuperelement(), FiberShear(levels=1)
        both = model.simulate(scenario), fibers.simulate(scenario)
        if all(outcome_of(each) == "ok" and "peak_displacement" in each for each in both):
            peak, reference = (float(each["peak_displacement"]) for each in both)
            errors.append(peak / reference - 1.0)
    assert len(errors) >= 10
    assert sum(abs(error) <= 0.10 for error in errors[:10]) >= 8
