"""Numbers, units and intervals as the reader sees them."""

from __future__ import annotations

import math

import pytest

from workbench.report.page.formatting import (
    axis_label,
    count,
    duration,
    in_unit,
    interval,
    metric_value,
    number,
    part,
    percent,
)
from workbench.responses import VARIABLES


@pytest.mark.parametrize(
    ("ratio", "text"),
    [(1.0, "1"), (1.2, "1"), (0.9, "1"), (4.0, "5"), (1900.0, "2000"), (0.24, "1/5"),
     (4.8e-4, "1/2000"), (0.0, "–"), (None, "–")],
)  # fmt: skip
def test_ratios_of_times_are_rounded_to_one_two_and_five(ratio, text) -> None:
    assert part(ratio) == text


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (90.256, "90.26"),
        (-0.0012345, "−0.001234"),
        (999.96, "1000"),
        (123456.7, "123457"),
        (1.25e-7, "1.25×10⁻⁷"),
        (-3e9, "−3×10⁹"),
        (None, "–"),
        (math.nan, "–"),
        (-math.inf, "−∞"),
    ],
)
def test_number(value, text):
    assert number(value) == text


def test_rounding_up_to_a_power_of_ten_keeps_the_digits():
    assert number(9.9996) == "10.00"
    assert number(0.99996) == "1.000"


@pytest.mark.parametrize(
    ("share", "signed", "text"),
    [
        (0.0123, True, "+1.23 %"),
        (-0.2, True, "−20.0 %"),
        (-1e-9, True, "0.00 %"),
        (0.05, False, "5.00 %"),
        (0.0999, False, "9.99 %"),
        (0.09999, False, "10.0 %"),
    ],
)
def test_percent(share, signed, text):
    assert percent(share, signed=signed).replace("\u2009", " ") == text


def test_quantities_have_units_of_the_trade():
    assert in_unit(0.09026, "peak_displacement") == "90.26\u00a0mm"
    assert in_unit(0.0188, "time_of_peak", 3) == "18.8\u00a0ms"
    assert in_unit(2.5e5, "peak_force", 3) == "250\u00a0kN"
    assert axis_label("moment") == "moment (kN m)"
    assert axis_label("shear_utilisation") == "shear utilisation"


def test_every_response_variable_has_an_axis_label():
    for name in VARIABLES:
        assert axis_label(name)
        assert "_" not in axis_label(name)


def test_intervals_of_metrics():
    shown = interval("relative_error", "impulse", -0.0157, 0.0072).replace("\u2009", " ")
    assert shown == "−1.57 ± 0.72 %"
    assert "unknown" in interval("relative_error", "impulse", 0.01, None)
    assert interval("relative_error", "impulse", None, None) == "–"
    difference = interval("difference", "peak_displacement", 0.002, 0.001)
    assert difference == "2.00\u00a0mm ± 1.00\u00a0mm"
    assert not metric_value("area_difference", "force", 0.1).startswith("+")


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(2.3e-5, "23 µs"), (0.0456, "46 ms"), (3.21, "3.2 s"), (600.0, "10 min"), (None, "–")],
)
def test_duration(seconds, text):
    assert duration(seconds).replace("\u00a0", " ") == text


def test_count():
    assert count(1, "case") == "1 case"
    assert count(2, "case") == "2 cases"
