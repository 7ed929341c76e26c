"""Decks of a struck column for CalculiX and Abaqus/Standard: the same but for a few lines.

The axial load grows, over a period of the column along its axis, while the striker flies: so the
column is nearly at rest when it is hit. The spring at the head is unstressed under that load. The
striker, a mass on a line along the hit, presses through a spring without tension. Von Mises
plasticity, large displacements, implicit steps of Hilber, Hughes and Taylor with the damping that
the programs take by themselves (alpha = -0.05).

Pitfalls of CalculiX 2.20: C3D8I diverges in plastic steps; an initial stress counts twice in an
elastic-plastic brick; a static step before the hit stops the striker; a first number without a
point below *SPRING is read as a dof; steps of more than 0.2 ms diverge at the struck edge.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import cos, sin
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from workbench.base.errors import InputError
from workbench.base.fields import Choice, Declared, Number, checked
from workbench.extras.exchange.meshes import MESHES, DeckMesh
from workbench.mechanics.frames.members import override_findings
from workbench.models.base import with_options
from workbench.models.references.shell.mesh import face_of, target_of
from workbench.models.references.solid.model import section_values
from workbench.responses import Finding
from workbench.scenarios import Column, ColumnImpact, Scenario, frame_of
from workbench.steel.materials import POISSON_RATIO
from workbench.steel.sections import AXES
from workbench.study.store import write_atomically

FACE = (0.12, 0.12)  # m, across and along the column, as of `shell`
_SMALL = 1e-9  # cosine of a direction that an equation leaves out
_RUN = {"calculix": "ccx -i {}", "abaqus": "abaqus job={}"}
_DOFS = {"CPS8R": 2, "C3D20R": 3, "S8R": 6}  # of a node


@dataclass(frozen=True)
class DeckChoices(Declared, table="option"):
    """Choices of a deck: its program and mesh, where the striker presses, its steps."""

    program: str = checked(Choice(tuple(_RUN)), "calculix")
    mesh: str = checked(Choice(tuple(MESHES)), "plane-stress")
    refinement: int = checked(
        Number(-1, 3, integer=True), 0, help="how often all elements are halved (-1: doubled)"
    )
    struck: str = checked(
        Choice(("section", "face")),
        "section",
        help="the section as one, as in plane references, or 0.12 x 0.12 m of the flange",
    )
    step: float = checked(Number(1e-7, 1e-3, "s"), 1e-4, help="longest one")
    contact: float = checked(
        Number(1e6, 1e13, "N/m"), 5e9, help="stiffness that a rigid striker presses through"
    )

    @property
    def is_plane(self) -> bool:
        """Whether the column stays in its plane."""
        return self.mesh == "plane-stress"

    def check_scenario(self, scenario: Scenario) -> ColumnImpact:
        """The scenario, if the deck can carry it. Raises `InputError` naming what it cannot."""
        if not isinstance(scenario, ColumnImpact):
            text = f"must be {ColumnImpact.KIND}: a deck holds one struck column"
            raise InputError("kind", scenario.KIND, text, "take --to vtu for others")
        column, striker, law = scenario.column, scenario.striker, scenario.column.steel.rate
        section, solid = column.strength_section.about("strong"), "take --mesh bricks or shells"
        for number, name in enumerate(("base", "head")):
            if "pinned" in [column.ends_about(axis)[number] for axis in AXES]:
                text = "must not be pinned: the end of a deck is no plate that turns"
                raise column.refusal(name, text, "take a clamped base, a guided or fixed head")
        if law is not None and self.program == "calculix":
            text = "must be none: CalculiX has no such law of strain rate"
            raise InputError("steel.rate", law, text, "--set steel.rate=none, or --to abaqus")
        if scenario.acceleration:
            text = "must be horizontal: a deck leaves weight out"
            raise InputError("striker.direction", scenario.direction, text, "--set gravity=false")
        for name in ("restitution", "friction"):
            if getattr(striker, name):
                raise striker.refusal(name, "must be 0 in a deck", f"--set striker.{name}=0")
        if self.is_plane and striker.angle:
            raise striker.refusal("angle", "must be 0 in plane stress", solid)
        if self.is_plane and self.struck == "face":
            raise self.refusal("struck", "must be section in plane stress", solid)
        if striker.eccentricity and self.struck == "section":
            text = "must be 0 where the struck section moves as one"
            raise striker.refusal("eccentricity", text, f"--option struck=face, and {solid}")
        if target_of(section, scenario.angle_from_height, striker.eccentricity).room < 0.0:
            raise striker.refusal("eccentricity", "must be less: it misses the column")
        return scenario


class MoreNodes(NamedTuple):
    """Numbers of the nodes that are no places of the mesh."""

    head: int
    face: int
    striker: int

    @classmethod
    def after(cls, mesh: DeckMesh) -> "MoreNodes":
        """The numbers after those of a mesh, which begin with 1."""
        return cls(*(len(mesh.places) + number for number in (1, 2, 3)))


def flight(column: Column) -> float:
    """Time in s before the hit: a period of the column along its axis."""
    stiffness = column.strength_section.area * column.steel.elastic_modulus
    return float(4.0 * column.length * np.sqrt(column.properties.mass_per_length / stiffness))


def write_deck(scenario: Scenario, target: Path, **options: Any) -> tuple[str, list[Finding]]:
    """Write the deck of a struck column; options are those of `DeckChoices`.

    Gives a sentence on how to run it, and what of the scenario it does not follow. Raises
    `InputError` for what a deck cannot carry.
    """
    choices: DeckChoices = with_options(DeckChoices, options)
    impact = choices.check_scenario(scenario)
    mesh = MESHES[choices.mesh](impact.column, choices.refinement)
    write_atomically(target, deck_text(impact, mesh, choices).encode())
    count, run = sum(len(each.nodes) for each in mesh.plates), _RUN[choices.program]
    findings = override_findings(frame_of(impact.column), section_values, "the deck comes")
    return f"{count} elements {mesh.kind}; run {run.format(target.stem)}", findings


def deck_text(scenario: ColumnImpact, mesh: DeckMesh, choices: DeckChoices) -> str:
    """Text of the deck of a scenario that `DeckChoices.check_scenario` took."""
    blocks = (
        *_head(scenario, mesh, choices),
        *_body(mesh, scenario),
        *_material(scenario.column),
        *_supports(mesh, scenario.column),
        *_pressed(scenario, mesh, choices),
        *_springs_and_masses(scenario, mesh, choices),
        *_history(scenario, mesh, choices),
    )
    return "\n".join(blocks) + "\n"


def _head(scenario: ColumnImpact, mesh: DeckMesh, choices: DeckChoices) -> Iterator[str]:
    """The deck in words, which nodes to look at, and how it is run."""
    more, rise = MoreNodes.after(mesh), flight(scenario.column)
    run = _RUN[choices.program].format("NAME")
    yield f"** {scenario.name}"
    yield f"** struck column, {choices.mesh}, in m, N, kg, s; run {run}"
    yield "** x: height of the section, y: axis of the column from the base on, -z: width"
    yield f"** node {more.face}: struck {choices.struck}, displacement 1 is that along the hit"
    yield f"** node {more.head}: head, displacement 2 is minus the shortening"
    yield f"** node {more.striker}: striker; it hits after {rise:.9g} s, when the axial load is on"


def _body(mesh: DeckMesh, scenario: ColumnImpact) -> Iterator[str]:
    """Nodes and elements."""
    head, before = (0.0, scenario.column.length + 1.0, 0.0), -_reach(scenario)
    places = [*mesh.places, head, (0.0, -1.0, 0.0), (before, -1.0, 0.0)]
    yield "*NODE, NSET=ALL"
    yield from (f"{n}, {x:.9f}, {y:.9f}, {z:.9f}" for n, (x, y, z) in enumerate(places, 1))
    first, kind = 1, "SHELL" if mesh.kind == "S8R" else "SOLID"
    for number, (nodes, thickness) in enumerate(mesh.plates, 1):
        yield f"*ELEMENT, TYPE={mesh.kind}, ELSET=PLATE{number}"
        yield from (_rows([n, *each], 11) for n, each in enumerate(nodes + 1, first))
        yield f"*{kind} SECTION, ELSET=PLATE{number}, MATERIAL=STEEL"
        if thickness is not None:
            yield f"{thickness:.9f}"
        first += len(nodes)
    yield "*ELSET, ELSET=STEEL"
    yield from (f"PLATE{number}," for number in range(1, len(mesh.plates) + 1))


def _reach(scenario: ColumnImpact) -> float:
    """Distance in m that the striker cannot fly within the record, length of its spring."""
    return 1.0 + scenario.striker.velocity * (flight(scenario.column) + scenario.duration)


def _material(column: Column) -> Iterator[str]:
    """Steel, elastic and plastic; the density gives the mass of the rolled profile."""
    steel, density = column.steel, column.properties.mass_per_length / column.strength_section.area
    top = steel.yield_stress + (steel.hardening_modulus or 0.0)
    yield f"*MATERIAL, NAME=STEEL\n*ELASTIC\n{steel.elastic_modulus:.9e}, {POISSON_RATIO}"
    yield f"** gives the mass of the rolled profile to what is meshed\n*DENSITY\n{density:.9e}"
    yield f"*PLASTIC\n{steel.yield_stress:.9e}, 0.\n{top:.9e}, 1."
    if steel.rate is not None:
        law = steel.rate
        yield "** Cowper and Symonds\n*RATE DEPENDENT, TYPE=POWER LAW"
        yield f"{law.reference_rate:.9e}, {law.exponent:.9e}"


def _supports(mesh: DeckMesh, column: Column) -> Iterator[str]:
    """Clamped base; a head that keeps its section and moves along the axis alone."""
    more, last = MoreNodes.after(mesh), _DOFS[mesh.kind]
    base, head = mesh.at(0.0), mesh.at(column.length)
    yield "** the base is clamped, the head keeps its section and moves along the axis alone"
    yield "*BOUNDARY"
    yield from (f"{node}, 1, {last}" for node in base)
    yield from (f"{node}, 1, 1" for node in (*head, more.head))
    yield from (f"{node}, 3, {last}" for node in head if last > 2)
    yield f"{more.head}, 3, 3\n{more.face}, 2, 3\n{more.striker}, 2, 3"
    yield from (_equation([(node, 2, 1.0), (more.head, 2, -1.0)]) for node in head)


def _pressed(scenario: ColumnImpact, mesh: DeckMesh, choices: DeckChoices) -> Iterator[str]:
    """The part of the column that the striker meets, tied to one node."""
    column, face = scenario.column, MoreNodes.after(mesh).face
    angle = 0.0 if choices.is_plane else scenario.angle_from_height
    ways = [(dof, x) for dof, x in ((1, cos(angle)), (3, -sin(angle))) if abs(x) > _SMALL]
    if choices.struck == "section":
        yield "** the struck section moves along the hit as one"
        for node in mesh.at(column.length_below):
            yield _equation([*((node, *way) for way in ways), (face, 1, -1.0)])
        return
    yield "** the striker presses evenly on a face and moves as the mean of it"
    seen = np.flatnonzero(mesh.planes)
    part: Any = mesh._replace(places=mesh.places[seen])
    section, eccentricity = column.strength_section.about("strong"), scenario.striker.eccentricity
    target = target_of(section, angle, eccentricity)
    near = part.section[np.abs(part.section[:, target.fixed] - target.level).argmin()]
    target = target._replace(level=near[target.fixed])  # fillets put the flanges of bricks inwards
    met = zip(*face_of(part, column.length_below, FACE, target), strict=True)
    terms = [(seen[node] + 1, dof, x * share) for node, share in met for dof, x in ways]
    yield _equation([(face, 1, -1.0), *terms])


def _springs_and_masses(
    scenario: ColumnImpact, mesh: DeckMesh, choices: DeckChoices
) -> Iterator[str]:
    """Striker, masses on the column, the spring at the head and that of the contact."""
    column, striker, more = scenario.column, scenario.striker, MoreNodes.after(mesh)
    first = 1 + sum(len(plate.nodes) for plate in mesh.plates)
    yield "** masses: striker, on the head, on the struck part"
    masses = striker.mass, column.head_mass, column.attached_mass
    places = more.striker, more.head, more.face
    for number, (node, mass) in enumerate(zip(places, masses, strict=True)):
        if mass > 0.0:
            name = f"MASS{number}"
            yield f"*ELEMENT, TYPE=MASS, ELSET={name}\n{first + number}, {node}"
            yield f"*MASS, ELSET={name}\n{mass:.9e}"
    if column.head != "fixed" and column.restraint_stiffness:
        yield f"** spring at the head\n*ELEMENT, TYPE=SPRING1, ELSET=HEAD\n{first + 3}, {more.head}"
        yield f"*SPRING, ELSET=HEAD\n2\n{column.restraint_stiffness:.9e}"
    reach, stiffness = _reach(scenario), striker.stiffness or choices.contact
    law = striker.crush or ((0.0, 0.0), (reach, stiffness * reach))
    words = "that of a striker which gives back all it takes" if striker.crushes else "stiff"
    yield f"** contact, {words}: force over length, without tension; the gap closes in flight"
    yield f"*ELEMENT, TYPE=SPRINGA, ELSET=CONTACT\n{first + 4}, {more.striker}, {more.face}"
    yield "*SPRING, ELSET=CONTACT, NONLINEAR" + "\n" * (choices.program == "abaqus")  # no dof
    away = striker.velocity * flight(column)
    yield from (f"{0.0 - force:.9e}, {-away - stroke:.9e}" for stroke, force in reversed(law))
    yield f"0., 10.\n*INITIAL CONDITIONS, TYPE=VELOCITY\n{more.striker}, 1, {striker.velocity:.9e}"


def _history(scenario: ColumnImpact, mesh: DeckMesh, choices: DeckChoices) -> Iterator[str]:
    """One dynamic step: the load rises, the striker flies and hits."""
    column, more, rise = scenario.column, MoreNodes.after(mesh), flight(scenario.column)
    stiffness = column.strength_section.area * column.steel.elastic_modulus / column.length
    is_calculix, end = choices.program == "calculix", rise + scenario.duration
    yield f"*NSET, NSET=SEEN\n{_rows([*more, *mesh.at(column.length_below)], 8)}"
    yield f"*AMPLITUDE, NAME=RISE\n0., 0., {rise:.9e}, 1., 1000., 1."
    yield "*STEP, NLGEOM, INC=1000000\n*DYNAMIC"
    yield f"{choices.step:.9e}, {end:.9e}, 1e-9, {choices.step:.9e}"
    if is_calculix:
        yield "*CONTROLS, PARAMETERS=TIME INCREMENTATION\n5, 8, 9, 16, 10, 5, , 9, ,"
        yield "0.6, 0.6, 0.75, 0.85, , , 1.25,"
        yield "** forces over their mean, which is small\n*CONTROLS, PARAMETERS=FIELD\n0.05, 0.02"
    if column.head == "fixed":
        yield "** the head, held once it is as far as the axial load presses it"
        yield f"*BOUNDARY, AMPLITUDE=RISE\n{more.head}, 2, 2, {-column.axial_load / stiffness:.9e}"
    else:
        load = column.axial_load * (1.0 + column.restraint_stiffness / stiffness)
        yield f"** {column.axial_load:.9g} N on the column, the rest in the spring at its head"
        yield f"*CLOAD, AMPLITUDE=RISE\n{more.head}, 2, {-load:.9e}"
    yield "*NODE PRINT, NSET=SEEN\nU"
    if is_calculix:
        yield "*EL PRINT, ELSET=STEEL, TOTALS=ONLY\nELSE, ELKE"
        yield "** add *NODE FILE for pictures: a FREQUENCY there thins what is printed as well"
    else:
        yield "*ENERGY PRINT\n*OUTPUT, FIELD, VARIABLE=PRESELECT, FREQUENCY=50"
        yield "*OUTPUT, HISTORY, VARIABLE=PRESELECT\n*NODE OUTPUT, NSET=SEEN\nU"
    yield "*END STEP"


def _equation(terms: list[tuple[Any, int, float]]) -> str:
    """Equation of dofs (node, number, factor), the first of which depends on the rest."""
    texts = [f"{node}, {dof}, {factor:.12e}" for node, dof, factor in terms]
    return f"*EQUATION\n{len(terms)}\n{_rows(texts, 4)}"


def _rows(values: list[Any], most: int) -> str:
    """Values in lines of at most so many, which end in a comma but for the last."""
    parts = (values[i : i + most] for i in range(0, len(values), most))
    return ",\n".join(", ".join(map(str, part)) for part in parts)
