"""Reference in space: the struck column as folded plates that may buckle, twist and lean.

Explicit steps of shells with one point in their plane (Belytschko, Lin and Tsay) and von Mises
plasticity in four layers. A rigid striker presses on a face of a flange, at any eccentricity, or on
the web as a whole.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import degrees
from typing import Any, ClassVar

import numpy as np

from workbench.base.arrays import Array
from workbench.base.fields import Choice, Declared, Flag, Number, checked
from workbench.mechanics.frames.members import override_findings
from workbench.mechanics.frames.runs import resting
from workbench.mechanics.structures.explicit import explicit_impact
from workbench.mechanics.structures.impact import PointMass
from workbench.models.base import respond
from workbench.models.domain import member_findings
from workbench.models.hit_mass import light_impact_mass
from workbench.models.references.refine import LEVELS, MESHES, check_levels, refined
from workbench.models.references.shell.assembly import ShellAssembly, shell_column
from workbench.models.references.shell.mesh import (
    FaceTarget,
    face_of,
    target_of,
)
from workbench.models.references.solid.model import section_values
from workbench.responses import (
    Finding,
    Response,
    build_response,
    energy_error,
    finding,
    findings_of,
    set_findings,
)
from workbench.scenarios import ColumnImpact, Scenario, frame_of
from workbench.steel.sections import AXES, ISection, RectangularTube

COARSEST = -1  # refinement: four elements across a flange
RECORDS = 500  # of an impact
AT_REST = 0.01  # largest unbalanced force before the hit, over that of its imperfections or weight
OPEN_LEDGER = 1e-3  # of the input energy: work over steps is of second order in their turns
MUCH_HOURGLASS = 0.05  # work against hourglass modes over the plastic work
SHAPES = (ISection, RectangularTube)
OWN = {  # histories of its own: unit and meaning, by name
    "axis": ("m", "displacement of the centroid of the struck section along the hit"),
    "edge": ("m", "displacement of the struck edge of the flange along the hit"),
    "hourglass": ("J", "work against hourglass modes, part of what is stored"),
}


@dataclass(frozen=True)
class Shell(Declared, table="option"):
    """Folded plates of shells, free to buckle and to twist."""

    refinement: int = checked(
        Number(COARSEST, 2, integer=True),
        0,
        help="how often all elements are halved in both directions (-1: doubled)",
    )
    struck: str = checked(
        Choice(("flange", "web")), "flange", help="a face of the flange, or the web as a whole"
    )
    face_width: float = checked(Number(1e-3, 2.0, "m"), 0.12, help="of the striker, across")
    face_height: float = checked(Number(1e-3, 2.0, "m"), 0.12, help="of the striker, along")
    bow: float = checked(
        Number(0.0, 0.02), 0.0, help="initial bow along the width of the section over the length"
    )
    tilt: float = checked(
        Number(0.0, 0.05), 0.0, help="of the edges of flanges out of their planes over the width"
    )
    upright: bool = checked(
        Flag(), False, help="whether the middle plane of the section is held, as in plane models"
    )
    time_step: float | None = checked(
        Number(1e-9, 1e-4, "s"),
        optional=True,
        help="longest one of an impact (None: what the fastest wave allows, never more)",
    )
    levels: int = checked(LEVELS, 2, help=MESHES)

    name: ClassVar[str] = "shell"
    material: ClassVar[tuple[str, ...]] = ("rate", "hardening")
    version: ClassVar[int] = 1
    judged: ClassVar[bool] = False
    crushing: ClassVar[bool] = True
    spatial: ClassVar[bool] = True
    eccentric: ClassVar[bool] = True
    unused: ClassVar[tuple[str, ...]] = ("column.unbraced_length", "striker.friction")
    answers: ClassVar[tuple[str, ...]] = (ColumnImpact.KIND,)
    assumptions: ClassVar[tuple[str, ...]] = (
        "Plates in their middle planes, without root fillets, whose area goes to the flanges; they "
        "may buckle, dent, warp and twist. No residual stress, no fracture, no weld.",
        "One point in the plane of an element, hourglass modes held elastically, four layers of "
        "von Mises plasticity in plane stress; transverse shear stays elastic, thickness stays.",
        "The striker presses evenly on a face that stays where it is on the column, and moves as "
        "the mean of it; it does not turn, rub, nor meet other places as the section turns.",
        "Ends are clamped or rigid plates that turn both ways, warping held; the head is also held "
        "sideways and against twist. Braces are left out.",
        "The column is straight and upright but for `bow` and `tilt`; a bow of 1/750 of the length "
        "is part of the stated uncertainty.",
        "Elastic stiffness and strength are both those of the strength section; the mass is that "
        "of the rolled profile, spread over the plates.",
        "Perfect plasticity has no length of its own: kinks shrink with the mesh.",
    )
    sources: ClassVar[tuple[str, ...]] = (
        "belytschko-lin-tsay1984",
        "belytschko-liu-moran2000",
        "simo-hughes1998",
    )

    def check(self) -> None:
        """Refuse levels that do not fit the refinement."""
        check_levels(self.refinement, self.levels, COARSEST)

    def domain(self, scenario: ColumnImpact) -> list[Finding]:
        """Sections that are no plates, buckling under the axial load, a hit beside the flange."""
        column, striker = scenario.column, scenario.striker
        section = column.strength_section.about("strong")
        if not isinstance(section.shape, SHAPES):
            return [finding("shell-section", section=column.section.name)]
        findings = [each for each in member_findings(scenario) if each.refusal]
        free, load = column.changed(unbraced_length=None), column.axial_load
        critical = min(map(free.euler_load, AXES))
        if load >= critical and not (findings or self.upright):
            kilo = {"load": load / 1e3, "critical": critical / 1e3}
            findings.append(finding("euler-reached", load / critical, **kilo))  # type: ignore[arg-type]
        direction, away = scenario.angle_from_height, striker.eccentricity
        if self.upright and direction:
            findings.append(finding("off-plane", degrees(direction), name="upright shell"))
        room = target_of(section, direction, away).room
        if room < 0.0 or (away and (self.struck == "web" or self.upright)):
            findings.append(finding("beside-column", away, most=max(abs(away) + room, 0.0)))
        findings += light_impact_mass(scenario)
        return findings + override_findings(frame_of(column), section_values, "the shell comes")

    def simulate(self, scenario: Scenario) -> Response:
        """Answer a column impact, with the uncertainty of mesh and imperfection."""
        return respond(self, scenario, lambda given: refined(self, given, self._solve))

    def _solve(self, scenario: ColumnImpact) -> Response:
        """Let the loaded column come to rest, then strike it.

        From then on the restraint spring, unstressed, or the lock of a fixed head acts.
        """
        column = scenario.column
        shells = shell_column(column, self.refinement, self.bow, self.tilt, self.upright)
        direction = scenario.angle_from_height
        section = column.strength_section.about("strong")
        target = target_of(section, direction, scenario.striker.eccentricity)
        met, size = None if self.struck == "web" else target, (self.face_width, self.face_height)
        face = shells.face(*face_of(shells.mesh, column.length_below, size, met), direction)
        shells.attach(face, column.attached_mass)
        if scenario.acceleration:
            shells.weigh(scenario.acceleration, direction)
        settled = shells.settle(AT_REST) if self.bow or self.tilt or scenario.acceleration else 0
        if column.head == "fixed":
            shells.held = np.array([shells.head])
        else:
            shells.spring = (column.restraint_stiffness, float(shells.displacement[shells.head]))
        states = ShellRecord(shells, scenario, target, direction)
        states.see(float(face.shares @ shells.displacement[face.dofs]), 0.0)
        spans = [(scenario.duration, scenario.duration / RECORDS)]
        rows = [(0.0, scenario.input_energy, scenario.striker.velocity, 0.0, 0.0, 0.0)]
        hitting, longest = PointMass.of(scenario), (self.time_step or np.inf) / 2.0**self.refinement
        for taken in explicit_impact(shells, face, hitting, spans, longest):
            assert taken.striker is not None
            energy = taken.kinetic + taken.striker.kinetic_energy
            contact = taken.impulse, taken.contact_loss, taken.external_work
            rows.append((taken.time, energy, taken.striker.velocity, *contact))
            at, speed = shells.displacement[face.dofs], shells.velocity[face.dofs]
            states.see(float(face.shares @ at), float(face.shares @ speed))
        time, kinetic, speeds, percussion, lost, work = np.array(rows).T
        values = {
            "kinetic": kinetic,
            "striker_velocity": speeds,
            "percussion": percussion,
            "contact_loss": np.cumsum(lost),
            "external_work": np.cumsum(work),
            "input_energy": scenario.input_energy,
        }
        residual, warnings = resting(scenario)
        response = states.response(values | residual, time, warnings)
        response.attrs.update(settling_steps=settled)
        return response


class ShellRecord:
    """Numbers of the committed states of `shells`, one row for each.

    Arguments: the `scenario`; its `target`; `direction` (rad).
    """

    def __init__(
        self, shells: ShellAssembly, scenario: ColumnImpact, target: FaceTarget, direction: float
    ) -> None:
        self.shells, mesh = shells, shells.mesh
        self._way = np.array([np.cos(direction), np.sin(direction)])
        level = mesh.along[np.argmin(np.abs(mesh.along - scenario.column.length_below))]
        self._nodes = np.flatnonzero(mesh.along == level)
        flat = mesh.section[self._nodes]
        self._edge = int(np.argmin(np.hypot(*(flat - target.corner).T)))
        self._flat, self._weight = flat, shells.nodal_mass[self._nodes, 0]
        self._start = self._at()
        self._plastic_before = shells.dissipated
        column = scenario.column
        stiffness = column.strength_section.area * column.steel.elastic_modulus
        self._shortened = column.axial_load * column.length / stiffness
        self._rows: list[tuple[float, ...]] = []

    def _at(self) -> Array:
        """Places (nodes, 2) of the nodes of the struck section, across the column."""
        mesh, nodal = self.shells.mesh, self.shells.nodal
        return np.asarray(mesh.place[self._nodes, :2] + nodal[self._nodes, :2])

    def see(self, displacement: float, velocity: float) -> None:
        """Read the committed state, in which the face is at a displacement (m), so fast (m/s)."""
        shells, at = self.shells, self._at()
        moved, weight = at - self._start, self._weight / self._weight.sum()
        middle, from_middle = weight @ moved, at - weight @ at
        along, across = middle @ self._way, self._way[0] * middle[1] - self._way[1] * middle[0]
        x, y = self._flat.T
        turn = np.arctan2(
            weight @ (x * from_middle[:, 1] - y * from_middle[:, 0]),
            weight @ (x * from_middle[:, 0] + y * from_middle[:, 1]),
        )
        edge = moved[self._edge] @ self._way
        own = float(turn), across, along, edge, shells.hourglass
        shortening = self._shortened - float(shells.displacement[shells.head])
        energies = shells.stored, shells.dissipated - self._plastic_before
        self._rows.append((displacement, velocity, shortening, *energies, *own))

    def response(
        self, values: Mapping[str, Any], time: Array, warnings: Sequence[Finding]
    ) -> Response:
        """The response with these `values` at `time` (steps,) in s."""
        rows, shells = np.array(self._rows).T, self.shells
        rows[0] -= rows[0, 0]
        names = (
            "displacement",
            "velocity",
            "shortening",
            "elastic",
            "dissipated",
            "twist",
            "sideways",
        )
        known: dict[str, Any] = dict(zip(names, rows, strict=False))
        response = build_response({**known, **values}, time=time, warnings=list(warnings))
        for (name, (unit, meaning)), history in zip(OWN.items(), rows[len(names) :], strict=True):
            told = {"units": unit, "long_name": meaning}
            response[f"shell.{name}"] = ("time", history, told)
        doubts = []
        open_by = energy_error(response) or 0.0
        if open_by > OPEN_LEDGER:
            doubts.append(finding("energy-balance", open_by, error=open_by))
        share = shells.hourglass / max(shells.dissipated, 1e-9 * response["input_energy"].item())
        if shells.dissipated > 0.0 and share > MUCH_HOURGLASS:
            doubts.append(finding("hourglass", share, percent=100.0 * share))
        set_findings(response, [*findings_of(response), *doubts])
        response.attrs.update(
            elements=len(shells.mesh.areas),
            dofs=shells.size,
            smallest_element=shells.mesh.smallest,
            hourglass_share=share,
        )
        return response
