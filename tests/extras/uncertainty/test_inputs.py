"""Distributions as TOML writes them, and the samples that they give."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.base.errors import InputError
from workbench.extras.uncertainty.distributions import distribution_of
from workbench.extras.uncertainty.inputs import load_uncertain, uncertain_from_text

COLUMN = """
kind = "column-impact"
name = "uncertain"
[column]
section = "HEB 220"
length_below = 2.0
length_above = 2.0
axial_load = {axial}
[steel]
yield_stress = { jcss = "S355" }
[striker]
mass = { normal = [1500.0, 400.0], low = 500.0 }
velocity = 15.0
"""
AXIAL = "{ lognormal = { mean = 500e3, cov = 0.15 } }"


def column(more="", axial=AXIAL):
    return uncertain_from_text(COLUMN.replace("{axial}", axial) + more)


@pytest.mark.parametrize(
    ("law", "mean", "sd"),
    [
        ({"normal": [14.0, 2.0]}, 14.0, 2.0),
        ({"lognormal": {"mean": 14.0, "cov": 0.3}}, 14.0, 4.2),
        ({"gumbel": {"mean": 14.0, "sd": 2.0}}, 14.0, 2.0),
        ({"weibull": [14.0, 5.0]}, 14.0, 5.0),
        ({"uniform": [2.0, 8.0]}, 5.0, 6.0 / np.sqrt(12.0)),
        ({"triangular": [0.0, 1.0, 5.0]}, 2.0, np.sqrt(21.0 / 18.0)),
        ({"discrete": {"values": [1.0, 3.0], "weights": [3, 1]}}, 1.5, np.sqrt(0.75)),
    ],
)
def test_values_have_the_moments_that_are_asked(law, mean, sd):
    shares = (np.arange(200_000) + 0.5) / 200_000
    from scipy.special import ndtri

    values = distribution_of("key", law).values(ndtri(shares)).astype(float)
    assert values.mean() == pytest.approx(mean, rel=2e-3)
    assert values.std() == pytest.approx(sd, rel=5e-3)


@given(st.floats(-6.0, 6.0), st.floats(-6.0, 6.0))
@settings(max_examples=50, deadline=None)
def test_truncated_values_stay_inside_and_rise(first, second):
    distribution = distribution_of("key", {"normal": [10.0, 5.0], "low": 6.0, "high": 11.0})
    low, high = distribution.values(np.array(sorted((first, second))))
    assert 6.0 <= low <= high <= 11.0


def test_named_yield_stress_is_that_of_the_model_code():
    # JCSS Probabilistic Model Code 3.2: 355 exp(0.14) - 20 = 388.3 MPa, cov 0.07
    values = distribution_of("steel.yield_stress", {"jcss": "S355"}).frozen
    assert values.mean() == pytest.approx(388.3e6, rel=1e-3)
    assert values.std() / values.mean() == pytest.approx(0.07)


def test_points_by_index_are_those_of_the_whole_sequence():
    uncertain = column()
    whole = uncertain.normal_scores(256, (3, 1))
    assert np.array_equal(whole[37:38], uncertain.normal_scores(1, (3, 1), 37))
    assert np.array_equal(whole[64:96], uncertain.normal_scores(32, (3, 1), 64))
    assert not np.array_equal(whole, uncertain.normal_scores(256, (3, 2)))


def test_scenarios_carry_their_values():
    uncertain = column()
    assert uncertain.names == ["column.axial_load", "steel.yield_stress", "striker.mass"]
    scores = uncertain.normal_scores(8, (1, 0))
    values = uncertain.values(scores)
    for number, scenario in enumerate(uncertain.scenarios(scores)):
        assert scenario.column.axial_load == values["column", "axial_load"][number]
        assert scenario.striker.mass == values["striker", "mass"][number] >= 500.0
        assert scenario.column.steel.yield_stress == values["steel", "yield_stress"][number]


def test_copula_correlates_the_scores():
    pairs = '[correlation]\npairs = [["column.axial_load", "striker.mass", 0.6]]\n'
    uncertain = column(pairs)
    values = uncertain.values(uncertain.normal_scores(4096, (1, 0)))
    load, mass = np.log(values["column", "axial_load"]), values["striker", "mass"]
    assert np.corrcoef(load, mass)[0, 1] == pytest.approx(0.6, abs=0.02)


@pytest.mark.parametrize(
    ("axial", "message"),
    [
        ("{ normal = [1.0] }", "column.axial_load.normal"),
        ("{ normal = [1.0, -2.0] }", "standard deviation above 0"),
        ("{ normal = [1.0, 2.0], gumbel = [1.0, 2.0] }", "must name one law"),
        ("{ normal = [1.0, 2.0], middle = 3.0 }", "must name one law"),
        ("{ mean = 1.0, cov = 0.1 }", r"is no known distribution.*normal = \[14.0, 2.0\]"),
        ("{ gauss = [1.0, 2.0] }", "laws are normal, lognormal, gumbel"),
        ("{ normal = [1.0, 2.0], low = 5.0, high = 4.0 }", "between low and high"),
        ("{ lognormal = [-1.0, 2.0] }", "mean above 0"),
        ("{ weibull = [1.0, 20.0] }", "coefficient of variation"),
        ("{ uniform = [2.0, 1.0] }", "must rise"),
        ("{ triangular = [1.0, 2.0] }", "low, mode and high"),
        ("{ discrete = { values = [1.0], weights = [1.0, 2.0] } }", "a weight"),
        ("{ discrete = [1.0] }", "values"),
        ('{ jcss = "S355" }', "is known for"),
        ('{ normal = ["a", 1.0] }', "must be a number"),
        (
            "{ normal = [1e308, 1e308] }",
            r"normal = 1e\+308: must be a number in SI units, within 1e\+30",
        ),
        ("{ lognormal = [1e308, 1e307] }", "within 1e"),
        ("{ gumbel = [1.0, 1e308] }", "within 1e"),
        ("{ uniform = [-1e308, 1e308] }", "within 1e"),
        ("{ triangular = [-1e308, 0.0, 1e308] }", "within 1e"),
        ("{ normal = [5e5, 1e5], high = 1e308 }", "axial_load.high = 1e"),
        ("{ discrete = { values = [1.0], weights = [1e308] } }", "within 1e"),
        (f"{{ normal = [1{'0' * 400}, 1.0] }}", "within 1e"),
        ("{ lognormal = { mean = 5e5, cov = 1e6 } }", "variation from 1e-06 to 10"),
        ("{ lognormal = [5e5, 5e11] }", "variation from 1e-06 to 10"),
        ("{ normal = { mean = 5e5, cov = 1e6 } }", "variation from 1e-06 to 10"),
        ("{ normal = [5e5, 1e-300] }", "write a number where nothing varies"),
        ("{ normal = [0.0, 1e-300] }", "write a number where nothing varies"),
    ],
)
def test_wrong_distributions_are_refused_in_one_line(axial, message):
    with pytest.raises(InputError, match=message) as error:
        column(axial=axial)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    "pairs",
    [
        '[["column.axial_load", "striker.velocity", 0.6]]',
        '[["column.axial_load", "striker.mass", 1.5]]',
        '[["column.axial_load", "striker.mass"]]',
        "0.5",
        '[["column.axial_load", "striker.mass", 0.9], ["column.axial_load", "steel.yield_stress",'
        ' 0.9], ["steel.yield_stress", "striker.mass", -0.9]]',
    ],
)
def test_wrong_correlations_are_refused(pairs):
    with pytest.raises(InputError, match="correlation"):
        column(f"[correlation]\npairs = {pairs}\n")


def test_unreadable_files_are_refused(tmp_path):
    path = tmp_path / "c.toml"
    for content in (b"kind = [", b"\xff\xfe", b"\x00"):
        path.write_bytes(content)
        with pytest.raises(InputError):
            load_uncertain(path)
