"""Columns whose steel hardens, with and without a rate: bars of level B against fibers."""

from dataclasses import replace
from itertools import islice
from pathlib import Path

import pytest

from workbench.materials import MILD_STEEL, CowperSymonds
from workbench.models.four_dof import FourDof
from workbench.references.fiber_reissner import FiberReissner
from workbench.study import load_study

STUDY = Path(__file__).parents[2] / "studies" / "rate_columns.py"


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [0.002, 0.01])
@pytest.mark.parametrize("rate", [None, MILD_STEEL], ids=["static", "rate"])
def test_eight_columns_that_harden(ratio: float, rate: CowperSymonds | None) -> None:
    """The first eight of the study that are clamped, guided and hit from 0.21 L on."""
    columns = (case.scenario for case in load_study(str(STUDY)).study.cases)
    supported = (
        each
        for each in columns
        if (each.column.base, each.column.head) == ("clamped", "guided")
        and each.column.length_below > 0.21 * each.column.length
    )
    model, fibers = FourDof(hit_mass="waves", rate_level="bars"), FiberReissner(levels=1)
    errors = []
    for impact in islice(supported, 8):
        steel = impact.column.steel
        steel = replace(steel, rate=rate, hardening_modulus=ratio * steel.elastic_modulus)
        hit = replace(impact, column=replace(impact.column, steel=steel), duration=0.4)
        peaks = (float(each.simulate(hit)["peak_displacement"]) for each in (model, fibers))
        errors.append(next(peaks) / next(peaks) - 1.0)
    # measured: 31 of 32 within 3 %, the other -3.02 % (IPE 360, 0.01 E, on two meshes of fibers)
    assert sum(abs(each) < 0.03 for each in errors) >= 7
    assert max(map(abs, errors)) < 0.031
