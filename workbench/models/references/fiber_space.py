"""Models in space, and their reference: co-rotational fiber beams, hit from any side.

The section of a column is turned about its axis, and a frame as a whole, so that the hit stays
along x and what the column does sideways is along z. Fibers lie in both directions; torsion is
elastic, by St Venant.
"""

from abc import abstractmethod
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from math import cos, sin
from typing import Any, ClassVar, NamedTuple

import numpy as np

from workbench.base.arrays import Array
from workbench.base.fields import Number, checked
from workbench.mechanics.frames.members import LAYERS, NAMED
from workbench.mechanics.frames.structure import (
    FrameStructure,
    apply_dead_loads,
    free_to_spin,
    in_space,
)
from workbench.mechanics.structures.space import (
    SpaceAssembly,
    SpaceBeams,
    SpaceElements,
    SpaceSection,
    space_fibers,
)
from workbench.models.frame_model import FrameModel, as_column, as_frame
from workbench.models.references.fiber import (
    CLASSICAL_RULE,
    FiberMembers,
    FiberReference,
    FrameMesh,
    MeshRule,
    mesh_frame,
)
from workbench.models.references.fiber_beams import INTERPOLATED, SAMPLED
from workbench.models.references.refine import REFINEMENT
from workbench.responses import Finding, Response, finding
from workbench.scenarios import (
    ColumnImpact,
    ColumnScenario,
    Frame,
    FrameImpact,
    FramePulse,
    FrameScenario,
    Member,
)
from workbench.scenarios.frame_events import azimuth, facing
from workbench.scenarios.parts import HELD_BESIDE, PINNED, RIGID
from workbench.steel.hinges.interaction import surface_in_space
from workbench.steel.sections.slenderness import twist_stiffness

BESIDE = {"sideways": "w", "twist": "turn_y"}  # histories of a column by component


class SpaceMembers(FiberMembers):
    """Reads members off their elements in space, of a frame the resultants about both axes."""

    def __init__(self, placed: "Placed", beams: Any, sampled: float, *, resultant: bool) -> None:
        frame = placed.frame
        super().__init__(frame, placed.mesh, beams, None, sampled, shear_yields=False)
        self._resultant = resultant
        both = [frame.about_both(member) for member in frame.members]
        strengths = [(s.squash_load, w.plastic_moment, s.plastic_moment) for s, w in both]
        self._strength = np.repeat(strengths, 2, axis=0)
        sections = [frame.strength_section(member).about("strong") for member in frame.members]
        distinct = list(dict.fromkeys(sections))
        rows = np.repeat([distinct.index(each) for each in sections], 2)
        self._surfaces = [
            (surface_in_space(each), np.flatnonzero(rows == i)) for i, each in enumerate(distinct)
        ]

    def moments(self) -> Array:
        """Bending moments (hinges,)."""
        if not self._resultant:
            return super().moments()
        beams: Any = self.elements
        ends = beams.section_forces[..., self._ends, self._side, 1:]
        return np.asarray(np.linalg.norm(ends, axis=-1))

    def plastic_rotations(self) -> Array:
        """Plastic rotations (hinges,) of the half members next to the ends."""
        if not self._resultant:
            return super().plastic_rotations()
        beams: Any = self.elements
        turns = np.moveaxis(beams.plastic_turns(), -1, 0)
        return np.asarray(np.hypot(*(self._near_ends(each) for each in turns)))

    def utilisation(self) -> Array:
        """Gauge of N, M_y and M_z (hinges,) where the end is sampled: 1 on the exact surface."""
        beams: Any = self.elements
        forces, rows = beams.section_forces[..., self._ends, :, :], np.arange(len(self._ends))
        near, far = forces[..., rows, self._side, :], forces[..., rows, 1 - self._side, :]
        share = ((1.0 - self._sampled) * near + self._sampled * far) / self._strength
        used = np.zeros(share.shape[:-1])
        for surface, alike in self._surfaces:
            used[..., alike] = surface.gauge(share[..., alike, :][..., [0, 2, 1]])
        return used


class Placed(NamedTuple):
    """A frame in space, meshed.

    `heights` (elements, 3), directions of that of the section; `axes` (elements, 2, 3, 3) of dofs.
    """

    frame: Frame
    mesh: FrameMesh
    heights: Array
    axes: Array

    def stand(
        self, beams: SpaceElements, held: Iterable[tuple[str, str]], sampled: float, *, column: bool
    ) -> FrameStructure:
        """Bring the dead loads on the elements. Raises `SolverError`.

        Arguments: what is `held` beside a plane, nodes and components; `sampled`, where an element
        samples plasticity, from its end over its length; whether it stands for a `column`.
        """
        assembly = SpaceAssembly(self.mesh.coordinates, [beams])
        assembly.hold([assembly.dof(self.frame.number[name], part) for name, part in held])
        members = SpaceMembers(self, beams, sampled, resultant=not column)
        structure = apply_dead_loads(self.frame, assembly, members)
        if not column:
            return structure
        hit = self.frame.number["hit"]
        beside = {name: (assembly.dof(hit, part), 1.0) for name, part in BESIDE.items()}
        column_structure = as_column(structure)
        return replace(column_structure, watched={**column_structure.watched, **beside})


