"""Hits beside the shear centre: the drawn pairs, the factor they give, who answers with it."""

from __future__ import annotations

import re
from dataclasses import replace
from math import radians, tan
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from workbench.api.sweeps import sweep
from workbench.base.catalogue import load
from workbench.cli import run
from workbench.models.base import make_model
from workbench.models.batch import simulate_many
from workbench.models.domain import (
    EDGE,
    FACE,
    FEATURES_BESIDE,
    MESH,
    PAIRS_BESIDE,
    PRESSED,
    factor,
    factor_line,
    features_beside,
    log_factors,
    oblique_findings,
    undrawn,
)
from workbench.models.frame_model import as_frame
from workbench.models.references.shell import Shell
from workbench.responses import Outcome, findings_of, outcome_of
from workbench.scenarios import Column, ColumnImpact, Striker
from workbench.scenarios.files import to_toml
from workbench.steel.materials import Steel
from workbench.steel.sections import find
from workbench.study.error_model.error_model import choose, expected_error
from workbench.study.limit import find_limit

PAIRS = load(PAIRS_BESIDE)
ANSWERED = PAIRS[(PAIRS["refinement"] == MESH) & (PAIRS["eccentric_outcome"] == "ok")]
HIT = ColumnImpact(
    "hit", Column("HEB 220", 1.6, 2.3, axial_load=3e5), Striker(760.0, 9.9, eccentricity=0.07), 0.05
)


def drawn(row: Any) -> ColumnImpact:
    """The eccentric hit of a stored row."""
    column = Column(
        find(row["section"]),
        row["length_below_m"],
        row["length_above_m"],
        Steel(yield_stress=row["yield_stress_Pa"]),
        axial_load=row["axial_load_N"],
        restraint_stiffness=row["restraint_stiffness_N_per_m"],
    )
    striker = Striker(row["striker_mass_kg"], row["striker_velocity_m_per_s"])
    striker = striker.changed(eccentricity=row["eccentricity_m"])
    return ColumnImpact(row["case"], column, striker, row["duration_s"])


def test_sixty_pairs_of_six_families_were_drawn_and_more_that_go_far() -> None:
    coarse = PAIRS[PAIRS["refinement"] == MESH]
    assert len(coarse) == 84
    assert len(set(coarse["section"].str.split().str[0])) == 6
    assert coarse["eccentricity_over_half_width"].between(0.0, 1.0).all()


def test_stored_features_are_those_of_the_stored_inputs() -> None:
    for _, row in PAIRS.iterrows():
        values = features_beside(drawn(row))
        for name in (*FEATURES_BESIDE, PRESSED):
            assert values[name] == pytest.approx(row[name], rel=2e-5, abs=1e-5)


def test_a_stored_pair_is_what_shells_say() -> None:
    row = PAIRS[PAIRS["refinement"] == MESH].sort_values("duration_s").iloc[0]
    response = Shell(levels=1, refinement=MESH).simulate(drawn(row))
    assert float(response["displacement"].max()) == pytest.approx(row[FACE], rel=0.01)
    assert float(response["shell.edge"].max()) == pytest.approx(row[EDGE], rel=0.01)


def test_the_default_mesh_says_the_same_of_edge_and_striker() -> None:
    fine = PAIRS[PAIRS["refinement"] == 0].set_index("case")
    coarse = PAIRS[PAIRS["refinement"] == MESH].set_index("case").loc[fine.index]
    for target, most in ((EDGE, 0.05), (FACE, 0.10)):
        ratio = (fine[target] / fine["centred_axis_m"]) / (
            coarse[target] / coarse["centred_axis_m"]
        )
        assert abs(np.log(ratio).median()) < most


@pytest.mark.parametrize("target", [EDGE, FACE])
def test_nine_of_ten_pairs_lie_in_the_interval_of_the_others(target: str) -> None:
    """The line by another solver; rests by lines without their pair."""
    given = np.column_stack([np.ones(len(ANSWERED)), ANSWERED[list(FEATURES_BESIDE)]])
    ratios = np.log(ANSWERED[target] / ANSWERED["centred_axis_m"]).to_numpy()
    known = np.isfinite(ratios)
    given, ratios = given[known], ratios[known]
    found = factor_line(target)
    assert found.coefficients == pytest.approx(np.linalg.lstsq(given, ratios)[0], rel=1e-6)
    rests = []
    for number in range(len(ratios)):
        kept = np.arange(len(ratios)) != number
        slope = np.linalg.lstsq(given[kept], ratios[kept])[0]
        rests.append(ratios[number] - given[number] @ slope)
    assert found.rests == pytest.approx(np.sort(rests), abs=1e-9)
    low, high = np.quantile(rests, [0.05, 0.95], method="weibull")
    assert np.mean((rests >= low) & (rests <= high)) == pytest.approx(0.9, abs=0.02)


