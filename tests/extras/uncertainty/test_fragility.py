"""A fragility curve from end to end: single-dof corrected by four-dof, whose truth is cheap."""

import copy
import json
from dataclasses import dataclass
from math import isfinite, log
from typing import ClassVar

import numpy as np
import pytest
from builders import UNCERTAIN

from workbench.base.errors import InputError, WorkbenchError
from workbench.cli import run
from workbench.extras.uncertainty.certificate import certificate, verify
from workbench.extras.uncertainty.critical_velocity import (
    ALREADY,
    BY_COLLAPSE,
    NEVER,
    NO_ANSWER,
    REACHED,
    Asked,
    DisplacementLimit,
    critical_velocity,
)
from workbench.extras.uncertainty.fragility import fragility
from workbench.extras.uncertainty.inputs import uncertain_from_text
from workbench.extras.uncertainty.sample_runs import Sampled, Setup, Target
from workbench.extras.uncertainty.verbs.fragility import pair_of
from workbench.models.base import make_model
from workbench.models.four_dof import FourDof
from workbench.responses.uncertainty import WIDTHS
from workbench.scenarios import frame_scenario

TEXT = f"""{UNCERTAIN}mass = {{ lognormal = {{ mean = 1500.0, cov = 0.1 }} }}
velocity = 10.0
"""
SAMPLES = 1024


def setup(**options):
    given = {"samples": SAMPLES, "references": 16, "target": Target(0.5), **options}
    pair = make_model("single-dof"), make_model("four-dof")
    return Setup(uncertain_from_text(TEXT), *pair, DisplacementLimit(0.1), (5.0, 20.0), **given)


@pytest.fixture(scope="module")
def result():
    return fragility(setup())


def test_band_holds_the_critical_velocities_of_the_better_model(result):
    asked = setup()
    scores = np.vstack([asked.uncertain.normal_scores(32, (1, k)) for k in range(4)])
    truth = Setup(asked.uncertain, asked.reference, None, asked.limit, asked.ends)
    outcome = Sampled.of(truth, scores, map).roots(truth, np.full(len(scores), log(9.0)))
    roots = np.array([root.log_velocity for root in outcome])
    for probability in (0.2, 0.5, 0.8):
        low, _, high = result.curve.velocity(probability)
        margin = 0.35 * roots.std() / np.sqrt(len(roots))  # of 128 points of a Sobol sequence
        assert low - margin <= np.quantile(roots, probability) <= high + margin


class Alone:
    """A model that answers no stacks."""

    def __init__(self, model):
        self.model, self.name = model, model.name

    def simulate(self, scenario):
        return self.model.simulate(scenario)


@pytest.mark.thorough
@pytest.mark.parametrize("alone", [False, True])
@pytest.mark.parametrize(
    ("limit", "ends", "duration", "kinds"),
    [
        (
            DisplacementLimit(0.1),
            (5.0, 20.0),
            0.01,
            {REACHED, NO_ANSWER},
        ),  # records that are made longer
        (DisplacementLimit(0.9), (5.0, 20.0), 0.2, {REACHED, BY_COLLAPSE, NO_ANSWER}),
        (DisplacementLimit(0.2), (2.0, 3.8), 0.2, {REACHED, NEVER, NO_ANSWER}),
        (DisplacementLimit(0.05), (19.0, 40.0), 0.2, {REACHED, ALREADY, NO_ANSWER}),
    ],
)
def test_searches_in_step_are_those_of_single_calls(alone, limit, ends, duration, kinds):
    text = TEXT.replace("mean = 500e3, cov = 0.15", "mean = 1e6, cov = 1.5")  # some are squashed
    uncertain = uncertain_from_text(text, [f"time.duration={duration}"])
    model = make_model("single-dof")
    asked = Setup(uncertain, Alone(model) if alone else model, None, limit, ends)
    scores = uncertain.normal_scores(48, (1, 0))
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


@pytest.fixture(scope="module")
def content(result):
    return json.loads(json.dumps(certificate(result), allow_nan=False))


