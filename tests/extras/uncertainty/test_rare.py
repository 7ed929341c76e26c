"""Rare probabilities against closed forms, crude samples, and a column that a car hits."""

import json
import subprocess
import sys
from math import inf

import numpy as np
import pandas as pd
import pytest
from builders import UNCERTAIN
from scipy.special import ndtr
from scipy.stats import chi2

from workbench.base.errors import InputError, WorkbenchError
from workbench.cli import run
from workbench.extras.uncertainty.critical_velocity import DisplacementLimit
from workbench.extras.uncertainty.inputs import uncertain_from_text
from workbench.extras.uncertainty.rare import SamplingMixture, Struck, rare_probability
from workbench.models.base import make_model


class Closed:
    """A structure with a margin in closed form; `steering`, the one that searches see."""

    def __init__(self, margin, steering=None):
        self.margin, self.steering = margin, steering or margin

    def margins(self, scores):
        return self.steering(scores), len(scores)

    def failures(self, scores):
        return (self.margin(scores) < 0.0).astype(float)


TURNED = np.linalg.qr(np.random.default_rng(9).standard_normal((6, 6)))[0]
PARABOLA = 4.5 + 0.1 * chi2.rvs(4, size=1_000_000, random_state=1)
BLIND = Closed(lambda z: np.minimum(4.5 - z[:, 0], 4.6 + z[:, 1]), lambda z: 4.5 - z[:, 0])


@pytest.mark.parametrize(
    ("structure", "inputs", "known", "points"),
    [
        (Closed(lambda z: 4.75 - z[:, 0]), 1, ndtr(-4.75), {1}),
        (Closed(lambda z: 4.75 - z @ np.ones(5) / 5**0.5), 5, ndtr(-4.75), {1}),
        (Closed(lambda z: 3.0 - z @ np.ones(30) / 30**0.5), 30, ndtr(-3.0), {1}),
        (Closed(lambda z: 1.0 - z[:, 0]), 5, ndtr(-1.0), {1}),
        (Closed(lambda z: 4.5 - z[:, 0] + 0.1 * (z[:, 1:] ** 2).sum(axis=1)), 5, None, {1}),
        (
            Closed(lambda z: np.minimum(4.5 - z @ TURNED[0], 4.5 - z @ TURNED[1])),
            6,
            1.0 - ndtr(4.5) ** 2,
            {2, 3, 4, 5, 6},
        ),
        (Closed(lambda z: 4.5 - np.abs(z @ TURNED[0])), 6, 2.0 * ndtr(-4.5), {2, 3}),
        (BLIND, 4, ndtr(-4.5) + ndtr(-4.6), {2, 3}),
        (Closed(lambda z: 4.2 - z[:, :3].max(axis=1)), 6, 1.0 - ndtr(4.2) ** 3, {3, 4, 5, 6}),
    ],
    ids=[
        *("one", "linear", "many", "not-rare", "curved", "two", "opposite"),
        *("steered-to-one-of-two", "three"),
    ],
)
def test_closed_forms_are_met_and_the_scatter_is_what_it_says(structure, inputs, known, points):
    known = float(ndtr(-PARABOLA).mean()) if known is None else known
    results = [rare_probability(structure, inputs, np.random.default_rng(k)) for k in range(40)]
    outcome = np.array([result.probability for result in results]) / known
    covs = np.array([result.cov for result in results])
    assert abs(outcome.mean() - 1.0) < 4.0 * covs.mean() / 40**0.5
    assert outcome.std() < 1.5 * covs.mean()
    assert np.median(covs) <= 0.1
    assert all(sum(result.runs.values()) <= 5000 for result in results)
    assert {len(result.points) for result in results} <= points
    held = [result.band[0] < known < result.band[1] for result in results]
    assert np.mean(held) > 0.75  # of nominal 0.9, 40 times
    nearest = results[0].points[0]
    if points == {1}:
        assert structure.steering(nearest[None])[0] == pytest.approx(0.0, abs=0.1)
        assert results[0].shares.sum() == pytest.approx(1.0)


def test_weights_are_those_of_the_inputs():
    mixture = SamplingMixture(np.array([[2.0, 0.0], [0.0, -1.5]]), np.array([0.7, 0.3]), 1.4)
    scores = mixture.draw(100_000, np.random.default_rng(1))
    weights, far = mixture.ratios(scores)
    for moment, known in ((weights, 1.0), (weights * scores[:, 0] ** 2, 1.0)):
        assert moment.mean() == pytest.approx(known, abs=4.0 * moment.std() / 100_000**0.5)
    assert 0.0 < far.mean() < 0.1


def test_a_failure_all_around_has_no_few_design_points():
    structure = Closed(lambda z: 30.0 - (z**2).sum(axis=1))
    with pytest.raises(WorkbenchError, match="a design point was not found"):
        rare_probability(structure, 4, np.random.default_rng(1))


def test_what_gives_no_probability_is_refused():
    random = np.random.default_rng(1)
    with pytest.raises(InputError, match="not rare"):
        rare_probability(Closed(lambda z: -1.0 - z[:, 0]), 3, random)
    with pytest.raises(InputError, match="--runs"):
        rare_probability(Closed(lambda z: 4.0 - z[:, 0]), 3, random, most=1200)
    with pytest.raises(WorkbenchError, match="fails in none"):
        rare_probability(Closed(lambda z: np.ones(len(z))), 3, random)
    silent = Closed(lambda z: 4.0 - z[:, 0])
    silent.failures = lambda z: np.where(z[:, 1] > 0.0, np.nan, (z[:, 0] > 4.0).astype(float))
    with pytest.raises(WorkbenchError, match="without an answer"):
        rare_probability(silent, 3, random)


