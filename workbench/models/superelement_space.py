"""Superelements in space: columns and frames of elastic bars between hinges, hit from any side.

The sibling in space of `flexible-superelement`: co-rotational bars with the exact N-My-Mz domain of
the section at both ends, steps that hold energy exactly.
"""

from dataclasses import dataclass
from typing import ClassVar

from workbench.base.fields import Number, checked
from workbench.mechanics.frames.structure import FrameStructure
from workbench.mechanics.structures.space import SpaceSuperelements
from workbench.models.frame_model import (
    ELEMENTS,
    REGULARISATION,
    TIME_STEP,
    Clock,
)
from workbench.models.references.fiber_space import Placed, SpaceModel
from workbench.models.superelements import SHARE, march
from workbench.responses import Response
from workbench.scenarios import FrameImpact


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
    version: ClassVar[int] = 4
    pins: ClassVar[bool] = True
    sampled: ClassVar[float] = 0.0
    geometry = "co-rotational"
    least_parts: ClassVar[int] = 2
    most_parts: ClassVar[int] = 2  # more cost up to ten times as much, peaks move by 1 to 2 %
    much_shared: ClassVar[float] = 0.15  # 62 columns with 0.06 to 0.14: -4 to +5 % off fibers
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

    def bars(self, placed: Placed) -> SpaceSuperelements:
        """The superelements of a frame in space."""
        mesh = placed.mesh
        given = placed.frame, mesh.nodes, mesh.member, mesh.lengths, placed.heights, placed.axes
        return SpaceSuperelements(*given, self.hinge_stiffness, self.regularisation)
