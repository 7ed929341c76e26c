"""Reference in space: a column of co-rotational fiber beams, hit from any side.

The section is turned about the axis of the column, so that the hit stays along x and what the
column does sideways is along z. Fibers lie in both directions; torsion is elastic, by St Venant.
"""

from dataclasses import dataclass, replace
from math import cos, pi, sin
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
from workbench.models.seven_dof.model import about, torsion_constants
from workbench.responses import Finding, Response, finding
from workbench.scenarios import ColumnImpact, ColumnScenario, Frame, FrameScenario
from workbench.steel.hinges import BiaxialSurface
from workbench.steel.sections import AXES


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

    name: ClassVar[str] = "fiber-space"
    version: ClassVar[int] = 1
    answers: ClassVar[tuple[str, ...]] = (ColumnImpact.KIND,)
    spatial: ClassVar[bool] = True
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

    def domain(self, scenario: ColumnScenario | FrameScenario) -> list[Finding]:
        """Findings of all fibers, buckling about the weaker axis, and a face with friction."""
        assert isinstance(scenario, ColumnImpact)
        columns = [about(scenario.column, axis) for axis in AXES]
        weaker = min(columns, key=lambda column: column.euler_load(column.axis))
        findings = super().domain(scenario.unchecked(column=weaker))
        friction = scenario.striker.friction
        if friction > 0.0:
            findings.append(finding("face-friction", friction, name=self.name))
        return findings

    def solve(self, scenario: FrameScenario | ColumnScenario) -> Response:
        """Answer a scenario that is in the domain; raises as `FrameModel.solve`."""
        return self.run(as_frame(scenario), self.structure(scenario))

    def structure(self, scenario: ColumnScenario | FrameScenario) -> FrameStructure:
        """The column under its dead loads. Raises `SolverError`."""
        assert isinstance(scenario, ColumnImpact)
        column = about(scenario.column, "strong")
        angle = scenario.striker.angle + (0.5 * pi if scenario.column.axis == "weak" else 0.0)
        frame = as_frame(scenario.unchecked(column=column)).frame
        mesh = mesh_frame(frame, self.lengths(scenario))
        beams = self.fibers(frame, mesh, angle)
        flat = np.zeros((len(mesh.coordinates), 1))
        assembly = SpaceAssembly(np.concatenate([mesh.coordinates, flat], axis=1), [beams])
        base, hit, head = (frame.number[name] for name in ("base", "hit", "head"))
        for number, end in zip((base, head), column.ends_about("weak"), strict=True):
            turn = [] if end == "pinned" else ["turn_x"]
            assembly.hold([assembly.dof(number, name) for name in ("w", "turn_y", *turn)])
        members = SpaceMembers(frame, mesh, beams, self.sampled)
        structure = as_column(apply_dead_loads(frame, assembly, members))
        beside = {"sideways": assembly.dof(hit, "w"), "twist": assembly.dof(hit, "turn_y")}
        watched = {name: (dof, 1.0) for name, dof in beside.items()}
        return replace(structure, watched={**structure.watched, **watched})

    def fibers(self, frame: Frame, mesh: FrameMesh, angle: float = 0.0) -> SpaceBeams:
        """Co-rotational beams, the height of whose section is turned from the hit by an `angle`.

        Rotations of the supports are those about the axes of the section.
        """
        steel, member = frame.steel, frame.members[0]
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
            torsion=steel.shear_modulus * torsion_constants(section)[0],
        )
        c, s = cos(angle), sin(angle)
        supports = np.isin(mesh.nodes, [frame.number[name] for name in ("base", "head")])
        turned = np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])
        axes = np.where(supports[:, :, None, None], turned, np.eye(3))
        return SpaceBeams(mesh.nodes, np.zeros_like(mesh.member), [fibers], (-c, 0.0, s), axes=axes)
