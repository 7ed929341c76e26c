"""Resistance of a column at its impact point by the name of its shape, its end, its findings.

A panel shorter than about 2 M_f / V_pl slides before it bends: the plateau of the resistance is
V_pl of it and what the bar on the other side carries, R_0 = V_pl + V_b with
V_b L_b = M_f + M_c(V_b). Chords that turn, the axial force and catenary action come on top; they
have no closed form, so that the curve is the push of the four-DOF column with panels, straight
between its points.

**Second part.** A resistance curve that the user gives, from tests or a finer model: points in a
table.

Crawford et al., Lee et al. and Yu and Guo move one mass on such curves (Heng 2017, chapter 4).
Between its points the curve is straight and may soften; behind its last one nothing is known.
"""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import scipy

from workbench.base.arrays import Array, Flags
from workbench.base.datafiles import open_input
from workbench.base.errors import (
    Collapse,
    CollapseError,
    InputError,
    Mechanism,
    OutOfDomainError,
    SolverError,
)
from workbench.base.fields import Choice, Number, checked
from workbench.base.tables import FILES, read_points
from workbench.mechanics.frames.collapse import COLLAPSE_SIDEWAYS
from workbench.models.base import Answering
from workbench.models.domain import buckles, buckling_findings, member_findings
from workbench.models.four_dof import FourDofShear
from workbench.models.hit_mass import HIT_MASS, THESIS
from workbench.models.resistance.curve import (
    INTERACTIONS,
    SECTION,
    PlasticMechanism,
    ResistanceCurve,
    any_mechanism,
    mechanism_of,
    straight_pieces,
)
from workbench.models.resistance.shapes import RESISTANCES, MechanismRows, beam_of, resistance_curve
from workbench.models.strain_rate import rate_factor
from workbench.responses import Finding, finding
from workbench.scenarios import Column, ColumnImpact, ColumnPushover, ColumnScenario, MemberPulse
from workbench.scenarios.pulse import UNIFORM
from workbench.scenarios.varied import spread

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
        "displacement_m and force_N of any other curve at the impact point",
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


def given_curve(mechanism: PlasticMechanism, shape: str, factor: float = 1.0) -> ResistanceCurve:
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


def panel_curve(
    column: Column, mechanism: PlasticMechanism, rotational_stiffness: float | None
) -> ResistanceCurve:
    """Static curve of the column's panels up to nine tenths of the shorter bar.

    It ends where the resistance is lost to the axial load: nothing is in equilibrium far behind.
    Raises `OutOfDomainError` where the panels do not hold for the column.
    """
    top = 0.9 * min(mechanism.lengths)
    model = FourDofShear(rotational_stiffness=rotational_stiffness)
    refusals = [str(f) for f in model.domain(ColumnPushover("curve", column, top)) if f.refusal]
    if refusals:
        raise OutOfDomainError(f"static curve of its panels: {'; '.join(refusals)}")
    try:
        records, values = model.pushed(column, top, least=0.0)
    except SolverError as error:
        raise OutOfDomainError(f"static curve of its panels: {error}") from error
    v, force, top = values["displacement"], values["force"], values["displacement"][-1]
    flows = np.flatnonzero(values["dissipated"] > _FLOWS * records["elastic"])
    limit = float(v[max(flows[0] - 1, 1)]) if len(flows) else top
    # where it stiffens or softens elastically, closely where hinges form, then evenly
    elastic, forming = np.linspace(0.0, limit, 21), min(0.1 * top, 10.0 * limit)
    at = np.unique([*elastic, *np.linspace(limit, forming, 60), *np.linspace(limit, top, 140)])
    f = np.interp(at, v, force)
    return ResistanceCurve("panel", mechanism, straight_pieces(at, f), limit)


@lru_cache(maxsize=256)
def column_curve(
    column: Column,
    rotational_stiffness: float | None,
    shape: str,
    interaction: str = SECTION,
    uniform: bool = False,
    given: tuple[str, float] = NOTHING,
) -> ResistanceCurve:
    """Resistance of a column at its impact point, by the name of its shape; kept for later hits.

    To a force there, or to half of a `uniform` load, which does the same work on rigid bars. Of a
    curve that is `given` the digest of its points, so that it is not kept for others, and its
    factor of strain rate.
    Raises `OutOfDomainError`, see `mechanism_of`, `resistance_curve` and `panel_curve`, and
    `InputError` of a file, see `given_curve`.
    """
    mechanism = mechanism_of(column, rotational_stiffness, interaction, uniform)
    if given != NOTHING:
        return given_curve(mechanism, shape, given[1])
    if shape == PANEL:
        return panel_curve(column, mechanism, rotational_stiffness)
    return resistance_curve(mechanism, shape)


