"""Reference in space: a column of co-rotational fiber beams, hit from any side.

The section is turned about the axis of the column, so that the hit stays along x and what the
column does sideways is along z. Fibers lie in both directions; torsion is elastic, by St Venant.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import cos, pi, sin
from typing import Any, ClassVar, NamedTuple

import numpy as np

from workbench.base.arrays import Array
from workbench.base.fields import Number, checked
from workbench.mechanics.frames.members import LAYERS
from workbench.mechanics.frames.structure import FrameStructure, apply_dead_loads
from workbench.mechanics.structures.fibers.section import LinearHardening
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
from workbench.scenarios import ColumnImpact, ColumnScenario, Frame, FrameScenario
from workbench.steel.hinges import BiaxialSurface
from workbench.steel.sections import AXES
from workbench.steel.sections.slenderness import torsion_constants


class SpaceMembers(FiberMembers):
    """Reads the members of a column off their elements in space."""

    def __init__(self, frame: Frame, mesh: FrameMesh, beams: Any, sampled: float) -> None:
        super().__init__(frame, mesh, beams, None, sampled, shear_yields=False)
        section = frame.strength_section(frame.members[0])
        about_both = [section.about(axis).plastic_moment(frame.steel) for axis in reversed(AXES)]
        self._strength = np.array([section.squash_load(frame.steel), *about_both])
        self._surface = BiaxialSurface(section)

    def utilisation(self) -> Array:
        """Gauge of N, M_y and M_z (hinges,) where the end is sampled: 1 on the exact surface."""
        beams: Any = self.elements
        forces, rows = beams.section_forces[..., self._ends, :, :], np.arange(len(self._ends))
        near, far = forces[..., rows, self._side, :], forces[..., rows, 1 - self._side, :]
        share = (1.0 - self._sampled) * near + self._sampled * far
        return self._surface.gauge((share / self._strength)[..., [0, 2, 1]])


class Turned(NamedTuple):
    """A column whose section is turned away from the hit, meshed.

    Its `frame`, bent about the strong axis; `mesh`; `height` (3,), direction of that of the
    section; `axes` (elements, 2, 3, 3) of dofs: at supports those of the section.
    """

    frame: Frame
    mesh: FrameMesh
    height: tuple[float, float, float]
    axes: Array


def stand_in_space(
    scenario: ColumnImpact,
    lengths: list[Array],
    elements: Callable[[Turned], SpaceElements],
    sampled: float,
) -> FrameStructure:
    """A column in space under its dead loads. Raises `SolverError`.

    Arguments: `lengths` (m) of the elements below and above the impact point; `elements`, makes
    them; `sampled`, where an element samples plasticity, from its end and over its length.
    """
    column = scenario.column.bent_about("strong")
    angle = scenario.striker.angle + (0.5 * pi if scenario.column.axis == "weak" else 0.0)
    frame = as_frame(scenario.unchecked(column=column)).frame
    mesh = mesh_frame(frame, lengths)
    base, hit, head = (frame.number[name] for name in ("base", "hit", "head"))
    c, s = cos(angle), sin(angle)
    turned = np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])
    supports = np.isin(mesh.nodes, [base, head])[:, :, None, None]
    beams = elements(Turned(frame, mesh, (-c, 0.0, s), np.where(supports, turned, np.eye(3))))
    flat = np.zeros((len(mesh.coordinates), 1))
    assembly = SpaceAssembly(np.concatenate([mesh.coordinates, flat], axis=1), [beams])
    for number, end in zip((base, head), column.ends_about("weak"), strict=True):
        turn = [] if end == "pinned" else ["turn_x"]
        assembly.hold([assembly.dof(number, name) for name in ("w", "turn_y", *turn)])
    members = SpaceMembers(frame, mesh, beams, sampled)
    structure = as_column(apply_dead_loads(frame, assembly, members))
    beside = {
        "sideways": (assembly.dof(hit, "w"), 1.0),
        "twist": (assembly.dof(hit, "turn_y"), 1.0),
    }
    return replace(structure, watched={**structure.watched, **beside})


class SpaceModel(FrameModel):
    """A model of columns in space, which a face with friction does not suit."""

    answers: ClassVar[tuple[str, ...]] = (ColumnImpact.KIND,)
    spatial: ClassVar[bool] = True

    def domain(self, scenario: ColumnScenario | FrameScenario) -> list[Finding]:
        """Findings of all such models, buckling about the weaker axis, a face with friction."""
        assert isinstance(scenario, ColumnImpact)
        findings = super().domain(scenario.unchecked(column=scenario.column.weaker))
        friction = scenario.striker.friction
        rubs = [finding("face-friction", friction, name=self.name)] if friction > 0.0 else []
        return findings + rubs

    def solve(self, scenario: FrameScenario | ColumnScenario) -> Response:
        """Answer a scenario that is in the domain; raises as `FrameModel.solve`."""
        return self.run(as_frame(scenario), self.structure(scenario))


@dataclass(frozen=True)
class FiberSpace(SpaceModel, FiberReference):
    """Co-rotational fiber beam in space, of columns that are hit from any side.

    By rule the smallest element is 1/32 of the shorter member that is hit, but not below 0.1 of the
    depth; the largest one 1/40 of the column.
    """

    hardening_ratio: float = checked(
        Number(1e-9, 0.1), 1e-6, help="regularising hardening over the elastic modulus"
    )
    layers: int = checked(LAYERS, 12, help="over the depth and across flanges, an even number")
    refinement: int = checked(REFINEMENT, 1, help="how often all elements and steps are halved")

    name: ClassVar[str] = "fiber-space"
    version: ClassVar[int] = 1
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

    def structure(self, scenario: ColumnScenario | FrameScenario) -> FrameStructure:
        """The column under its dead loads. Raises `SolverError`."""
        assert isinstance(scenario, ColumnImpact)
        return stand_in_space(scenario, self.lengths(scenario), self._beams, self.sampled)

    def fibers(self, frame: Frame, mesh: FrameMesh) -> SpaceBeams:
        """Co-rotational beams, the height of whose section is along the hit."""
        axes = np.broadcast_to(np.eye(3), (len(mesh.nodes), 2, 3, 3))
        return self._beams(Turned(frame, mesh, (-1.0, 0.0, 0.0), axes))

    def _beams(self, column: Turned) -> SpaceBeams:
        frame, mesh = column.frame, column.mesh
        steel, member = frame.steel, frame.members[0]
        section = frame.strength_section(member)
        places = space_fibers(section, self.layers)
        hardening = steel.hardening_modulus or self.hardening_ratio * steel.elastic_modulus
        law = LinearHardening(steel.elastic_modulus, steel.yield_stress, hardening, rate=steel.rate)
        fibers = SpaceSection(
            y=places.y,
            area=places.area,
            law=law,
            mass_per_length=frame.properties(member).mass_per_length,
            z=places.z,
            torsion=steel.shear_modulus * torsion_constants(section)[0],
        )
        number = np.zeros_like(mesh.member)
        return SpaceBeams(mesh.nodes, number, [fibers], column.height, axes=column.axes)
