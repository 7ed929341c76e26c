"""Sections by catalogue name, from dimensions in Python, and from values of a scenario file."""

import difflib
import inspect
import re
from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import cache
from itertools import chain
from types import MappingProxyType

from workbench.base.datafiles import data_directory
from workbench.base.errors import InputError
from workbench.base.fields import Instance, check_keys
from workbench.base.tables import records
from workbench.steel.sections.section import (
    DIMENSION,
    FILLET,
    CircularTube,
    ISection,
    Rectangle,
    RectangularTube,
    Section,
    Shape,
)

_LONGEST = 40  # characters of a name
_HOLLOW = re.compile(
    r"(RHS|SHS|CHS|HSS)[\s_-]*((?:[\d./ -]{1,8}\s*[x×*]\s*){1,2}[\d./]{1,8})(?:\s*mm)?", re.I
)
_INCH = 0.0254  # m
_HSS_WALL = 0.93  # design wall over the nominal one of ASTM A500 (AISC 360, B4.2)
# nominal depth (mm) in the metric name of a W profile, by that in inches (ASTM A6/A6M)
_METRIC = {
    **{4: 100, 5: 130, 6: 150, 8: 200, 10: 250, 12: 310, 14: 360, 16: 410, 18: 460, 21: 530},
    **{24: 610, 27: 690, 30: 760, 33: 840, 36: 920, 40: 1000, 44: 1100},
}
_POUND_PER_FOOT = 1.4881639  # kg/m
_ONE_SIDED = re.compile(r"(UPN|UPE|UNP|PFC|MC|C|L|WT|MT)[\s_-]*\d.*", re.I)
# Words and sizes in either order: HE 220 B, UB 203x133x25, 203x133x25 UB.
_NAME = re.compile(r"([A-Za-z]*)[\s_-]*(\d[\d.,]*(?:\s*[xX×]\s*\d[\d.,]*)*)[\s_-]*([A-Za-z]*)")
_TABLES = ("european_profiles.csv", "rolled_profiles.csv")
_DIMENSIONS = ("height", "width", "web", "flange", "fillet")


@cache
def profiles() -> MappingProxyType[str, ISection]:
    """Read all profiles of the catalogue, in the order of the files, by name."""
    shapes = {}
    for table in _TABLES:
        for row in records((data_directory() / "profiles" / table).read_text(encoding="utf-8")):
            # Moving the decimal point in the text keeps the nearest number: 3.8 mm is 0.0038 m.
            metres = (float(f"{row[f'{dimension}_mm']}e-3") for dimension in _DIMENSIONS)
            shapes[row["name"]] = ISection(*metres)
    return MappingProxyType(shapes)


def _spelled(name: str) -> str:
    """Spell a profile name as the catalogue does.

    ``heb220`` and ``HE 220 B`` are HEB 220, ``ub203X133×25`` and ``203 x 133 x 25 UB`` are
    UB 203x133x25, ``HD 260 x 93,0`` is HD 260x93.
    """
    parts = _NAME.fullmatch(name.strip()) if len(name) <= _LONGEST else None
    if parts is None:
        return name.upper()
    sizes = re.split(r"\s*[xX×]\s*", parts[2].replace(",", "."))
    return (
        f"{parts[1]}{parts[3]}".upper()
        + " "
        + "x".join(re.sub(r"\.0+$", "", size) for size in sizes)
    )


def _nearest(name: str) -> list[str]:
    """Find up to two names of the catalogue that may have been meant, the nearest sizes first."""

    def sizes(spelled: str) -> list[float]:
        return [float(size) for size in spelled.split(" ")[1].split("x")]

    known, spelled = list(profiles()), _spelled(name)
    same = [candidate for candidate in known if candidate.split()[0] == spelled.split(" ")[0]]
    try:
        wanted = sizes(spelled) if same else []
    except ValueError:  # not numbers
        same = []
    if not same:
        return difflib.get_close_matches(spelled, known, 2, cutoff=0.7)

    def distances(candidate: str) -> list[float]:
        return [abs(a - b) for a, b in zip(sizes(candidate), wanted, strict=False)]

    return sorted(same, key=distances)[:2]


def _families() -> str:
    """Name the families of the catalogue with their smallest and largest profile."""
    sizes: dict[str, list[str]] = {}
    for name in profiles():
        family, size = name.split()
        sizes.setdefault(family, []).append(size)
    return ", ".join(f"{family} {size[0]} to {size[-1]}" for family, size in sizes.items())


def names() -> tuple[str, ...]:
    """Return the names of all profiles in the catalogue."""
    return tuple(profiles())


def find(name: str, path: str = "section") -> Section:
    """Look up a profile of the catalogue; spaces, case and the sign between sizes do not matter.

    ``RHS 200x100x8``, ``SHS 100x5`` and ``CHS 219.1x10`` are tubes of these sizes in mm, those of
    four sides with sharp corners, and are called as other sections from dimensions are;
    ``HSS 8x6x3/8`` is one in inches with 0.93 of the nominal wall; ``W 310x38.7`` is W 12x26.
    Raises `InputError` naming `path`, with the nearest known names.
    """
    hollow = _HOLLOW.fullmatch(name.strip()) if isinstance(name, str) else None
    if hollow is not None:
        return _tube(hollow[1].upper(), hollow[2], name, path)
    known = profiles()
    spelled = _spelled(name) if isinstance(name, str) else ""
    spelled = spelled if spelled in known else _in_inches(spelled)
    if spelled in known:
        return Section(spelled, known[spelled])
    if isinstance(name, str) and _ONE_SIDED.fullmatch(name.strip()):
        text = "is not doubly symmetric: models bend sections with two axes of symmetry alone"
        raise InputError(path, name, text, "take an I section or a tube")
    near = _nearest(name) if isinstance(name, str) else []
    guess = "did you mean " + " or ".join(near) + "?" if near else "or give its dimensions in m"
    raise InputError(path, name, f"must be a profile of the catalogue ({_families()})", guess)


