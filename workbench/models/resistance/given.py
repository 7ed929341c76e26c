"""A resistance curve that the user gives, from tests or a finer model: points in a table.

Crawford et al., Lee et al. and Yu and Guo move one mass on such curves (Heng 2017, chapter 4).
Between its points the curve is straight and may soften; behind its last one nothing is known.
"""

import hashlib
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from workbench.base.arrays import Array
from workbench.base.datafiles import open_input
from workbench.base.errors import InputError
from workbench.base.fields import Choice, Number, checked
from workbench.base.tables import FILES, read_points
from workbench.models.base import Answering
from workbench.models.domain import buckles
from workbench.models.hit_mass import HIT_MASS, THESIS
from workbench.models.resistance.curve import (
    INTERACTIONS,
    SECTION,
    Mechanism,
    ResistanceCurve,
    straight_pieces,
)
from workbench.models.resistance.shapes import RESISTANCES
from workbench.models.strain_rate import rate_factor
from workbench.scenarios import ColumnImpact, ColumnScenario

GIVEN = "given"  # shape of such a curve
_COLUMNS = {"displacement_m": Number(0.0, 1e3, "m"), "force_N": Number(0.0, 1e12, "N")}
_FIELD = "option.resistance"
_LARGEST = 1_000_000  # bytes
PANEL = "panel"
SHAPES = (*RESISTANCES, PANEL)
NOTHING = "", 1.0  # digest of the points and rate factor of a curve that is derived
_STRAIGHT = 1e-3  # share of the force by which the curve leaves its first slope: yielding


def is_given(shape: str) -> bool:
    """Whether the name of a shape is that of a file."""
    return isinstance(shape, str) and shape.endswith(FILES)


@dataclass(frozen=True)
class Resistance(Choice):
    """A shape of the resistance out of a list, or a CSV file of points, which is read."""

    def _allowed(self) -> str:
        return f"{super()._allowed()}, or the name of a {FILES[0]} file of points"

    def check(self, path: str, value: object) -> object:
        """Return the value, or raise `InputError` naming `path`, or the line of the file."""
        if is_given(value):  # type: ignore[arg-type]
            points(content(str(value)), str(value))
            return value
        return super().check(path, value)


@dataclass(frozen=True)
class OnCurve(Answering):
    """A model on a resistance curve, whose options are those of a mechanism."""

    unused: ClassVar[tuple[str, ...]] = ("column.head_mass",)

    resistance: str = checked(
        Resistance(SHAPES),
        "analytic",
        help="panel: webs yield in shear, the static curve of four-dof-shear; a file: columns "
        "displacement_m and force_N of any other curve at the hit point",
    )
    rotational_stiffness: float | None = checked(
        Number(0.1, 1e6),
        optional=True,
        help="c of the hinge stiffness c EI / l (the thesis: 6; None: as of four-dof)",
    )
    interaction: str = checked(
        Choice(INTERACTIONS),
        SECTION,
        help="yield surface of N and M: straight lines with the area of the exact envelope, or "
        "one line",
    )
    hit_mass: str = checked(HIT_MASS, THESIS, help="a third of the column, or as of four-dof")
    rate_factor: float | None = checked(
        Number(1.0, 10.0),
        optional=True,
        help="of strain rate on the strength of a curve that is given (None: that of the steel's "
        "rate law in an impact)",
    )

    @property
    def material(self) -> tuple[str, ...]:
        """Names of steel properties behind a given curve: no yield stress can be raised."""
        return ("rate", "hardening") if is_given(self.resistance) else ()

    @property
    def shear_yields(self) -> bool:
        """Whether webs slide where they carry less than their mechanism needs."""
        return self.resistance == PANEL

    def curve_stacks(self, scenario: ColumnScenario) -> bool:
        """Whether curves of a stack of such impacts are made in compiled code."""
        if not isinstance(scenario, ColumnImpact) or self.resistance not in RESISTANCES:
            return False
        return not scenario.striker.crushes and not scenario.acceleration

    def refused(self, scenario: ColumnImpact) -> Any:
        """Whether the domain refuses an impact; flags of a stack."""
        return buckles(scenario)

    def given(self, scenario: ColumnScenario | None = None) -> tuple[str, float]:
        """Digest of the points that are given and the factor on their strength; or `NOTHING`.

        The factor is `rate_factor`, else that of the strain rate of an impact on steel with a law.
        """
        if not is_given(self.resistance):
            return NOTHING
        factor = self.rate_factor
        if factor is None and isinstance(scenario, ColumnImpact) and scenario.column.steel.rate:
            factor = rate_factor(scenario)
        return self.data_digest, factor or 1.0

    @property
    def data_digest(self) -> str:
        """Hash of the points that are given, so that stored answers follow them ("": none)."""
        return digest(self.resistance)

    def check(self) -> None:
        """Refuse options that have no part in a curve that is given. Raises `InputError`."""
        for name, usual in (("rotational_stiffness", None), ("interaction", SECTION)):
            if is_given(self.resistance) and getattr(self, name) != usual:
                raise self.refusal(name, f"has no part in the curve of {self.resistance}")
        if self.rate_factor is not None and not is_given(self.resistance):
            text = "is for a curve that is given"
            raise self.refusal("rate_factor", text, "give the steel a rate law instead")


def content(name: str) -> bytes:
    """Content of a file of points. Raises `InputError`."""
    with open_input(Path(name), _FIELD, _LARGEST) as stream:
        return stream.read()


def digest(shape: str) -> str:
    """First digits of the SHA-256 of the points of a `shape` ("" of one that is no file)."""
    return hashlib.sha256(content(shape)).hexdigest()[:16] if is_given(shape) else ""


@lru_cache(maxsize=16)
def points(data: bytes, name: str) -> Array:
    """Points (n, 2) of a file: displacements (m), rising from 0, and forces (N), from 0.

    Raises `InputError` with the `name` of the file and the line.
    """
    table, lines = read_points(data, name, _FIELD, _COLUMNS)
    if table[0].any():
        text = "must be the point 0,0"
        raise InputError(f"{name}, line {lines[0]}", table[0].tolist(), text)
    if table[1, 1] <= 0.0:
        text = "must be above 0: the curve begins with its elastic stiffness"
        raise InputError(f"{name}, line {lines[1]}, force_N", float(table[1, 1]), text)
    return table


def given_curve(mechanism: Mechanism, shape: str, factor: float = 1.0) -> ResistanceCurve:
    """The curve through the points of a file, elastic as long as it keeps its first slope.

    Up to a thousandth of the force. Its strength grows by a `factor` of strain rate, its stiffness
    does not: the lesser of the first slope and of the factor times the force. Raises `InputError`.
    """
    v, force = points(content(shape), shape).T
    if factor > 1.0:
        elastic, force = force[1] / v[1] * v, factor * force
        above = elastic - force  # where that turns positive the curve leaves its first slope
        i = int(np.argmax(above > 0.0))
        if above[i] <= 0.0:  # it never does
            i = len(v)
        else:
            share = above[i - 1] / (above[i - 1] - above[i])
            corner = v[i - 1] + share * (v[i] - v[i - 1])
            v, elastic = np.insert(v, i, corner), np.insert(elastic, i, elastic[1] / v[1] * corner)
            force = np.insert(force, i, elastic[i])
        force[:i] = elastic[:i]
    soft = np.flatnonzero(force < (1.0 - _STRAIGHT) * force[1] / v[1] * v)
    limit = float(v[max(soft[0] - 1, 1)] if len(soft) else v[-1])
    return ResistanceCurve(GIVEN, mechanism, straight_pieces(v, force), limit, float(v[-1]))
