"""Units of tables against what they are by definition."""

from __future__ import annotations

import pytest

from workbench.base.errors import InputError
from workbench.extras.intake.conversion import factor


@pytest.mark.parametrize(
    ("unit", "into", "times"),
    [
        ("km/h", "m/s", 1.0 / 3.6),
        ("mph", "m/s", 0.44704),
        ("ft/s", "m/s", 0.3048),
        ("kip", "kN", 4.4482216),
        ("ksi", "MPa", 6.8947573),
        ("tf", "kN", 9.80665),
        ("lb", "kg", 0.45359237),
        ("t", "kg", 1000.0),
        ("in", "mm", 25.4),
        ("ms", "s", 1e-3),
        ("kN/mm", "N/m", 1e6),
        ("kip/in", "kN/mm", 0.17512684),
        ("pcf", "kg/m3", 16.018463),
        ("N/mm²", "Pa", 1e6),
    ],
)
def test_factors_are_those_of_the_definitions(unit: str, into: str, times: float) -> None:
    assert factor(unit, into, "field") == pytest.approx(times, rel=1e-6)


def test_units_of_other_quantities_are_refused() -> None:
    with pytest.raises(InputError, match=r"field.*is no unit of a force"):
        factor("MPa", "kN", "field")
