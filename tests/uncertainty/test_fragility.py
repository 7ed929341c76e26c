"""A fragility curve from end to end: single-dof corrected by four-dof, whose truth is cheap."""

import copy
import json
from math import isfinite, log

import numpy as np
import pytest
from builders import UNCERTAIN

from workbench.cli import run
from workbench.cli.fragility import pair_of
from workbench.errors import InputError, WorkbenchError
from workbench.registry import make_model
from workbench.scenarios import frame_scenario
from workbench.uncertainty.certificate import certificate, verify
from workbench.uncertainty.critical_velocity import (
    ALREADY,
    BY_COLLAPSE,
    NEVER,
    NO_ANSWER,
    REACHED,
    Asked,
    Limit,
    critical_velocity,
)
from workbench.uncertainty.fragility import fragility
from workbench.uncertainty.inputs import uncertain_from_text
from workbench.uncertainty.sample_runs import Sampled, Setup, Target

TEXT = f"""{UNCERTAIN}mass = {{ lognormal = {{ mean = 1500.0, cov = 0.1 }} }}
velocity = 10.0
"""
SAMPLES = 1024


def setup(**options):
    given = {"samples": SAMPLES, "references": 16, "target": Target(0.5), **options}
    pair = make_model("single-dof"), make_model("four-dof")
    return Setup(uncertain_from_text(TEXT), *pair, Limit(0.1), (5.0, 20.0), **given)


@pytest.fixture(scope="module")
def result():
    return fragility(setup())


def test_band_holds_the_critical_velocities_of_the_better_model(result):
    asked = setup()
    scores = np.vstack([asked.uncertain.normal_scores(64, (1, k)) for k in range(4)])
    truth = Setup(asked.uncertain, asked.reference, None, asked.limit, asked.ends)
    outcome = Sampled.of(truth, scores, map).roots(truth, np.full(len(scores), log(9.0)))
    roots = np.array([root.log_velocity for root in outcome])
    for probability in (0.2, 0.5, 0.8):
        low, _, high = result.curve.velocity(probability)
        margin = 0.35 * roots.std() / np.sqrt(len(roots))  # of 256 points of a Sobol sequence
        assert low - margin <= np.quantile(roots, probability) <= high + margin


class Alone:
    """A model that answers no stacks."""

    def __init__(self, model):
        self.model, self.name = model, model.name

    def simulate(self, scenario):
        return self.model.simulate(scenario)


@pytest.mark.parametrize("alone", [False, True])
@pytest.mark.parametrize(
    ("limit", "ends", "duration", "kinds"),
    [
        (Limit(0.1), (5.0, 20.0), 0.01, {REACHED, NO_ANSWER}),  # records that are made longer
        (Limit(0.9), (5.0, 20.0), 0.2, {REACHED, BY_COLLAPSE, NO_ANSWER}),
        (Limit(0.2), (2.0, 3.8), 0.2, {REACHED, NEVER, NO_ANSWER}),
        (Limit(0.05), (19.0, 40.0), 0.2, {REACHED, ALREADY, NO_ANSWER}),
    ],
)
def test_searches_in_step_are_those_of_single_calls(alone, limit, ends, duration, kinds):
    text = TEXT.replace("mean = 500e3, cov = 0.15", "mean = 1e6, cov = 1.5")  # some are squashed
    uncertain = uncertain_from_text(text, [f"time.duration={duration}"])
    model = make_model("single-dof")
    asked = Setup(uncertain, Alone(model) if alone else model, None, limit, ends)
    scores = uncertain.normal_scores(96, (1, 0))
    starts = np.full(len(scores), log(9.0))
    together = Sampled.of(asked, scores, map).roots(asked, starts)
    assert kinds <= {root.kind for root in together}
    for scenario, start, root in zip(uncertain.scenarios(scores), starts, together, strict=True):
        if isinstance(scenario, InputError):
            assert root.kind == NO_ANSWER
            continue
        single = critical_velocity(Asked(model, scenario).peak_at, limit, start, asked.search)
        assert (root.kind, root.runs) == (single.kind, single.runs)
        known = pytest.approx(single.log_velocity, abs=1e-9, nan_ok=True)
        assert root.log_velocity == known


def test_result_says_what_it_rests_on(result):
    assert result.kinds == {"reached": SAMPLES}
    assert len(result.ratios) == 16
    assert result.runs["references"] == 16
    assert result.turning == 0
    assert result.numerical is None  # four-dof has no mesh: no width is invented for it
    assert not result.reaches_target
    low, middle, high = result.at(9.0)
    assert 0.0 <= low <= middle <= high <= 1.0


def test_certificate_holds_and_a_changed_one_does_not(result):
    content = json.loads(json.dumps(certificate(result), allow_nan=False))
    assert all(each.agrees for each in verify(content, seed=3))
    forged = copy.deepcopy(content)
    for entry in forged["references"]:
        entry["log_ratio"] += 0.01
    assert not any(each.agrees for each in verify(forged, seed=3))
    other = copy.deepcopy(content)
    other["models"]["reduced"]["version"] += 1
    with pytest.raises(InputError, match="version"):
        verify(other, seed=3)
    del other["models"]
    with pytest.raises(InputError, match="lacks"):
        verify(other, seed=3)
    with pytest.raises(InputError, match="kind"):
        verify({}, seed=3)


def test_same_numbers_by_any_number_of_processes(result):
    again = fragility(setup(samples=SAMPLES, jobs=2))
    assert np.array_equal(again.curve.median, result.curve.median)
    assert again.ratios == result.ratios


