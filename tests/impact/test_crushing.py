"""A striker that crushes: its law, its limits, its energy, and models of other kinds beside it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.base.errors import InputError
from workbench.cli import run
from workbench.mechanics.impact import contact
from workbench.mechanics.impact.integrator import law_of
from workbench.models.base import make_model
from workbench.models.four_dof import FourDof
from workbench.models.single_dof import SingleDof
from workbench.models.soft_impact import SoftImpact
from workbench.models.strain_rate import with_strain_rate
from workbench.responses import Response, findings_of, outcome_of
from workbench.scenarios import (
    Column,
    ColumnImpact,
    Striker,
    column,
    frame_scenario,
    load_scenario,
    scenario_hash,
    to_toml,
)
from workbench.scenarios.pulse import LIGHTEST
from workbench.steel.materials import Steel
from workbench.steel.sections import find
from workbench.study.error_model.error_model import expected_error
from workbench.study.error_model.error_table import DEMAND, YIELDING, features

POINTS = ((0.0, 0.0), (0.1, 2e5), (0.2, 2e5), (0.3, 1e5), (0.4, 4e5))
PEAK = "peak_displacement"


def peak(response: Response) -> float:
    assert response.attrs["outcome"] == "ok", response.attrs["message"]
    return float(response[PEAK])


def crushing_by(impact: ColumnImpact, **law: object) -> ColumnImpact:
    return replace(impact, striker=replace(impact.striker, **law))


@given(
    st.floats(-0.1, 0.6), st.floats(-0.1, 0.6), st.floats(0.0, 0.5), st.sampled_from([None, 3e5])
)
def test_the_mean_force_does_the_work_of_the_law(
    start: float, end: float, crushed: float, stiffness: float | None
) -> None:
    points = POINTS if stiffness is None else None
    law = law_of(Striker(1500.0, 15.0, stiffness=stiffness, crush=points))
    law["crushed"] = crushed = max(crushed, start)
    knots = [contact.front(law), crushed, *law["strokes"]]
    way = np.unique(np.clip([start, end, *knots], *sorted((start, end))))
    forces = [contact.force_at(law, each)[0] for each in way]
    if abs(end - start) < 1e-6:
        return
    mean, slope = contact.mean_force(law, start, end)
    assert min(forces) >= 0.0
    assert mean * abs(end - start) == pytest.approx(np.trapezoid(forces, way), abs=1e-4)
    farther = end + 1e-7 * (1.0 if end > start else -1.0)
    if not any(abs(end - knot) < 1e-6 for knot in knots):
        change = (contact.mean_force(law, start, farther)[0] - mean) / (farther - end)
        assert slope == pytest.approx(change, rel=1e-3, abs=1e3)  # of 2e8 N/m backwards


def test_as_many_points_are_kept_as_a_scenario_takes() -> None:
    assert contact.MOST_POINTS == column.MOST_POINTS
    points = [(0.01 * i, 1e4 * i) for i in range(column.MOST_POINTS)]
    law = law_of(Striker(1.0, 1.0, crush=tuple(points)))
    assert contact.envelope(law, 0.485)[0] == pytest.approx(4.85e5)


@pytest.mark.parametrize("model", [SingleDof(), FourDof()], ids=lambda model: model.name)
def test_a_stiff_striker_is_the_rigid_one(model: SingleDof | FourDof) -> None:
    for section, length, mass in (("HEB 220", 4.0, 1500.0), ("IPE 300", 5.0, 400.0)):
        bar = Column(find(section), 0.4 * length, 0.6 * length, axial_load=1e5)
        rigid = ColumnImpact("rigid", bar, Striker(mass, 8.0), 0.1)
        stiff = model.simulate(crushing_by(rigid, stiffness=1e9))
        assert peak(stiff) == pytest.approx(peak(model.simulate(rigid)), rel=0.01)


LAWS = ({"stiffness": 4e6}, {"crush": ((0.0, 0.0), (0.1, 3e5), (0.2, 3e5), (0.3, 2e6))})


@pytest.mark.parametrize("law", LAWS, ids=["stiffness", "points"])
def test_models_on_a_mass_agree_and_their_ledgers_close(
    law: dict[str, object], thesis_impact: ColumnImpact
) -> None:
    impact = crushing_by(replace(thesis_impact, duration=0.3), **law)
    implicit, leapfrog = SingleDof().simulate(impact), SoftImpact().simulate(impact)
    assert peak(implicit) == pytest.approx(peak(leapfrog), rel=2e-3)
    for response, bound in ((implicit, 1e-9), (leapfrog, 1e-4), (FourDof().simulate(impact), 1e-6)):
        assert "contact_loss" not in response
        spent, whole = response["crushing"].values, impact.input_energy
        assert abs(response["balance_error"]).max() < bound * whole
        _, forces = np.transpose(impact.striker.crush or ((0.0, 0.0), (1.0, 4e6)))
        assert 0.0 < spent.max() <= whole
        kept = 0.5 * float(response["peak_force"]) ** 2 / law_of(impact.striker)["unloading"]
        assert spent[-1] >= spent.max() - 1.2 * kept - bound * whole  # steep: little comes back
        assert float(response["peak_force"]) < 1.01 * forces.max()


def test_a_striker_that_is_crushed_past_its_law_says_so(thesis_impact: ColumnImpact) -> None:
    impact = crushing_by(thesis_impact, crush=((0.0, 0.0), (0.1, 2e5), (0.2, 2e5)))
    findings = findings_of(SingleDof().simulate(replace(impact, duration=0.3)))
    past = [each for each in findings if each.subject == "crush-law"]
    work = impact.input_energy  # the column stays elastic: nearly all of it crushes
    assert len(past) == 1
    assert past[0].number == pytest.approx(0.05 + work / 2e5, rel=0.03)


@pytest.mark.parametrize("model", ["biggs", "energy-estimate", "hand-estimate"])
def test_who_knows_rigid_strikers_only_refuses_in_one_line(
    model: str, thesis_impact: ColumnImpact
) -> None:
    impact = crushing_by(thesis_impact, stiffness=3e5)
    response = make_model(model).simulate(impact)
    assert outcome_of(response).value == "out-of-domain"
    assert "rigid strikers only" in response.attrs["message"]
    assert "\n" not in response.attrs["message"]


def test_hard_impact_takes_one_stiffness(thesis_impact: ColumnImpact) -> None:
    given_twice = make_model("en-1991-hard-impact", {"striker_stiffness": 6e5}).simulate(
        thesis_impact
    )
    law = crushing_by(thesis_impact, stiffness=6e5)
    response = make_model("en-1991-hard-impact").simulate(law)
    assert peak(response) == peak(given_twice)
    points = make_model("en-1991-hard-impact").simulate(crushing_by(thesis_impact, crush=POINTS))
    assert "one stiffness" in points.attrs["message"]


@pytest.mark.parametrize(
    ("law", "message"),
    [
        ({"stiffness": 0.0}, "must be a number from 1"),
        ({"stiffness": 3e5, "restitution": 0.2}, "must be 0 where the striker crushes"),
        ({"stiffness": 3e5, "crush": POINTS}, "cannot stand beside crush"),
        ({"crush": ((0.0, 1.0), (0.4, 4e5))}, "must begin with"),
        ({"crush": ((0.0, 0.0),)}, "2 to 50 of them"),
        ({"crush": ((0.0, 0.0), (0.4,))}, "2 numbers"),
        ({"crush": ((0.0, 0.0), (0.4, 4e5), (0.3, 5e5))}, "strokes must rise"),
        ({"crush": ((0.0, 0.0), (0.4, 0.0))}, "must rise somewhere"),
        ({"crush": ((0.0, 0.0), (0.4, -1.0))}, "must be a number from 0"),
    ],
)
def test_laws_that_are_none(law: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message) as error:
        Striker(**{"mass": 1500.0, "velocity": 15.0, **law})  # type: ignore[arg-type]
    assert "\n" not in str(error.value)


def test_files_keep_the_law_and_rigid_strikers_their_hash(
    thesis_impact: ColumnImpact, tmp_path: object
) -> None:
    assert "stiffness" not in to_toml(thesis_impact).replace("restraint_stiffness", "")
    assert "crush" not in to_toml(thesis_impact)
    path = f"{tmp_path}/scenario.toml"
    for law in ({"stiffness": 3e5}, {"crush": POINTS}):
        for impact in (
            crushing_by(thesis_impact, **law),
            frame_scenario(crushing_by(thesis_impact, **law)),
        ):
            Path(path).write_text(to_toml(impact), "utf-8")
            assert load_scenario(path) == impact
        assert scenario_hash(crushing_by(thesis_impact, **law)) != scenario_hash(thesis_impact)


def test_an_error_was_measured_and_no_collision_gives_a_rate(thesis_impact: ColumnImpact) -> None:
    impact = crushing_by(thesis_impact, stiffness=3e6)
    error = expected_error(impact, FourDof().simulate(impact))
    assert error.low < error.expected < error.high
    assert "front that crushes" in error.cell
    bar = impact.column
    mild = replace(impact, column=replace(bar, steel=Steel(grade="S355")))
    assert with_strain_rate(FourDof(), replace(mild, striker=thesis_impact.striker))[1] > 1.1
    scenario, factor, findings = with_strain_rate(FourDof(), mild)
    assert (scenario.column.steel.rate, factor) == (None, 1.0)
    assert any("strain rate" in str(each) for each in findings)


def test_a_rigid_vehicle_is_an_upper_bound(
    thesis_impact: ColumnImpact, tmp_path: object, capsys: pytest.CaptureFixture[str]
) -> None:
    assert LIGHTEST == 1500.0  # a car, EN 1991-1-7, Table C.2
    for mass, stiffness, notes in ((1500.0, None, 1), (1499.0, None, 0), (1500.0, 3e5, 0)):
        path = f"{tmp_path}/scenario.toml"
        hit = crushing_by(thesis_impact, mass=mass, stiffness=stiffness)
        Path(path).write_text(to_toml(hit), "utf-8")
        assert run(["simulate", path, "--model", "single-dof"]) == 0
        assert capsys.readouterr().out.count("upper bound") == notes


def bending(number: int) -> list[ColumnImpact]:
    """Columns, drawn once, whose webs carry twice the mechanism, hit beyond their elastic limit."""
    generator, impacts = np.random.default_rng(31), list[ColumnImpact]()
    while len(impacts) < number:
        section = find(generator.choice(["HEB 180", "HEB 220", "HEB 300", "IPE 300", "HEA 240"]))
        length, at = generator.uniform(3.5, 6.0), generator.uniform(0.3, 0.7)
        base = str(generator.choice(["clamped", "pinned"]))
        bar = Column(section, at * length, (1.0 - at) * length, base=base, fillets=False)
        mass = float(np.exp(generator.uniform(np.log(600.0), np.log(3000.0))))
        velocity = generator.uniform(6.0, 14.0)
        stiffness = float(np.exp(generator.uniform(np.log(2e6), np.log(2e7))))
        striker = Striker(mass, velocity, stiffness=stiffness)
        hit = ColumnImpact("c", bar, striker, 0.3)
        values = features(hit)
        if values[DEMAND] <= 0.5 and 10.0 <= values[YIELDING] <= 60.0:
            impacts.append(hit)
    return impacts


@pytest.mark.slow
def test_superelements_meet_fibers_where_bending_governs() -> None:
    """Two masses and four degrees of freedom agree too, and are up to a tenth off both."""
    names = ("soft-impact", "four-dof", "flexible-superelement")
    models = [
        *(make_model(name, {}) for name in names),
        make_model("fiber-reissner", {"levels": 1}),
    ]
    for impact in bending(10):
        masses, lumped, superelements, fibers = (peak(each.simulate(impact)) for each in models)
        assert superelements == pytest.approx(fibers, rel=0.05)
        assert masses == pytest.approx(lumped, rel=0.02)
        assert masses == pytest.approx(fibers, rel=0.12)
