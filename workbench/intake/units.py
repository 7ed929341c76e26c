"""The units that tables may have: a closed list per quantity, each with its value in SI."""

from workbench.errors import InputError
from workbench.fields import did_you_mean

_INCH, _POUND, _POUND_FORCE = 0.0254, 0.45359237, 4.4482216152605
_SQUARE_INCH = _INCH**2
UNITS: dict[str, dict[str, float]] = {
    "length": {"m": 1.0, "cm": 0.01, "mm": 1e-3, "in": _INCH, "ft": 12.0 * _INCH},
    "force": {
        **{"N": 1.0, "kN": 1e3, "MN": 1e6, "kgf": 9.80665, "tf": 9806.65},
        **{"lbf": _POUND_FORCE, "kip": 1e3 * _POUND_FORCE},
    },
    "stress": {
        **{"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "N/mm2": 1e6},
        **{"psi": _POUND_FORCE / _SQUARE_INCH, "ksi": 1e3 * _POUND_FORCE / _SQUARE_INCH},
    },
    "stiffness": {
        **{"N/m": 1.0, "kN/m": 1e3, "N/mm": 1e3, "MN/m": 1e6, "kN/mm": 1e6},
        **{"lbf/in": _POUND_FORCE / _INCH, "kip/in": 1e3 * _POUND_FORCE / _INCH},
    },
    "mass": {"kg": 1.0, "g": 1e-3, "t": 1e3, "lb": _POUND},
    "velocity": {
        **{"m/s": 1.0, "mm/s": 1e-3, "km/h": 1.0 / 3.6},
        **{"ft/s": 12.0 * _INCH, "mph": 0.44704},
    },
    "time": {"s": 1.0, "ms": 1e-3},
    "density": {"kg/m3": 1.0, "g/cm3": 1e3, "lb/ft3": _POUND / (12.0 * _INCH) ** 3},
}
_SPELLED = {
    **{"kips": "kip", "lbs": "lb", "inch": "in", "inches": "in", "kph": "km/h", "N/mm²": "N/mm2"},
    **{"kg/m³": "kg/m3", "kg/m^3": "kg/m3", "N/mm^2": "N/mm2", "g/cm³": "g/cm3", "pcf": "lb/ft3"},
}
_ALL = {unit: (quantity, value) for quantity, of in UNITS.items() for unit, value in of.items()}


def spelled(unit: str) -> str:
    """A unit as the list spells it, brackets around it left out."""
    bare = unit.strip().strip("[]()").strip().rstrip(".")
    return _SPELLED.get(bare, bare)


def is_unit(text: str) -> bool:
    """Whether a text is a unit of the list."""
    return spelled(text) in _ALL


def factor(unit: str, into: str, field: str) -> float:
    """How many of the unit `into` one `unit` is.

    Raises `InputError` naming `field` for a unit that is not on the list, or of another quantity.
    """
    quantity, value = _ALL[into]
    own = _ALL.get(spelled(unit))
    if own is None or own[0] != quantity:
        allowed = f"is no unit of a {quantity} that is known; " + ", ".join(UNITS[quantity])
        raise InputError(field, unit, allowed, did_you_mean(unit, UNITS[quantity]))
    return own[1] / value