def test_a_hit_beside_the_shear_centre_needs_a_model_that_knows_it():
    """All others would answer the hit through it: `fragility`, `rare` and studies take a setup."""
    pair = make_model("four-dof"), make_model("fiber-reissner")
    shells = make_model("shell", {"levels": 1})
    for given in ("0.07", "{ normal = { mean = 0.0, sd = 0.03 } }"):
        uncertain = uncertain_from_text(
            TEXT.replace("[striker]", f"[striker]\neccentricity = {given}")
        )
        for reference in (pair[1], None):
            with pytest.raises(InputError, match=r"eccentricity.*take shell"):
                Setup(uncertain, pair[0], reference, DisplacementLimit(0.1), (5.0, 20.0))
        assert Setup(uncertain, pair[0], shells, DisplacementLimit(0.1), (5.0, 20.0)).has_meshes


def test_certificate_holds_and_changed_references_do_not(content):
    sound = verify(content, seed=3)
    assert sound.holds
    assert len(sound.runs) == 2
    assert sound.differs == ()
    forged = copy.deepcopy(content)
    for entry in forged["references"]:
        entry["log_ratio"] += 0.01
    again = verify(forged, seed=3)
    assert not any(each.agrees for each in again.runs)
    assert "curve.velocity" in again.differs
    other = copy.deepcopy(content)
    other["models"]["reduced"]["version"] += 1
    with pytest.raises(InputError, match="version"):
        verify(other, seed=3)
    del other["models"]
    with pytest.raises(InputError, match="lacks"):
        verify(other, seed=3)
    with pytest.raises(InputError, match="kind"):
        verify({}, seed=3)


def halve_the_median(content):
    content["curve"]["median"] = [0.5 * p for p in content["curve"]["median"]]


def narrow_the_band(content):
    content["curve"]["low"] = content["curve"]["high"] = content["curve"]["median"]


def shift_a_reference(content):
    content["references"][4]["velocity"] *= 1.01


def take_other_references(content):
    content["references"][4]["sample"] += 1


def swap_velocities(content):
    first, second = content["references"][:2]
    first["velocity"], second["velocity"] = second["velocity"], first["velocity"]


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("forge", "place"),
    [
        (halve_the_median, "curve.median"),
        (narrow_the_band, "curve.low"),
        (shift_a_reference, "references"),
        (take_other_references, "references"),
        (swap_velocities, "references"),
        (lambda c: c["references"].reverse(), "references"),
        (lambda c: c["references"].pop(), "curve.median"),
        (lambda c: c.update(level=0.95), "level"),
        (lambda c: c.update(seed=2), "curve.median"),
        (lambda c: c.update(kinds={"reached": 2 * SAMPLES}), "kinds.reached"),
        (lambda c: c["turning"].update(samples=3), "turning.samples"),
        (lambda c: c.update(numerical_half_width=0.001), "numerical_half_width"),
        (lambda c: c["half_width"].update(probability=0.0), "half_width.probability"),
        (lambda c: c["runs"].update(references=1000), "runs.references"),
        (lambda c: c["curve"].update(velocity=c["curve"]["velocity"][1:]), "curve.velocity"),
        (lambda c: c.pop("curve"), "curve.median"),
    ],
)
def test_every_part_of_a_certificate_is_computed_again(content, forge, place):
    forged = copy.deepcopy(content)
    forge(forged)
    again = verify(forged, seed=3)
    assert not again.holds
    assert place in again.differs


