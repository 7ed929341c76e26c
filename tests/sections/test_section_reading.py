"""Sections from names and tables, back to TOML, and every way to get them wrong."""

import time

import pytest

from workbench.base.errors import InputError
from workbench.steel.sections import (
    Section,
    circular_tube,
    find,
    i_section,
    names,
    plate,
    rectangle,
    rectangular_tube,
    section_from,
    section_value,
    square,
    square_tube,
)


@pytest.mark.parametrize(
    "name", ["HEB 220", "HEB220", "heb 220", " Heb-220 ", "HE 220 B", "he220b", "HEB_220"]
)
def test_names_are_read_tolerantly(name: str) -> None:
    assert find(name) == section_from(name, "column.section") == find("HEB 220")
    assert find(name).name == "HEB 220"


@pytest.mark.parametrize(
    ("known", "written"),
    [
        (
            "UB 203x133x25",
            ("ub203X133×25", "UB 203 x 133 x 25", "203x133x25 UB", "UB-203x133x25.0"),
        ),
        ("UC 254x254x89", ("UC254x254x89", "uc 254X254X89", " 254 x 254 x 89 UC ")),
        ("HD 400x421", ("hd400x421", "HD 400 × 421")),
        ("HD 260x93", ("HD 260x93.0", "HD 260 x 93,0")),
        ("IPN 200", ("ipn200", "IPN_200")),
        ("W 12x26", ("W12x26", "w 12 x 26", "W310x38.7", "W310x39", "W 310 x 39")),  # 38.69 kg/m
        ("W 36x135", ("W36x135", "W920x201")),
        ("W 14x90", ("W14X90", "W360x134", "W360x133.9")),
    ],
)
def test_names_of_several_sizes_are_read_tolerantly(known: str, written: tuple[str, ...]) -> None:
    assert known in names()
    assert [find(name).name for name in written] == [known] * len(written)


@pytest.mark.parametrize(
    ("table", "section"),
    [
        (
            {"height": 0.22, "width": 0.22, "web": 0.0095, "flange": 0.016, "fillet": 0.018},
            i_section(0.22, 0.22, 0.0095, 0.016, 0.018),
        ),
        (
            {"height": 0.22, "width": 0.22, "web": 0.0095, "flange": 0.016},
            i_section(0.22, 0.22, 0.0095, 0.016),
        ),
        ({"side": 0.2}, square(0.2)),
        ({"side": 1}, square(1.0)),
        ({"height": 0.3, "width": 0.2}, rectangle(0.3, 0.2)),
        ({"width": 0.2, "thickness": 0.01}, plate(0.2, 0.01)),
        ({"height": 0.3, "width": 0.2, "wall": 0.01}, rectangular_tube(0.3, 0.2, 0.01)),
        ({"side": 0.2, "wall": 0.01}, square_tube(0.2, 0.01)),
        ({"diameter": 0.2, "wall": 0.01}, circular_tube(0.2, 0.01)),
    ],
)
def test_tables(table: dict[str, float], section: Section) -> None:
    read = section_from(table, "column.section")
    assert read == section
    assert read.name == section.name


def test_a_plate_bends_out_of_its_plane() -> None:
    assert plate(0.2, 0.01).height == 0.01
    assert plate(0.2, 0.01).width == 0.2


def test_a_section_passes_through() -> None:
    section = square(0.2)
    assert section_from(section, "column.section") is section


def test_catalogue_sections_are_written_by_name() -> None:
    assert [section_value(find(name)) for name in names()] == list(names())


def test_a_borrowed_name_is_not_trusted() -> None:
    impostor = Section("HEB 220", square(0.2).shape)
    assert section_value(impostor) == {"height": 0.2, "width": 0.2}
    bare = find("HEB 220").without_fillets()
    assert section_from(section_value(bare), "section") == bare


I_TABLE = {"height": 0.2, "width": 0.2, "web": 0.01, "flange": 0.01}
METRES = "lengths are in metres, not millimetres"


