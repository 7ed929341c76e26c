"""The usual stud by the codes, against numbers worked out by hand."""

import pytest

from workbench.studs.formulas import SHEAR_MODELS, usual_stud


@pytest.mark.parametrize(
    ("name", "steel", "concrete", "gamma"),
    [
        ("en1994", 102.1, 103.9, 1.25),  # 0.8 A f_u; 0.29 d2 sqrt(30 x 32837)
        ("roik-mean", 127.6, 150.8, None),  # A f_u; 0.374 d2 sqrt(38 x 32837)
        ("aisc360", 95.7, 125.0, None),  # 0.75 A f_u; 0.5 A sqrt(30 x 25924)
    ],
)
def test_terms_are_those_worked_out_by_hand(name, steel, concrete, gamma):
    result = usual_stud(SHEAR_MODELS[name])
    assert result["steel_term"] / 1e3 == pytest.approx(steel, abs=0.1)
    assert result["concrete_term"] / 1e3 == pytest.approx(concrete, abs=0.1)
    assert result["resistance"] == min(result["steel_term"], result["concrete_term"])
    assert result["partial_factor"] == gamma


def test_another_modulus_lets_the_concrete_govern():
    result = usual_stud(SHEAR_MODELS["en1994"])
    assert result["other_concrete_term"] / 1e3 == pytest.approx(97.95, abs=0.1)
    assert result["other_concrete_term"] < result["steel_term"]


def test_a_formula_of_no_code_has_no_usual_stud():
    assert usual_stud(SHEAR_MODELS["ollgaard"]) is None
