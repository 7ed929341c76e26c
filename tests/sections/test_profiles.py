"""The profile catalogue against the tabulated values that stand beside the dimensions."""

import csv
import tomllib
from pathlib import Path

import pytest

from workbench.base.datafiles import data_directory
from workbench.steel.sections import Section, find, names

TABLE = data_directory() / "profiles" / "european_profiles.csv"
ROLLED = TABLE.with_name("rolled_profiles.csv")


def _rows(table: Path) -> list[dict[str, str]]:
    with table.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


ROWS, ROLLED_ROWS = _rows(TABLE), _rows(ROLLED)

IPE = (80, 100, 120, 140, 160, 180, 200, 220, 240, 270, 300, 330, 360, 400, 450, 500, 550, 600)
HE = (*range(100, 300, 20), 300, 320, 340, 360, 400, 450, 500, 550, 600)


def test_the_promised_families_are_complete() -> None:
    promised = {f"IPE {size}" for size in IPE}
    promised |= {f"{family} {size}" for family in ("HEA", "HEB", "HEM") for size in HE}
    assert promised <= set(names())
    assert len(names()) == len(set(names())) == len(ROWS) + len(ROLLED_ROWS)


def _computed(section: Section) -> dict[str, float]:
    """Properties about the strong axis in the units of the tables."""
    return {
        "area_cm2": section.area * 1e4,
        "second_moment_cm4": section.second_moment * 1e8,
        "elastic_section_modulus_cm3": section.elastic_section_modulus * 1e6,
        "plastic_section_modulus_cm3": section.plastic_section_modulus * 1e6,
    }


# Tables print four digits at least where the leading digit is small: half a unit is 5e-4; the
# area of IPE 80 (7.64 cm2) has three. 1e-3 catches any wrong millimetre.
@pytest.mark.parametrize("row", ROWS, ids=lambda row: row["name"])
def test_properties_match_the_tabulated_values(row: dict[str, str]) -> None:
    section = find(row["name"])
    for column, value in _computed(section).items():
        assert value == pytest.approx(float(row[column]), rel=1e-3), column
    # Masses are printed to 0.1 kg/m.
    mass = float(row["mass_kg_per_m"])
    assert section.area * 7850 == pytest.approx(mass, abs=0.051)


# Three digits are printed: half a unit of 101 is 0.5 %. The flanges of IPN are tapered: plates of
# their mean thickness without fillets stand for them. Nominal masses of W 21x223 to 21x275 are up
# to 1.5 % off their areas.
@pytest.mark.parametrize("row", ROLLED_ROWS, ids=lambda row: row["name"])
def test_dimensions_give_the_tabulated_area_second_moment_and_mass(row: dict[str, str]) -> None:
    section = find(row["name"])
    computed = _computed(section) | {"mass_kg_per_m": section.area * 7850}
    bound = {"IPN": 0.02, "W": 0.015}.get(row["name"].split()[0], 0.01)
    for column, value in computed.items():
        assert value == pytest.approx(float(row[column]), rel=bound), column


# Typed from a second transcription, which rounds depth and width to mm.
SECOND = {
    "UB 127x76x13": (127, 76, 4, 7.6),
    "UB 203x133x25": (203, 133, 5.7, 7.8),
    "UB 305x165x54": (310, 167, 7.9, 13.7),
    "UB 457x191x67": (453, 190, 8.5, 12.7),
    "UB 610x229x101": (603, 228, 10.5, 14.8),
    "UB 914x419x388": (921, 420.5, 21.4, 36.6),
    "UC 152x152x23": (152, 152, 5.8, 6.8),
    "UC 254x254x89": (260, 256, 10.3, 17.3),
    "UC 356x406x634": (475, 424, 47.6, 77),
    "HD 400x421": (425, 409, 32.8, 52.6),
    "HD 360x134": (356, 369, 11.2, 18),
    "IPN 200": (200, 90, 7.5, 11.3),
    "IPN 400": (400, 155, 14.4, 21.6),
}


