"""The three shapes of the resistance curve of a column.

Equilibrium at the hit point, with small rotations of two rigid bars: F = sum(s_g M_g) + kappa N v
over the hinge groups g, and compatibility of the axial force N with the chords' stretching
kappa v^2 / 2, the restraint and the plastic elongation of the hinges (linear yield surface,
associated flow). Heng 2017, section 5.2, gives the stages in figure 5.5 but no formula; see the
theory page for the derivation.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from workbench.errors import OutOfDomainError
from workbench.models.resistance import _kernels
from workbench.models.resistance.curve import Array, ResistanceCurve
from workbench.models.resistance.mechanism import Mechanism

_YIELDS = {"base": "base yields", "hit": "hit point yields", "head": "head yields"}
_MECHANISM, _NO_AXIAL_FORCE, _CATENARY = "mechanism load", "axial force vanishes", "catenary"


def resistance_curve(mechanism: Mechanism, shape: str) -> ResistanceCurve:
    """The resistance curve of a mechanism.

    Arguments: `mechanism`; `shape`: analytic, cubic or linear. Raises `OutOfDomainError` if a
    yielded hinge would unload on the way (analytic), KeyError for another shape.
    """
    return _SHAPES[shape](mechanism)


def analytic(mechanism: Mechanism) -> ResistanceCurve:
    """Exact event-driven curve of the mechanism with a linear yield surface.

    Raises `OutOfDomainError` if a yielded hinge would unload: the derivation excludes it.
    """
    count, starts, coefficients, axial, plastic, events, which, unloads = _kernels.analytic_curve(
        *mechanism.arguments
    )
    if unloads:
        raise OutOfDomainError(
            "a yielded hinge would unload while the push goes on, which the analytic resistance "
            "excludes: use the four-DOF model or a simplified resistance"
        )
    names = []
    for event, group in zip(events[1:count].tolist(), which[1:count].tolist(), strict=True):
        if event == _kernels.GROUP_YIELDS:
            names.append(_YIELDS[mechanism.groups[group]])
        elif event == _kernels.AXIAL_FORCE_VANISHES:
            names.append(_NO_AXIAL_FORCE)
        elif event == _kernels.TENSION_GROWS:
            names.append("tension grows")
        else:
            names.append(_CATENARY)
    yielded = np.flatnonzero(plastic[:count].any(axis=1))
    return ResistanceCurve(
        "analytic",
        mechanism,
        starts[:count].copy(),
        coefficients[:count].copy(),
        float(starts[yielded[0]]),
        tuple(names),
        axial[:count].copy(),
        plastic[:count].copy(),
    )


def cubic(mechanism: Mechanism) -> ResistanceCurve:
    """Simplification 1: elastic line, plateau, cubic, catenary.

    A reconstruction: the source names it and shows its curve, and of several dozen definitions
    that give the published peaks this is one.
    """
    count, starts, coefficients = _kernels.cubic_curve(*mechanism.arguments)
    names = (_MECHANISM, "last hinge yields", _CATENARY)[: count - 1]
    return _without_gaps(
        "cubic", mechanism, starts[:count].copy(), coefficients[:count].copy(), names, None
    )


def linear(mechanism: Mechanism) -> ResistanceCurve:
    """Simplification 2: axial force linear in the displacement once all hinges have yielded.

    A choice: the source shows a curve but prints neither formula nor number.
    """
    count, starts, coefficients, axial = _kernels.linear_curve(*mechanism.arguments)
    names: tuple[str, ...] = (_MECHANISM, "last hinge yields", _NO_AXIAL_FORCE, _CATENARY)
    if count == 4:
        names = (_MECHANISM, "last hinge yields", _CATENARY)
    return _without_gaps(
        "linear",
        mechanism,
        starts[:count].copy(),
        coefficients[:count].copy(),
        names[: count - 1],
        axial[:count].copy(),
    )


def _without_gaps(
    shape: str,
    mechanism: Mechanism,
    starts: Array,
    coefficients: Array,
    names: tuple[str, ...],
    axial: Array | None,
) -> ResistanceCurve:
    """The curve without the empty pieces (a single hinge group has no plateau)."""
    keep = np.append(np.diff(starts) > 0.0, True)
    # a piece that is left takes the name of the first one that begins where it does
    first = np.searchsorted(starts, starts[keep][1:])
    kept = tuple(names[i - 1] for i in first.tolist())
    return ResistanceCurve(
        shape,
        mechanism,
        starts[keep],
        coefficients[keep],
        float(starts[1]),
        kept,
        None if axial is None else axial[keep],
    )


_SHAPES: dict[str, Callable[[Mechanism], ResistanceCurve]] = {
    "analytic": analytic,
    "cubic": cubic,
    "linear": linear,
}
RESISTANCES = tuple(_SHAPES)