def test_limits_out_of_reach_and_certain_scenarios_are_refused():
    far = setup()
    with pytest.raises(InputError, match="--limit"):
        fragility(Setup(far.uncertain, far.reduced, far.reference, far.limit, (0.5, 1.0)))
    plain = uncertain_from_text(
        TEXT.replace('{ jcss = "S355" }', "355e6")
        .replace("{ lognormal = { mean = 500e3, cov = 0.15 } }", "5e5")
        .replace("{ lognormal = { mean = 1500.0, cov = 0.1 } }", "1500.0")
    )
    with pytest.raises(InputError, match="no uncertain input"):
        fragility(Setup(plain, far.reduced, far.reference, far.limit, far.ends))


def test_a_reference_without_answers_is_no_curve():
    class Silent:
        name, version = "silent", 1

        def simulate(self, scenario):
            raise WorkbenchError("nothing here")

    asked = setup()
    broken = Setup(
        *(asked.uncertain, asked.reduced, Silent(), asked.limit, asked.ends),
        samples=SAMPLES,
        references=8,
    )
    with pytest.raises(WorkbenchError, match="8 of 8 references have no answer"):
        fragility(broken)


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "column.toml"
    path.write_text(TEXT)
    return str(path)


OVER = ("--over", "striker.velocity=5:20")
LIMIT = ("--limit", "displacement=0.1")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--over", "striker.mass=5:20", *LIMIT), "--over"),
        (("--over", "striker.velocity=5", *LIMIT), "--over"),
        (("--over", "striker.velocity=20:5", *LIMIT), "must rise"),
        (("--over", "striker.velocity=0:5", *LIMIT), "--over"),
        ((*OVER, "--limit", "drift=1"), "--limit"),
        ((*OVER, *LIMIT, "--samples", "1000"), "--samples"),
        ((*OVER, *LIMIT, "--and", "striker.mass"), "--and"),
        ((*OVER, *LIMIT, "--and", "striker.mass=1000,,2000"), "--and"),
        ((*OVER, *LIMIT, "--and", "striker.velocity=5,6"), "--and"),
        ((*OVER, *LIMIT, "--and", "striker.mass=1000,heavy"), "striker.mass"),
        ((*OVER, *LIMIT, "--references", "3"), "--references"),
        ((*OVER, *LIMIT, "--jobs", "0"), "--jobs"),
        ((*OVER, *LIMIT, "--seed", "-1"), "--seed"),
        ((*OVER, *LIMIT, "--plot", "x.docx"), "--plot"),
        ((*OVER, *LIMIT, "--model", "nothing"), "nothing"),
        ((*OVER, *LIMIT, "--set", "striker.velocity={ normal = [10.0, 1.0] }"), "striker.velocity"),
        ((*OVER, *LIMIT, "--set", "striker.mass={ normal = [1.0] }"), "striker.mass"),
    ],
)
def test_bad_input_is_one_line(file, capsys, arguments, message):
    assert run(["fragility", file, *arguments]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1


def test_structures_have_models_of_their_own():
    column = uncertain_from_text(TEXT).base
    short = column.changed(column=column.column.changed(length_below=0.4, length_above=0.8))
    assert pair_of(column, None, None) == ("four-dof", "fiber-reissner")
    assert pair_of(short, None, None) == ("four-dof-shear", "fiber-shear")
    assert pair_of(column, "single-dof", None) == ("single-dof", "fiber-reissner")
    struck = frame_scenario(column)
    assert pair_of(struck, None, None) == ("flexible-superelement", "fiber-reissner")


def test_certificates_that_are_none_are_one_line(tmp_path, capsys):
    path = tmp_path / "c.json"
    for content in ("nothing", "[1]", "{}"):
        path.write_text(content)
        assert run(["verify", str(path)]) == 2
        assert capsys.readouterr().err.count("\n") == 1


def test_verb_writes_certificate_and_picture(file, tmp_path, capsys):
    out, plot = tmp_path / "c.json", tmp_path / "c.png"
    pair = ("--model", "single-dof", "--reference", "four-dof", "--samples", "2048")
    more = ("--references", "8", "--jobs", "1", "--out", str(out), "--plot", str(plot))
    assert run(["fragility", file, *OVER, *LIMIT, *pair, *more]) == 1  # no mesh of the reference
    shown = capsys.readouterr().out
    assert "probability 0.5" in shown
    assert "numerical error of the reference is not known" in " ".join(shown.split())
    assert plot.stat().st_size > 10_000
    content = json.loads(out.read_text())
    assert isfinite(log(content["curve"]["velocity"][0]))
    assert run(["verify", str(out)]) == 0


def test_a_second_number_has_a_curve_for_each_value(file, tmp_path, capsys):
    out, plot = tmp_path / "c.json", tmp_path / "c.png"
    pair = ("--model", "single-dof", "--reference", "four-dof", "--samples", "2048")
    more = ("--references", "8", "--jobs", "1", "--out", str(out), "--plot", str(plot))
    given = ("--and", "striker.mass=1000,2000")
    assert run(["fragility", file, *OVER, *LIMIT, *pair, *more, *given]) == 1
    assert "striker.mass" in capsys.readouterr().out
    assert plot.stat().st_size > 10_000
    content = json.loads(out.read_text())
    light, heavy = content["curves"]
    assert [light["given"], heavy["given"]] == ["striker.mass=1000", "striker.mass=2000"]
    assert light["curve"]["velocity"][80] > 1.2 * heavy["curve"]["velocity"][80]
    assert light["seed"] == heavy["seed"]  # and so the samples of the other inputs
    for entry in content["curves"][1]["references"]:
        entry["log_ratio"] = 0.5
    assert run(["verify", str(out)]) == 0
    out.write_text(json.dumps(content))
    assert run(["verify", str(out)]) == 1
