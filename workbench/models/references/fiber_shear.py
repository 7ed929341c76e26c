"""Reference whose webs yield in shear: where beam theory without shear yielding ends.

The geometrically exact fiber beam of `fiber_reissner`, with fibers along the shear force (webs,
solid sections) that yield under normal and shear stress together, sigma^2 + 3 tau^2 = fy^2, with
the rate law of the steel on the right where it has one.
"""

from dataclasses import dataclass
from typing import ClassVar

from workbench.mechanics.structures.fibers.section import ShearYielding
from workbench.models.domain import DIRECT_SHEAR, shear_demand
from workbench.models.frame_model import as_frame
from workbench.models.hinge_limits import web_findings, web_of
from workbench.models.references.fiber_mesh import SHEAR_RULE, MeshRule
from workbench.models.references.fiber_reissner import BEAMS, ExactBeams
from workbench.responses import Finding, finding
from workbench.scenarios import ColumnScenario, FrameScenario, MemberPulse
from workbench.scenarios.pulse import UNIFORM
from workbench.steel.materials import Steel


@dataclass(frozen=True)
class FiberShear(ExactBeams):
    """Geometrically exact fiber beam with shear yielding.

    By rule the smallest element is 1/64 of the shorter member that is hit, but not below 1/20 of
    the depth; time steps are twice as long as of other references.
    """

    name: ClassVar[str] = "fiber-shear"
    material: ClassVar[tuple[str, ...]] = ("rate", "hardening")
    version: ClassVar[int] = 8
    shear_yields: ClassVar[bool] = True
    longer: ClassVar[float] = 2.0  # webs that yield take the waves out
    assumptions: ClassVar[tuple[str, ...]] = (
        "Plane sections that may stretch, shear and turn by any amount; one shear strain per "
        "section.",
        "Webs and solid sections yield under normal and shear stress together, flanges and "
        "fillets carry no shear; the elastic shear stiffness is that of the same fibers.",
        "Plastic shear does not stretch the member: above a mean shear strain of 0.3 the "
        "catenary action of a real member is missed.",
        "The mass is that of the rolled profile, distributed along the member.",
        "Point contact; no local denting, no web buckling, no fracture; strain rate and hardening "
        "as the steel has them, one law for both stresses of a fiber.",
    )

    @property
    def sources(self) -> tuple[str, ...]:
        """Bibliography keys of the beam and of the options that are on."""
        return (
            *BEAMS,
            "simo-hughes1998",
            *(["eccs1984"] if self.residual_stress != "none" else []),
        )

    def domain(self, scenario: ColumnScenario | FrameScenario) -> list[Finding]:
        """Findings of all fibers; webs that buckle; pulses that webs decide, clear of flanges here.

        At the ends of a line load all webs that yield slide alike, see docs/theory/shear-panel.md.
        """
        frame = as_frame(scenario).frame
        webs = {m.name: web_of(frame.strength_section(m), frame.steel) for m in frame.members}
        findings = super().domain(scenario) + web_findings(webs)
        if isinstance(scenario, MemberPulse):
            if scenario.load == UNIFORM:
                findings = [each for each in findings if each.subject != DIRECT_SHEAR]
            needed = max(shear_demand(scenario).values())
            if needed > 1.0 and all(each.subject != DIRECT_SHEAR for each in findings):
                findings.append(finding("clear-web", needed, needed=needed))
        return findings

    def mesh_rule(self, scenario: FrameScenario) -> MeshRule:
        """Sizes of elements where no option gives them."""
        return SHEAR_RULE

    def law(self, steel: Steel) -> ShearYielding:
        """Fibers along the shear force yield under sigma^2 + 3 tau^2."""
        moduli = steel.elastic_modulus, steel.shear_modulus
        hardening = steel.hardening_modulus or self.hardening_ratio * steel.elastic_modulus
        return ShearYielding(*moduli, steel.yield_stress, hardening, steel.rate)
