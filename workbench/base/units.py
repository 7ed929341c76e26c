"""Numbers with a unit as texts: ``"500 kN"``, ``"90 km/h"``; what they are in SI.

A unit is a product of names with powers, divided by at most one such product: ``N/mm2``, ``kN m``,
``kg/m^3``. Sums are exact: ``"200 mm"`` is the number 0.2.
"""

import re
from fractions import Fraction
from math import pi

Size = tuple[Fraction, tuple[int, int, int]]  # value in SI, powers of kg, m and s

_NUMBER = re.compile(r"\s*([+-]?(?:\d{1,20}\.?\d{0,20}|\.\d{1,20})(?:[eE][+-]?\d{1,2})?)\s*(.*)")
_FACTOR = re.compile(r"([A-Za-z]+)(?:\^?([1-4]))?")
_NAMES: dict[str, Size] = {
    name: (Fraction(value), powers)
    for name, value, powers in (
        *(("kg", "1", (1, 0, 0)), ("t", "1000", (1, 0, 0)), ("g", "1/1000", (1, 0, 0))),
        *(("m", "1", (0, 1, 0)), ("cm", "1/100", (0, 1, 0)), ("mm", "1/1000", (0, 1, 0))),
        *(("km", "1000", (0, 1, 0)), ("s", "1", (0, 0, 1)), ("ms", "1/1000", (0, 0, 1))),
        *(("h", "3600", (0, 0, 1)), ("Hz", "1", (0, 0, -1)), ("rad", "1", (0, 0, 0))),
        ("deg", str(pi / 180.0), (0, 0, 0)),
        *(("N", "1", (1, 1, -2)), ("kN", "1000", (1, 1, -2)), ("MN", "1000000", (1, 1, -2))),
        *(("Pa", "1", (1, -1, -2)), ("kPa", "1000", (1, -1, -2)), ("J", "1", (1, 2, -2))),
        *(("MPa", "1000000", (1, -1, -2)), ("GPa", "1000000000", (1, -1, -2))),
        *(("kJ", "1000", (1, 2, -2)), ("Nm", "1", (1, 2, -2)), ("kNm", "1000", (1, 2, -2))),
    )
}
_MEANT = {"kmh": "km/h", "kph": "km/h", "mps": "m/s", "kn": "kN", "to": "t", "tons": "t"}

_EVERYDAY = {  # unit: sizes from which on a factor and a name are used, falling
    "m": ((1.0, 1.0, "m"), (0.0, 1e3, "mm")),
    "kg": ((1e3, 1e-3, "t"), (0.0, 1.0, "kg")),
    "s": ((1.0, 1.0, "s"), (0.0, 1e3, "ms")),
    "Pa": ((1e9, 1e-9, "GPa"), (0.0, 1e-6, "MPa")),
    **{unit: ((0.0, 1e-3, f"k{unit}"),) for unit in ("N", "N/m", "N m", "J", "N m/rad")},
    "N or N/m": ((0.0, 1e-3, "kN or kN/m"),),
    "rad": ((0.0, 180.0 / pi, "deg"),),
    "m2": ((0.0, 1e4, "cm2"),),
    "m4": ((0.0, 1e8, "cm4"),),
}


def in_words(value: object, unit: str = "") -> str:
    """A value of the input as people write it: ``1.5 t``, ``15 m/s (54 km/h)``; `unit` in SI.

    Of a part with a name that, of another one its own words; of many how many, and the first ones.
    """
    if isinstance(value, tuple):
        first = ", ".join(in_words(each, unit) for each in value[:4])
        return f"{first}, ... ({len(value)})" if len(value) > 4 else first
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        parts = getattr(value, "words", {})
        return str(getattr(value, "name", "")) or (
            ", ".join(f"{n} ({t})" if ", " in t else f"{n} {t}" for n, t in parts.items())
            or str(value)
        )
    of = (each for each in _EVERYDAY.get(unit, ()) if abs(value) >= each[0])
    _, factor, name = next(of, (0.0, 1.0, unit))
    speed = f" ({3.6 * value:.4g} km/h)" if unit == "m/s" else ""
    return f"{factor * value:.5g} {name}".strip() + speed


def in_si(text: str, unit: str) -> float | None:
    """The number that a text with a unit is in the SI `unit`.

    None if it is no such text, or of another dimension.
    """
    match = _NUMBER.fullmatch(text) if len(text) <= 60 else None
    meant, wanted = _size(match[2].strip()) if match else None, _size(unit)
    if match is None or meant is None or wanted is None or meant[1] != wanted[1]:
        return None
    return float(Fraction(match[1]) * meant[0] / wanted[0])


def unknown_in(text: str) -> str:
    """Which name in the unit of a text is not known, to stand before advice; empty without one."""
    match = _NUMBER.fullmatch(text) if len(text) <= 60 else None
    factors = re.split(r"[\s*·/]+", match[2]) if match else ()
    read = (_FACTOR.fullmatch(factor) for factor in factors)
    name = next((each[1] for each in read if each and each[1] not in _NAMES), "")
    guess = f"did you mean {_MEANT[name.lower()]}? " if name.lower() in _MEANT else ""
    known = f"known are products of {', '.join(_NAMES)}; {guess}"
    return name and f"unit {name} is not known; {known}"


def _size(unit: str) -> Size | None:
    """Size of a unit in SI; None for one that is not known."""
    value, powers = Fraction(1), [0, 0, 0]
    above, slash, below = unit.partition("/")
    for sign, product in ((1, above), (-1, below)):
        for factor in filter(None, re.split(r"[\s*·]+", product)):
            match = _FACTOR.fullmatch(factor)
            if match is None or match[1] not in _NAMES:
                if sign > 0 and factor == "1":  # as in 1/s
                    continue
                return None
            size, dimension = _NAMES[match[1]]
            power = sign * int(match[2] or 1)
            value *= size**power
            powers = [sum_ + power * each for sum_, each in zip(powers, dimension, strict=True)]
    if not above.strip() or (slash and not below.strip()):
        return None
    return value, (powers[0], powers[1], powers[2])