@pytest.mark.parametrize(
    ("value", "field", "message"),
    [
        ("HEB 230", "column.section", "did you mean HEB 220 or HEB 240?"),
        ("heb230", "column.section", "did you mean HEB 220 or HEB 240?"),
        ("HEX 220", "column.section", "HEB 220"),
        ("IPX 200", "column.section", "IPE 200"),
        ("W 200x200", "column.section", "IPN 80 to 550"),
        ("UB 203x133x26", "column.section", "did you mean UB 203x133x25 or UB 203x133x30?"),
        ("uc 254", "column.section", "did you mean UC 254x254x73 or UC 254x254x89?"),
        ("914x305x239 UB", "column.section", "did you mean UB 914x305x238 or UB 914x305x253?"),
        ("203x133x25", "column.section", "did you mean UB 203x133x25"),
        ("UB 203x133x2.5.1", "column.section", "UB 203x133x25"),
        ("IPE 220 A", "column.section", "did you mean IPE 220"),
        ("HEB 22.0", "column.section", "must be a profile of the catalogue"),
        ("gibberish", "column.section", "IPE 80 to 600"),
        ("", "column.section", "or give its dimensions"),
        (220, "column.section", "must be a profile name or a table"),
        (None, "column.section", "must be a profile name or a table"),
        ([0.2], "column.section", "must be a profile name or a table"),
        ({}, "column.section", "must have the keys"),
        ({"height": 0.2}, "column.section", "must have the keys"),
        ({**I_TABLE, "wall": 0.01}, "column.section", "must have the keys"),
        ({"heigth": 0.2, "width": 0.2}, "column.section.heigth", "did you mean height?"),
        ({1: 0.2}, "column.section.1", "unknown key"),
        ({"side": 200}, "column.section.side", METRES),
        ({"side": 0.001}, "column.section.side", METRES),
        ({"side": -0.2}, "column.section.side", METRES),
        ({"side": "200 kN"}, "column.section.side", "without quotes"),
        ({"side": True}, "column.section.side", "must be a number"),
        ({"side": float("nan")}, "column.section.side", "finite"),
        ({**I_TABLE, "height": 220.0}, "column.section.height", METRES),
        ({**I_TABLE, "flange": 16.0}, "column.section.flange", METRES),
        ({**I_TABLE, "fillet": 18.0}, "column.section.fillet", METRES),
        ({**I_TABLE, "flange": 0.1}, "column.section.flange", "half the height"),
        ({**I_TABLE, "web": 0.2}, "column.section.web", "below the width"),
        ({**I_TABLE, "fillet": 0.0951}, "column.section.fillet", "fit between web and flange"),
        ({**I_TABLE, "fillet": 1e-6}, "column.section.fillet", "must be 0, or at least"),
        ({"diameter": 0.2, "wall": 0.1}, "column.section.wall", "half the diameter"),
        ({"side": 0.2, "wall": 0.1}, "column.section.wall", "half the smaller side"),
        ({"height": 0.3, "width": 0.02, "wall": 0.01}, "column.section.wall", "smaller side"),
        ({"width": 0.2, "thickness": 10}, "column.section.thickness", METRES),
    ],
)
def test_bad_values_name_the_key_and_say_what_is_allowed(
    value: object, field: str, message: str
) -> None:
    with pytest.raises(InputError) as caught:
        section_from(value, "column.section")
    assert caught.value.field == field
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_constructors_in_python_check_too() -> None:
    with pytest.raises(InputError, match=r"section\.height.*millimetres"):
        i_section(220, 220, 9.5, 16)
    with pytest.raises(InputError, match=r"section\.wall"):
        circular_tube(0.2, 0.15)
    with pytest.raises(InputError, match="must be a profile"):
        find(220)  # type: ignore[arg-type]


def test_long_names_take_no_longer_than_their_length() -> None:
    began = time.process_time()
    for name in ("HEB 220" + " " * 30_000 + "x", "H" * 30_000 + "?", "HEB" + "-" * 30_000):
        with pytest.raises(InputError, match="must be a profile of the catalogue"):
            find(name)
    assert time.process_time() - began < 2.0


@pytest.mark.parametrize(
    ("name", "section"),
    [
        # inches; design wall 0.93 of the nominal one: 0.465 in. for 1/2 (AISC Manual, table 1-12)
        ("HSS8X8X1/2", square_tube(8 * 0.0254, 0.465 * 0.0254)),
        ("HSS 10x6x3/8", rectangular_tube(10 * 0.0254, 6 * 0.0254, 0.93 * 0.375 * 0.0254)),
        ("HSS 3-1/2x3-1/2x1/4", square_tube(3.5 * 0.0254, 0.93 * 0.25 * 0.0254)),
        ("hss10.750x0.500", circular_tube(10.75 * 0.0254, 0.465 * 0.0254)),
        ("CHS 273 x 10 mm", circular_tube(0.273, 0.010)),
        ("SHS 100x5 mm", square_tube(0.1, 0.005)),
    ],
)
def test_tubes_in_inches_and_with_a_unit(name: str, section: Section) -> None:
    assert find(name).area == pytest.approx(section.area, rel=1e-9)
    assert type(find(name).shape) is type(section.shape)


@pytest.mark.parametrize(
    "name", ["UPN 200", "upe200", "C 12x20.7", "L 100x100x10", "PFC 200x75x23"]
)
def test_sections_of_one_axis_are_named_as_such(name: str) -> None:
    with pytest.raises(InputError, match=r"not doubly symmetric.*take an I section or a tube"):
        find(name)


@pytest.mark.parametrize("name", ["HSS 8x6x3/0", "HSS 8/x6x1", "W310x45000", "W 315x39"])
def test_wrong_american_names_are_refused(name: str) -> None:
    with pytest.raises(InputError, match="section = "):
        find(name)