MAIN = "from workbench.cli import main; main()"
TEXT = f"""{UNCERTAIN}mass = {{ jcss = "car" }}
velocity = {{ jcss = "parking" }}
"""


CAR_PARK = (
    *("column.section=HEA 240", "column.length_below=0.6", "column.length_above=2.4"),
    *("column.restraint_stiffness=1e7", "time.duration=0.2"),
)


@pytest.mark.thorough
def test_crude_samples_agree():
    uncertain = uncertain_from_text(TEXT)
    count, model = 400_000, make_model("energy-estimate")
    struck = Struck(uncertain, model, DisplacementLimit(0.15), map, 1)
    scores = np.random.default_rng(3).standard_normal((count, len(uncertain.inputs)))
    crude = float(np.mean(struck.failures(scores)))
    assert 5e-4 < crude < 3e-3
    result = rare_probability(struck, len(uncertain.inputs), np.random.default_rng(1))
    spread = np.hypot(result.cov, (crude * count) ** -0.5)
    assert result.probability == pytest.approx(crude, rel=3.0 * spread)


@pytest.mark.thorough
@pytest.mark.parametrize("seed", [1, 2])
def test_a_car_park_column_collapses_with_one_in_a_million(seed):
    uncertain = uncertain_from_text(TEXT, CAR_PARK)
    struck = Struck(uncertain, make_model("four-dof"), DisplacementLimit(inf), map, 1)
    result = rare_probability(struck, len(uncertain.inputs), np.random.default_rng(seed))
    assert 1e-8 < result.probability < 1e-5
    assert result.cov <= 0.1
    assert sum(result.runs.values()) <= 5000
    velocity = list(uncertain.values(result.points[:1]))[-1]
    assert velocity == ("striker", "velocity")
    assert result.shares[-1] > 0.8  # the velocity has the largest scatter by far


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "column.toml"
    path.write_text(TEXT)
    return str(path)


@pytest.mark.thorough
def test_verb_prints_the_probability_and_where_it_fails(file, capsys):
    asked = ["rare", file, "--limit", "displacement=0.15", "--model", "energy-estimate"]
    command = [sys.executable, "-c", MAIN, *asked, "--jobs", "1", "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    content = json.loads(done.stdout)
    low, high = content["band"]
    assert low < content["probability"] < high
    assert content["reliability_index"] == pytest.approx(-float(np.log10(1e-3)), abs=0.3)
    assert [row["input"] for row in content["inputs"]][-1] == "striker.velocity"
    assert run([*asked, "--jobs", "1"]) == 0
    shown = " ".join(capsys.readouterr().out.split())
    assert "exceeds 0.15 m with probability" in shown
    assert "error of the model" in shown
    assert run([*asked, "--jobs", "1", "--cov", "0.01", "--runs", "3000"]) == 1


def test_a_velocity_may_be_one_of_a_list(file, capsys):
    """Lorries at 15 m/s in one case of fifty, else at 8 or 10."""
    law = '{ discrete = { values = [8.0, "36 km/h", 15], weights = [0.5, 0.48, 0.02] } }'
    asked = ["rare", file, "--limit", "displacement=0.15", "--model", "energy-estimate"]
    status = run([*asked, "--jobs", "1", "--json", "--set", f"striker.velocity={law}"])
    content = json.loads(capsys.readouterr().out)
    assert status == int(content["cov"] > 0.1)
    samples = ["--samples", "4096", "--seed", "3", "--jobs", "1", "--model", "energy-estimate"]
    out = file.replace("toml", "csv")
    assert run(["sample", file, *samples, "--set", f"striker.velocity={law}", "--out", out]) == 0
    share = float((pd.read_csv(out)["peak_displacement"] > 0.15).mean())
    assert share > 0.0
    assert content["probability"] == pytest.approx(share, rel=0.3)


@pytest.mark.parametrize(
    ("arguments", "status", "message"),
    [
        (("--limit", "drift=1"), 2, "--limit"),
        (("--limit", "collapse", "--cov", "0"), 2, "--cov"),
        (("--limit", "collapse", "--runs", "10"), 2, "--runs"),
        (("--limit", "collapse", "--seed", "-1"), 2, "--seed"),
        (("--limit", "collapse", "--jobs", "0"), 2, "--jobs"),
        (("--limit", "collapse", "--model", "nothing"), 2, "nothing"),
        (("--limit", "displacement=0.1", "--set", "striker.velocity=40"), 2, "not rare"),
        (("--limit", "collapse", "--set", "striker.velocity=0.05"), 1, "fails in none"),
    ],
)
def test_bad_input_is_one_line(file, capsys, arguments, status, message):
    chosen = () if "--model" in arguments else ("--model", "energy-estimate")
    assert run(["rare", file, *arguments, *chosen]) == status
    lines = capsys.readouterr().err.splitlines()
    assert message in lines[-1]
    assert all("at work" in line for line in lines[:-1])