# W in inches: depth, width, web, flange of a second transcription, which rounds depth and width
# less; the manual of AISC gives three digits of them.
INCHES = {
    "W8x31": (8.00, 7.995, 0.285, 0.435),
    "W10x49": (10.00, 10.000, 0.340, 0.560),
    "w 12 x 53": (12.06, 9.995, 0.345, 0.575),
    "W12X72": (12.25, 12.040, 0.430, 0.670),
    "12x96 W": (12.71, 12.160, 0.550, 0.900),
}


@pytest.mark.parametrize("name", INCHES)
def test_a_second_transcription_in_inches_agrees(name: str) -> None:
    size = find(name).shape.dimensions
    inches = [size[side] / 0.0254 for side in ("height", "width", "web", "flange")]
    assert inches[:2] == pytest.approx(INCHES[name][:2], abs=0.051)
    assert inches[2:] == pytest.approx(INCHES[name][2:], abs=0.001)


@pytest.mark.parametrize("name", SECOND)
def test_a_second_transcription_agrees(name: str) -> None:
    size = find(name).shape.dimensions
    millimetres = [1e3 * size[side] for side in ("height", "width", "web", "flange")]
    assert millimetres[:2] == pytest.approx(SECOND[name][:2], abs=0.5001)
    assert millimetres[2:] == pytest.approx(SECOND[name][2:], abs=1e-9)


@pytest.mark.parametrize(
    ("column", "beam"),
    [
        ("HD 260x54.1", None),
        ("HD 260x68.2", "HEA 260"),
        ("HD 260x93", "HEB 260"),
        ("HD 260x172", "HEM 260"),
        ("HD 320x97.6", "HEA 320"),
        ("HD 320x127", "HEB 320"),
        ("HD 320x245", "HEM 320"),
    ],
)
def test_hd_of_the_sizes_of_he_are_the_same_sections(column: str, beam: str | None) -> None:
    same = [name for name in names() if not name.startswith("HD") and _same(name, column)]
    assert same == ([beam] if beam else [])


def _same(one: str, other: str) -> bool:
    return find(one).shape == find(other).shape


# Published values typed from the printed tables of ArcelorMittal, apart from the data file.
PRINTED = {
    "IPE 300": (8356e-8, 557.1e-6, 628.4e-6),
    "HEA 200": (3692e-8, 388.6e-6, 429.5e-6),
    "HEB 220": (8091e-8, 735.5e-6, 827.0e-6),
    "HEM 300": (59200e-8, 3482e-6, 4078e-6),
}


@pytest.mark.parametrize("name", PRINTED)
def test_printed_values(name: str) -> None:
    section = find(name)
    result = (
        section.second_moment,
        section.elastic_section_modulus,
        section.plastic_section_modulus,
    )
    assert result == pytest.approx(PRINTED[name], rel=5e-4)


@pytest.mark.parametrize("size", HE)
def test_the_series_grow_from_a_to_m(size: int) -> None:
    light, normal, heavy = (find(f"{family} {size}") for family in ("HEA", "HEB", "HEM"))
    assert light.area < normal.area < heavy.area
    assert light.plastic_section_modulus < normal.plastic_section_modulus
    assert normal.plastic_section_modulus < heavy.plastic_section_modulus


@pytest.mark.parametrize(
    ("dataset", "table"), [("european-profiles", TABLE), ("rolled-profiles", ROLLED)]
)
def test_the_data_catalogue_lists_the_profiles(dataset: str, table: Path) -> None:
    listed = tomllib.loads((data_directory() / "catalogue.toml").read_text("utf-8"))["dataset"]
    entry = next(item for item in listed if item["name"] == dataset)
    assert data_directory() / entry["file"] == table
    assert entry["role"] == "verify"
    assert all(entry[key] for key in ("title", "source", "licence", "units", "uncertainty"))