@pytest.mark.parametrize("name", ["four-dof", "seven-dof", "flexible-superelement"])
def test_models_that_never_twist_answer_with_a_factor(name: str) -> None:
    model = make_model(name)
    centred = replace(HIT, striker=HIT.striker.changed(eccentricity=0.0))
    response = model.simulate(HIT)
    assert outcome_of(response) is Outcome.OK
    peak = float(response["peak_displacement"])
    assert peak == float(model.simulate(centred)["peak_displacement"])
    (warned,) = (each for each in findings_of(response) if each.subject == "eccentricity")
    low, middle, high = factor(HIT, EDGE)
    assert f"goes {middle:.2f} times ({low:.2f} to {high:.2f}) as far as the axis" in warned.text
    assert warned.outside
    assert "take shell" in str(warned)
    assert 1.0 < low < middle < high


def test_both_edges_are_alike_and_the_outer_one_goes_farther() -> None:
    def at(place: float) -> tuple[float, float, float]:
        return factor(replace(HIT, striker=HIT.striker.changed(eccentricity=place)), EDGE)

    assert at(0.07) == at(-0.07)
    assert at(0.03)[1] < at(0.07)[1]


@pytest.mark.parametrize(
    "changes",
    [
        {"column.section": find("SHS 200x10")},
        {"column.axis": "weak"},
        {"column.axial_load": 1.5e6},
        {"striker.eccentricity": 0.12},
        {"striker.angle": 0.2},
        {"striker.stiffness": 1e6},
        {"striker.velocity": 0.5},
    ],
)
def test_what_was_not_drawn_is_refused(changes: dict[str, Any]) -> None:
    hit = HIT
    for path, value in changes.items():
        part, field = path.split(".")
        hit = replace(hit, **{part: getattr(hit, part).changed(**{field: value})})
    assert undrawn(hit)
    response = make_model("four-dof").simulate(hit)
    assert outcome_of(response) is Outcome.OUT_OF_DOMAIN
    (refused,) = (each for each in findings_of(response) if each.subject == "eccentricity")
    assert refused.refusal
    assert undrawn(hit) in refused.text


def test_a_frame_that_is_hit_beside_the_shear_centre_is_refused() -> None:
    frame = as_frame(replace(HIT, striker=HIT.striker.changed(eccentricity=0.0)))
    frame = replace(frame, striker=frame.striker.changed(eccentricity=0.07))
    response = make_model("flexible-superelement").simulate(frame)
    assert outcome_of(response) is Outcome.OUT_OF_DOMAIN
    assert "shells were drawn of I sections" in response.attrs["message"]


@pytest.mark.parametrize("name", ["four-dof", "seven-dof", "flexible-superelement"])
def test_rows_of_a_table_carry_the_factor(name: str) -> None:
    hits = [replace(HIT, striker=HIT.striker.changed(eccentricity=e)) for e in (0.0, 0.05, 0.2)]
    table = simulate_many(make_model(name), hits)
    assert list(table["outcome"]) == ["ok", "ok", "out-of-domain"]
    centred, beside = table["peak_displacement"][:2]
    assert beside == pytest.approx(centred, rel=1e-6)
    known = table.loc[1, ["edge_factor_low", "edge_factor", "edge_factor_high"]]
    assert tuple(known) == factor(hits[1], EDGE)
    assert table["edge_factor"].isna().tolist() == [True, False, True]
    assert "edge_factor" not in simulate_many(make_model(name), hits[:1])


@pytest.fixture
def file(tmp_path: Path) -> str:
    path = tmp_path / "hit.toml"
    path.write_text(to_toml(HIT))
    return str(path)


