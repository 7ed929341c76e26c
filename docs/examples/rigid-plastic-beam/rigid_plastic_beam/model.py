"""A clamped beam between fixed supports that a heavy mass strikes: rigid, perfectly plastic.

Two straight bars turn about plastic hinges at the hit point and at both ends, which do not give
way. A rectangle yields at M / M_p + (N / N_p)^2 = 1, and its flow rule gives the tension in the
bars, N / N_p = w / h up to w = h, the depth of the section; from there on the beam is a string:

    P / P_0 = 1 + (w / h)^2, and 2 w / h beyond,   P_0 = 2 M_p (1 / a + 1 / b),   h = 4 M_p / N_p

The work of P up to the peak is the energy that the collision with the bars leaves to the striker.
"""

from dataclasses import dataclass
from math import asinh, sinh, sqrt
from typing import Any, ClassVar

from workbench.base.fields import Number, checked
from workbench.models.base import Answering
from workbench.models.domain import member_findings
from workbench.responses import Finding, Response, build_response
from workbench.scenarios import Column, ColumnImpact

RIGID = 3.0  # energy over what the beam can store elastically, from which on it counts as rigid
SQUARE = 0.01  # share by which the depth may differ from that of a rectangle


@dataclass(frozen=True)
class RigidPlasticBeam(Answering):
    """A clamped beam that a mass strikes, rigid and perfectly plastic, with tension in the bars."""

    dynamic_factor: float = checked(Number(1.0, 5.0), 1.0, help="on the static yield stress")

    name: ClassVar[str] = "rigid-plastic-beam"
    version: ClassVar[int] = 1
    answers: ClassVar[tuple[str, ...]] = (ColumnImpact.KIND,)
    assumptions: ClassVar[tuple[str, ...]] = (
        "Rigid, perfectly plastic; small rotations; supports that do not give way.",
        "Yield curve of a rectangle, of the depth 4 M_p / N_p for other sections.",
        "Striker and bars move on together, with a third of the mass of the beam.",
        "No shear yielding, no fracture; strain rate by one factor.",
    )
    sources: ClassVar[tuple[str, ...]] = (
        "Haythornthwaite, R. M.: Beams with full end fixity. Engineering 183 (1957)",
        "Jones, N.: Structural Impact. Cambridge University Press, 2nd edition (2012)",
    )
    unused: ClassVar[tuple[str, ...]] = (  # by its numbers
        *("column.axial_load", "column.head_mass", "column.restraint_stiffness", "column.area"),
        *("column.second_moment", "steel.elastic_modulus"),
        *("striker.restitution", "striker.direction"),
    )

    def domain(self, scenario: ColumnImpact) -> list[Finding]:
        """Findings of all members without shear; ends, shape of the section, elastic energy."""
        column, findings = scenario.column, member_findings(scenario)
        if column.ends != ("clamped", "fixed"):
            ends = " and ".join(column.ends)
            text = f"ends are {ends}: it answers beams between supports that do not give way"
            remedy = 'set column.base = "clamped" and column.head = "fixed", or take single-dof'
            findings.append(Finding("ends", text, refusal=True, remedy=remedy))
        ratio = self.depth(column) / column.section.height
        if abs(ratio - 1.0) > SQUARE:
            text = f"depth 4 M_p / N_p is {ratio:.2f} heights of the section: it is no rectangle"
            findings.append(Finding("shape", text, number=ratio, limit=1.0))
        ratio = self.energy(scenario) / elastic_energy(column)
        if ratio < RIGID:
            text = f"energy is {ratio:.2g} times what the beam stores elastically, which counts"
            findings.append(Finding("elastic", text, number=ratio, limit=RIGID))
        return findings

    def depth(self, column: Column) -> float:
        """Depth (m) of the rectangle of the same plastic moment and squash load."""
        return 4.0 * column.properties.plastic_moment / column.properties.squash_load

    def plateau(self, column: Column) -> float:
        """Force (N) at which the beam yields without tension."""
        moment = self.dynamic_factor * column.properties.plastic_moment
        return 2.0 * moment * (1.0 / column.length_below + 1.0 / column.length_above)

    def energy(self, scenario: ColumnImpact) -> float:
        """Energy (J) that is left once the bars move with the striker."""
        mass = scenario.striker.mass
        return scenario.input_energy * mass / (mass + scenario.column.properties.impact_mass)

    def _solve(self, scenario: ColumnImpact) -> Response:
        depth = self.depth(scenario.column)
        work = self.energy(scenario) / (self.plateau(scenario.column) * depth)
        # x + x^3 / 3 = work up to x = w / h = 1, and x^2 + 1 / 3 = work beyond
        x = 2.0 * sinh(asinh(1.5 * work) / 3.0) if work < 4.0 / 3.0 else sqrt(work - 1.0 / 3.0)
        values: dict[str, Any] = {
            "peak_displacement": x * depth,
            "residual_displacement": x * depth,
            "impulse": scenario.striker.mass * scenario.striker.velocity,
            "input_energy": scenario.input_energy,
        }
        return build_response(values)


def elastic_energy(column: Column) -> float:
    """Energy (J) of the beam in bending at its plastic moment everywhere, M_p^2 l / (2 E I)."""
    properties = column.properties
    stiffness = column.steel.elastic_modulus * properties.second_moment
    return properties.plastic_moment**2 * column.length / (2.0 * stiffness)