SEGMENTS = ("below", "above")
_PARTS = 1000  # of the way to collapse, in which a displacement is looked for
BENDING = STAGES, MECHANISM = "stages", "mechanism"  # shapes without an axial force
_FLOWS = 1e-9  # of the elastic energy; round-off of an elastic push dissipates some 1e-15 of it
_ROTATION = 0.5  # rad; small rotations change the force by about 7 % here
_SHORT = 0.15  # of the period: below, higher modes and bending beside the force take much
_SOFT = 0.03  # of an elastic peak, by bars that stretch less than the member
_WORK = 0.10  # share by which a simplification may leave the analytic curve without a warning


def reach(column: Column) -> float:
    """Largest displacement (m) at which the mechanism means anything."""
    shorter: float = np.minimum(column.length_below, column.length_above)
    return COLLAPSE_SIDEWAYS * shorter


def limit_of(curve: ResistanceCurve, column: Column) -> float:
    """Displacement (m) at which the column has collapsed, or its `curve` ends."""
    return min(reach(column), curve.lost_at, curve.end)


def first_where(
    curve: ResistanceCurve, column: Column, excess: Callable[[Any], Any], start: float = 0.0
) -> float:
    """First displacement (m) from a `start` on at which an `excess` over it is not below 0.

    Raises `CollapseError` or `OutOfDomainError`, as `collapsed` says.
    """
    limit = limit_of(curve, column)
    at = np.append(np.linspace(start, limit, _PARTS), curve.starts)
    at = np.unique(at[(at >= start) & (at <= limit)])
    done = np.flatnonzero(excess(at) >= 0.0)
    if not done.size:
        raise collapsed(curve, column, limit)
    return float(scipy.optimize.brentq(excess, at[max(done[0] - 1, 0)], at[done[0]]))


def displacement_under(curve: ResistanceCurve, column: Column, force: float) -> float:
    """Displacement (m) at which the resistance comes to a force (N); raises as `first_where`."""
    size = abs(force)
    reached = first_where(curve, column, lambda v: curve.force(v) - size) if size else 0.0
    return float(np.copysign(reached, force))


def collapsed(
    curve: ResistanceCurve,
    column: Column,
    displacement: float,
    time: float | None = None,
    energy: float = 0.0,
) -> CollapseError | OutOfDomainError:
    """How a column collapses that has come to the limit of its resistance `curve`.

    Arguments: the `displacement` (m) that it has reached, at a `time` (s; None: not known); the
    `energy` (J) brought in until then, which counts on curves of bending alone.
    No collapse is the end of a curve that was given, nor of one of bending alone where catenary
    action may hold the column: nothing is known of what follows.
    """
    if curve.end * (1.0 + 1e-9) < min(curve.lost_at, reach(column)):
        return OutOfDomainError(
            f"the resistance curve that is given ends at {curve.end:.4g} m, the column goes on: "
            "give points beyond"
        )
    lost = curve.lost_at <= reach(column)
    if not lost and curve.shape in BENDING and _may_hang(curve, displacement, energy):
        return OutOfDomainError(finding("last-stage", displacement))
    return fallen(column, lost, displacement, time)


def _may_hang(curve: ResistanceCurve, displacement: float, energy: float) -> bool:
    """Whether tension, which a `curve` of bending alone leaves out, may stop a column.

    Where its ends are held apart and the analytic curve absorbs the `energy` (J) or does not hold.
    """
    if np.isinf(curve.mechanism.axial_flexibility):
        return False
    companion = _analytic_companion(curve)
    return companion is None or bool(companion.work(displacement) > energy)


def fallen(
    column: Column, lost: bool, displacement: float, time: float | None = None
) -> CollapseError:
    """How a column collapses that has `lost` its resistance, or come to its reach; as above."""
    if not lost:
        return out_of_reach(column, displacement, time)
    collapse = Collapse(Mechanism.BUCKLING, SEGMENTS, displacement, time)
    return CollapseError(collapse, "the column has lost its resistance to the axial load")


def out_of_reach(column: Column, displacement: float, time: float | None = None) -> CollapseError:
    """How a column collapses that has come to the `reach` of the mechanism; as `collapsed`."""
    shorter = SEGMENTS[column.length_below > column.length_above]
    collapse = Collapse(Mechanism.GEOMETRY, (shorter,), displacement, time)
    return CollapseError(collapse, "the displacement passes nine tenths of the shorter segment")


