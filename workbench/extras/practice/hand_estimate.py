"""Estimate on half a page: momentum, then energy against a constant mechanism load.

An inelastic collision joins the striker m with the effective mass m_e of the column,
v1 = m v0 / (m + m_e); what is left of the energy, E = (m + m_e) v1^2 / 2, is the work of the
plastic mechanism load R over the displacement, E = R v. Rigid-plastic: nothing comes back, and R
brings the masses to rest after t = (m + m_e) v1 / R = m v0 / R. Weights that go along are taken
off R.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from workbench.base.fields import checked
from workbench.models.base import Answering
from workbench.models.domain import member_findings
from workbench.models.energy_estimate import energy_to_absorb, no_restitution, weights_of
from workbench.models.resistance import ResistanceCurve, columns, mechanism_of
from workbench.models.resistance.curve import straight_pieces
from workbench.models.resistance.shapes import AXIAL, AXIAL_HELP, SECTION, plastic_moment
from workbench.responses import Finding, Response, build_response
from workbench.scenarios import Column, ColumnImpact


def turning(column: Column) -> float:
    """Rotations of all hinges of the mechanism per displacement of the impact point, per m."""
    return sum((2.0 if clamped else 1.0) / length for length, clamped in column.bars.values())


def mechanism_load(column: Column, axial: str) -> float:
    """Force (N) at the impact point of the mechanism with hinges there and at clamped ends."""
    return plastic_moment(column, axial) * turning(column)


@dataclass(frozen=True)
class HandEstimate(Answering):
    """Momentum, then energy against the plastic mechanism load."""

    axial: str = checked(AXIAL, SECTION, help=AXIAL_HELP)

    name: ClassVar[str] = "hand-estimate"
    version: ClassVar[int] = 2
    answers: ClassVar[tuple[str, ...]] = (ColumnImpact.KIND,)
    unused: ClassVar[tuple[str, ...]] = (
        *("column.head_mass", "column.restraint_stiffness", "column.second_moment"),
        "steel.elastic_modulus",
    )
    assumptions: ClassVar[tuple[str, ...]] = (
        "Inelastic collision with a third of the column's mass; restitution 1: the whole energy "
        "of the striker is absorbed.",
        "Rigid-plastic: the mechanism with hinges at the impact point and at clamped ends resists "
        "with a constant force; no elastic deformation, so that all displacement stays.",
        "The axial load lowers the plastic moment and does nothing else: no second-order work, no "
        "catenary action.",
        "No shear yielding, no local buckling; strain rate by one factor.",
    )
    sources: ClassVar[tuple[str, ...]] = ("biggs1964",)

    def domain(self, scenario: ColumnImpact) -> list[Finding]:
        """Findings of all member models; a restitution that is not used."""
        return member_findings(scenario) + no_restitution(scenario)

    def _solve(self, scenario: ColumnImpact) -> Response:
        column, striker = scenario.column, scenario.striker
        force = mechanism_load(column, self.axial) - weights_of(scenario)
        energy, reach = energy_to_absorb(scenario), columns.reach(column)
        if energy >= force * reach:
            pieces = straight_pieces(np.array([0.0, reach]), np.array([force, force]))
            curve = ResistanceCurve(columns.MECHANISM, mechanism_of(column), pieces, 0.0)
            raise columns.collapsed(curve, column, reach, energy=energy)
        time = striker.mass * striker.velocity / force
        values = {
            "peak_displacement": energy / force,
            "residual_displacement": energy / force,
            "time_of_peak": time if striker.restitution == 0.0 else None,
            "input_energy": scenario.input_energy,
        }
        return build_response(values, segments=columns.SEGMENTS)
