"""Texts with a unit: exact values in SI, nothing else accepted; the scenario stays what it was."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.base.errors import InputError
from workbench.base.fields import Number
from workbench.base.units import in_si
from workbench.scenarios import Column, load_scenario, scenario_hash
from workbench.steel.materials import GRADES, Steel
from workbench.steel.sections import SECTION, circular_tube, find, rectangular_tube, square_tube

FILE = "data/published/heng2017_impact_column.toml"


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("500 kN", "N", 5e5),
        ("3.2m", "m", 3.2),
        ("200 mm", "m", 0.2),
        ("90 km/h", "m/s", 25.0),
        ("355 N/mm2", "Pa", 355e6),
        ("355 MPa", "Pa", 355e6),
        ("8091 cm^4", "m4", 8.091e-5),
        ("20 kNm/rad", "N m/rad", 2e4),
        ("10 kN/mm", "N/m", 1e7),
        ("-1.5e2 kN m", "N m", -1.5e5),
        ("7.85 t/m3", "kg/m3", 7850.0),
        ("9810 mm/s2", "m/s2", 9.81),
        ("20 ms", "s", 0.02),
        (".5 1/s", "1/s", 0.5),
    ],
)
def test_values_are_exact(text: str, unit: str, value: float) -> None:
    assert in_si(text, unit) == value


@pytest.mark.parametrize(
    "text", ["500", "", "kN", "5 kg", "5 kN/", "5 N/m/m", "5,0 kN", "1e999 kN", "5 mN", "x" * 99]
)
def test_what_is_no_force_is_refused_in_one_line(text: str) -> None:
    with pytest.raises(InputError, match='or with a unit in quotes, such as "500 kN"'):
        Number(-1e9, 1e9, "N").check("column.axial_load", text)
    with pytest.raises(InputError, match="write a number without quotes"):
        Number(0.0, 1.0).check("striker.restitution", "0.5 m")


@pytest.mark.parametrize(("text", "name"), [("45 kph", "kph"), ("45 m/sec", "sec")])
def test_a_unit_that_is_not_known_is_named(text: str, name: str) -> None:
    """Not only the range of the numbers, which is kept."""
    with pytest.raises(InputError, match=f"unit {name} is not known; known are .* km, s, .*km/h"):
        Number(0.0, 100.0, "m/s").check("striker.velocity", text)


@given(st.decimals(-1000, 1000, allow_nan=False, places=3))
def test_a_length_in_mm_is_the_nearest_number_in_m(length: object) -> None:
    assert in_si(f"{length} mm", "m") == float(f"{length}e-3")


def test_a_scenario_with_units_is_the_same_one() -> None:
    known = load_scenario(FILE)
    texts = ["column.length_below=80 cm", 'striker.velocity="54 km/h"', "striker.mass=1.5 t"]
    plain = ["column.length_below=0.8", "striker.velocity=15", "striker.mass=1500"]
    assert load_scenario(FILE, texts) == load_scenario(FILE, plain)
    assert scenario_hash(load_scenario(FILE, texts)) == scenario_hash(load_scenario(FILE, plain))
    assert known.column.section == find("HEB 220")
    with pytest.raises(
        InputError, match=r'striker.mass = .*with a unit in quotes, such as "1.5 t"'
    ):
        load_scenario(FILE, ["striker.mass=1.5 km"])


def test_tubes_are_found_by_their_sizes() -> None:
    assert find("rhs 200 x 100 x 8") == rectangular_tube(0.2, 0.1, 0.008)
    assert find("SHS100x5") == find("SHS 100x100x5") == square_tube(0.1, 0.005)
    assert find("CHS 219.1x10") == circular_tube(0.2191, 0.01)
    column = Column("CHS 219.1x10", "0.8 m", 3.2)
    assert SECTION.read(SECTION.write(column.section), "section") == column.section  # type: ignore[misc]


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("RHS 200x8", "must look like RHS 200x100x8"),
        ("SHS 100x90x5", "must look like"),
        ("CHS 20x10", "section.wall must be below half the diameter"),
        ("RHS 2..0x100x8", "must look like"),
        ("RHS 0x100x8", "section.height must be"),
    ],
)
def test_tubes_that_cannot_be_are_refused(name: str, message: str) -> None:
    with pytest.raises(InputError, match=r"column\.section = ") as error:
        find(name, "column.section")
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("striker.velocity=30 kmh", r"unit kmh is not known; .*did you mean km/h\?"),
        ("column.length_below=0,8 m", "decimals have a point; write a number without quotes"),
        ("column.base=fixed", "one of clamped, pinned; a support that is fixed.* is clamped"),
        ("column.grade=S355", r"column\.grade: unknown key; grade stands in \[steel\]"),
    ],
)
def test_messages_name_what_was_meant(override: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        load_scenario(FILE, [override])


@pytest.mark.parametrize(
    ("written", "thickness", "stress", "like"),
    [
        ("S355J2", None, 355e6, "S355"),
        ("s355 jr", 0.03, 345e6, "S355"),
        ("S275", None, 275e6, "S235"),
        ("S 275 J0H", 0.05, 255e6, "S235"),
        ("S420", 0.02, 400e6, "S460"),
        ("S450J0", None, 450e6, "S460"),
        ("A36", 0.05, 250e6, "S235"),
        ("ASTM A992", None, 345e6, "S355"),
        ("A572 Gr. 50", 0.03, 345e6, "S355"),
    ],
)
def test_grades_are_read_as_people_write_them(
    written: str, thickness: float | None, stress: float, like: str
) -> None:
    steel = Steel(grade=written, thickness=thickness)
    assert steel.yield_stress == stress
    assert steel.rate == GRADES[like][1]


@pytest.mark.parametrize("written", ["S356", "A572 Gr 60", "A500", "S355 stainless"])
def test_other_grades_are_refused_with_the_known_ones(written: str) -> None:
    with pytest.raises(InputError, match=r"steel\.grade.*S235, S275, S355, S420, S450, S460, A36"):
        Steel(grade=written)