def curve_findings(scenario: ColumnScenario, shape: str) -> list[Finding]:
    """Findings of all member models, and those of every model on a resistance curve.

    Of the shape of panels those of the four-DOF column with them; a curve that is given may know
    shear, so that no bound of it is told.
    Refusal: a push beyond their reach.
    """
    domain = FourDofShear().domain if shape == PANEL else member_findings
    domain = buckling_findings if is_given(shape) else domain
    findings = list(domain(scenario))
    column = scenario.column
    if isinstance(scenario, ColumnPushover) and scenario.displacement > reach(column):
        findings.append(finding("reach", displacement=scenario.displacement, reach=reach(column)))
    return findings


def reached(
    curve: ResistanceCurve, column: Column, displacement: float
) -> tuple[Array | None, list[Finding]]:
    """Shear of a column that has come to a displacement (m) on its curve, and warnings of that.

    Largest V / V_pl of the segments below and above, (2,), from the hinge moments of the analytic
    curve: simplified ones have none of their own. None where that does not hold. Warnings: rotation
    of the shorter bar above 0.5 rad; a simplified curve whose work differs by more than a tenth
    from that of the analytic one.
    """
    companion, shear = _analytic_companion(curve), None
    if companion is not None:
        largest = companion.largest_shear(displacement)
        shear = np.asarray(largest / column.properties.shear_resistance)
    findings = []
    rotation = displacement / min(curve.mechanism.lengths)
    if rotation > _ROTATION and curve.shape not in (PANEL, GIVEN):
        findings.append(finding("small-rotations", rotation=rotation, displacement=displacement))
    if companion is not None and companion is not curve and displacement > 0.0:
        exact = float(companion.work(displacement))
        simplified = float(curve.work(displacement))
        if not abs(simplified - exact) <= _WORK * abs(exact):
            name = "simplified-work-unsafe" if simplified > exact else "simplified-work"
            work: dict[str, Any] = {"simplified": simplified / 1e3, "exact": exact / 1e3}
            findings.append(finding(name, displacement=displacement, shape=curve.shape, **work))
    return shear, findings


@lru_cache(maxsize=256)
def _analytic_companion(curve: ResistanceCurve) -> ResistanceCurve | None:
    """The analytic curve of the same mechanism (None where its derivation does not hold).

    The curve of panels, and one that is given, simplify no other one.
    """
    if curve.shape in ("analytic", PANEL, GIVEN):
        return curve if curve.knows_moments else None
    try:
        return resistance_curve(curve.mechanism, "analytic")
    except OutOfDomainError:
        return None


def of_one_shape(
    scenario: MemberPulse, curve: ResistanceCurve, mass: float, top: float
) -> list[Finding]:
    """Warnings of what one shape of deflection leaves out of a member that has come to `top` (m).

    Arguments: resistance `curve` and elastic `mass` (kg) of the shape.
    A pulse much shorter than the period. An elastic member whose ends are held apart: its shape
    stretches by Lambda v^2 (see `Shape.stretching`), two straight bars by less; a step then makes
    the work of the resistance F v, which the shape does at a smaller v.
    """
    uniform = scenario.load == UNIFORM
    stiffness, softness = curve.initial_stiffness, curve.mechanism.axial_flexibility
    lasts = scenario.pulse.lasts / (2.0 * np.pi * np.sqrt(mass / stiffness))
    findings = [finding("short-pulse", lasts, limit=_SHORT)] if lasts < _SHORT else []
    if curve.shape == GIVEN or top > curve.elastic_limit or np.isinf(softness) or top <= 0.0:
        return findings
    elastic, *_, rigid = beam_of(scenario.column, uniform).stages(np.ones(3))
    pulled = elastic.shape.stretching**2 / softness * rigid.load_factor / elastic.load_factor
    mean = float(curve.work(top)) / top

    def missing(v: float) -> float:
        return 0.5 * (stiffness + pulled * v**2) * v - mean

    if missing(top) > 0.0:
        excess = top / scipy.optimize.brentq(missing, 0.0, top) - 1.0
        findings += [finding("straight-bars", 100.0 * excess)] if excess > _SOFT else []
    return findings


def rows_of(
    column: Column, count: int, shape: str, rotational_stiffness: float | None, interaction: str
) -> tuple[MechanismRows, Flags]:
    """Mechanisms of a stack of `count` columns; whether the axial load exhausts their stiffness."""
    mechanism = any_mechanism(column, rotational_stiffness, interaction)
    rates, moments, flexibilities, *numbers = mechanism.kernel
    by_row = (
        np.ascontiguousarray(np.broadcast_to(each.T, (count, len(each))))
        for each in (rates, moments, flexibilities)
    )
    long = (spread(each, count) for each in (*numbers, reach(column)))
    whole: Any = (*by_row, *long, RESISTANCES.index(shape))
    rows = MechanismRows(*whole)
    return rows, np.broadcast_to(mechanism.carries <= column.axial_load, count)
