"""Catalogue of rolled European profiles: names and shapes."""

import csv
import difflib
import re
from functools import cache
from types import MappingProxyType

from workbench.datafiles import data_directory
from workbench.sections.shapes import ISection

_LONGEST = 40  # characters of a name
_DIMENSIONS = ("height", "width", "web", "flange", "fillet")


@cache
def profiles() -> MappingProxyType[str, ISection]:
    """Read all profiles of the catalogue, in the order of the file, by name."""
    path = data_directory() / "profiles" / "european_profiles.csv"
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    shapes = {}
    for row in rows:
        # Moving the decimal point in the text keeps the nearest number: 3.8 mm is 0.0038 m.
        metres = (float(f"{row[f'{dimension}_mm']}e-3") for dimension in _DIMENSIONS)
        shapes[row["name"]] = ISection(*metres)
    return MappingProxyType(shapes)


def canonical(name: str) -> str:
    """Spell a profile name as the catalogue does: ``heb220`` and ``HE 220 B`` are HEB 220."""
    spelled = name.strip() if len(name) <= _LONGEST else ""
    parts = re.fullmatch(r"([A-Za-z]+)[\s_-]*([0-9]+)[\s_-]*([ABMabm]?)", spelled)
    if parts is None:
        return name
    return f"{parts[1]}{parts[3]} {parts[2]}".upper()


def nearest(name: str) -> list[str]:
    """Find up to two names of the catalogue that may have been meant."""
    known = list(profiles())
    family, _, size = canonical(name).partition(" ")
    same = [candidate for candidate in known if candidate.split()[0] == family]
    if same and size.isdecimal() and len(size) < 9:
        same.sort(key=lambda candidate: abs(int(candidate.split()[1]) - int(size)))
        return same[:2]
    return difflib.get_close_matches(canonical(name).upper(), known, 2, cutoff=0.7)


def families() -> str:
    """Name the families of the catalogue with their smallest and largest profile."""
    first: dict[str, str] = {}
    last: dict[str, str] = {}
    for name in profiles():
        family, size = name.split()
        first.setdefault(family, size)
        last[family] = size
    return ", ".join(f"{family} {first[family]} to {last[family]}" for family in first)
