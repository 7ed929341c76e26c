"""The stud that is answered for is that of one's own table, and is named."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path

import pandas as pd
import pytest

from workbench.base.errors import InputError
from workbench.cli import run
from workbench.studs import TESTS
from workbench.studs.mechanical import MechanicalFit, Stud, Surroundings, residual_curve, studs_of
from workbench.studs.mechanical.calibration import complete_rows
from workbench.studs.schema import USUAL, from_frame
from workbench.studs.tables import identity_of

NOTHING: dict[str, float | None] = dict.fromkeys(USUAL)


def table(*rows: tuple[float | None, ...]) -> pd.DataFrame:
    """Push-outs of studs (diameter, height, concrete, steel)."""
    columns = dict(zip(USUAL, zip(*rows, strict=True), strict=True))
    names = [f"s{i}" for i in range(len(rows))]
    values = {"campaign": "our lab", "specimen": names, "test": "push-out", "shear_kN": 100.0}
    return from_frame(pd.DataFrame({**values, **columns}), TESTS)


def test_studs_of_a_table_are_told_apart_and_averaged() -> None:
    result, _ = studs_of(
        table((16, 90, 40, 480), (19, 100, 30, 450), (19, 100, 32, 460), (19.05, 100, 31, 440)),
        NOTHING,
    )
    assert [each.tests for each in result] == [3, 1]
    assert result[0].stud.title == "19.02 x 100 mm, f_c 31 MPa, f_u 450 MPa"
    assert result[1].stud.title == "16 x 90 mm, f_c 40 MPa, f_u 480 MPa"
    assert not any(each.assumed for each in result)


def test_a_stocky_stud_is_refused_and_takes_none_from_the_others() -> None:
    stocky, usual = (19, 75, 30, 450), (19, 100, 30, 450)
    result, refused = studs_of(table(stocky, stocky, usual), NOTHING)
    assert [each.stud.height for each in result] == pytest.approx([0.1])
    assert "stud.height = 0.075: must be 4 diameters or more; stockier studs may pry" in refused[0]
    with pytest.raises(InputError, match="4 diameters"):
        studs_of(table(stocky), NOTHING)
    complete = complete_rows(table(stocky, usual))
    assert complete["height_mm"].tolist() == [100.0]


def test_what_is_not_told_is_assumed_and_named() -> None:
    rows = table((16, None, 40, None), (16, None, 41, None))
    (one,), _ = studs_of(rows, NOTHING)
    assert one.assumed == "height_mm 100, fu_MPa 450"
    assert one.stud.diameter == pytest.approx(0.016)
    assert one.stud.concrete_strength == pytest.approx(40.5e6)
    (given,), _ = studs_of(rows, {**NOTHING, "height_mm": 90.0, "fu_MPa": 480.0})
    assert (given.assumed, given.stud.height) == ("", pytest.approx(0.09))
    (usual,), _ = studs_of(rows.iloc[:0], NOTHING)
    assert (usual.tests, usual.stud.title) == (0, "19 x 100 mm, f_c 30 MPa, f_u 450 MPa")


def test_a_laboratory_without_damaged_tests_gets_its_own_stud(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    # assumed parameters, few levels and no band: which stud is computed is what matters here
    model = MechanicalFit(
        Surroundings(), {}, table((19, 100, 30, 450)), {}, 1, identity_of(table((19, 100, 30, 450)))
    )
    monkeypatch.setattr("workbench.studs.laboratory.shipped_model", lambda: model)
    short = partial(residual_curve, levels=(0.0, 0.5), spread={})
    monkeypatch.setattr("workbench.studs.mechanical.residual_curve", short)
    file = tmp_path / "lab.csv"
    rows = table((16, 90, 40, 480), (16, 90, 40, 480), (16, 90, 40, 480))
    rows.assign(shear_kN=[88.0, 90.0, 92.0], use_for_fit=1).to_csv(file, index=False)
    assert run(["fit", "residual", str(file), "--json"]) == 0
    results = json.loads(capsys.readouterr().out)["results"]
    given = short(Stud.of_concrete(0.016, 0.09, 40e6, 480e6), model.around)
    studs = [fit["stud"] for fit in results["fit"]]
    assert studs == ["16 x 90 mm, f_c 40 MPa, f_u 480 MPa"] * 2
    assert all("assumed" not in row["sentence"] for row in results["findings"])
    left = [row["left"] for row in results["curve"] if row["of"] == "strength"]
    assert left[20] == pytest.approx(given.ratio[1])
    assert run(["fit", "residual", "--json", "--quantity", "strength"]) == 0
    usual = json.loads(capsys.readouterr().out)["results"]
    assert usual["fit"][0]["stud"] == "19 x 100 mm, f_c 30 MPa, f_u 450 MPa"
    assert any("assumed: diameter_mm 19" in row["sentence"] for row in usual["findings"])
    assert usual["curve"][20]["left"] > left[20] + 0.01
    assert run(["fit", "residual", str(file), "--fcm-mpa", "3000"]) == 2
    assert "--fcm-mpa = 3000.0: must be a number from 5 to 250 MPa" in capsys.readouterr().err
