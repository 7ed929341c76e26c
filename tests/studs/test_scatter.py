"""Formulas that tests do not tell apart by their scatter, and tests of other slabs left out."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from workbench.cli import run
from workbench.studs import TESTS, fit_strength
from workbench.studs.laboratory import rank_scatters
from workbench.studs.schema import from_frame


def rows(logs: np.ndarray, labs: int = 3) -> pd.DataFrame:
    names = [f"s{i}" for i in range(len(logs))]
    campaign = [f"lab {i % labs}" for i in range(len(logs))]
    return pd.DataFrame({"campaign": campaign, "specimen": names, "ratio": np.exp(logs)})


def ranked(tests: dict[str, pd.DataFrame]) -> tuple[str, pd.Series]:
    """The formula of least scatter, and its only rival."""
    stacked = pd.concat([table.assign(of=name) for name, table in tests.items()])
    first, rival = (row for _, row in rank_scatters(stacked, 0.9).iterrows())
    return first["of"], rival


def test_the_ratio_of_scatters_by_hand() -> None:
    """Two campaigns of three; residuals (1, 0, -1) and (2, -1, -1): r = 3 / sqrt(2 x 6), nu = 3."""
    one = 0.1 * np.array([1.0, 1.0, 0.0, 0.0, -1.0, -1.0])
    two = 0.1 * np.array([2.0, 2.0, -1.0, -1.0, -1.0, -1.0])
    best, rival = ranked({"one": rows(one, 2), "two": rows(two, 2)})
    assert best == "one"
    assert rival["ratio"] == pytest.approx(np.sqrt(3.0))
    wide = 1.0 + 2.0 * (1.0 - 0.75) * 2.353363**2 / 3.0  # t of 3 degrees of freedom at 95 %
    factor = np.sqrt(wide + np.sqrt(wide**2 - 1.0))
    assert (rival["low"], rival["high"]) == pytest.approx(
        (3**0.5 / factor, 3**0.5 * factor), rel=1e-6
    )
    assert not rival["apart"]


@pytest.mark.thorough
def test_the_interval_covers_what_it_says() -> None:
    generator, inside = np.random.default_rng(8), 0
    spread = np.array([[1.0, 0.9], [0.9, 1.44]])  # scatters 1 and 1.2, r = 0.75
    for _ in range(400):
        logs = generator.multivariate_normal([0.0, 0.0], 0.01 * spread, size=18)
        tests = {name: rows(logs[:, k]) for k, name in enumerate(("one", "two"))}
        best, rival = ranked(tests)
        low, high = rival["low"], rival["high"]
        inside += low <= 1.2 <= high if best == "one" else 1.0 / high <= 1.2 <= 1.0 / low
    assert inside / 400 == pytest.approx(0.9, abs=0.045)  # three standard errors


def test_different_scatters_are_told_apart() -> None:
    generator = np.random.default_rng(2)
    logs = 0.05 * generator.normal(size=30)
    best, rival = ranked({"far": rows(logs + 0.2 * generator.normal(size=30)), "near": rows(logs)})
    assert best == "near"
    assert rival["apart"]
    assert rival["low"] > 1.01


def one_type(**changes: object) -> pd.DataFrame:
    loads = [101.3, 108.4, 97.2, 104.9, 110.6, 99.8]
    values = {"campaign": ["a", "a", "a", "b", "b", "b"], "specimen": list("uvwxyz"),
            "test": "push-out", "diameter_mm": 19.0, "height_mm": 100.0, "slab": "solid",
            "fcm_MPa": 31.0, "fu_MPa": 470.0, "shear_kN": loads}  # fmt: skip
    return pd.DataFrame({**values, **changes})


@pytest.mark.thorough
def test_one_type_of_stud_tells_no_formula_apart(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, report = tmp_path / "lab.csv", tmp_path / "r.html"
    one_type().to_csv(file, index=False)
    models = ["--model", "aisc360", "--model", "en1994", "--model", "roik-mean"]
    arguments = ["fit", "stud-strength", str(file), *models]
    assert run([*arguments, "--json", "--report", str(report)]) == 0
    answer = json.loads(capsys.readouterr().out)
    first, *rivals = answer["results"]["ranking"]
    assert first["of"] == "AISC 360-22"  # the first: none is better
    assert [each["apart"] for each in rivals] == [False, False]
    assert [each["ratio"] for each in rivals] == pytest.approx([1.0, 1.0])
    text = "the tests cannot tell AISC 360-22, solid slab (Rg = 1, Rp = 0.75) from EN 1994-1-1, "
    assert text + "EN 1994-1-1, mean form" in report.read_text()
    assert run(arguments) == 0
    assert text in " ".join(capsys.readouterr().out.split())


def test_tests_in_decks_do_not_leave_silently() -> None:
    decks = one_type(campaign="d", slab="deck transverse", deck_depth_mm=55.0, deck_width_mm=100.0)
    table = from_frame(pd.concat([one_type(), decks]), TESTS)
    (finding,) = [e for e in fit_strength(table, "en1994").findings if "left out" in e.text]
    assert finding.text == (
        "6 of 12 tests in profiled decks are left out: d u, d v, d w, d x, d y, and 1 more"
    )
    assert finding.remedy == "--slab deck"
    (finding,) = [
        e for e in fit_strength(table, "en1994", slab="deck").findings if "left out" in e.text
    ]
    assert "6 of 12 tests in solid slabs are left out" in finding.text