def test_a_sweep_names_the_factor_and_its_picture_the_hit(
    file: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    over = {"striker.eccentricity": [0.0, 0.07]}
    swept = sweep(HIT, over, ["four-dof"])["edge_factor"]
    assert "of the struck edge" in swept.attrs["long_name"]
    middle = factor(HIT, EDGE)[1]
    assert swept.to_numpy().ravel() == pytest.approx([np.nan, middle], nan_ok=True)
    picture = tmp_path / "peaks.svg"
    asked = ["--over", "striker.eccentricity=0,0.07", "--model", "four-dof", "--plot", str(picture)]
    assert run(["sweep", file, *asked]) == 0
    assert f"{middle:.2f}" in capsys.readouterr().out
    assert "as if hit through the shear centre" in picture.read_text()


def test_a_limit_says_that_it_is_of_the_hit_through_the_shear_centre(
    file: str, capsys: pytest.CaptureFixture[str]
) -> None:
    narrow = ["--from", "9", "--to", "10", "--tolerance", "0.5", "--model", "four-dof"]
    assert run(["limit", file, *narrow]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert "no collapse up to 10 m/s (36 km/h), hit through the shear centre" in text
    assert "warning of four-dof there (eccentricity)" in text
    limit = find_limit(make_model("four-dof"), HIT.at_velocity, (9.0, 10.0), 0.5)
    assert "as if hit through the shear centre" in " ".join(map(str, limit.warnings))


def test_the_error_of_an_answer_holds_what_it_leaves_out() -> None:
    """It moves by the factor of the striker, and no side of its interval becomes smaller."""
    model = make_model("flexible-superelement")
    centred = replace(HIT, striker=HIT.striker.changed(eccentricity=0.0))
    plain, beside = (expected_error(each, model.simulate(each)) for each in (centred, HIT))
    assert None not in (plain.low, plain.high, beside.low, beside.expected)
    assert beside.low < plain.low
    ratio = (1.0 + plain.expected) / (1.0 + beside.expected)
    assert ratio == pytest.approx(np.exp(np.median(log_factors(HIT, FACE))), rel=1e-3)
    assert beside.residual is None
    assert choose(HIT).model == "shell"


def test_an_oblique_hit_folds_the_flange_that_its_line_meets() -> None:
    """As one along the web so far beside it; from the corner on the other flange takes a part."""

    def oblique(degrees: float) -> list[str]:
        striker = HIT.striker.changed(angle=radians(degrees), eccentricity=0.0)
        response = make_model("seven-dof").simulate(replace(HIT, striker=striker))
        return [each.text for each in findings_of(response) if each.subject == "direction"]

    beside = 0.5 * (0.22 - 0.016) * tan(radians(30.0))
    along = replace(HIT, striker=HIT.striker.changed(eccentricity=beside))
    low, middle, high = factor(along, FACE)
    (text,) = oblique(30.0)
    assert f"{beside:.3g} m beside the web" in text
    assert f"goes {middle:.2f} times ({low:.2f} to {high:.2f})" in text
    assert oblique(0.0) == oblique(85.0) == []
    edge = replace(HIT, striker=HIT.striker.changed(eccentricity=0.11))
    share = 0.11 / (0.5 * (0.22 - 0.016) * tan(radians(60.0)))
    middle = factor(edge, FACE)[1] ** share
    (text,) = oblique(60.0)
    assert f"its edge takes {50.0 * (1.0 + share):.0f} % of the force" in text
    assert f"goes {middle:.2f} times" in text


@pytest.mark.parametrize(
    ("section", "degrees", "over_the_axis_of_hinges"),
    [
        *(("IPE 300", 30.0, 1.54), ("IPE 300", 65.0, 1.04), ("HEB 220", 65.0, 1.32)),
        *(("UB 457x191x82", 45.0, 1.23), ("HEA 300", 65.0, 1.92)),
    ],
)
def test_shells_struck_on_both_edges_lie_in_the_interval(
    section: str, degrees: float, over_the_axis_of_hinges: float
) -> None:
    """Strikers of coarser shells over `seven-dof`, columns of the study `struck_shells`."""
    column = Column(find(section), 1.4, 2.6, restraint_stiffness=5e6)
    properties = column.properties
    column = column.changed(axial_load=0.1 * properties.squash_load)
    resistance = 2.0 * properties.plastic_moment * (1.0 / 1.4 + 1.0 / 2.6)
    striker = Striker(2.0 * resistance * 0.056 / 100.0, 10.0, angle=radians(degrees))
    (said,) = oblique_findings(ColumnImpact("hit", column, striker, 0.1))
    low, high = map(float, re.findall(r"\(([\d.]+) to ([\d.]+)\)", said.text)[0])
    assert low < over_the_axis_of_hinges < high
