"""Superelements in space: a column of elastic bars between hinges, hit from any side.

The sibling in space of `flexible-superelement`: co-rotational bars with the exact N-My-Mz domain of
the section at both ends, steps that hold energy exactly.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from workbench.base.fields import Number, checked
from workbench.mechanics.frames.structure import FrameStructure
from workbench.mechanics.structures.space import SpaceBar, SpaceSuperelements
from workbench.models.frame_model import (
    ELEMENTS,
    REGULARISATION,
    TIME_STEP,
    Clock,
    as_frame,
)
from workbench.models.references.fiber_space import (
    SpaceModel,
    Turned,
    stand_in_space,
)
from workbench.models.superelements import SHARE, march
from workbench.responses import Response
from workbench.scenarios import ColumnImpact, ColumnScenario, FrameImpact, FrameScenario
from workbench.steel.hinges import BiaxialSurface
from workbench.steel.sections.slenderness import torsion_constants


@dataclass(frozen=True)
class SuperelementSpace(SpaceModel):
    """Elastic bars in space between hinges that yield under N and both moments.

    Options: `hinge_stiffness`, n of the hinges' n 2EA/L and n 6EI/L (100: nearly rigid-plastic);
    `accuracy`, as of the plane superelements.
    """

    elements: int | None = ELEMENTS()
    time_step: float | None = TIME_STEP()
    regularisation: float = REGULARISATION()
    hinge_stiffness: float = checked(Number(0.1, 1e9), 10.0)
    accuracy: float = SHARE()

    name: ClassVar[str] = "superelement-space"
    version: ClassVar[int] = 2
    geometry = "co-rotational"
    least_parts: ClassVar[int] = 2
    sources: ClassVar[tuple[str, ...]] = ("heng2017", "battini-pacoste2002")
    assumptions: ClassVar[tuple[str, ...]] = (
        "Elastic Bernoulli bars, straight against their chord, rigid in shear; elastic torsion by "
        "St Venant whose ends are held, warping is left out.",
        "All plasticity in hinges at the ends of the bars, on the exact domain of the section "
        "under N, My and Mz, with associated flow; no shear yielding, no local buckling; strain "
        "rate by one factor on the yield stress.",
        "Point contact on the axis with a face that lets the column slide along it.",
    )

    def _struck(self, scenario: FrameImpact, structure: FrameStructure, clock: Clock) -> Response:
        return march(self, scenario, structure, clock.timed)

    def structure(self, scenario: FrameScenario | ColumnScenario) -> FrameStructure:
        """The column under its dead loads. Raises `SolverError`."""
        assert isinstance(scenario, ColumnImpact)
        event = as_frame(scenario)
        pairs = zip(event.frame.lengths.tolist(), self.parts(event), strict=True)
        lengths = [np.full(count, length / count) for length, count in pairs]
        return stand_in_space(scenario, lengths, self._bars, 0.0)

    def _bars(self, column: Turned) -> SpaceSuperelements:
        frame, mesh = column.frame, column.mesh
        steel, member = frame.steel, frame.members[0]
        section, whole = frame.strength_section(member), frame.properties(member)
        weak, modulus = section.about("weak"), steel.elastic_modulus
        bar = SpaceBar(
            surface=BiaxialSurface(section),
            strength=(whole.squash_load, whole.plastic_moment, weak.plastic_moment(steel)),
            axial=modulus * whole.area,
            bending=(modulus * whole.second_moment, modulus * weak.second_moment),
            torsion=steel.shear_modulus * torsion_constants(section)[0],
            hinge_stiffness=self.hinge_stiffness,
            mass=whole.mass_per_length,
            rotary=whole.mass_per_length * whole.second_moment / whole.area,
        )
        of = np.zeros_like(mesh.member)
        given = mesh.nodes, of, [bar], mesh.lengths, column.height, column.axes
        return SpaceSuperelements(*given, self.regularisation)
