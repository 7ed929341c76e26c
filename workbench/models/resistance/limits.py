"""Where the rigid-bar mechanism and its simplified curves stop being trustworthy."""

from functools import lru_cache
from typing import Any

import numpy as np

from workbench.arrays import Array
from workbench.errors import Collapse, CollapseError, Mechanism, OutOfDomainError
from workbench.frames.collapse_watch import COLLAPSE_SIDEWAYS
from workbench.models.domain import member_findings
from workbench.models.four_dof import FourDofShear
from workbench.models.resistance.curve import ResistanceCurve
from workbench.models.resistance.panel import PANEL
from workbench.models.resistance.shapes import resistance_curve
from workbench.responses import Finding, finding
from workbench.scenarios import Column, ColumnPushover, ColumnScenario, MemberPulse

SEGMENTS = ("below", "above")
_ROTATION = 0.5  # rad; small rotations change the force by about 7 % here
_WORK = 0.10  # share by which a simplification may leave the analytic curve without a warning


def reach(column: Column) -> float:
    """Largest displacement (m) at which the mechanism means anything."""
    return COLLAPSE_SIDEWAYS * min(column.length_below, column.length_above)


def limit_of(curve: ResistanceCurve, column: Column) -> float:
    """Displacement (m) at which the column on its resistance `curve` has collapsed."""
    return min(reach(column), curve.lost_at)


def collapsed(
    curve: ResistanceCurve, column: Column, displacement: float, time: float | None = None
) -> CollapseError:
    """How a column collapses that has come to the limit of its resistance `curve`.

    Arguments: the `displacement` (m) that it has reached, at a `time` (s; None: not known).
    """
    if curve.lost_at <= reach(column):
        collapse = Collapse(Mechanism.BUCKLING, SEGMENTS, displacement, time)
        return CollapseError(collapse, "the column has lost its resistance to the axial load")
    return out_of_reach(column, displacement, time)


def out_of_reach(column: Column, displacement: float, time: float | None = None) -> CollapseError:
    """How a column collapses that has come to the `reach` of the mechanism; as `collapsed`."""
    shorter = SEGMENTS[column.length_below > column.length_above]
    collapse = Collapse(Mechanism.GEOMETRY, (shorter,), displacement, time)
    return CollapseError(collapse, "the displacement passes nine tenths of the shorter segment")


def curve_findings(scenario: ColumnScenario, shape: str) -> list[Finding]:
    """Findings of all member models, and those of every model on a resistance curve.

    Of the shape of panels those of the four-DOF column with them.
    Warning: a head mass, which a pulse moves here without. Refusal: a push beyond their reach.
    """
    domain = FourDofShear().domain if shape == PANEL else member_findings
    findings = list(domain(scenario))
    column = scenario.column
    if column.head_mass > 0.0 and isinstance(scenario, MemberPulse):
        findings.append(finding("head-mass", head_mass=column.head_mass))
    if isinstance(scenario, ColumnPushover) and scenario.displacement > reach(column):
        findings.append(finding("reach", displacement=scenario.displacement, reach=reach(column)))
    return findings


def reached(
    curve: ResistanceCurve, column: Column, displacement: float
) -> tuple[Array | None, list[Finding]]:
    """Shear of a column that has come to a displacement (m) on its curve, and warnings of that.

    Largest V / V_pl of the segments below and above, (2,), from the hinge moments of the analytic
    curve: simplified ones have none of their own. None where that does not hold.
    """
    companion, shear = _analytic_companion(curve), None
    if companion is not None:
        largest = companion.largest_shear(displacement)
        shear = np.asarray(largest / column.properties.shear_resistance)
    return shear, _reached_findings(curve, companion, displacement)


@lru_cache(maxsize=256)
def _analytic_companion(curve: ResistanceCurve) -> ResistanceCurve | None:
    """The analytic curve of the same mechanism (None where its derivation does not hold).

    The curve of panels simplifies no other one.
    """
    if curve.shape in ("analytic", PANEL):
        return curve if curve.knows_moments else None
    try:
        return resistance_curve(curve.mechanism, "analytic")
    except OutOfDomainError:
        return None


def _reached_findings(
    curve: ResistanceCurve, companion: ResistanceCurve | None, displacement: float
) -> list[Finding]:
    """Warnings that depend on the largest displacement (m) that was reached.

    Rotation of the shorter bar above 0.5 rad; a simplified curve whose work differs by more than
    a tenth from that of its analytic `companion`.
    """
    findings = []
    rotation = displacement / min(curve.mechanism.lengths)
    if rotation > _ROTATION and curve.shape != PANEL:
        findings.append(finding("small-rotations", rotation=rotation, displacement=displacement))
    if companion is not None and companion is not curve and displacement > 0.0:
        exact = float(companion.work(displacement))
        simplified = float(curve.work(displacement))
        if not abs(simplified - exact) <= _WORK * abs(exact):
            name = "simplified-work-unsafe" if simplified > exact else "simplified-work"
            work: dict[str, Any] = {"simplified": simplified / 1e3, "exact": exact / 1e3}
            findings.append(finding(name, displacement=displacement, shape=curve.shape, **work))
    return findings
