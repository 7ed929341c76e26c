"""Reference in space: a column of co-rotational fiber beams, hit from any side.

The section is turned about the axis of the column, so that the hit stays along x and what the
column does sideways is along z. Fibers lie in both directions; torsion is elastic, by St Venant.
"""

from dataclasses import dataclass, replace
from math import cos, radians, sin
from typing import ClassVar

import numpy as np

from workbench.base.arrays import Array
from workbench.base.fields import Number, checked
from workbench.mechanics.frames.structure import FrameStructure, apply_dead_loads
from workbench.mechanics.structures.fibers.section import LinearHardening
from workbench.mechanics.structures.space import (
    SpaceAssembly,
    SpaceBeams,
    SpaceSection,
    space_fibers,
)
from workbench.models.frame_model import as_column, as_frame
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
from workbench.responses import Response
from workbench.scenarios import ColumnImpact, ColumnScenario, Frame, FrameScenario
from workbench.steel.hinges import BiaxialSurface
from workbench.steel.sections.slenderness import torsion_constant


class SpaceMembers(FiberMembers):
    """Reads the members of a column off their fiber beams in space."""

    def __init__(self, frame: Frame, mesh: FrameMesh, beams: SpaceBeams, sampled: float) -> None:
        super().__init__(frame, mesh, beams, None, sampled, shear_yields=False)
        section = beams.sections[0]
        assert isinstance(section, SpaceSection)
        stress, area = frame.steel.yield_stress, section.area
        levers = np.ones_like(area), np.abs(section.z), np.abs(section.y)
        self._strength = stress * np.array([np.sum(lever * area) for lever in levers])
        self._surface = BiaxialSurface(frame.strength_section(frame.members[0]))

    def utilisation(self) -> Array:
        """Gauge of N, M_y and M_z (hinges,) where the end is sampled: 1 on the exact surface."""
        beams = self.elements
        assert isinstance(beams, SpaceBeams)
        forces, rows = beams.section_forces[self._ends], np.arange(len(self._ends))
        near, far = forces[rows, self._side], forces[rows, 1 - self._side]
        share = (1.0 - self._sampled) * near + self._sampled * far
        return self._surface.gauge((share / self._strength)[:, [0, 2, 1]])


@dataclass(frozen=True)
class FiberSpace(FiberReference):
    """Co-rotational fiber beam in space, of columns that are hit from any side.

    By rule the smallest element is 1/32 of the shorter member that is hit, but not below 0.1 of the
    depth; the largest one 1/40 of the column.
    """

    hardening_ratio: float = checked(
        Number(1e-9, 0.1), 1e-6, help="regularising hardening over the elastic modulus"
    )
    refinement: int = checked(REFINEMENT, 1, help="how often all elements and steps are halved")
    direction: float = checked(
        Number(0.0, 90.0, "deg"), 0.0, help="of the hit, from the height of the section"
    )

    name: ClassVar[str] = "fiber-space"
    version: ClassVar[int] = 1
    answers: ClassVar[tuple[str, ...]] = (ColumnImpact.KIND,)
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

    def solve(self, scenario: FrameScenario | ColumnScenario) -> Response:
        """Answer a scenario that is in the domain; raises as `FrameModel.solve`."""
        return self.run(as_frame(scenario), self.structure(scenario))

    def structure(self, scenario: ColumnScenario | FrameScenario) -> FrameStructure:
        """The column under its dead loads. Raises `SolverError`."""
        frame = as_frame(scenario).frame
        mesh = mesh_frame(frame, self.lengths(scenario))
        beams = self.fibers(frame, mesh)
        flat = np.zeros((len(mesh.coordinates), 1))
        assembly = SpaceAssembly(np.concatenate([mesh.coordinates, flat], axis=1), [beams])
        for number, node in enumerate(frame.nodes):
            if "u" in node.held:
                across = ["w", "turn_y", *(["turn_x"] if "rotation" in node.held else [])]
                assembly.hold([assembly.dof(number, component) for component in across])
        members = SpaceMembers(frame, mesh, beams, self.sampled)
        column = as_column(apply_dead_loads(frame, assembly, members))
        hit = frame.number["hit"]
        beside = {"sideways": (assembly.dof(hit, "w"), 1.0)}
        beside["twist"] = assembly.dof(hit, "turn_y"), 1.0
        return replace(column, watched={**column.watched, **beside})

    def fibers(self, frame: Frame, mesh: FrameMesh) -> SpaceBeams:
        """Co-rotational beams, the height of whose section is turned away from the hit."""
        steel, member, turned = frame.steel, frame.members[0], radians(self.direction)
        section = frame.strength_section(member)
        places = space_fibers(section, self.layers)
        hardening = steel.hardening_modulus or self.hardening_ratio * steel.elastic_modulus
        fibers = SpaceSection(
            y=places.y,
            area=places.area,
            law=LinearHardening(
                steel.elastic_modulus, steel.yield_stress, hardening, rate=steel.rate
            ),
            mass_per_length=frame.properties(member).mass_per_length,
            z=places.z,
            torsion=steel.shear_modulus * torsion_constant(section.shape),
        )
        height = -cos(turned), 0.0, sin(turned)
        return SpaceBeams(mesh.nodes, np.zeros_like(mesh.member), [fibers], height)