def _meshed(frame: Frame, lengths: list[Array]) -> FrameMesh:
    mesh = mesh_frame(frame, lengths)
    return mesh._replace(coordinates=in_space(mesh.coordinates))


def place_column(scenario: ColumnImpact, lengths: list[Array]) -> Placed:
    """A column whose section is turned away from the hit; `lengths` (m) of its elements.

    Dofs at supports lie along the axes of the section.
    """
    column = scenario.column.bent_about("strong")
    frame = as_frame(scenario.unchecked(column=column)).frame
    mesh = _meshed(frame, lengths)
    c, s = cos(scenario.angle_from_height), sin(scenario.angle_from_height)
    turned = np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])
    supports = np.isin(mesh.nodes, [frame.number[name] for name in ("base", "head")])
    axes = np.where(supports[:, :, None, None], turned, np.eye(3))
    return Placed(frame, mesh, np.tile((-c, 0.0, s), (len(mesh.nodes), 1)), axes)


def place_frame(frame: Frame, lengths: list[Array]) -> Placed:
    """A frame in space; `lengths` (m) of its elements, which know by themselves where pins are."""
    members = (m.unchecked(joint_start=RIGID.name, joint_end=RIGID.name) for m in frame.members)
    mesh = _meshed(frame.unchecked(members=tuple(members)), lengths)
    axes = np.broadcast_to(np.eye(3), (len(mesh.nodes), 2, 3, 3))
    return Placed(frame, mesh, frame.heights[mesh.member], axes)


def held_by_ends(scenario: ColumnImpact) -> Iterator[tuple[str, str]]:
    """Nodes and what the ends of a column hold of them beside the plane of the hit."""
    ends = scenario.column.bent_about("strong").ends_about("weak")
    for name, end in zip(("base", "head"), ends, strict=True):
        turn = [] if end == "pinned" else ["turn_x"]
        yield from ((name, part) for part in ("w", "turn_y", *turn))


def held_beside(frame: Frame) -> Iterator[tuple[str, str]]:
    """Nodes and what supports hold of them beside a plane, and turns that nothing resists.

    A frame that stays in its plane is held in it by any support.
    """
    for node in frame.nodes:
        held = ("w", "turn_x", "turn_y") if node.held and not frame.spatial else node.held_beside
        yield from ((node.name, part) for part in held)
    for number in free_to_spin(frame):
        yield from ((frame.nodes[number].name, part) for part in ("turn_x", "turn_y"))


def place(
    scenario: ColumnScenario | FrameScenario, lengths: list[Array]
) -> tuple[Placed, Iterator[tuple[str, str]]]:
    """A column or frame in space, and what is held of it beside a plane; `lengths` (m)."""
    if isinstance(scenario, ColumnImpact):
        return place_column(scenario, lengths), held_by_ends(scenario)
    frame = as_frame(scenario).frame
    return place_frame(frame, lengths), held_beside(frame)


class SpaceModel(FrameModel):
    """A model of columns and frames in space, which a face with friction does not suit.

    Frames are turned so that what acts on them lies along x, and their pictures back.
    """

    answers: ClassVar[tuple[str, ...]] = (ColumnImpact.KIND, FrameImpact.KIND, FramePulse.KIND)
    spatial: ClassVar[bool] = True
    pins: ClassVar[bool] = False
    sampled: ClassVar[float]

    @abstractmethod
    def bars(self, placed: Placed) -> SpaceElements:
        """The elements of a frame in space."""

    def domain(self, scenario: ColumnScenario | FrameScenario) -> list[Finding]:
        """Findings of all such models, buckling about the weaker axis, a face with friction."""
        friction = getattr(getattr(scenario, "striker", None), "friction", 0.0)
        rubs = [finding("face-friction", friction, name=self.name)] if friction > 0.0 else []
        if isinstance(scenario, ColumnImpact):
            return super().domain(scenario.unchecked(column=scenario.column.weaker)) + rubs
        event = facing(as_frame(scenario))
        unknown = space_parts(event, pins=self.pins)
        if unknown:
            named = ", ".join(unknown[:NAMED])
            return [finding("space-parts", len(unknown), name=self.name, unknown=named)]
        return super().domain(event) + rubs

    def structure(self, scenario: ColumnScenario | FrameScenario) -> FrameStructure:
        """The column or frame under its dead loads. Raises `SolverError`."""
        placed, held = place(scenario, self.lengths(scenario))
        column = isinstance(scenario, ColumnImpact)
        return placed.stand(self.bars(placed), held, self.sampled, column=column)

    def solve(self, scenario: FrameScenario | ColumnScenario) -> Response:
        """Answer a scenario that is in the domain; raises as `FrameModel.solve`."""
        if isinstance(scenario, ColumnImpact):
            return self.run(as_frame(scenario), self.structure(scenario))
        frame = as_frame(scenario)
        event, turn = facing(frame), azimuth(frame)
        response = self.run(event, self.structure(event))
        turn_shapes(response, turn)
        return response


