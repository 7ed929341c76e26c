"""Formulas of tension, pry-out and decks, each by a value worked out by hand."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from workbench.base.errors import InputError
from workbench.cli import run
from workbench.studs import TESTS, fit_factors, fit_strength
from workbench.studs.formulas import FORMULAS, SHEAR_MODELS, TENSION_MODELS
from workbench.studs.schema import read_text
from workbench.studs.tables import Specimens, specimens

STUD = {
    "campaign": "lab", "specimen": "a", "test": "pull-out", "diameter_mm": 19, "height_mm": 100,
    "embedment_mm": 90, "head_diameter_mm": 32, "fcm_MPa": 30, "fu_MPa": 450, "tension_kN": 60,
}  # fmt: skip


def stud(**changes: object) -> Specimens:
    row = {key: value for key, value in {**STUD, **changes}.items() if value is not None}
    text = ",".join(row) + "\n" + ",".join(map(str, row.values()))
    return specimens(read_text(text, TESTS).accept())


def of(name: str, **changes: object) -> float:
    return float(FORMULAS[name].of(stud(**changes))[0]) / 1e3


# with the root r of f_c E_c 948.68 MPa, A_s f_u = 141.76 kN and 90^1.5 sqrt(30) = 4.6765 kN: 0.29
# and 0.374 d^2 r, 0.75 A_s f_u, 0.5 A_s r, 17 sqrt(30) 19^1.4 90^0.6, 0.6 A_s f_u, 25 x 4.6765,
# 12.7, 12.5 and 16.8 x 4.6765, A_s f_u
BY_HAND = {
    **{"en1994": 99.3177, "roik-mean": 128.0855, "aisc360": 106.3233, "ollgaard": 134.4895},
    **{"pallares-hajjar": 85.4693, "en1992-shear": 85.0586, "aci318-shear": 116.9134},
    **{"en1992-tension": 59.3920, "aci318-tension": 58.4567, "ccd-mean": 78.5658},
    "aisc360-tension": 141.7644,
}


@pytest.mark.claim("formula:{name}", "19 mm stud, kN", "closed form", "{expected}", "0.01 %")
@pytest.mark.parametrize(("name", "expected"), BY_HAND.items())
def test_formulas_by_hand(claim, name: str, expected: float) -> None:
    claim(of(name, Ecm_MPa=30000, fu_MPa=500))


# A_s f_u = 283.53 x 450 = 127.59 kN; cone 12.7 sqrt(30) 90^1.5 = 59.39 kN; below the head
# 10.5 x (pi/4)(32^2 - 19^2) x 30 = 164.03 kN
@pytest.mark.parametrize(
    ("name", "changes", "expected"),
    [
        ("en1992-tension", {"embedment_mm": 200, "height_mm": 210}, 127.588),
        ("en1992-tension", {"embedment_mm": 200, "height_mm": 210, "fu_MPa": 700,
                            "head_diameter_mm": 25}, 65.312),
        ("en1992-shear", {"embedment_mm": 50, "height_mm": 60}, 24.593),  # once the cone
        ("aci318-shear", {"embedment_mm": 64}, 35.054),  # below 65 mm once
    ],
)  # fmt: skip
def test_other_terms_by_hand(name: str, changes: dict[str, object], expected: float) -> None:
    assert of(name, **changes) == pytest.approx(expected, rel=2e-4)


def test_the_worked_example_of_aci_349() -> None:
    """ACI 349.2R-07, example A1: 12.76, 15.42 (cracked) and 18.88 kip (cracked)."""
    inch, kip, ksi = 25.4, 4.448222, 6.894757
    head = inch * np.sqrt(4.0 * (0.59 + 0.25 * np.pi * 0.25) / np.pi)
    given = {"diameter_mm": 12.7, "height_mm": 130, "embedment_mm": 4.69 * inch,
             "head_diameter_mm": head, "fcm_MPa": 4 * ksi, "fu_MPa": 65 * ksi}  # fmt: skip
    assert of("aci318-tension", **given) == pytest.approx(12.7627 * kip, rel=1e-4)
    strong = {**given, "fu_MPa": 1400}
    assert of("aci318-tension", **strong) == pytest.approx(1.25 * 15.417 * kip, rel=6e-3)
    deep = {**strong, "embedment_mm": 300, "height_mm": 310}
    assert of("aci318-tension", **deep) == pytest.approx(1.4 * 18.88 * kip, rel=1e-4)


def test_a_free_width_cuts_the_cone() -> None:
    """Specimens of 80 mm width, 60 mm embedment: 12.7 sqrt(56.8) 60^1.5 x 0.4444 x 0.8333."""
    narrow = {"embedment_mm": 60, "height_mm": 70, "fcm_MPa": 56.8, "free_width_mm": 80}
    assert of("en1992-tension", **narrow) == pytest.approx(16.476, rel=1e-4)
    assert of("en1992-tension", **{**narrow, "free_width_mm": 500}) == pytest.approx(44.484, 1e-4)


def test_heads_and_embedments_that_are_not_told_are_usual_ones() -> None:
    assert of("en1992-tension", embedment_mm=None) == pytest.approx(59.888, rel=1e-4)
    low = {"height_mm": 300, "embedment_mm": None, "head_diameter_mm": None, "fu_MPa": 1400}
    area = 0.25 * np.pi * 19**2 * (1.65**2 - 1.0)
    assert of("en1992-tension", **low) == pytest.approx(10.5 * area * 30 / 1e3)


def texts(name: str, **changes: object) -> str:
    return "; ".join(each.text for each in FORMULAS[name].findings(stud(**changes)))


DECK = {"test": "push-out", "tension_kN": None, "shear_kN": 70, "slab": "deck transverse",
        "deck_depth_mm": 55, "deck_width_mm": 100}  # fmt: skip


@pytest.mark.parametrize(
    ("name", "changes", "words"),
    [
        ("en1994", {"height_mm": 92}, "h from h_p + 2 d"),  # 37 mm above, 38 asked
        ("en1994", {"fu_MPa": 460}, "f_u up to 450 MPa across ribs"),
        ("aisc360", {"deck_depth_mm": 80, "height_mm": 130}, "ribs up to 75 mm"),
        ("aisc360", {"deck_width_mm": 45}, "ribs from 50 mm wide"),
        ("aisc360", {"height_mm": 92}, "h from 38 mm above the deck"),
        ("aisc360", {"diameter_mm": 22, "height_mm": 120}, "d up to 19 mm in decks"),
    ],
)
def test_limits_in_decks(name: str, changes: dict[str, object], words: str) -> None:
    assert words in texts(name, **{**DECK, **changes})
    assert texts(name, **{**DECK, "height_mm": 100}) == ""
    assert words not in texts(name, **{**DECK, **changes, "slab": "solid", "deck_depth_mm": None,
                                       "deck_width_mm": None})  # fmt: skip


def test_lightweight_concrete_asks_for_slender_studs() -> None:
    light = {"density_kg_per_m3": 1800, "height_mm": 125}  # h/d = 6.6
    assert "h/d from 7 in lightweight concrete" in texts("aisc360", **light)
    assert "h/d from 10 in lightweight concrete" in texts("aisc360-tension", **light)
    assert "h/d from 8" in texts("aisc360-tension", height_mm=150)
    assert "heads from 1.6 d" in texts("aisc360-tension", height_mm=160, head_diameter_mm=30)
    assert "normal-weight concrete" in texts("en1992-tension", **light)
    assert texts("aisc360", height_mm=125) == texts("aisc360-tension", height_mm=160) == ""


def test_steel_across_ribs_counts_up_to_450() -> None:
    strong = {**DECK, "fcm_MPa": 80, "fu_MPa": 600, "height_mm": 110}
    expected = 0.8 * 0.25 * np.pi * 19**2 * 450 / 1e3 * 0.85  # k_t at its limit, thin sheet
    assert of("en1994", **strong) == pytest.approx(expected)
    along = {**strong, "slab": "deck parallel"}  # k_l = 1
    assert of("en1994", **along) == pytest.approx(0.8 * 0.25 * np.pi * 19**2 * 600 / 1e3)


def test_every_formula_says_what_of_its_source_was_read() -> None:
    words = ("read in", "recalled", "transcription")
    assert all(any(word in each.source for word in words) for each in FORMULAS.values())
    assert {each.load for each in SHEAR_MODELS.values()} == {"shear"}
    assert {each.load for each in TENSION_MODELS.values()} == {"tension"}
    statements = FORMULAS["en1992-tension"].formula
    assert statements == "P = min(1 A_s f_u; 12.7 √f_c h_ef^1.5; 10.5 A_h f_c)"
    assert FORMULAS["en1992-shear"].formula.endswith("k = 2 from h_ef = 60 mm on, else 1")


# -- pull-outs are fitted as push-outs are --------------------------------------------------------


@pytest.fixture
def pull_outs(tmp_path: Path) -> Path:
    generator = np.random.default_rng(4)
    header = "campaign,specimen,test,diameter_mm,height_mm,fcm_MPa,fu_MPa,tension_kN,shear_kN"
    lines = [header]
    for j in range(3):
        effect = 0.05 * generator.normal()
        for i in range(6):
            fc, h = generator.uniform(25, 45), generator.choice([75.0, 100.0])
            load = 16.8 * np.sqrt(fc) * (h - 9.5) ** 1.5 / 1e3
            load *= 1.1 * np.exp(effect + 0.05 * generator.normal())
            lines.append(f"lab {j},t{i},pull-out,19,{h},{fc:.1f},470,{load:.2f},")
    lines.append("lab 0,v,push-out,19,100,30,470,,100")
    path = tmp_path / "pull.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


def test_pull_outs_judge_formulas_of_tension(
    pull_outs: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    models = ["--model", "ccd-mean", "--model", "en1992-tension"]
    arguments = ["fit", "stud-strength", str(pull_outs), *models]
    assert run([*arguments, "--report", str(tmp_path / "r.html"), "--json"]) == 0
    results = json.loads(capsys.readouterr().out)["results"]
    ccd, en = results["fit"]
    assert ccd["tests"] == 18
    assert ccd["bias"] == pytest.approx(1.1, abs=0.08)
    ratio = en["bias"] / ccd["bias"]
    assert ratio == pytest.approx(16.8 / 12.7, rel=1e-6)
    assert results["d8"][0]["r_m"] == pytest.approx(results["d8"][0]["r_k"], rel=0.6)
    assert not any("modulus" in row["sentence"] for row in results["findings"])
    assert "Annex B" not in (tmp_path / "r.html").read_text()
    assert run(["fit", "stud-strength", str(pull_outs), "--model", "ccd-mean",
                "--model", "en1994"]) == 2  # fmt: skip
    assert "all be of shear, or all of tension" in capsys.readouterr().err


def test_unseen_pull_outs_and_factors(pull_outs: Path) -> None:
    table = read_text(pull_outs.read_text(), TESTS).accept()
    fit = fit_strength(table[table["campaign"] != "lab 2"], "ccd-mean")
    assert len(fit.judge(table[table["campaign"] == "lab 2"]).rows) == 6
    factor = fit_factors(table, "ccd-mean").estimates["concrete"]
    assert factor == pytest.approx(16.8 * 1.1, rel=0.08)
    with pytest.raises(InputError, match="one term of concrete"):
        fit_factors(table, "en1992-tension")
