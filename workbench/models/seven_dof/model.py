"""The sibling in space of the four-DOF column: hit from any side, two rigid bars, four hinges.

Springs, masses and pace are those of `four_dof`, the springs once for either axis; hinges yield on
the exact N-My-Mz domain of the section. Mathematics: `march`.
"""

from dataclasses import dataclass
from math import inf
from typing import Any, ClassVar

import numpy as np

from workbench.base.arrays import Array, Flags
from workbench.base.errors import CollapseError, OutOfDomainError, SolverError
from workbench.base.fields import Choice, checked
from workbench.mechanics.frames.members import shear_stiffness
from workbench.mechanics.impact.integrator import FollowedImpact, follow
from workbench.mechanics.impact.pace import Pace
from workbench.models.base import findings_before
from workbench.models.batch import BatchAnswers
from workbench.models.domain import shear_findings
from workbench.models.elastic_springs import Springs, beam_springs, thesis_springs
from workbench.models.four_dof.march import CLOSELY, HINGES, NEARLY
from workbench.models.four_dof.model import RigidBars, answer_stack, collapsed, stackable
from workbench.models.four_dof.statics import Tables
from workbench.models.hit_mass import HIT_MASS_IN_SPACE, SUPPORTS, direction_of, with_hit_mass
from workbench.models.seven_dof import march
from workbench.models.seven_dof.kinematics import (
    BELOW,
    COLUMN,
    HEAD,
    STATE,
    TABLES,
    TWIST,
    WORK,
    N,
    T,
    U,
)
from workbench.models.strain_rate import FACTOR, with_strain_rate
from workbench.responses import Finding
from workbench.scenarios import Column, ColumnImpact, ColumnScenario
from workbench.scenarios.varied import spread
from workbench.steel.hinges.biaxial_kernels import ROOM
from workbench.steel.hinges.interaction import surface_in_space
from workbench.steel.sections import AXES
from workbench.steel.sections.slenderness import torsion_constants

_BARS, _ENDS = np.array(HINGES).T


