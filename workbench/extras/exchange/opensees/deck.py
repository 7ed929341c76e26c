"""Commands of OpenSees for a frame: nodes, fibers, elements, masses, dead loads, springs.

Members are co-rotational elements of three forms: displacement-based with two Legendre points,
force-based with Lobatto points (Spacone et al. 1996), or force-based between hinges
of a given length under modified Gauss-Radau integration (Scott and Fenves 2006), one a member.
Fibers follow Steel01; masses stand at the nodes.
"""

from collections.abc import Iterator
from math import isfinite
from typing import Any, NamedTuple

import numpy as np

from workbench.mechanics.frames.members import shear_stiffness
from workbench.mechanics.frames.structure import FrameStructure, in_space
from workbench.mechanics.structures.space import space_fibers
from workbench.models.references.fiber import FrameMesh, joint_laws
from workbench.scenarios import Frame
from workbench.scenarios.parts import COMPONENT
from workbench.steel.sections.slenderness import twist_stiffness

FORCE_BASED, DISPLACEMENT_BASED, HINGES = FORMS = ("force-based", "displacement-based", "hinges")
HINGE_SHARE = 0.125  # of a member: longer hinges than that leave nothing between them
AXES = {"u": 1, "v": 2, "w": 3, "turn_x": 4, "turn_y": 5, "rotation": 6}


Command = tuple[Any, ...]


class Commands(NamedTuple):
    """Some commands, each its name and arguments, under a `title`."""

    title: str
    commands: list[Command]


class Form(NamedTuple):
    """Elements of a deck.

    Their `element`, one of `FORMS`; `layers` of fibers over the depth; Lobatto `points`;
    `hinge_length` over the depth; `hardening` over the elastic modulus where the steel has none.
    """

    element: str
    layers: int
    points: int
    hinge_length: float
    hardening: float


class Deck(NamedTuple):
    """Commands up to the dead loads (`standing`), and those that follow them (`after`).

    `loaded`, whether there are any; `watched`, tags of the nodes that move and of force-based
    elements; `ends`, elements at the start and the end of every member.
    """

    standing: list[Commands]
    loaded: bool
    after: list[Commands]
    watched: tuple[list[int], list[int]]
    ends: list[int]


def deck_of(structure: FrameStructure, mesh: FrameMesh, heights: Any, form: Form) -> Deck:
    """Commands for a structure that stands without loads.

    Arguments: its `mesh`; directions of the heights of sections (elements, 3) in space, None in the
    plane; `form` of its elements.
    """
    frame, assembly = structure.frame, structure.assembly
    spatial = heights is not None
    size = 6 if spatial else 3
    tags = range(1, len(mesh.coordinates) + 1)
    place = {name: AXES[name] if spatial else 1 + n for name, n in assembly.components.items()}
    dofs = np.array([[assembly.dof(n, part) for part in place] for n in range(len(tags))])
    tied_parts = np.zeros(dofs.shape, dtype=bool)  # the master's
    tied_parts[[slave for _, slave in mesh.ties], : assembly.axes] = True
    masses = np.where(tied_parts, 0.0, assembly.mass_times(np.ones(assembly.size))[dofs])
    loads = np.where(tied_parts, 0.0, assembly.load[dofs])
    held = np.isin(dofs, assembly.held) & ~tied_parts
    nodes = [("node", tag, *map(float, at)) for tag, at in zip(tags, mesh.coordinates, strict=True)]
    fixed = [("fix", tags[n], *map(int, held[n])) for n in np.flatnonzero(held.any(axis=1))]
    tied = [
        ("equalDOF", master + 1, slave + 1, *range(1, assembly.axes + 1))
        for master, slave in mesh.ties
    ]
    weighty = [("mass", tag, *map(float, row)) for tag, row in zip(tags, masses, strict=True)]
    start = [("wipe",), ("model", "basic", "-ndm", assembly.axes, "-ndf", size)]
    standing = [
        Commands("Nodes, in m", start + nodes),
        Commands("Supports and joints", fixed + tied),
        Commands("Masses of nodes, in kg and kg m2", weighty),
        Commands("Steel and sections", list(_sections(frame, form, spatial=spatial))),
        Commands("Members", list(_elements(frame, mesh, heights, form))),
    ]
    joints = list(_joints(frame, mesh))
    if joints:
        standing.append(Commands("Joints that turn", joints))
    pulled = [
        ("load", tags[n], *map(float, loads[n])) for n in np.flatnonzero((loads != 0).any(axis=1))
    ]
    if pulled:
        first = [("timeSeries", "Linear", 1), ("pattern", "Plain", 1, 1)]
        standing.append(Commands("Dead loads, in N and N m", first + pulled))
    springs = list(_springs(frame, mesh, place))
    after = Commands("Springs, unstressed under the dead loads, and locks", springs)
    moving = [tags[n] for n in range(len(tags)) if not held[n].all()]
    forced = [] if form.element == DISPLACEMENT_BASED else list(range(1, len(mesh.nodes) + 1))
    ends = np.stack([mesh.first[:-1], mesh.first[1:] - 1], axis=1).ravel() + 1
    return Deck(standing, bool(pulled), [after] if springs else [], (moving, forced), ends.tolist())


