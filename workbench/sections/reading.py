"""Sections by catalogue name, from dimensions in Python, and from values of a scenario file."""

import inspect
from collections.abc import Callable, Mapping
from itertools import chain

from workbench.errors import InputError
from workbench.fields import Instance, check_keys
from workbench.sections.catalogue import canonical, families, nearest, profiles
from workbench.sections.section import Section
from workbench.sections.shapes import (
    DIMENSION,
    FILLET,
    CircularTube,
    ISection,
    Rectangle,
    RectangularTube,
    Shape,
)


def names() -> tuple[str, ...]:
    """List the names of all profiles in the catalogue."""
    return tuple(profiles())


def find(name: str, path: str = "section") -> Section:
    """Look up a profile of the catalogue; spaces and case do not matter.

    Raises `InputError` naming `path`, with the nearest known names.
    """
    known = profiles()
    spelled = canonical(name) if isinstance(name, str) else ""
    if spelled in known:
        return Section(spelled, known[spelled])
    near = nearest(name) if isinstance(name, str) else []
    guess = "did you mean " + " or ".join(near) + "?" if near else "or give its dimensions in m"
    raise InputError(path, name, f"must be a profile of the catalogue ({families()})", guess)


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


SECTION = Instance(Section, "use sections.find(name)", section_from, Section.to_toml)
