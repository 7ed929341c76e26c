"""OpenSees as a model: a struck column or frame in another program, with the same steel and loads.

OpenSees (McKenna, Scott and Fenves 2010) is called through openseespy, an extra that is not shipped
with the workbench. It takes mesh, masses and loads from the scenario, and everything else from its
own code: elements, sections, steel, equilibrium and steps in time. See `deck` for the elements and
`driver` for the contact.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any, ClassVar

import numpy as np

from workbench.base.arrays import Array
from workbench.base.errors import SolverError
from workbench.base.fields import Choice, Declared, Number, checked
from workbench.extras.exchange.opensees import driver
from workbench.extras.exchange.opensees.deck import (
    DISPLACEMENT_BASED,
    FORCE_BASED,
    FORMS,
    HINGES,
    Commands,
    Deck,
    Form,
    deck_of,
)
from workbench.mechanics.frames.collapse import CollapseWatch
from workbench.mechanics.frames.elastic import Spans
from workbench.mechanics.frames.members import LAYERS
from workbench.mechanics.frames.structure import (
    FrameStructure,
    equip,
    hinge_names,
    member_names,
)
from workbench.mechanics.structures.assembly import PlanarAssembly
from workbench.mechanics.structures.space import SpaceAssembly
from workbench.models.base import is_oblique, respond
from workbench.models.frame_model import as_column, as_frame
from workbench.models.references.fiber import FiberMembers, FrameMesh, mesh_frame
from workbench.models.references.fiber_beams import FiberCorotational
from workbench.models.references.fiber_space import (
    FiberSpace,
    place,
    turn_shapes,
)
from workbench.models.references.refine import (
    HALVED_STEPS,
    LEVELS,
    MESHES,
    REFINEMENT,
    check_levels,
    refined,
)
from workbench.responses import Finding, Response, build_response, finding, peak_of
from workbench.scenarios import ColumnImpact, FrameImpact, Scenario
from workbench.scenarios.frame_events import azimuth, facing

PACKAGE = "openseespy"
PROGRAM = "program"  # subject of the refusal where it is not installed
ELEMENTS = {  # that have an option
    "points": (FORCE_BASED,),
    "hinge_length": (HINGES,),
    "smallest_element": (FORCE_BASED, DISPLACEMENT_BASED),
    "largest_element": (FORCE_BASED, DISPLACEMENT_BASED),
}
OPEN = 0.02  # of the energy brought in, that a run may lose to its steps without a warning
NO_LEDGER = 0.1  # of it, beyond which a run is no answer
HEAVY = 0.05  # of it, lost in contact, from which the mass of the struck node decides the peak
PICTURES = 60  # deformed shapes over the record, and one of the peak
DEPTHS = 2.0  # length of a force-based element; shorter ones lose their strength where hinges form
# Hardening that gives hinges a length. With less force-based elements leave their path: at 1e-6
# sections took 1e4 times the work of their element, whatever the step.
LEAST_HARDENING = {DISPLACEMENT_BASED: 1e-6, FORCE_BASED: 1e-5, HINGES: 1e-5}


@dataclass(frozen=True)
class OpenSees(Declared, table="option"):
    """Columns and frames struck in OpenSees.

    By rule displacement-based elements and all time steps are as long as those of
    `fiber-corotational`, force-based elements two depths; a member between hinges is one element.
    """

    element: str = checked(
        Choice(FORMS),
        FORCE_BASED,
        help="force-based: Lobatto points; displacement-based: two Legendre points; hinges: "
        "beamWithHinges, fiber hinges under Gauss-Radau integration about an elastic member",
    )
    points: int | None = checked(
        Number(2, 10, integer=True),
        optional=True,
        help="of a force-based element (None: 3; practice has one element of 5)",
    )
    hinge_length: float | None = checked(
        Number(0.05, 5.0),
        optional=True,
        help="of hinges over the depth, at most 1/8 of the member (None: 1)",
    )
    hardening_ratio: float | None = checked(
        Number(1e-9, 0.1),
        optional=True,
        help="regularising hardening over the elastic modulus (None: 1e-6 of displacement-based "
        "elements, 1e-5 of others, which leave their path with less)",
    )
    layers: int = checked(LAYERS, 20, help="of fibers over the depth, in space also across flanges")
    smallest_element: float | None = checked(
        Number(1e-3, 10.0, "m"), optional=True, help="at ends of members (None: by rule)"
    )
    largest_element: float | None = checked(
        Number(1e-3, 100.0, "m"), optional=True, help="None: by rule"
    )
    refinement: int = checked(
        REFINEMENT, 0, help="how often elements and steps are halved; of hinges steps alone"
    )
    step_refinement: int = checked(REFINEMENT, 0, help=HALVED_STEPS)
    levels: int = checked(LEVELS, 3, help=MESHES)

    name: ClassVar[str] = "opensees"
    version: ClassVar[int] = 1
    judged: ClassVar[bool] = False
    spatial: ClassVar[bool] = True
    answers: ClassVar[tuple[str, ...]] = (ColumnImpact.KIND, FrameImpact.KIND)
    material: ClassVar[tuple[str, ...]] = ("hardening",)
    unused: ClassVar[tuple[str, ...]] = ("joint.axial_stiffness", "joint.*_resistance")
    sources: ClassVar[tuple[str, ...]] = ("mckenna2010", "spacone1996", "scott2006")
    assumptions: ClassVar[tuple[str, ...]] = (
        "Plane sections; large displacements by the co-rotational transformation; elastic shear "
        "strain, of which displacement-based elements have none.",
        "Steel01 fibers: elastic-plastic with kinematic hardening, plasticity from normal stress.",
        "Elastic torsion by St Venant where members are in space.",
        "Masses at the nodes; no damping but that of the steps (TRBDF2).",
        "Point contact: a collision at an instant with Newton's restitution, then one mass until "
        "the striker is let go; no denting, no local buckling, no fracture; strain rate as one "
        "factor on the yield stress.",
    )

    def check(self) -> None:
        """Refuse levels that do not fit, and options of other elements."""
        check_levels(self.refinement, self.levels)
        for option, elements in ELEMENTS.items():
            if getattr(self, option) is not None and self.element not in elements:
                text = f"is an option of element = {' or '.join(elements)}"
                raise self.refusal(option, text, "leave it out")

    def domain(self, scenario: Any) -> list[Finding]:
        """Findings of fiber beams in the plane or in space; what OpenSees is not told."""
        findings = self._twin(scenario).domain(scenario)
        if find_spec(PACKAGE) is None:
            findings.append(finding("no-program", name=self.name, package=PACKAGE))
        if self.element != DISPLACEMENT_BASED:  # forces along such elements are exact
            findings = [each for each in findings if each.subject != "mesh"]
        unknown = [] if not scenario.acceleration else ["weight of the striker along its flight"]
        if isinstance(scenario, ColumnImpact) and is_oblique(scenario):
            column = scenario.column.bent_about("strong")
            if column.ends_about("weak") != column.ends_about("strong"):
                unknown.append("ends that differ about the two axes")
        if self.element == HINGES:
            findings.append(finding("hinge-length"))
        if unknown:
            findings.append(finding("not-told", name=self.name, unknown=", ".join(unknown)))
        return findings

    def simulate(self, scenario: Scenario) -> Response:
        """Answer an impact, with numerical uncertainty."""
        return respond(self, scenario, lambda given: refined(self, given, self.solve))

    def _twin(self, scenario: Any) -> FiberCorotational | FiberSpace:
        """The model of the workbench whose mesh, masses and time steps are taken."""
        refinement, further = self.refinement, self.step_refinement
        smallest, largest = self.smallest_element, self.largest_element
        if self.element == HINGES:
            refinement, further = 0, refinement + further
        elif self.element == FORCE_BASED:
            event: Any = as_frame(scenario)
            struck = event.frame.meeting(event.striker.node)
            size = DEPTHS * max(end.member.section.height for end in struck)
            smallest, largest = smallest or size, largest or size
        else:
            refinement += 1
        given: dict[str, Any] = {
            "smallest_element": smallest,
            "largest_element": largest,
            "refinement": refinement,
            "step_refinement": further,
            "layers": self.layers,
            "levels": 1,
        }
        if is_oblique(scenario):
            return FiberSpace(**given)
        return FiberCorotational(shear_flexible=False, **given)

    def deck(self, scenario: Any) -> tuple[FrameStructure, Deck, FrameImpact, Spans]:
        """Structure, commands, the event in the plane or turned along x, and time spans (s)."""
        twin = self._twin(scenario)
        event: Any = as_frame(scenario)
        column, heights = isinstance(scenario, ColumnImpact), None
        if isinstance(twin, FiberSpace):
            event = event if column else facing(event)
            given = scenario if column else event
            placed, held = place(given, self._lengths(twin, given))
            frame, mesh, heights = placed.frame, placed.mesh, placed.heights
            beams: Any = twin.bars(placed)
            assembly: PlanarAssembly = SpaceAssembly(mesh.coordinates, [beams])
            assembly.hold([assembly.dof(frame.number[name], part) for name, part in held])
        else:
            frame, mesh = event.frame, mesh_frame(event.frame, self._lengths(twin, event))
            beams = twin.fibers(frame, mesh)
            assembly = PlanarAssembly(mesh.coordinates, [beams], ties=mesh.ties)
        structure = _loaded(frame, mesh, beams, assembly)
        hardening = self.hardening_ratio or LEAST_HARDENING[self.element]
        form = Form(
            self.element, self.layers, self.points or 3, self.hinge_length or 1.0, hardening
        )
        deck = deck_of(structure, mesh, heights, form)
        return (as_column(structure) if column else structure), deck, event, twin.time_spans(event)

    def _lengths(self, twin: FiberCorotational | FiberSpace, scenario: Any) -> list[Array]:
        """Element lengths (m) of every member; one between its hinges."""
        if self.element != HINGES:
            return twin.lengths(scenario)
        return [np.array([length]) for length in as_frame(scenario).frame.lengths]

    def solve(self, scenario: Any) -> Response:
        """Answer an impact that is in the domain; raises `SolverError`, `CollapseError`."""
        import openseespy.opensees as ops

        structure, deck, event, spans = self.deck(scenario)
        record = _Record(ops, structure, deck)
        with quiet():
            try:
                build(ops, deck)
                strike = driver.Strike(ops, *deck.watched, *striker_of(structure, event))
                record.begin(strike)
                for _ in strike.follow(spans):
                    record.take(strike)
            except driver.UnsolvedError as error:
                if record.watch.turned is not None:
                    raise record.watch.turned from error
                raise SolverError(f"OpenSees: {error}", error.residual, "shorter steps") from error
            finally:
                ops.wipe()
        response = record.response()
        if isinstance(scenario, FrameImpact) and structure.assembly.axes == 3:
            turn_shapes(response, azimuth(scenario))
        if self.element != HINGES:  # whose meshes have one length
            response.attrs["smallest_element"] = float(structure.members.elements.lengths.min())
        return response


@contextmanager
def quiet() -> Iterator[None]:
    """Keep what OpenSees prints, five lines for every attempt that fails, from the terminal."""
    kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)


def build(ops: Any, deck: Deck) -> None:
    """Run the commands of a deck, its dead loads included."""
    for part in deck.standing:
        _command(ops, part)
    if deck.loaded:
        driver.stand(ops)
    for part in deck.after:
        _command(ops, part)


def _command(ops: Any, part: Commands) -> None:
    """Run some commands. Raises `SolverError` naming one that OpenSees refuses."""
    for name, *arguments in part.commands:
        try:
            getattr(ops, name)(*arguments)
        except ops.OpenSeesError as error:
            given = ", ".join(map(str, arguments))
            raise SolverError(f"the command {name}({given})", np.inf, "nothing else") from error


def striker_of(structure: FrameStructure, event: FrameImpact) -> tuple[Any, ...]:
    """Node, number of the dof and sign of a strike; mass, velocity and restitution."""
    striker = event.striker
    dof = 1 + "xy".index(striker.direction.lstrip("+-"))
    sign = -1.0 if striker.direction.startswith("-") else 1.0
    tag = structure.frame.number[striker.node] + 1
    return tag, dof, sign, striker.mass, striker.velocity, striker.restitution


def _loaded(frame: Any, mesh: FrameMesh, beams: Any, assembly: PlanarAssembly) -> FrameStructure:
    """A structure with supports, masses and dead loads that are not on yet."""
    members = _Nodes(frame, mesh, beams, None, 0.0, shear_yields=False)
    members.assembly = assembly
    equip(frame, assembly, members)
    return FrameStructure(frame, assembly, members, np.zeros(assembly.size))


class _Nodes(FiberMembers):
    """Reads members off the displacements of their nodes alone."""

    assembly: PlanarAssembly

    def lengths_left(self) -> Array:
        """Ones: no element of another program is known to crumple."""
        return np.ones(len(self.first) - 1)

    def contractions(self) -> Array:
        """Loss of length along the axis of each member (members,)."""
        mesh, assembly = self._mesh, self.assembly
        parts = list(assembly.components)[: assembly.axes]
        nodes = range(len(mesh.coordinates))
        moved = np.stack([assembly.displacement[assembly.dofs(nodes, p)] for p in parts], axis=1)
        chords = np.diff((mesh.coordinates + moved)[mesh.nodes], axis=1)[:, 0]
        return np.add.reduceat(mesh.lengths - np.linalg.norm(chords, axis=1), self.first[:-1])


class _Record:
    """Histories of a run, read from OpenSees after every step."""

    def __init__(self, ops: Any, structure: FrameStructure, deck: Deck) -> None:
        self._ops, self._structure, self._deck = ops, structure, deck
        assembly = structure.assembly
        self.watch = CollapseWatch(structure)
        parts = list(assembly.components)
        dofs = [[assembly.dof(tag - 1, part) for part in parts] for tag in deck.watched[0]]
        self._dofs = np.array(dofs).ravel()
        self._rows: dict[str, list[Any]] = {}

    def begin(self, strike: driver.Strike) -> None:
        """Read the state under the dead loads."""
        self.given = strike.kinetic
        self._read(strike)

    def take(self, strike: driver.Strike) -> None:
        """Read the state after a step. Raises `CollapseError`."""
        self._read(strike)
        self.watch.check(strike.moved, strike.time)

    def _read(self, strike: driver.Strike) -> None:
        structure, ends = self._structure, self._deck.ends
        structure.assembly.displacement[self._dofs] = strike.places
        forces = np.array([self._ops.eleResponse(tag, "localForce") for tag in ends])
        side = np.arange(len(ends)) % 2
        forces = forces.reshape(len(ends), 2, -1)[np.arange(len(ends)), side]
        forces *= np.where(side == 0, -1.0, 1.0)[:, None]
        seen = {
            "time": strike.time,
            "displacement": strike.moved,
            "velocity": strike.speed,
            "percussion": strike.impulse,
            "kinetic": strike.kinetic,
            "contact_loss": strike.lost,
            "balance_error": self.given - strike.kinetic - strike.work - strike.lost,
            "axial_force": forces[:, 0],
            "moment": structure.sense * forces[:, -1],
            "moved": structure.assembly.displacement.copy(),
        }
        for name, value in seen.items():
            self._rows.setdefault(name, []).append(value)

    def response(self) -> Response:
        """Response of the run. Raises `CollapseError` where it ends turned over, without a peak."""
        structure = self._structure
        rows: dict[str, Any] = {n: np.stack(each, axis=-1) for n, each in self._rows.items()}
        time, moved, frame = rows.pop("time"), rows.pop("moved"), structure.frame
        peak = peak_of(time, rows["displacement"])
        warnings = []
        if self.watch.turned is not None:
            if not peak:
                raise self.watch.turned
            warnings.append(finding("hangs-on", reason=self.watch.turned.reason))
        taken = float(rows["contact_loss"][-1]) / self.given
        if taken > HEAVY:
            warnings.append(finding("heavy-node", taken, taken=taken))
        lost = float(np.abs(rows["balance_error"]).max()) / self.given
        if lost > NO_LEDGER:
            raise SolverError("the energy balance of OpenSees", lost, "its steps: reduce them")
        if lost > OPEN:
            warnings.append(finding("energy-balance", lost, error=lost))
        if structure.assembly.axes == 3:
            del rows["moment"]  # about two axes
        if not structure.is_column:
            rows["residual_displacement"] = None  # takes periods of the sway to find
        for name, (dof, sign) in structure.watched.items():
            rows[name] = sign * moved[dof]
        shown = np.unique(np.linspace(0, len(time) - 1, PICTURES).round().astype(int))
        shown = np.union1d(shown, int(np.argmax(np.abs(rows["displacement"]))))
        shapes = []
        for row in shown:
            structure.assembly.displacement[:] = moved[:, row]
            shapes.append(structure.members.shapes(structure.assembly))
        drawn = np.stack(shapes, axis=-1)  # (members, points, axes, snapshots)
        response = build_response(
            {
                **rows,
                **{f"shape_{'xyz'[k]}": drawn[:, :, k] for k in range(drawn.shape[2])},
                "snapshot_at": time[shown],
                "input_energy": self.given,
            },
            time=time,
            hinges=structure.hinges or hinge_names(frame),
            members=member_names(frame),
            warnings=warnings,
        )
        lengths = structure.members.elements.lengths
        response.attrs.update(elements=len(lengths), time_step=float(np.diff(time).max()))
        return response