def _sections(frame: Frame, form: Form, *, spatial: bool) -> Iterator[Command]:
    """One steel for all; of every member a fiber section and, between hinges, an elastic one.

    Force-based elements take elastic shear strain, which displacement-based ones do not know.
    """
    steel, count = frame.steel, len(frame.members)
    hardening = steel.hardening_modulus or form.hardening * steel.elastic_modulus
    ratio = hardening / (steel.elastic_modulus + hardening)
    yield "uniaxialMaterial", "Steel01", 1, steel.yield_stress, steel.elastic_modulus, ratio
    for number, member in enumerate(frame.members, 1):
        section = frame.strength_section(member)
        about = [section.about("strong"), section.about("weak")] if spatial else [section]
        if spatial:
            y, z, area = space_fibers(about[0], form.layers)
            twist: tuple[Any, ...] = ("-GJ", twist_stiffness(about[0], steel))
        else:
            y, area = section.fibers(form.layers)
            z, twist = np.zeros(len(y)), ()
        sheared = form.element != DISPLACEMENT_BASED
        tag = count + number if sheared else number
        yield "section", "Fiber", tag, *twist
        for fiber in zip(y, z, area, strict=True):
            yield "fiber", *map(float, fiber), 1
        if not sheared:
            continue
        pairs: list[Any] = []
        for way, each in zip(("Vy", "Vz"), about, strict=False):
            law = 2 * number + len(pairs) // 2  # behind that of the steel
            yield "uniaxialMaterial", "Elastic", law, shear_stiffness(each, steel)
            pairs += [law, way]
        yield "section", "Aggregator", number, *pairs, "-section", tag
        if form.element == HINGES:
            second = [float(np.sum(at**2 * area)) for at in (y, z)[: len(about)]]
            torsion = twist[1] / steel.shear_modulus if spatial else 0.0
            elastic = steel.elastic_modulus, float(np.sum(area)), *second, steel.shear_modulus
            shares = [shear_stiffness(each, steel) / steel.shear_modulus for each in about]
            factors = [share / elastic[1] for share in shares]
            yield "section", "Elastic", 2 * count + number, *elastic, *[torsion] * spatial, *factors


def _elements(frame: Frame, mesh: FrameMesh, heights: Any, form: Form) -> Iterator[Command]:
    """Integration of every member, and its elements."""
    displaced = form.element == DISPLACEMENT_BASED
    kind = "dispBeamColumn" if displaced else "forceBeamColumn"
    inner = () if displaced else ("-iter", 50, 1e-12)  # J
    for number, member in enumerate(frame.members, 1):
        first, last = int(mesh.first[number - 1]), int(mesh.first[number])
        if form.element == HINGES:
            wanted = form.hinge_length * frame.strength_section(member).height
            length = min(wanted, HINGE_SHARE * frame.length(member))
            hinges = number, length, number, length, 2 * len(frame.members) + number
            yield "beamIntegration", "HingeRadau", number, *hinges
        elif form.element == FORCE_BASED:
            yield "beamIntegration", "Lobatto", number, number, form.points
        else:
            yield "beamIntegration", "Legendre", number, number, 2
        beside: tuple[float, ...] = ()
        if heights is not None:  # local z, along the width: the axis times the height
            axis = in_space(frame.chords)[number - 1] / frame.length(member)
            beside = tuple(np.cross(axis, heights[first]).tolist())
        yield "geomTransf", "Corotational", number, *beside
        for element in range(first, last):
            ends = (int(node) + 1 for node in mesh.nodes[element])
            yield "element", kind, element + 1, *ends, number, number, *inner


def _joints(frame: Frame, mesh: FrameMesh) -> Iterator[Command]:
    """Rotational springs between members and their nodes, in the plane; pins need none."""
    tag = len(mesh.nodes) + 2 * len(frame.members)
    for pair, (stiffness, most, least) in joint_laws(frame, mesh):
        if stiffness == 0.0:
            continue
        tag += 1
        law: Command = ("Elastic", tag, stiffness)
        if isfinite(most) or isfinite(least):  # a bound alone: the other is never met
            most, least = min(most, 1e3 * least), min(least, 1e3 * most)
            law = "ElasticPP", tag, stiffness, most / stiffness, -least / stiffness
        yield "uniaxialMaterial", *law
        first, second = (int(node) + 1 for node in pair)
        yield "element", "zeroLength", tag, first, second, "-mat", tag, "-dir", AXES["rotation"]


def _springs(frame: Frame, mesh: FrameMesh, place: dict[str, int]) -> Iterator[Command]:
    """Springs on fixed twins of the nodes, and locks; `place` of each component, from 1.

    A zero-length element is unstressed, and a support holds, at the displacement that it is built
    at.
    """
    size, count = len(place), len(mesh.coordinates) + len(mesh.nodes) + 4 * len(frame.members)
    for number, node in enumerate(frame.nodes):
        wanted = {part: getattr(node, f"spring_{way}") for way, part in COMPONENT.items()}
        wanted = {part: stiffness for part, stiffness in wanted.items() if stiffness > 0.0}
        tag = 10 * (count + number + 1)
        if wanted:
            yield "node", tag, *mesh.coordinates[number].tolist()
            yield "fix", tag, *size * [1]
        for offset, (part, stiffness) in enumerate(wanted.items()):
            way = AXES["rotation"] if part == "rotation" else place[part]
            yield "uniaxialMaterial", "Elastic", tag + offset, stiffness
            ends = tag + offset, tag, number + 1
            yield "element", "zeroLength", *ends, "-mat", tag + offset, "-dir", way
        if node.locked != "none":
            held = place[COMPONENT[node.locked]]
            yield "fix", number + 1, *(int(dof == held) for dof in range(1, size + 1))
