"""Undamaged references of damaged tests: tabulated, and their scatter counted."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from workbench.cli import run
from workbench.studs import TESTS, fit_residual
from workbench.studs.damaged import damaged_rows
from workbench.studs.schema import from_frame

LEVELS = [0.1, 0.25, 0.4, 0.55, 0.7, 0.9]


def laboratory(undamaged: list[float], reference: float | None = None) -> pd.DataFrame:
    """Six tests after pull-out that lose 0.4 D, and their undamaged companions (19 mm)."""
    scatter = [0.01, -0.02, 0.015, -0.01, 0.02, -0.015]
    damaged = pd.DataFrame({
        "specimen": [f"d{i}" for i in range(6)], "predamage": "pull-out",
        "predamage_measure": "load ratio", "predamage_level": LEVELS,
        "shear_kN": [100.0 * (1 - 0.4 * d + e) for d, e in zip(LEVELS, scatter, strict=True)],
        "undamaged_shear_kN": reference,
    })  # fmt: skip
    whole = pd.DataFrame({"specimen": [f"u{i}" for i in range(len(undamaged))],
                          "shear_kN": undamaged})  # fmt: skip
    table = pd.concat([damaged, whole]).assign(campaign="lab", test="push-out", diameter_mm=19.0)
    return from_frame(table, TESTS)


def test_references_by_hand() -> None:
    """Companions 96, 100, 104: mean 100, scatter 4 %, of a mean of three 2.31 %."""
    rows = damaged_rows(laboratory([96.0, 100.0, 104.0]), "strength")
    assert rows["reference"].to_numpy() == pytest.approx(100.0)
    assert set(rows["reference_tests"]) == {3.0}
    assert (rows["uncertainty"] / rows["ratio"]).to_numpy() == pytest.approx(0.04 / np.sqrt(3.0))
    given = damaged_rows(laboratory([], 100.0), "strength")
    assert set(given["reference_tests"]) == {0.0}
    assert given["uncertainty"].isna().all()


def test_scatter_is_pooled_over_groups() -> None:
    """Groups of 19 mm (nu = 2, s = 4 %) and 22 mm (nu = 1, s = 7.07 %): s^2 = (2 16 + 50) / 3."""
    first = laboratory([96.0, 100.0, 104.0])
    second = laboratory([190.0, 210.0])
    second = second.assign(diameter_mm=22.0, specimen="w" + second["specimen"])
    rows = damaged_rows(pd.concat([first, second], ignore_index=True), "strength")
    spread = np.sqrt((2 * 16 + 50) / 3) / 100
    counts = rows["diameter_mm"].map({19.0: 3.0, 22.0: 2.0})
    expected = spread / np.sqrt(counts)
    assert (rows["uncertainty"] / rows["ratio"]).to_numpy() == pytest.approx(expected.to_numpy())


def test_the_scatter_of_references_is_told() -> None:
    """Of few campaigns; with three or more it is a part of what campaigns differ by."""
    tested, given = (
        fit_residual(laboratory(*each)) for each in (([96.0, 100.0, 104.0],), ([], 100.0))
    )
    texts = [" ".join(str(each) for each in fit.findings) for fit in (tested, given)]
    assert "references of 6 of 6 tests scatter: what is left is uncertain by 2.3 %" in texts[0]
    assert "the scatter of the references of 6 of 6 tests is not known" in texts[1]


def test_the_report_tabulates_every_reference(tmp_path: Path) -> None:
    file, report = tmp_path / "lab.csv", tmp_path / "r.html"
    columns = ["campaign", "specimen", "test", "diameter_mm", "shear_kN", "predamage",
               "predamage_measure", "predamage_level"]  # fmt: skip
    laboratory([96.0, 100.0, 104.0])[columns].to_csv(file, index=False)
    arguments = ["fit", "residual", str(file), "--quantity", "strength", "--no-mechanical"]
    assert run([*arguments, "--report", str(report)]) == 0
    text = report.read_text()
    for words in ("strength: damage D", "strength: left R", "u(R) by its reference",
                  "strength: reference", "strength: tests behind it"):  # fmt: skip
        assert words in text
