"""Structural steel as the models use it: stiffness, strength, hardening and strain rate."""

from __future__ import annotations

import re
from bisect import bisect_left
from collections.abc import Mapping
from dataclasses import dataclass
from math import sqrt
from typing import Any, Self

from workbench.base.errors import InputError
from workbench.base.fields import Choice, Declared, Instance, Number, check_keys, checked

POISSON_RATIO = 0.3
COWPER_SYMONDS, NO_RATE = "cowper-symonds", "none"
_RATE = Number(1e-3, 1e30, "1/s", advice="D of mild steel is 40.4 1/s, of S355 some 500 1/s")


@dataclass(frozen=True)
class CowperSymonds(Declared, table="steel.rate"):
    """Rate sensitivity: the stress at plastic strain rate r is fy (1 + (r / D)^(1 / q)).

    Arguments: `reference_rate` D in 1/s, `exponent` q; `slow` and `fast`, ends of the 90 %
    interval of D in 1/s where it is known (a small D is a sensitive steel). Source: Cowper and
    Symonds 1957.
    """

    reference_rate: float = checked(_RATE, path="steel.rate.D")
    exponent: float = checked(Number(1.0, 50.0), path="steel.rate.q")
    slow: float | None = checked(_RATE, optional=True, path="steel.rate.D_range")
    fast: float | None = checked(_RATE, optional=True, path="steel.rate.D_range")

    def check(self) -> None:
        """Refuse an interval that does not hold D."""
        if self.slow is None and self.fast is None:
            return
        low, high = self.slow or self.fast, self.fast or self.slow
        if low is None or high is None or not low <= self.reference_rate <= high:
            text = f"must be two rates with D = {self.reference_rate:g} 1/s between them"
            raise InputError("steel.rate.D_range", [self.slow, self.fast], text)

    def factor(self, rate: float) -> float:
        """Yield stress at a plastic strain rate (1/s) over the static one."""
        factor: float = 1.0 + (rate / self.reference_rate) ** (1.0 / self.exponent)
        return factor


MILD_STEEL = CowperSymonds(40.4, 5.0)  # Jones 2012, table 8.1
# Yield stress (Pa) and rate law of a grade. D of 90 % of the steels: chosen between what tests at
# yield and tests at large strain give (docs/theory/strain-rate.md), a judgement in part.
GRADES: Mapping[str, tuple[float, CowperSymonds]] = {
    "S235": (235e6, CowperSymonds(200.0, 5.0, 35.0, 4000.0)),
    "S355": (355e6, CowperSymonds(500.0, 5.0, 100.0, 7000.0)),
    "S460": (460e6, CowperSymonds(3000.0, 5.0, 500.0, 130e3)),
}


# Lower yield stress (Pa) up to these thicknesses (m), and the grade whose rate law is taken: EN
# 10025-2:2019 table 6 (EN 10210-1 the same for S235 and S355), S420 EN 10025-3, A36, A572 grade 50
# and A992 by ASTM (36 and 50 ksi). Not verified in print.
THICKNESSES = (0.016, 0.040, 0.063, 0.080, 0.100)
_YIELD: Mapping[str, tuple[tuple[float, ...], str]] = {
    "S235": ((235e6, 225e6, 215e6, 215e6, 215e6), "S235"),
    "S275": ((275e6, 265e6, 255e6, 245e6, 235e6), "S235"),
    "S355": ((355e6, 345e6, 335e6, 325e6, 315e6), "S355"),
    "S420": ((420e6, 400e6, 390e6, 370e6, 360e6), "S460"),
    "S450": ((450e6, 430e6, 410e6, 390e6, 380e6), "S460"),
    "S460": ((460e6, 440e6, 420e6, 400e6, 390e6), "S460"),
    "A36": ((250e6,) * 5, "S235"),
    "A572": ((345e6,) * 5, "S355"),
    "A992": ((345e6,) * 5, "S355"),
}
_GRADE_NAME = re.compile(
    r"(?:ASTM\s*)?([SA])\s?(\d{2,3})\s*(?:J[R02]|K2|NL?|ML?|H)*\s*(?:\bGr(?:ade)?\.?\s*50)?", re.I
)


@dataclass(frozen=True)
class _Grade(Choice):
    """A grade by its name as people write it: S355J2, A572 Gr. 50."""

    def check(self, path: str, value: Any) -> Any:
        """Return the grade of the table, or raise `InputError` naming `path`."""
        name = _GRADE_NAME.fullmatch(value.strip()) if isinstance(value, str) else None
        return super().check(path, f"{name[1]}{name[2]}".upper() if name else value)


def _read_rate(value: Any, path: str) -> Any:
    """Return the rate law of a file's value: a table, the name of a grade, or none."""
    if isinstance(value, str):
        return value
    if not isinstance(value, Mapping):
        example = f'write {{ law = "{COWPER_SYMONDS}", D = 500.0, q = 5.0 }} or "S355"'
        raise InputError(path, value, "must be a table or the name of a grade", example)
    check_keys(list(value), ["law", "D", "q", "D_range"], path)
    Choice((COWPER_SYMONDS,)).check(f"{path}.law", value.get("law", COWPER_SYMONDS))
    for key in ("D", "q"):
        if key not in value:
            raise InputError(f"{path}.{key}", None, "is missing", "a rate law needs D and q")
    ends = value.get("D_range", [None, None])
    if not isinstance(ends, list) or len(ends) != 2:
        raise InputError(f"{path}.D_range", ends, "must be two rates in 1/s", "[100.0, 7000.0]")
    return CowperSymonds(value["D"], value["q"], *ends)


