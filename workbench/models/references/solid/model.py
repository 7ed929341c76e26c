"""Reference: the column as an elastic-plastic solid in plane stress, pushed or struck.

A push is quasi-static; a strike moves the solid in explicit steps with its mass at the nodes.
Nine-node elements of the thickness of the section at each height, nominal (Biot) strain with
additive von Mises plasticity, so that N <= A f_y holds as in the beam theories. What beams leave
out is in: shear yielding of the web, transverse stress at supports and plastic kinks.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from workbench.base.arrays import Array
from workbench.base.fields import Declared, Number, checked
from workbench.mechanics.frames.members import override_findings
from workbench.mechanics.frames.runs import OPEN_LEDGER, resting
from workbench.mechanics.structures.explicit import explicit_impact
from workbench.mechanics.structures.impact import PointMass
from workbench.mechanics.structures.paths import apply_loads, push
from workbench.models.base import respond
from workbench.models.domain import member_findings
from workbench.models.hit_mass import light_impact_mass
from workbench.models.references.refine import (
    HALVED_STEPS,
    LEVELS,
    MESHES,
    REFINEMENT,
    check_levels,
    refined,
)
from workbench.models.references.solid.kernels import (
    SQUEEZED,
    SolidAssembly,
    nodal_mass,
    solid_column,
)
from workbench.responses import (
    Finding,
    Response,
    build_response,
    energy_error,
    finding,
    findings_of,
    set_findings,
)
from workbench.responses.uncertainty import SPACE
from workbench.scenarios import (
    Column,
    ColumnImpact,
    ColumnPushover,
    ColumnScenario,
    Scenario,
    frame_of,
)
from workbench.steel.materials import Steel
from workbench.steel.sections import Section

STEPS_PER_SEGMENT = 320  # steps to push by the length of the shorter segment
LEAST_STEPS = 20
FIRST_STEP, STEP_GROWTH = 0.125, 1.25  # the knee of the curve comes early
COARSEST = -1  # refinement: a flange has one row of elements then, half a web too
TOLERANCE = 1e-8  # of the largest nodal force, or of the squash load if that is smaller
MOST_CUTS = 8
RECORDS = 1000  # of an impact
SEGMENTS = ("below", "above")
KINKED = 0.05  # nominal strain beyond which forces fall by several per cent with each refinement
REGULAR = 0.005  # hardening ratio from which on they do not
LOCALISED = 0.8  # nominal strain at which kinks fold up
LARGEST_IMBALANCE = 1e-3  # of the work of the push


@dataclass(frozen=True)
class SolidPlaneStress(Declared, table="option"):
    """Plane-stress solid."""

    smallest_element: float | None = checked(
        Number(1e-3, 10.0, "m"),
        optional=True,
        help="along the axis, at the ends and at the hit section (None: a sixth of the height)",
    )
    refinement: int = checked(
        Number(COARSEST, 4, integer=True),
        0,
        help="how often all elements are halved in both directions (-1: doubled)",
    )
    hardening_ratio: float = checked(
        Number(0.0, 0.1), 1e-6, help="isotropic hardening modulus over Young's modulus"
    )
    step: float | None = checked(
        Number(1e-6, 1.0, "m"),
        optional=True,
        help="of the push (None: 1/320 of the shorter segment); the first ones are smaller",
    )
    time_step: float | None = checked(
        Number(1e-9, 1e-4, "s"),
        optional=True,
        help="longest one of an impact (None: what the fastest wave allows, never more)",
    )
    step_refinement: int = checked(REFINEMENT, 0, help=HALVED_STEPS)
    levels: int = checked(LEVELS, 2, help=MESHES)

    name: ClassVar[str] = "solid-plane-stress"
    material: ClassVar[tuple[str, ...]] = ("rate", "hardening")
    version: ClassVar[int] = 3
    judged: ClassVar[bool] = False
    crushing: ClassVar[bool] = True
    answers: ClassVar[tuple[str, ...]] = (ColumnPushover.KIND, ColumnImpact.KIND)
    assumptions: ClassVar[tuple[str, ...]] = (
        "Plane stress in layers of the width of the section: no shear lag, no torsion, no local or "
        "lateral buckling; flanges and web stay plane.",
        "Von Mises plasticity, additive in the nominal strain U - I: the nominal stress is limited "
        "(N <= A f_y), there is no necking; Poisson's ratio 0.3.",
        "Elastic stiffness and strength are both those of the strength section; the mass is that "
        "of the rolled profile, spread over the meshed section.",
        "End sections are rigid plates, clamped or turning about their centroid; the hit section "
        "moves sideways as one, where the striker meets it. No local denting, no fracture.",
        "A struck solid flows at the rate law of the steel, if it has one, by the equivalent "
        "plastic strain; the hardening modulus of the steel goes before `hardening_ratio`.",
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
        findings = [each for each in member_findings(scenario) if each.refusal]
        findings += light_impact_mass(scenario)
        return findings + override_findings(
            frame_of(scenario.column), section_values, "the solid comes"
        )

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
        """Bring the axial load on with the column held straight; then push or strike it.

        One that lies under its own weight is not held straight. From then on the restraint spring,
        unstressed, or the lock of a fixed head acts.
        """
        column = scenario.column
        solid = solid_column(column, self.smallest_element, self.refinement, self.hardening_ratio)
        head, hit = solid.supports.head, solid.supports.hit
        solid.load[head], solid.held = -column.axial_load, np.array([hit])
        if isinstance(scenario, ColumnImpact) and scenario.acceleration:
            weight = nodal_mass(solid.mesh, column) * scenario.acceleration
            weight[solid.mesh.dofs[:, 1::2]] = 0.0  # along the column
            solid.load, solid.held = solid.load + solid.supports.gathering @ weight, solid.held[:0]
        apply_loads(solid, tolerance=TOLERANCE, most_cuts=0, name="axial load")
        solid.held = np.array([head] if column.head == "fixed" else [], dtype=np.int64)
        if column.head != "fixed":
            solid.spring = (column.restraint_stiffness, float(solid.displacement[head]))
        if isinstance(scenario, ColumnPushover):
            return _push(scenario, solid, self.path(scenario))
        longest = (self.time_step or np.inf) / 2.0 ** (self.refinement + self.step_refinement)
        return _strike(scenario, solid, longest)


class _States:
    """Numbers of the committed states of a `solid`, one column for each."""

    def __init__(self, solid: SolidAssembly) -> None:
        self.solid, self._plastic_before = solid, solid.dissipated
        self._origin = float(solid.displacement[solid.supports.hit])
        self._rows: list[tuple[float, ...]] = []

    def see(self) -> None:
        """Read the committed state."""
        solid = self.solid
        hit, head = solid.supports.hit, solid.supports.head
        across = solid.displacement[hit] - self._origin
        moved = across, solid.velocity[hit], -solid.displacement[head]
        energies = solid.stored, solid.dissipated - self._plastic_before
        limits = solid.largest_strain(), np.min(solid.area_ratio())
        self._rows.append((*moved, *energies, *solid.segment_shear(), *limits))

    def response(
        self,
        column: Column,
        values: Mapping[str, ArrayLike],
        time: Array | None = None,
        warnings: Sequence[Finding] = (),
    ) -> Response:
        """The response with these `values`, of an impact at `time` (steps,) in s."""
        rows = np.array(self._rows).T
        names = "displacement", "velocity", "shortening", "elastic", "dissipated"
        known: dict[str, Any] = dict(zip(names, rows, strict=False))
        path, shear, (strain, area) = known["displacement"], rows[5:7], rows[7:]
        if time is None:
            del known["velocity"]
        shear = np.max(np.abs(shear), axis=1)
        known["shear_utilisation"] = shear / column.properties.shear_resistance
        response = build_response(
            {**known, **values},
            time=time,
            steps=None if time is not None else len(path),
            segments=SEGMENTS,
            warnings=[*warnings, *localisation(path, strain, area, self.solid.hardening_ratio)],
        )
        open_by = energy_error(response) or 0.0
        if open_by > (LARGEST_IMBALANCE if time is None else OPEN_LEDGER):
            doubt = finding("energy-balance", open_by, error=open_by)
            set_findings(response, [*findings_of(response), doubt])
        mesh = self.solid.mesh
        response.attrs.update(
            elements=len(mesh.dofs),
            dofs=mesh.size,
            smallest_element=mesh.smallest,
            dead_displacement=self._origin,
            largest_strain=float(np.max(strain)),
            least_area_ratio=float(np.min(area)),
        )
        return response


def _push(scenario: ColumnPushover, solid: SolidAssembly, path: Array) -> Response:
    """Lead the hit section of the loaded solid along `path` (steps,) in m, from zero."""
    states, start = _States(solid), solid.displacement
    states.see()
    steps = []
    for step in push(solid, solid.supports.hit, path[1:], TOLERANCE, MOST_CUTS):
        steps.append(step)
        states.see()
    work = np.cumsum([0.0, *(step.external_work for step in steps)])
    values = {
        "displacement": path,
        "force": [0.0, *(step.factor for step in steps)],
        "external_work": work,
        "input_energy": work[-1] - float(solid.load @ (solid.displacement - start)),
    }
    response = states.response(scenario.column, values)
    response.attrs.update(
        newton_iterations=sum(step.evaluations for step in steps),
        cut_steps=sum(step.cuts for step in steps),
    )
    return response


def _strike(scenario: ColumnImpact, solid: SolidAssembly, step: float) -> Response:
    """Follow an impact on the loaded solid with explicit steps of at most `step` s.

    They are no longer than the fastest wave takes through the smallest element, so that fronts,
    contact and yielding are resolved as far as the mesh is.
    """
    striker, states = scenario.striker, _States(solid)
    states.see()
    hitting = PointMass.of(scenario)
    spans = [(scenario.duration, scenario.duration / RECORDS)]
    rows = [(0.0, scenario.input_energy, striker.velocity, 0.0, 0.0, 0.0)]
    for taken in explicit_impact(solid, solid.supports.hit, hitting, spans, step):
        assert taken.striker is not None
        energy = taken.kinetic + taken.striker.kinetic_energy
        contact = taken.impulse, taken.contact_loss, taken.external_work
        rows.append((taken.time, energy, taken.striker.velocity, *contact))
        states.see()
    time, kinetic, speed, percussion, lost, work = np.array(rows).T
    values = {
        "kinetic": kinetic,
        "striker_velocity": speed,
        "percussion": percussion,
        "contact_loss": np.cumsum(lost),
        "external_work": np.cumsum(work),
        "input_energy": scenario.input_energy,
    }
    residual, warnings = resting(scenario)
    return states.response(scenario.column, values | residual, time, warnings)


def localisation(
    path: Array, strains: Array, areas: Array, hardening_ratio: float
) -> list[Finding]:
    """Findings where the mesh decides: on forces once kinks form, on everything once they fold up.

    Arguments: displacements `path` (steps,) in m; largest strain, and smallest share of its area
    that a point keeps, in the states there (steps,).
    """
    findings = []
    kinked = np.flatnonzero(strains > KINKED)
    if kinked.size and hardening_ratio < REGULAR:
        start, strain = path[kinked[0]], strains.max()
        findings.append(finding("kinks", start=start, strain=strain))
    folded = np.flatnonzero((strains > LOCALISED) | (areas < SQUEEZED))
    if folded.size:
        values = {"start": path[folded[0]], "strain": strains.max(), "area": areas.min()}
        findings.append(finding("localisation", **values))
    return findings


def section_values(section: Section, steel: Steel) -> dict[str, float]:
    """Properties of a meshed section, by the names of its overrides."""
    return {
        "area": section.area,
        "second_moment": section.second_moment,
        "plastic_moment": section.plastic_moment(steel),
        "squash_load": section.squash_load(steel),
    }