def turn_shapes(response: Response, turn: float) -> None:
    """Turn the pictures of a frame that was turned so that what acts lies along x (rad) back."""
    x, z = response["shape_x"], response["shape_z"]
    moved = cos(turn) * x - sin(turn) * z, cos(turn) * z + sin(turn) * x
    for name, values in zip(("shape_x", "shape_z"), moved, strict=True):
        response[name] = values.assign_attrs(response[name].attrs)


def space_parts(scenario: FrameScenario, *, pins: bool) -> list[str]:
    """Parts that models in space do not know, in words; `pins` that they know.

    Of a frame that stays in its plane these are joints alone.
    """
    frame = scenario.frame
    known = {RIGID.name, PINNED.name} if pins else {RIGID.name}
    joints = dict.fromkeys(n for m in frame.members for n in (m.joint_start, m.joint_end))
    parts = [f"joint {name}" for name in joints if name not in known]
    if not frame.spatial:
        return parts
    for node in frame.nodes:
        if node.support not in ("free", *HELD_BESIDE):
            parts.append(f"support {node.support} of node {node.name}")
        sprung = node.spring_x or node.spring_rotation
        parts += [f"spring of node {node.name}"] if sprung else []
        parts += [f"lock of node {node.name}"] if node.locked == "x" else []
    loads = (*frame.loads, *getattr(scenario, "loads", ()))
    parts += [f"load along x on node {each.node}" for each in loads if each.x]
    parts += [f"moment on node {each.node}" for each in loads if each.moment]
    return parts + [f"load along x on member {m.name}" for m in frame.members if m.load_x]


@dataclass(frozen=True)
class FiberSpace(SpaceModel, FiberReference):
    """Co-rotational fiber beam in space, of columns that are hit from any side.

    By rule the smallest element is 1/32 of the shorter member that is hit, but not below 0.1 of the
    depth; the largest one 1/40 of the column.
    """

    hardening_ratio: float = checked(
        Number(1e-9, 0.1), 1e-6, help="regularising hardening over the elastic modulus"
    )
    layers: int = checked(LAYERS, 12, help="over the depth and across flanges")
    refinement: int = checked(REFINEMENT, 1, help="how often all elements and steps are halved")

    name: ClassVar[str] = "fiber-space"
    version: ClassVar[int] = 2
    assumptions: ClassVar[tuple[str, ...]] = (
        "Plane sections; cubic deflections between nodes; large displacements and rotations.",
        "Elastic-perfectly plastic fibers, plasticity from normal stress alone.",
        "Rigid in shear; elastic torsion by St Venant, whose ends are held: warping is left out.",
        "Elastic stiffness and strength are both those of the fibers (column.fillets applies to "
        "both); the mass is that of the rolled profile, its rotary inertia about the strong axis "
        "counts about every axis.",
        "Point contact on the axis with a face that lets the column slide along it; no local "
        "denting, no local buckling, no fracture; strain rate and hardening as the steel has them.",
    )
    material: ClassVar[tuple[str, ...]] = ("rate", "hardening")
    sources: ClassVar[tuple[str, ...]] = ("heng2017", "battini-pacoste2002")
    sampled: ClassVar[float] = SAMPLED[INTERPOLATED]

    def mesh_rule(self, scenario: FrameScenario) -> MeshRule:
        """Sizes of elements where no option gives them."""
        return CLASSICAL_RULE

    def fibers(self, frame: Frame, mesh: FrameMesh) -> SpaceBeams:
        """Co-rotational beams of a frame in its plane."""
        return self.bars(place_frame(frame, np.split(mesh.lengths, mesh.first[1:-1])))

    def bars(self, placed: Placed) -> SpaceBeams:
        """Co-rotational beams with fibers in both directions."""
        frame, mesh = placed.frame, placed.mesh
        sections = [self.section(frame, member) for member in frame.members]
        return SpaceBeams(mesh.nodes, mesh.member, sections, placed.heights, axes=placed.axes)

    def section(self, frame: Frame, member: Member) -> SpaceSection:
        """The fibers of a member in both directions."""
        section = frame.strength_section(member).about("strong")
        fibers, twist = space_fibers(section, self.layers), twist_stiffness(section, frame.steel)
        mass = frame.properties(member).mass_per_length
        given: Any = {**fibers._asdict(), "mass_per_length": mass, "torsion": twist}
        return SpaceSection(law=self.law(frame.steel), **given)
