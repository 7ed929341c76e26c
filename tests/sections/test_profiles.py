"""The profile catalogue against the tabulated values that stand beside the dimensions."""

import csv
import tomllib

import pytest

from workbench.datafiles import data_directory
from workbench.sections import find, names

TABLE = data_directory() / "profiles" / "european_profiles.csv"
with TABLE.open(encoding="utf-8", newline="") as file:
    ROWS = list(csv.DictReader(file))

IPE = (80, 100, 120, 140, 160, 180, 200, 220, 240, 270, 300, 330, 360, 400, 450, 500, 550, 600)
HE = (*range(100, 300, 20), 300, 320, 340, 360, 400, 450, 500, 550, 600)


def test_the_promised_families_are_complete() -> None:
    promised = {f"IPE {size}" for size in IPE}
    promised |= {f"{family} {size}" for family in ("HEA", "HEB", "HEM") for size in HE}
    assert promised <= set(names())
    assert len(names()) == len(set(names())) == len(ROWS)


# Tables print four digits at least where the leading digit is small: half a unit is 5e-4; the
# area of IPE 80 (7.64 cm2) has three. 1e-3 catches any wrong millimetre.
@pytest.mark.parametrize("row", ROWS, ids=lambda row: row["name"])
def test_properties_match_the_tabulated_values(row: dict[str, str]) -> None:
    section = find(row["name"])
    computed = {
        "area_cm2": section.area * 1e4,
        "second_moment_cm4": section.second_moment * 1e8,
        "elastic_section_modulus_cm3": section.elastic_section_modulus * 1e6,
        "plastic_section_modulus_cm3": section.plastic_section_modulus * 1e6,
    }
    for column, value in computed.items():
        assert value == pytest.approx(float(row[column]), rel=1e-3), column
    # Masses are printed to 0.1 kg/m.
    mass = float(row["mass_kg_per_m"])
    assert section.area * 7850 == pytest.approx(mass, abs=0.051)


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
    found = (
        section.second_moment,
        section.elastic_section_modulus,
        section.plastic_section_modulus,
    )
    assert found == pytest.approx(PRINTED[name], rel=5e-4)


@pytest.mark.parametrize("size", HE)
def test_the_series_grow_from_a_to_m(size: int) -> None:
    light, normal, heavy = (find(f"{family} {size}") for family in ("HEA", "HEB", "HEM"))
    assert light.area < normal.area < heavy.area
    assert light.plastic_section_modulus < normal.plastic_section_modulus
    assert normal.plastic_section_modulus < heavy.plastic_section_modulus


def test_the_data_catalogue_lists_the_profiles() -> None:
    listed = tomllib.loads((data_directory() / "catalogue.toml").read_text("utf-8"))["dataset"]
    entry = next(item for item in listed if item["name"] == "european-profiles")
    assert data_directory() / entry["file"] == TABLE
    assert entry["role"] == "verify"
    assert all(entry[key] for key in ("title", "source", "licence", "units", "uncertainty"))