@dataclass(frozen=True)
class SevenDof(RigidBars):
    """Column hit from any side; its impact point may drift sideways and twist."""

    hit_mass: str = checked(HIT_MASS_IN_SPACE, SUPPORTS, help="a third, or less by late supports")
    rate_level: str = checked(Choice((FACTOR,)), FACTOR)

    name: ClassVar[str] = "seven-dof"
    version: ClassVar[int] = 2
    answers: ClassVar[tuple[str, ...]] = (ColumnImpact.KIND,)
    spatial: ClassVar[bool] = True
    marches: ClassVar[Any] = march
    assumptions: ClassVar[tuple[str, ...]] = (
        *RigidBars.assumptions,
        "Hinges yield on the exact domain of the section under N, My and Mz, with associated flow; "
        "no shear yielding, no local buckling; strain rate by one factor on the yield stress.",
        "The striker keeps its line; the impact point slides along its face, or sticks by its "
        "friction: sliding freely is the safe bound.",
        "St Venant torsion, and warping held at clamped ends and free at the impact point, resist "
        "a twist elastically; the hit is central.",
    )
    sources: ClassVar[tuple[str, ...]] = ("heng2017",)

    def _tables(self, column: Column) -> Tables:
        return TABLES

    def _springs(self, column: Column) -> Springs:
        return beam_springs(column, shear_stiffness(column.strength_section, column.steel))

    def _torsion(self, column: Column, count: int) -> Array:
        """Torque over twist (N m/rad) of the impact point, of each of `count` columns."""
        section = column.bent_about("strong").section
        (uniform, warping), total = torsion_constants(section), np.zeros(count)
        elastic, shear = (
            spread(each, count)
            for each in (column.steel.elastic_modulus, column.steel.shear_modulus)
        )
        for length, clamped in column.bent_about("strong").bars.values():
            whole = spread(length, count)
            held = np.sqrt(elastic * warping / (shear * uniform)) if clamped else np.zeros(count)
            total += 1.0 / (whole - held * np.tanh(whole / np.maximum(held, 1e-9 * whole)))
        return shear * uniform * total

    def table_of(self, column: Column, count: int = 1) -> tuple[Any, Array]:
        """Bars of a stack of `count` columns: tables of them and their states (count, 7)."""
        both = [column.bent_about(axis) for axis in AXES]
        properties, bars = both[0].properties, np.zeros(count, COLUMN)
        seconds = [spread(each.properties.second_moment, count) for each in both]
        moments = [spread(each.properties.plastic_moment, count) for each in both]
        lengths, strength = bars["lengths"], bars["strength"]
        lengths[:, 0], lengths[:, 1] = column.length_below, column.length_above
        strength[:, 0], strength[:, 1:] = properties.squash_load, np.stack([*moments] * 2, axis=1)
        axial = spread(column.steel.elastic_modulus * properties.area, count)[:, None] / lengths
        factor = self.rotational_stiffness
        stiffness = np.empty((count, 2, 5))
        stiffness[:, :, 0] = axial
        for i, each in enumerate(both, 1):
            springs = self._springs(each) if factor is None else thesis_springs(each, factor)
            base, below, above, head = (1.0 / spread(one, count) for one in springs)
            stiffness[:, 0, i], stiffness[:, 1, i] = base, head
            stiffness[:, 0, 2 + i], stiffness[:, 1, 2 + i] = below, above
        for i in range(5):
            bars["stiffness"][:, :, i, i] = stiffness[:, :, i] / strength[:, None, i] ** 2
        bars["surface"] = surface_in_space(both[0].strength_section).record
        bars["torsion"] = self._torsion(column, count)
        bars["free_head"] = column.head != "fixed"
        bars["spring"] = bars["free_head"] * column.restraint_stiffness
        bars["load"] = column.axial_load
        for i in (N, T, U):
            bars["mass"][:, i] = properties.impact_mass
        bars["mass"][:, HEAD] = column.head_mass
        polar = column.steel.density * column.length / 3.0
        bars["mass"][:, TWIST] = polar * (seconds[0] + seconds[1])
        force, q = bars["load"], np.zeros((count, 7))
        q[:, U], q[:, HEAD] = -force / axial[:, 0], -force * np.sum(1.0 / axial, axis=1)
        bars["unstressed"] = q[:, HEAD]
        return bars, q

    def _strike(self, bars: Any, scenario: ColumnImpact) -> None:
        bars["angle"] = np.stack(np.broadcast_arrays(*direction_of(scenario)), axis=-1)
        bars["friction"] = scenario.striker.friction

    def _march(
        self, scenario: ColumnImpact, pace: Pace, weight: float
    ) -> tuple[Any, FollowedImpact]:
        striker, (table, q) = scenario.striker, self._bars_of(scenario.column)
        self._strike(table, scenario)
        states, room = np.zeros(2, STATE), np.zeros(1, WORK)
        states["q"][0], hinges = q, np.zeros(2, ROOM)
        if weight:
            still = table.copy()
            still["weight"] = weight
            still["spring"] = 0.0
            if not march.lie(still, states, room, hinges):
                raise OutOfDomainError("the column does not carry its own weight")
            rest = states["q"][0]
            table["weight"], table["sag"] = weight, rest[N]
            table["unstressed"] += rest[HEAD] - q[HEAD]
        room["finish_below"] = NEARLY if pace.error < inf else CLOSELY
        drive = striker.mass, striker.velocity, striker.restitution, 0.0
        given = table, states, room, hinges
        run = follow(march.impact, given, pace, drive, march.RECORD, striker, scenario.acceleration)
        if run.collapsed:
            last = run.records[-1]
            place = np.array([np.hypot(*last["q"][[N, T]]), last["q"][U], 0.0, last["q"][HEAD]])
            raise collapsed(table[0], {"q": place, "time": last["time"]})
        return table[0], run

    def _values(self, column: Column, bars: Any, run: FollowedImpact) -> dict[str, Any]:
        q, stress = run.histories["q"], run.histories["stress"]
        lengths = bars["lengths"]
        along = np.stack([lengths[BELOW] + q[U], lengths[1] + q[HEAD] - q[U]])
        chords = np.sqrt(along**2 + q[N] ** 2 + q[T] ** 2)
        shear = [
            np.abs(stress[:, i] - stress[:, 2 + i])
            / chords
            / column.bent_about(axis).properties.shear_resistance
            for i, axis in enumerate(AXES, 1)
        ]
        return {
            "displacement": q[N] - bars["sag"],
            "sideways": q[T],
            "twist": q[TWIST],
            "force": run.histories["force"],
            "shortening": -q[HEAD],
            "dissipated": run.histories["dissipated"],
            "axial_force": stress[_BARS, 0],
            "moment": stress[_BARS, 2 * _ENDS - 1],
            "weak_moment": stress[_BARS, 2 * _ENDS],
            "shear_utilisation": np.maximum(*shear).max(axis=1),
            "plastic_rotation": march.turned(run.records),
        }

    def peak_of(self, scenario: ColumnImpact) -> float | None:
        """Peak (m) along the hit to half a percent, infinite of a collapse; None: no answer."""
        solved, _, left_out = with_strain_rate(self, scenario)
        if any(each.refusal for each in findings_before(self, scenario, left_out)):
            return None
        solved = with_hit_mass(solved, self.hit_mass)
        try:
            run = self._march(solved, self.pace(solved, -1), scenario.dead_force)[1]
        except CollapseError:
            return inf
        except (SolverError, OutOfDomainError):
            return None
        return run.peak(scenario.striker.rebounds).get("peak_displacement")

    def stackable(self, scenario: ColumnScenario) -> bool:
        """Whether it answers such impacts in stacks."""
        return stackable(self, scenario)

    def answer_stack(self, scenario: ColumnImpact, refused: Flags) -> BatchAnswers:
        """Answers to a stack of impacts, see `models.batch`; none of those that are `refused`."""
        return answer_stack(self, scenario, refused)

    def refused(self, scenario: ColumnImpact) -> Any:
        """Whether the domain refuses an impact; flags of a stack."""
        column = scenario.column
        strong, weak = (column.bent_about(axis).euler_load(axis) for axis in AXES)
        return column.axial_load >= np.minimum(strong, weak)

    def domain(self, scenario: Any) -> list[Finding]:
        """Findings on the smaller Euler load, and on shear forces along the web if it is hit so."""
        column = scenario.column
        findings = super().domain(scenario.unchecked(column=column.weaker))
        if any(each.refusal for each in findings):
            return findings
        sheared = column.bent_about("strong" if direction_of(scenario)[0] else "weak")
        return findings + shear_findings(scenario.unchecked(column=sheared))

    def _hinge_findings(self, scenario: ColumnScenario) -> list[Finding]:
        return []