def _in_inches(spelled: str) -> str:
    """Name of the W profile of the catalogue whose metric name is `spelled`, else `spelled`."""
    sizes = re.fullmatch(r"W (\d+)x([\d.]+)", spelled)
    depth = next((inch for inch, mm in _METRIC.items() if sizes and int(sizes[1]) == mm), None)
    if sizes is None or depth is None:
        return spelled
    masses = {  # distance of the mass (kg/m) from the one that is named
        name: abs(float(name.split("x")[1]) * _POUND_PER_FOOT - float(sizes[2]))
        for name in profiles()
        if name.startswith(f"W {depth}x")
    }
    nearest = min(masses, key=masses.__getitem__)
    return nearest if masses[nearest] <= max(0.6, 0.006 * float(sizes[2])) else spelled


def _size(text: str, family: str) -> float:
    """A size of a tube in m, from mm or, of HSS, from inches such as 3-1/2. Raises ValueError."""
    if family != "HSS":
        return float(f"{text.strip()}e-3")
    return float(sum(map(Fraction, re.split(r"[\s-]+", text.strip())))) * _INCH


def _tube(family: str, sizes: str, name: str, path: str) -> Section:
    """A hollow section by its family and sizes in mm, of HSS in inches."""
    try:
        size = [_size(text, family) for text in re.split("[xX×*]", sizes)]
        if family == "HSS":
            family = "RHS" if len(size) == 3 else "CHS"
            size[-1] *= _HSS_WALL
        if family == "SHS" and len(size) == 3 and size[0] == size[1]:
            size = size[1:]
        if len(size) != (3 if family == "RHS" else 2):
            raise ValueError
    except (ValueError, ZeroDivisionError):
        allowed = "must look like RHS 200x100x8, SHS 100x5 or CHS 219.1x10, in mm, or HSS 8x6x3/8"
        raise InputError(path, name, allowed) from None
    try:
        if family == "CHS":
            return circular_tube(*size)
        return rectangular_tube(*size) if family == "RHS" else square_tube(*size)
    except InputError as error:
        raise InputError(path, name, f"{error.field} {error.allowed}", error.advice) from None


def i_section(
    height: float, width: float, web: float, flange: float, fillet: float = 0.0
) -> Section:
    """I or H section from its dimensions (m). Raises `InputError`."""
    return _named(ISection(height, width, web, flange, fillet))


def rectangle(height: float, width: float) -> Section:
    """Solid rectangle, `height` in the plane of bending (m). Raises `InputError`."""
    return _named(Rectangle(height, width))


def square(side: float) -> Section:
    """Solid square (m). Raises `InputError`."""
    return rectangle(side, side)


def plate(width: float, thickness: float) -> Section:
    """Plate bent out of its plane (m). Raises `InputError`."""
    return rectangle(thickness, width)


def rectangular_tube(height: float, width: float, wall: float) -> Section:
    """Rectangular hollow section with sharp corners (m). Raises `InputError`."""
    return _named(RectangularTube(height, width, wall))


def square_tube(side: float, wall: float) -> Section:
    """Square hollow section with sharp corners (m). Raises `InputError`."""
    return rectangular_tube(side, side, wall)


def circular_tube(diameter: float, wall: float) -> Section:
    """Circular hollow section (m). Raises `InputError`."""
    return _named(CircularTube(diameter, wall))


def _named(shape: Shape) -> Section:
    return Section(shape.describe(), shape)


# The keys of a table in a file, the arguments of one of these, say what it describes.
_FORMS: dict[tuple[str, ...], Callable[..., Section]] = {
    tuple(inspect.signature(form).parameters): form
    for form in (i_section, square, rectangle, plate, rectangular_tube, square_tube, circular_tube)
}


def section_from(value: object, path: str = "section") -> Section:
    """Build the section that a value of a scenario file describes.

    `value` is a catalogue name, a table of dimensions in metres, or a `Section`, which passes
    through. Raises `InputError` naming `path`.
    """
    if isinstance(value, Section):
        return value
    if isinstance(value, str):
        return find(value, path)
    if not isinstance(value, Mapping):
        raise InputError(path, value, "must be a profile name or a table of dimensions in metres")
    table = {str(key): size for key, size in value.items()}
    check_keys(list(table), list(dict.fromkeys(chain.from_iterable(_FORMS))), path)
    meant = [keys for keys in _FORMS if {*keys} in ({*table}, {*table, "fillet"})]
    if not meant:
        *first, last = ["{" + ", ".join(keys) + "}" for keys in _FORMS]
        choices = f"must have the keys {', '.join(first)} or {last}"
        raise InputError(path, table, choices, "add or drop keys; lengths are in metres")
    # Checked here first, so that the message names the key that was written.
    for key, size in table.items():
        (FILLET if key == "fillet" else DIMENSION).check(f"{path}.{key}", size)
    try:
        return _FORMS[meant[0]](**table)
    except InputError as error:
        field = path + error.field.removeprefix("section")
        raise InputError(field, error.value, error.allowed, error.advice) from None


def section_value(section: Section) -> str | dict[str, float]:
    """Return the value that `section_from` turns back into a section: its name or dimensions."""
    section = section.about("strong")  # the axis is a field of what it is the section of
    known = profiles().get(section.name) == section.shape
    return section.name if known else section.shape.dimensions


SECTION = Instance(Section, "use sections.find(name)", section_from, section_value)
