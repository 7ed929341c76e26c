"""Reference: the column as an elastic-plastic solid in plane stress, pushed or struck.

A push is quasi-static; a strike moves the solid in explicit steps with its mass at the nodes.
Nine-node elements of the thickness of the section at each height, nominal (Biot) strain with
additive von Mises plasticity, so that N <= A f_y holds as in the beam theories. What beams leave
out is in: shear yielding of the web, transverse stress at supports and plastic kinks.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from threadpoolctl import threadpool_limits

from workbench.arrays import Array
from workbench.fields import Declared, Number, checked
from workbench.materials import Steel
from workbench.models.base import respond
from workbench.models.domain import member_findings
from workbench.references.fiber import override_findings
from workbench.references.refine import LEVELS, REFINEMENT, check_levels, refined
from workbench.references.solid.assembly import SolidAssembly
from workbench.references.solid.mesh import solid_mesh
from workbench.references.solid.push import apply_load
from workbench.references.solid.run import run_pushover
from workbench.references.solid.struck import run_impact
from workbench.references.solid.supports import supports_of
from workbench.responses import Finding, Response
from workbench.responses.uncertainty import SPACE
from workbench.scenarios import ColumnImpact, ColumnPushover, ColumnScenario, Scenario, frame_of
from workbench.sections import Section

STEPS_PER_SEGMENT = 320  # steps to push by the length of the shorter segment
LEAST_STEPS = 20
FIRST_STEP, STEP_GROWTH = 0.125, 1.25  # the knee of the curve comes early
COARSEST = -1  # refinement: a flange has one row of elements then, half a web too


@dataclass(frozen=True)
class SolidPlaneStress(Declared, table="option"):
    """Plane-stress solid.

    Options:
    `smallest_element` in m along the axis, at the ends and at the hit section (None: a sixth of
    the section's height); `refinement`, how often all elements are halved in both directions
    (-1: doubled); `hardening_ratio`, isotropic hardening modulus over Young's modulus; `step` of
    the push in m (None: 1/320 of the shorter segment; the first ones are smaller); longest
    `time_step` of an impact in s (None: what the fastest wave allows, never more);
    `step_refinement`, how often the steps are halved; `levels`, meshes behind an answer, each
    with twice the elements of the next finer one (1: that of `refinement` alone, the numerical
    uncertainty is then unknown).
    """

    smallest_element: float | None = checked(Number(1e-3, 10.0, "m"), optional=True)
    refinement: int = checked(Number(COARSEST, 4, integer=True), 0)
    hardening_ratio: float = checked(Number(0.0, 0.1), 1e-6)
    step: float | None = checked(Number(1e-6, 1.0, "m"), optional=True)
    time_step: float | None = checked(Number(1e-9, 1e-4, "s"), optional=True)
    step_refinement: int = checked(REFINEMENT, 0)
    levels: int = checked(LEVELS, 2)

    name: ClassVar[str] = "solid-plane-stress"
    version: ClassVar[int] = 2
    answers: ClassVar[tuple[str, ...]] = (ColumnPushover.KIND, ColumnImpact.KIND)
    assumptions: ClassVar[tuple[str, ...]] = (
        "Plane stress in layers of the width of the section: no shear lag, no torsion, no local or "
        "lateral buckling; flanges and web stay plane.",
        "Von Mises plasticity, additive in the nominal strain U - I: the nominal stress is limited "
        "(N <= A f_y), there is no necking; Poisson's ratio 0.3.",
        "Elastic stiffness and strength are both those of the strength section; the mass is that "
        "of the rolled profile, spread over the meshed section.",
        "End sections are rigid plates, clamped or turning about their centroid; the hit section "
        "moves sideways as one, where the striker meets it. No local denting, no rate effect, no "
        "fracture.",
        "Perfect plasticity has no length of its own: plastic kinks shrink with the mesh, the web "
        "is crushed in them, and resistance governed by bending falls with each refinement; a "
        "hardening_ratio of 0.01 makes it converge.",
        "A point squeezed below a fifth of its area stiffens, so that it cannot vanish.",
    )
    sources: ClassVar[tuple[str, ...]] = (
        "simo-hughes1998",
        "belytschko-liu-moran2000",
        "moreau1988",
        "heng2017",
    )
    refines_in_statics: ClassVar[str] = SPACE  # what `refinement` halves there

    def check(self) -> None:
        """Refuse levels that do not fit the refinement."""
        check_levels(self.refinement, self.levels, COARSEST)

    def domain(self, scenario: ColumnScenario) -> list[Finding]:
        """Buckling under the axial load, and overrides that a solid cannot follow."""
        findings = [found for found in member_findings(scenario) if found.refusal]
        text = "the solid takes its shape from the section alone and leaves overrides out"
        return findings + override_findings(frame_of(scenario.column), _values, text)

    def simulate(self, scenario: Scenario) -> Response:
        """Answer a column pushover or impact, with numerical uncertainty."""
        return respond(self, scenario, lambda given: refined(self, given, self._solve))

    def path(self, scenario: ColumnPushover) -> Array:
        """Displacements (m) of the hit section at the steps of the push, from zero."""
        column, final = scenario.column, scenario.displacement
        shorter = min(column.length_below, column.length_above)
        step = min(self.step or shorter / STEPS_PER_SEGMENT, final / LEAST_STEPS)
        step /= 2.0**self.step_refinement
        growing = FIRST_STEP * STEP_GROWTH ** np.arange(int(final / step) + LEAST_STEPS)
        at = np.concatenate([[0.0], np.cumsum(step * np.minimum(growing, 1.0))])
        last = int(np.searchsorted(at, final * (1.0 - 1e-12)))
        return np.asarray(at[: last + 1] * (final / at[last]))

    def _solve(self, scenario: ColumnPushover | ColumnImpact) -> Response:
        column = scenario.column
        with threadpool_limits(1, user_api="blas"):
            mesh = solid_mesh(column, self.smallest_element, self.refinement)
            supports = supports_of(mesh, column.base, column.head)
            assembly = SolidAssembly(mesh, supports, column.steel, self.hardening_ratio)
            apply_load(assembly, column.axial_load)
            if isinstance(scenario, ColumnPushover):
                return run_pushover(column, assembly, self.path(scenario))
            longest = (self.time_step or np.inf) / 2.0 ** (self.refinement + self.step_refinement)
            return run_impact(scenario, assembly, longest)


def _values(section: Section, steel: Steel) -> dict[str, float]:
    """What the meshed section comes to, by the names of its overrides."""
    return {
        "area": section.area,
        "second_moment": section.second_moment,
        "plastic_moment": section.plastic_moment(steel),
        "squash_load": section.squash_load(steel),
    }
