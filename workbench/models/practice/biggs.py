"""Biggs' equivalent single degree of freedom, stage by stage (Biggs 1964; UFC 3-340-02)."""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import ClassVar

import numpy as np

from workbench.fields import checked
from workbench.models.energy_estimate import energy_to_absorb
from workbench.models.practice.catenary import beam_of
from workbench.models.practice.deflected_shape import Stage
from workbench.models.practice.strength import AXIAL, SECTION, plastic_moment
from workbench.models.resistance import ResistanceCurve, mechanism_of
from workbench.models.resistance import curve as events
from workbench.models.resistance.kernels import PIECE
from workbench.models.single_dof import SingleDof
from workbench.scenarios import Column, ColumnImpact

_PLACES = ("base", "hit", "head")  # nodes of the beam


@dataclass(frozen=True)
class Biggs(SingleDof):
    """Equivalent mass and resistance of every stage, by integrating the deflected shape.

    Options: `axial`, how the axial load lowers the plastic moment: none, linear (M_p (1 - n)) or
    section (exact plastic envelope); `integrator`, `time_step` as in `single-dof`.
    """

    axial: str = checked(AXIAL, SECTION)
    resistance: ClassVar[str] = "stages"  # type: ignore[misc]
    rotational_stiffness: ClassVar[float] = 6.0  # type: ignore[misc]
    hit_mass: ClassVar[str] = "shape"  # type: ignore[misc]

    name: ClassVar[str] = "biggs"
    version: ClassVar[int] = 1
    assumptions: ClassVar[tuple[str, ...]] = (
        "The member moves in the shape that its load makes statically, another one for each stage: "
        "elastic, elastic with hinges, mechanism with hinges at clamped ends and at the hit point.",
        "Flexure alone: the axial load lowers the plastic moment and does nothing else, there is "
        "no second-order work and no catenary action.",
        "A striker meets the mass of the stage to which its energy takes the member; one that is "
        "given as the impact mass counts as it is.",
        "Elastic unloading with the initial stiffness; no shear, no local buckling, no strain-rate "
        "effect.",
    )
    sources: ClassVar[tuple[str, ...]] = ("heng2017", "biggs1964", "ufc3-340-02")

    def stages(self, column: Column, uniform: bool = False) -> tuple[Stage, ...]:
        """Stages under a force at the hit point, or under a `uniform` line load."""
        return _stages(column, self.axial, uniform)

    def curve(self, column: Column) -> ResistanceCurve:
        """Resistance of the column at its hit point. Raises `OutOfDomainError`."""
        return stage_curve(column, self.stages(column))

    def with_mass(self, scenario: ColumnImpact) -> ColumnImpact:
        """The impact with the mass (kg) of the stage to which the energy of the blow leads."""
        column, curve = scenario.column, self.curve(scenario.column)
        if column.impact_mass is not None:
            return scenario
        total = column.properties.mass_per_length * column.length
        for stage in reversed(self.stages(column)):
            column = replace(column, impact_mass=stage.mass_factor * total)
            found = replace(scenario, column=column)
            if energy_to_absorb(found) >= curve.work(stage.start):
                break
        return found


@lru_cache(maxsize=256)
def _stages(column: Column, axial: str, uniform: bool) -> tuple[Stage, ...]:
    return beam_of(column, uniform).stages(np.full(3, plastic_moment(column, axial)))


def stage_curve(column: Column, stages: tuple[Stage, ...]) -> ResistanceCurve:
    """Resistance (N) of the whole load over the displacement of the hit point."""
    mechanism = mechanism_of(column)
    pieces = np.zeros(len(stages), PIECE)
    before: frozenset[int] = frozenset()
    for piece, stage in zip(pieces, stages, strict=True):
        piece["start"], piece["c"][:2] = stage.start, (stage.load, stage.stiffness)
        if stage.stiffness == 0.0:
            piece["event"] = events.LOAD
        elif stage.hinges:
            piece["event"] = events.YIELDS
            place = _PLACES[min(stage.hinges - before)]
            piece["group"] = mechanism.groups.index(place)
        before = stage.hinges
    return ResistanceCurve("stages", mechanism, pieces, stages[1].start)
