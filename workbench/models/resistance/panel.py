"""The resistance of a column whose webs yield in shear: the static curve of its panels.

A panel shorter than about 2 M_f / V_pl slides before it bends: the plateau of the resistance is
V_pl of it and what the bar on the other side carries, R_0 = V_pl + V_b with
V_b L_b = M_f + M_c(V_b). Chords that turn, the axial force and catenary action come on top; they
have no closed form, so that the curve is the push of the four-DOF column with panels, straight
between its points.
"""

from functools import lru_cache

import numpy as np
from scipy.optimize import brentq

from workbench.errors import OutOfDomainError, SolverError
from workbench.hinges import ShearSurface
from workbench.models.four_dof import FourDofShear
from workbench.models.resistance.curve import ResistanceCurve
from workbench.models.resistance.kernels import PIECE
from workbench.models.resistance.mechanism import SECTION, Mechanism, mechanism_of
from workbench.models.resistance.shapes import RESISTANCES, resistance_curve
from workbench.scenarios import Column, ColumnPushover

PANEL = "panel"
SHAPES = (*RESISTANCES, PANEL)


def transition_length(surface: ShearSurface) -> float:
    """Length (m) of a panel below which it slides before it bends, 2 M_f / V_pl."""
    record = surface.record
    return float(2.0 * record["flange_moment"] / record["shear"])


def plateau(surface: ShearSurface, lengths: tuple[float, float]) -> float:
    """Limit load (N) at the hit point of two clamped panels of these lengths (m), without N.

    Both bend, V L = 2 M_c(V), or the shorter one slides and its flanges alone bend the other.
    """
    shorter, longer = sorted(lengths)
    record = surface.record

    def bent(length: float, passed: float) -> float:
        """Shear force with M_c at one end and at most `passed` at the other."""

        def excess(V: float) -> float:
            capacity = float(surface.moment_capacity(0.0, V))
            return V * length - capacity - min(passed, capacity)

        top = float(record["shear"])
        return top if excess(top) <= 0.0 else float(brentq(excess, 0.0, top))

    below = bent(shorter, np.inf)
    flanges = float(record["flange_moment"])
    return below + bent(longer, flanges if below >= record["shear"] else np.inf)


def panel_curve(
    column: Column, mechanism: Mechanism, rotational_stiffness: float | None
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
        _, values = model.pushed(column, top, least=0.0)
    except SolverError as error:
        raise OutOfDomainError(f"static curve of its panels: {error}") from error
    v, force, top = values["displacement"], values["force"], values["displacement"][-1]
    flows = np.flatnonzero(values["dissipated"] > 0.0)
    limit = float(v[max(flows[0] - 1, 1)]) if len(flows) else top
    # closely where hinges form, then evenly
    at = np.unique(
        [*np.linspace(limit, min(0.1 * top, 10.0 * limit), 60), *np.linspace(limit, top, 140)]
    )
    at = np.concatenate([[0.0], at])
    f = np.interp(at, v, force)
    pieces = np.zeros(len(at) - 1, PIECE)
    pieces["start"], pieces["c"][:, 0], pieces["c"][:, 1] = (
        at[:-1],
        f[:-1],
        np.diff(f) / np.diff(at),
    )
    return ResistanceCurve("panel", mechanism, pieces, limit)


@lru_cache(maxsize=256)
def column_curve(
    column: Column,
    rotational_stiffness: float | None,
    shape: str,
    interaction: str = SECTION,
    uniform: bool = False,
) -> ResistanceCurve:
    """Resistance of a column at its hit point, by the name of its shape; kept for the next strike.

    To a force there, or to half of a `uniform` load, which does the same work on rigid bars.
    Raises `OutOfDomainError`, see `mechanism_of`, `resistance_curve` and `panel_curve`.
    """
    mechanism = mechanism_of(column, rotational_stiffness, interaction, uniform)
    if shape == PANEL:
        return panel_curve(column, mechanism, rotational_stiffness)
    return resistance_curve(mechanism, shape)
