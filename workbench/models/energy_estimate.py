"""Largest and permanent displacement of the impacted column from an energy balance alone.

Heng 2017, section 5.2: the work of the resistance up to the largest displacement equals the
energy that the collision leaves, W(v_max) = E.
"""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from workbench.base.arrays import Array, Flags, Indices
from workbench.base.codec import set_inputs
from workbench.base.compiled import njit
from workbench.base.errors import CollapseError
from workbench.models.batch import COLLAPSES, LOST, SURVIVES, UNKNOWN, BatchAnswers
from workbench.models.hit_mass import with_hit_mass
from workbench.models.resistance import OnCurve, column_curve, columns
from workbench.models.resistance.columns import rows_of
from workbench.models.resistance.kernels import displacement_at, residual, work_between
from workbench.models.resistance.shapes import MechanismRows, curve_of
from workbench.responses import Finding, Response, build_response, finding
from workbench.scenarios import ColumnImpact, ColumnScenario
from workbench.scenarios.varied import spread, take


@dataclass(frozen=True)
class EnergyEstimate(OnCurve):
    """Energy-equivalent displacements."""

    name: ClassVar[str] = "energy-estimate"
    version: ClassVar[int] = 7
    answers: ClassVar[tuple[str, ...]] = (ColumnImpact.KIND,)
    assumptions: ClassVar[tuple[str, ...]] = (
        "Resistance of the single-DOF column: two rigid bars with plastic hinges, small rotations, "
        "springs of the elastic column.",
        "The cubic resistance is a reconstruction and the linear one a choice: the thesis prints "
        "no formula for either.",
        "Restitution 0: what the inelastic collision of striker and impact mass leaves is "
        "absorbed; restitution 1: the whole energy of the striker is; both masses rest at the "
        "largest displacement.",
        "Restitution between: repeated impacts lose almost all that the first one leaves above "
        "the inelastic case, so its energy is taken (within 1 % for the thesis column at 10 to "
        "20 m/s).",
        "A weight that goes along does work on all the way: resistance less weights absorbs.",
        "Elastic unloading with the initial stiffness gives the permanent displacement.",
        "No shear yielding but with resistance = panel, the static curve of "
        "`four-dof-shear`; no local buckling; strain rate by one factor.",
    )
    sources: ClassVar[tuple[str, ...]] = ("heng2017",)

    def domain(self, scenario: ColumnScenario) -> list[Finding]:
        """Findings of all models on a resistance curve; a restitution that is not used."""
        return columns.curve_findings(scenario, self.resistance) + no_restitution(scenario)

    def stackable(self, scenario: ColumnScenario) -> bool:
        """Whether it answers such impacts in stacks."""
        return self.curve_stacks(scenario)

    def answer_stack(self, scenario: ColumnImpact, refused: Flags) -> BatchAnswers:
        """Answers to a stack of impacts, see `models.batch`; none of those that are `refused`."""
        count = len(refused)
        options = self.resistance, self.rotational_stiffness, self.interaction
        scenario = with_hit_mass(scenario, self.hit_mass)
        rows, exhausted = rows_of(scenario.column, count, *options)
        codes = np.where(exhausted | refused, UNKNOWN, SURVIVES)
        peak, left = np.full((2, count), np.nan)
        energy = spread(energy_to_absorb(scenario), count)
        absorb(rows, energy, codes, peak, left)
        values = {"peak_displacement": peak, "residual_displacement": left}
        values["input_energy"] = spread(scenario.input_energy, count)

        def collapse(i: int) -> CollapseError:
            column = take(scenario.column, i)
            return columns.fallen(column, bool(codes[i] == LOST), float(peak[i]))

        return BatchAnswers.of(codes, values, collapse)

    def _solve(self, scenario: ColumnImpact) -> Response:
        column = scenario.column
        spring, given = (self.rotational_stiffness, self.resistance), self.given(scenario)
        curve = column_curve(column, *spring, self.interaction, given=given)
        energy = energy_to_absorb(with_hit_mass(scenario, self.hit_mass))
        limit, sag = columns.limit_of(curve, column), 0.0
        if scenario.acceleration:
            weights = weights_of(scenario)
            sag = columns.displacement_under(curve, column, scenario.dead_force)

            def taken(v: Any) -> Any:
                return curve.work(v) - curve.work(sag) - weights * (v - sag) - energy

            peak = columns.first_where(curve, column, taken, sag)
        elif energy >= curve.work(limit):
            raise columns.collapsed(curve, column, limit)
        else:
            peak = curve.displacement_at(energy)
        shear, warnings = columns.reached(curve, column, peak)
        values: dict[str, Any] = {
            "peak_displacement": peak - sag,
            "residual_displacement": curve.residual(peak),
            "input_energy": scenario.input_energy,
            "shear_utilisation": shear,
        }
        return build_response(values, segments=columns.SEGMENTS, warnings=warnings)


@njit(cache=True, error_model="numpy", nogil=True)
def absorb(rows: MechanismRows, energies: Array, codes: Indices, peaks: Array, left: Array) -> None:
    """Displacements (m) at which columns have absorbed `energies` (J), and what is left of them.

    Of one that collapses that of collapse. Arguments: `rows` of mechanisms; all others (n,).
    """
    for i in range(codes.size):
        if codes[i] != SURVIVES:
            continue
        pieces, elastic_limit, lost, unloads = curve_of(rows, i)
        peaks[i] = limit = min(rows.reach[i], lost)
        if unloads:
            codes[i] = UNKNOWN
        elif energies[i] >= work_between(pieces, 0.0, limit):
            codes[i] = LOST if lost <= rows.reach[i] else COLLAPSES
        else:
            peaks[i] = displacement_at(pieces, energies[i], lost)
            left[i] = residual(pieces, elastic_limit, peaks[i])


def weights_of(scenario: ColumnImpact) -> float:
    """Weight (N) along the strike of striker and column, which goes on with the impact point."""
    return scenario.striker.mass * scenario.acceleration + scenario.dead_force


def no_restitution(scenario: ColumnScenario) -> list[Finding]:
    """Warning of a restitution between 0 and 1, which `energy_to_absorb` does not know."""
    restitution = set_inputs(scenario).get("striker.restitution")
    if restitution is None or restitution.value == 1.0:
        return []
    return [finding("unused-input", input=restitution)]


def energy_to_absorb(scenario: ColumnImpact) -> float:
    """Energy (J) that the column absorbs: all for restitution 1, else that of the joined masses.

    E = M_A^2 v_0^2 / (2 (M_A + M_B)) after an inelastic collision.
    """
    striker, struck = scenario.striker.mass, scenario.column.properties.impact_mass
    whole = scenario.striker.restitution == 1.0
    share: Any = np.where(whole, 1.0, striker / (striker + struck))
    energy: float = scenario.input_energy * share
    return energy