@pytest.mark.parametrize(
    ("forge", "message"),
    [
        (lambda c: c["velocities"].reverse(), r"certificate\.velocities = .* must rise"),
        (
            lambda c: c.update(references=c["references"][:2]),
            "certificate.references = 2: .* from 8",
        ),
        (lambda c: c.update(looks=[12, 18, 27, 40, 60]), "references = 16: must be one of 12"),
        (lambda c: c["references"][3].update(log_ratio="x"), r"references\.3\.log_ratio = 'x'"),
        (lambda c: c.update(seed=-1), r"certificate\.seed = -1"),
        (lambda c: c.update(seed="one"), r"certificate\.seed"),
        (lambda c: c.update(limit=-1), r"certificate\.limit = -1"),
        (lambda c: c.update(limit=1e300), r"certificate\.limit"),
        (lambda c: c.update(samples=16.5), r"certificate\.samples"),
        (lambda c: c.update(samples=1 << 40), r"certificate\.samples"),
        (lambda c: c.update(references=7), "lacks or garbles"),
        (lambda c: c.update(references=[7]), "lacks or garbles"),
        (lambda c: c.update(models=[]), "lacks or garbles"),
        (lambda c: c.update(meshes=None), "lacks or garbles"),
        (
            lambda c: c["meshes"].update(runs=[{"shift": 0.0, "half_width": 0.0}]),
            "certificate.mesh",
        ),
        (lambda c: c.update(format=1), "make the certificate again"),
    ],
)
def test_certificates_that_cannot_be_are_refused(content, forge, message):
    forged = copy.deepcopy(content)
    forge(forged)
    with pytest.raises(InputError, match=message):
        verify(forged, seed=3)


@dataclass(frozen=True)
class Meshed(FourDof):
    """As if the model had a mesh, on which its peak hangs."""

    name: ClassVar[str] = "meshed"
    refinement: int = 0
    levels: int = 1

    def simulate(self, scenario):
        response = super().simulate(scenario)
        if "peak_displacement" in response:
            response["peak_displacement"] *= 1.0 + 0.02 / 4.0**self.refinement
            widths = {"peak_displacement": 1e-4 * scenario.column.steel.yield_stress / 355e6}
            response.attrs[WIDTHS] = json.dumps(widths)
        return response


def test_the_numerical_part_of_the_band_is_computed_again(monkeypatch):
    pair = make_model("single-dof"), Meshed()
    asked = Setup(
        *(uncertain_from_text(TEXT), *pair, DisplacementLimit(0.1), (5.0, 20.0), SAMPLES),
        references=8,
    )
    found = fragility(asked)
    width, shift = found.finer.error
    assert 0.0 < width < 0.01
    assert shift == pytest.approx(0.015 / 1.8, rel=0.3)  # what the finer mesh takes off the peak
    assert len(found.finer.runs) == 4
    known = {model.name: model for model in pair}
    monkeypatch.setattr("workbench.extras.uncertainty.certificate.make_model", known.get)
    content = json.loads(json.dumps(certificate(found), allow_nan=False))
    sound = verify(content, seed=3)
    assert sound.holds
    assert [each.mesh for each in sound.runs] == ["", "", f"{2**found.finer.refined} times finer"]
    forged = copy.deepcopy(content)
    forged["meshes"]["runs"] = []
    with pytest.raises(InputError, match=r"certificate\.meshes"):
        verify(forged, seed=3)
    forged["meshes"]["runs"] = [{"shift": 0.0, "half_width": 0.0}] * 4
    again = verify(forged, seed=3)
    assert not again.runs[-1].agrees
    assert {"numerical_half_width", "mesh_shift", "curve.low"} <= set(again.differs)


@pytest.mark.thorough
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
    oblique = column.changed(striker=column.striker.changed(angle=0.5))
    assert pair_of(oblique, None, None) == ("seven-dof", "fiber-space")
    assert pair_of(column, "single-dof", None) == ("single-dof", "fiber-reissner")
    struck = frame_scenario(column)
    assert pair_of(struck, None, None) == ("flexible-superelement", "fiber-reissner")


def test_certificates_that_are_none_are_one_line(tmp_path, capsys):
    path = tmp_path / "c.json"
    for content in ("nothing", "[1]", "{}"):
        path.write_text(content)
        assert run(["verify", str(path)]) == 2
        assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.thorough
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


@pytest.mark.thorough
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
    out.write_text(json.dumps(content))
    assert run(["verify", str(out)]) == 1
