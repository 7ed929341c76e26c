"""Fragility curves as answers: what a study stores, compares and shows of them."""

import numpy as np
import pytest
from builders import UNCERTAIN
from pages import views

from workbench.base.errors import InputError
from workbench.extras.uncertainty.chapter import in_short
from workbench.extras.uncertainty.exceedance import MEDIAN, Exceedance, shares
from workbench.extras.uncertainty.scenario import UncertainImpact
from workbench.report.gallery import draw_all
from workbench.responses import Outcome, attribute, outcome_of
from workbench.responses.uncertainty import SAMPLE_WIDTHS
from workbench.scenarios import load_scenario, to_toml
from workbench.study import Case, Figure, Study, run_study
from workbench.study.assessor import assess, read_assessment

TEXT = f"""{UNCERTAIN}mass = {{ lognormal = {{ mean = 1500.0, cov = 0.1 }} }}
velocity = 10.0
"""
LINES = tuple(TEXT.strip().splitlines())
SCENARIO = UncertainImpact("column", LINES, 5.0, 20.0, 0.1)
CORRECTED, ALONE = "corrected", "alone"


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    study = Study(
        name="curves",
        title="Curves",
        question="How likely?",
        cases=(Case("column", SCENARIO),),
        models={
            CORRECTED: Exceedance("single-dof", "four-dof", 1024, 8),
            ALONE: Exceedance("single-dof", samples=1024),
        },
        reference=CORRECTED,
        quantities=(MEDIAN,),
        figures=(Figure("exceedance", "exceedance", "Curves", "Both."),),
    )
    root = tmp_path_factory.mktemp("curves")
    run_study(study, root, jobs=1)
    assess(study, root)
    return read_assessment(root / study.name, study)


@pytest.mark.thorough
def test_velocities_are_those_of_the_samples(stored):
    corrected, alone = (stored.response("column", label) for label in (CORRECTED, ALONE))
    at = [float(alone[f"velocity.at_{p}"]) for p in (10, 50, 90)]
    assert at == sorted(at)
    curve = alone["curve.velocity"].to_numpy(), alone["curve.median"].to_numpy()
    assert np.interp(at[1], *curve) == pytest.approx(0.5, abs=1e-3)
    # single-dof columns are stiffer: the limit is reached at a higher velocity than by four-dof
    assert float(corrected[MEDIAN]) < at[1]
    assert attribute(corrected, SAMPLE_WIDTHS)[MEDIAN] > 0.0
    assert float(corrected["runs.references"]) == 8.0
    assert "band.meshes" not in corrected  # four-dof has no mesh


def test_comparisons_have_the_widths_of_both_bands(stored):
    row = stored.errors(MEDIAN, "relative_error", CORRECTED)["column", ALONE]
    assert 0.0 < row["error"] < 0.1
    assert 0.0 < row["uncertainty"] < row["error"]


def test_the_page_shows_curve_band_what_governs_and_cost(stored):
    plates = {plate.figure.key: plate for plate in draw_all(stored.study, stored)}
    titles = [panel.get_title(loc="left") for panel in plates["exceedance"].drawing.canvas.axes]
    assert titles == ["column: 0.1 m"]
    drawn = plates["exceedance"].drawing.data
    assert set(drawn["label"]) == {CORRECTED, ALONE}
    assert (drawn["low"] <= drawn["median"]).all()
    assert (drawn["median"] <= drawn["high"]).all()
    governs, table = views(in_short(stored.study, stored))
    assert str(governs).index("striker.mass") < str(governs).index("steel.yield_stress")
    assert len(table.rows) == 2


def test_shares_of_a_linear_relation_are_its_squared_weights():
    z = np.random.default_rng(1).standard_normal((20_000, 3))
    given = shares(2.0 + z @ [0.6, 0.8, 0.0], z)
    assert given == pytest.approx([0.36, 0.64, 0.0], abs=0.02)


def test_an_uncertain_impact_is_a_file_too(tmp_path):
    file = tmp_path / "uncertain.toml"
    file.write_text(to_toml(SCENARIO))
    assert load_scenario(file) == SCENARIO
    with pytest.raises(InputError, match="high"):
        UncertainImpact("column", LINES, 5.0, 5.0)


def test_what_has_no_distribution_is_refused():
    plain = TEXT.replace('{ jcss = "S355" }', "355e6").replace(
        "{ lognormal = { mean = 500e3, cov = 0.15 } }", "5e5"
    )
    lines = tuple(plain.replace("{ lognormal = { mean = 1500.0, cov = 0.1 } }", "15.0").split("\n"))
    with pytest.raises(InputError, match="no uncertain input"):
        Exceedance("single-dof").simulate(UncertainImpact("column", lines, 5.0, 20.0, 0.1))
    far = UncertainImpact("column", LINES, 0.5, 1.0, 1.0)
    with pytest.raises(InputError, match="limit"):
        Exceedance("single-dof").simulate(far)
    silent = Exceedance("single-dof", "nothing-known")
    with pytest.raises(InputError, match="nothing-known"):
        silent.simulate(SCENARIO)


def test_an_answer_says_how_it_ended(stored):
    assert outcome_of(stored.response("column", CORRECTED)) is Outcome.OK