def _write_rate(law: CowperSymonds) -> dict[str, Any]:
    table = {"law": COWPER_SYMONDS, "D": law.reference_rate, "q": law.exponent}
    ends = {} if law.slow is None else {"D_range": [law.slow, law.fast]}
    return table | ends


class _RateLaw(Instance):
    """A rate law, the name of the grade whose law it is, or "none"."""

    def _allowed(self) -> str:
        return f"a rate law, or one of {', '.join((*GRADES, NO_RATE))}"

    def _accepts(self, value: Any) -> bool:
        return isinstance(value, CowperSymonds) or value in (*GRADES, NO_RATE)


@dataclass(frozen=True)
class Steel(Declared, table="steel"):
    """Structural steel, perfectly plastic unless it hardens or knows its strain rate.

    A `grade`, with the `thickness` of the thickest plate (up to 16 mm where it is not given), is
    a shorthand, kept as the values that it stands for: yield stress (EN 10025-2) and rate law,
    where they are not given. `hardening_modulus` is the slope of stress over plastic strain;
    `rate` is a law of strain rate, the name of a grade whose law it takes, or "none".

    Examples
    --------
    >>> wb.Steel(grade="S355", thickness="20 mm").yield_stress
    345000000.0
    >>> wb.Steel(yield_stress="300 MPa").rate is None
    True
    """

    elastic_modulus: float = checked(
        Number(1e10, 1e12, "Pa", advice="moduli are in Pa: 210 GPa is 210e9"), 210e9
    )
    yield_stress: float = checked(
        Number(1e7, 3e9, "Pa", advice="stresses are in Pa: 355 MPa is 355e6"),
        optional=True,
        help="355e6 or that of the grade",
    )
    density: float = checked(
        Number(1e3, 3e4, "kg/m3", advice="densities are in kg/m3: steel has 7850"), 7850.0
    )
    hardening_modulus: float | None = checked(
        Number(0.0, 1e10, "Pa", advice="moduli are in Pa: 0.01 E is 2.1e9"), optional=True
    )
    rate: CowperSymonds | None = checked(
        _RateLaw(CowperSymonds, read=_read_rate, write=_write_rate), optional=True
    )
    grade: str | None = checked(
        _Grade(tuple(_YIELD)), optional=True, help="gives yield stress and rate law"
    )
    thickness: float | None = checked(
        Number(1e-4, THICKNESSES[-1], "m", advice="the thickest plate in m: 20 mm is 0.02"),
        optional=True,
        help="lowers the yield stress of the grade above 16 mm",
    )

    def check(self) -> None:
        """Put in what grade and named laws stand for."""
        stress, rate = 355e6, None
        if self.grade is not None:
            stresses, like = _YIELD[self.grade]
            stress = stresses[bisect_left(THICKNESSES, self.thickness or 0.0)]
            rate = GRADES[like][1]
        elif self.thickness is not None:
            advice = 'give steel.grade = "S355"' if self.yield_stress is None else "leave it out"
            allowed = "lowers the yield stress of a grade: no grade is given"
            raise InputError("steel.thickness", self.thickness, allowed, advice)
        law: Any = rate if self.rate is None else self.rate
        if isinstance(law, str):
            law = None if law == NO_RATE else GRADES[law][1]
        resolved = {"yield_stress": self.yield_stress or stress, "rate": law}
        resolved |= {"grade": None, "thickness": None}
        if self.hardening_modulus == 0.0:
            resolved["hardening_modulus"] = None
        for name, value in resolved.items():
            object.__setattr__(self, name, value)

    def stronger(self, factor: float) -> Steel:
        """Return the steel with a yield stress that many times as high."""
        return self.changed(yield_stress=factor * self.yield_stress)

    @property
    def shear_yield_stress(self) -> float:
        """Von Mises yield stress in pure shear, fy / sqrt(3), in Pa (EN 1993-1-1, 6.2.6)."""
        return self.yield_stress / sqrt(3.0)

    @property
    def shear_modulus(self) -> float:
        """Shear modulus with Poisson's ratio 0.3, in Pa."""
        return self.elastic_modulus / (2.0 * (1.0 + POISSON_RATIO))


class MadeOfSteel(Declared):
    """Object with a field `steel`, in which alone its grade is given. Raises `InputError`."""

    def __new__(cls, *_values: Any, **named: Any) -> Self:
        """Return the object, which its fields fill."""
        if "grade" in named:
            grade = named["grade"]
            advice = f"write steel=wb.Steel(grade={grade!r})"
            raise InputError(f"{cls.TABLE}.grade", grade, "is a field of the steel", advice)
        return super().__new__(cls)
