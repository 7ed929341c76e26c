"""Advice on which model to take instead: it goes up in trust, ends, and ends inside a domain."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import pytest

from workbench.base.catalogue import DATA, load
from workbench.models.base import make_model, model_kind, model_names
from workbench.models.four_dof import FourDof, FourDofShear
from workbench.models.references.fiber_beams import FiberShear
from workbench.models.superelements import FlexibleSuperelement
from workbench.responses import Finding, Response
from workbench.responses.outcome import WARNED
from workbench.scenarios import Column, ColumnImpact, ColumnPushover, Striker
from workbench.steel.sections import find, names, rectangular_tube, square
from workbench.study import load_study
from workbench.study.error_model.error_model import (
    NONE,
    ORDER,
    advise,
    advised,
    anchor_error,
    better,
    choose,
    with_remedies,
)
from workbench.study.error_model.error_table import ANCHOR, FINEST


def drawn(count: int) -> list[ColumnImpact]:
    """Columns and hits of all kinds, with fillets and without, some bouncing, some slender."""
    rng = np.random.default_rng(2701)
    rolled = sorted(names())
    hits = []
    for number in range(count):
        section = find(rolled[rng.integers(len(rolled))])
        if number % 8 == 0:
            section = rectangular_tube(0.2, 0.12, 0.006) if number % 16 else square(0.1)
        below, above = section.height + rng.uniform(0.1, 4.0, 2)
        column = Column(
            section,
            float(below),
            float(above),
            base=str(rng.choice(["clamped", "pinned"])),
            head=str(rng.choice(["guided", "pinned", "fixed"])),
            restraint_stiffness=float(rng.choice([0.0, 10.0 ** rng.uniform(5.0, 9.0)])),
            head_mass=float(rng.choice([0.0, 500.0])),
            fillets=bool(rng.integers(2)),
        )
        load = rng.choice([0.0, rng.uniform(0.0, 0.6)]) * column.properties.squash_load
        mass = column.properties.impact_mass * 10.0 ** rng.uniform(-0.5, 2.5)
        bounce = float(rng.choice([0.0, 0.0, rng.uniform(0.0, 1.0), 1.0]))
        striker = Striker(float(mass), float(10.0 ** rng.uniform(-0.3, 1.6)), bounce)
        column = replace(column, axial_load=float(load))
        hits.append(ColumnImpact(f"hit {number}", column, striker))
    return hits


@pytest.fixture(scope="module")
def models():
    kinds = {name: model_kind(name) for name in model_names() if name not in DATA}
    return {n: make_model(n) for n, kind in kinds.items() if ColumnImpact.KIND in kind.answers}


@pytest.mark.thorough
@pytest.mark.parametrize("count", [25, pytest.param(200, marks=pytest.mark.slow)])
def test_no_advice_goes_in_a_circle_and_all_of_it_ends_inside_a_domain(models, count: int) -> None:
    """Whatever model is asked, the one to take instead is followed until there is none."""
    below, taken = [name for name in models if name not in ORDER], set()
    for hit in drawn(count):
        trail: list[str] = []
        while names := better(trail[-1] if trail else below[0], hit):
            (name,) = names
            assert name not in trail
            trail.append(name)
            findings = models[name].domain(hit)
            if name == ANCHOR:
                error = anchor_error(hit)
                assert error.chance is not None, f"{hit.name}: {error}"
                assert not error.warns
                assert not [f for f in findings if f.refusal]
            else:
                assert not [f for f in findings if f.outside or f.refusal], f"{hit.name}: {trail}"
        assert len({better(name, hit) for name in below}) == 1
        chosen = choose(hit)
        assert chosen.model == (trail[0] if trail and trail[0] != FINEST else ANCHOR)
        taken.add(chosen.model)
    assert taken == set(ORDER[:2])


def advice_for(model: Any, hit: Any) -> dict[str, Finding]:
    return {f.subject: f for f in advise(model, hit, model.simulate(hit))}


def test_the_error_stands_in_place_of_what_a_domain_says(thesis_impact: ColumnImpact) -> None:
    statements = advice_for(FourDof(), thesis_impact)
    assert "shear" in {f.subject for f in FourDof().domain(thesis_impact)}
    assert set(statements) == {"error"}
    error = statements["error"]
    assert error.outside
    assert error.number > WARNED
    assert re.search(r"expect -\d+ %, 90 %: -\d+ to -\d+ %.*, because webs yield", error.text)
    assert error.remedy == f"take {ANCHOR}"
    assert (
        advice_for(make_model(ANCHOR), thesis_impact) == {}
    )  # within 10 %, and nothing else to say
    push = ColumnPushover("push", thesis_impact.column, 0.05)
    assert "shear" in advice_for(FourDof(), push)  # nothing was measured of these
    beam = make_model("fiber-reissner")
    assert "shear" in {f.subject for f in advise(beam, thesis_impact)}  # so that it judges nobody


def test_a_hit_that_hardly_yields_an_unequal_column_is_not_18_percent_off_in_silence() -> None:
    """The lumped mass stands for less than the longer bar takes up (docs/theory/hit-mass.md)."""
    column = Column(find("HEA 180"), 1.295, 5.115, axial_load=384.5e3)
    hit = ColumnImpact("unequal", column, Striker(392.0, 4.2))
    assert re.search(
        r"expect \+2\d %, 90 %: \+1\d to", advice_for(FourDofShear(), hit)["error"].text
    )


@pytest.mark.parametrize("name", ["single-dof", "energy-estimate"])
def test_the_default_resistance_sees_drawn_columns_collapse(name: str) -> None:
    """Cubic ones see none; with a fixed head they are low besides."""
    rows = load("columns")
    rows = rows[rows["reference_state"].isin(["ok", "collapse"])]
    falls, fixed = rows["reference_state"] == "collapse", rows["column.head"] == "fixed"
    given, cubic = rows[name], rows[f"{name} resistance=cubic"]
    assert make_model(name) == make_model(name, {"resistance": "analytic"})
    assert np.isinf(given[falls]).sum() >= 12 > np.isinf(cubic[falls]).sum() == 0
    ratios = (each[fixed & ~falls] / rows["reference_peak"] for each in (given, cubic))
    medians = [float(each[np.isfinite(each)].median()) for each in ratios]
    assert medians[0] > 0.94 > 0.91 > medians[1]


def test_outside_what_was_drawn_it_says_so_and_names_a_reference(thesis_impact) -> None:
    light = replace(thesis_impact, striker=Striker(3.0, 5.0))
    statements = advice_for(FourDof(), light)
    text = statements["error-not-measured"].text
    assert text.startswith("not measured here: ")
    assert "striker over lumped mass" in text
    assert "shear" in statements  # the physics is all that is known
    assert statements["error-not-measured"].remedy == "take fiber-shear"
    assert choose(light).model == "fiber-shear"


@dataclass(frozen=True)
class Biased(FlexibleSuperelement):
    """A model of somebody else, a fifth too small."""

    name: ClassVar[str] = "biased"

    def simulate(self, scenario: Any) -> Response:
        response = super().simulate(scenario)
        response["peak_displacement"] = 0.8 * response["peak_displacement"]
        return response


def test_a_plug_in_has_an_error_and_a_remedy_too(thesis_impact: ColumnImpact) -> None:
    error = json.loads(advised(Biased(), thesis_impact, Biased().simulate(thesis_impact)).error)
    answer = json.loads(advised(*answer_of(ANCHOR, thesis_impact)).error)
    assert 1.0 + error["expected"] == pytest.approx(0.8 * (1.0 + answer["expected"]))
    assert advice_for(Biased(), thesis_impact)["error"].remedy == f"take {ANCHOR}"


def answer_of(name: str, hit: Any) -> tuple[Any, Any, Response]:
    model = make_model(name)
    return model, hit, model.simulate(hit)


@pytest.mark.parametrize("falls", [True, False])
def test_where_a_model_and_the_anchor_differ_about_collapse_the_anchor_is_said(falls: bool) -> None:
    """A drawn column of which another model says the contrary of the anchor."""
    rows = load("columns")
    cases = {case.name: case.scenario for case in load_study("which_model").study.cases}
    name = "hand-estimate" if falls else "yin-wang"
    differs = (np.isinf(rows[ANCHOR]) == falls) & (np.isinf(rows[name]) != falls)
    known = rows[["reference_peak", ANCHOR, name]].notna().all(axis="columns")
    hit = cases[rows.loc[differs & known, "case"].iloc[0]]
    statements = advice_for(make_model(name), hit)["error"]
    assert statements.outside
    assert ("the anchor collapses" if falls else "the anchor survives") in statements.text
    assert statements.number > 0.7
    assert "error" not in advice_for(make_model(ANCHOR), hit) or not falls


@pytest.mark.parametrize(
    "change",
    [
        lambda hit: replace(hit, striker=replace(hit.striker, restitution=0.5)),
        lambda hit: replace(hit, striker=replace(hit.striker, restitution=1.0)),
        lambda hit: replace(hit, column=replace(hit.column, head_mass=2000.0)),
        lambda hit: replace(hit, column=replace(hit.column, head="fixed", restraint_stiffness=0.0)),
    ],
)
def test_restitution_head_mass_and_fixed_head_alone_warn_of_nothing(
    models, thesis_impact, change
) -> None:
    light = replace(thesis_impact, striker=Striker(60.0, 8.0))
    for hit in (thesis_impact, light):
        for name, model in models.items():
            before, after = ({f.subject for f in model.domain(h)} for h in (hit, change(hit)))
            assert after - {"unused-input"} <= before, name  # energies know no bounce in part


def test_nothing_is_above_the_last_and_input_that_is_mended_stays(thesis_impact) -> None:
    last = make_model(ORDER[-1])
    findings = [
        Finding("any", "text", instead=()),
        Finding("no-peak", "text", remedy="take longer"),
    ]
    none, kept = with_remedies(last, thesis_impact, findings)
    assert none.remedy == NONE
    assert none.instead == ()
    assert kept == findings[1]
    assert with_remedies(last, thesis_impact, [none]) == [none]


def test_beams_are_not_advised_where_webs_slide_further_than_they_follow(thesis_impact) -> None:
    """Webs slide by most of the shorter segment: `fiber-shear` does not stretch."""
    assert better(ANCHOR, thesis_impact) == (FINEST,)
    gentle = thesis_impact.at_velocity(3.0)
    assert better(ANCHOR, gentle) == ("fiber-shear",)
    slid = Finding("shear-strain", "a mean shear strain of 0.88", number=0.88, instead=())
    (slid,) = with_remedies(FiberShear(), thesis_impact, [slid])
    assert slid.remedy == "take solid-plane-stress, which takes minutes"
