"""The two models of two rigid bars: hinges that see N and M, and panels that see V as well."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from workbench.base.arrays import Flags
from workbench.base.errors import CollapseError
from workbench.base.fields import Flag, Number, checked
from workbench.mechanics.frames.members import shear_stiffness
from workbench.models.batch import SURVIVES, UNKNOWN, Answers
from workbench.models.domain import buckles, shear_findings, stub_findings
from workbench.models.elastic_springs import Springs, beam_springs
from workbench.models.four_dof import march
from workbench.models.four_dof.equations import along_tangent
from workbench.models.four_dof.rigid_bars import PACES, RigidBars, collapsed
from workbench.models.hinge_limits import panel_findings, panel_refused
from workbench.models.hit_mass import HIT_MASS, WAVES, with_hit_mass
from workbench.models.strain_rate import flows
from workbench.responses import Finding, finding
from workbench.scenarios import Column, ColumnImpact, ColumnScenario
from workbench.scenarios.varied import spread
from workbench.steel.hinges import ShearSurface, YieldSurface, has_shear_surface, has_webs
from workbench.steel.hinges.interaction import fitted_exponents
from workbench.steel.hinges.rate import bar_law, panel_law


@dataclass(frozen=True)
class FourDof(RigidBars):
    """Four-degree-of-freedom column of the thesis.

    Options: `alpha`, `beta`: exponents of the yield surface (None: fitted to the exact N-M
    envelope of the section and stated to one decimal, as the thesis does);
    `small_rotations`: the kinematics of the SDOF model.
    """

    alpha: float | None = checked(Number(1.0, 20.0), optional=True)
    beta: float | None = checked(Number(1.0, 20.0), optional=True)
    small_rotations: bool = checked(Flag(), False)

    name: ClassVar[str] = "four-dof"
    assumptions: ClassVar[tuple[str, ...]] = (
        *RigidBars.assumptions,
        "Elastic-perfectly plastic hinges with associated flow on a super-elliptic N-M surface; "
        "the thesis does not print its exponents, (1, 1.3) are inferred from its section.",
        "No shear yielding, no local buckling; strain rate by one factor on the yield stress, or, "
        "with rate_level = bars, rate and hardening at every point of the bars, on the exact N-M "
        "envelope of the plates, whose shape stays as it grows.",
    )

    def surface(self, column: Column) -> YieldSurface:
        """The yield surface of all hinges of the column."""
        properties = column.properties
        return YieldSurface(
            properties.squash_load, properties.plastic_moment, *self._exponents(column)
        )

    def _exponents(self, column: Column) -> tuple[float, float]:
        alpha, beta = fitted_exponents(column.strength_section, decimals=1)
        return (
            alpha if self.alpha is None else self.alpha,
            beta if self.beta is None else self.beta,
        )

    def stackable(self, scenario: ColumnScenario) -> bool:
        """Whether it answers such impacts in stacks."""
        return _stackable(self, scenario)

    def answer_stack(self, scenario: ColumnImpact, refused: Flags) -> Answers:
        """Answers to a stack of impacts, see `models.batch`; none of those that are `refused`."""
        return _answer_stack(self, scenario, refused)

    def refused(self, scenario: ColumnImpact) -> Any:
        """Whether the domain refuses an impact; flags of a stack."""
        return buckles(scenario)

    def _hinge_findings(self, scenario: ColumnScenario) -> list[Finding]:
        section = scenario.column.section
        if flows(self, scenario.column.steel) and not has_shear_surface(section):
            return [finding("no-plane-webs", name=section.name)]
        return shear_findings(scenario)

    def _springs(self, column: Column) -> Springs:
        section = column.strength_section
        return beam_springs(column, shear_stiffness(section, column.steel))

    def _strength(self, column: Column, bars: Any) -> None:
        N, M = column.properties.squash_load, column.properties.plastic_moment
        bars["squash_loads"], bars["plastic_moments"] = np.vstack((N, N)).T, np.vstack((M, M)).T
        bars["alpha"], bars["beta"] = self._exponents(column)
        bars["small_rotations"] = self.small_rotations
        if flows(self, column.steel):
            bars["law"] = bar_law(column.strength_section, column.steel, N, M)


@dataclass(frozen=True)
class FourDofShear(RigidBars):
    """Four-DOF column whose webs yield in shear and slide.

    Sliding stretches a bar, and webs carry shear between the centre lines of the flanges, as in a
    solid. Option: `hit_mass`, waves by default.
    """

    hit_mass: str = checked(HIT_MASS, WAVES)

    name: ClassVar[str] = "four-dof-shear"
    shear_yields: ClassVar[bool] = True
    version: ClassVar[int] = 7
    _CONTROL: ClassVar[tuple[tuple[float, float, float], ...]] = (
        (8e-5, 4e-3, 0.9),
        RigidBars._CONTROL[1],
    )
    assumptions: ClassVar[tuple[str, ...]] = (
        *RigidBars.assumptions,
        "Uniform shear stress in the webs, none in the flanges; associated flow on the N-M-V "
        "domain of the plates, root fillets in the flanges.",
        "A web slides without limit, and a sliding bar stretches as its flanges are continuous: no "
        "web buckling, no fracture, no mechanism of the flanges; strain rate by one factor, or, "
        "with rate_level = bars, rate and hardening of flanges and web at every point of the bars.",
    )
    sources: ClassVar[tuple[str, ...]] = ("heng2017", "en1993-1-5")

    def surface(self, column: Column) -> ShearSurface:
        """The yield surface of both ends of all bars."""
        if "webs" not in column.kept:
            column.kept["webs"] = ShearSurface(column.strength_section, column.steel)
        surface: ShearSurface = column.kept["webs"]
        return surface

    def stackable(self, scenario: ColumnScenario) -> bool:
        """Whether it answers such impacts in stacks."""
        return _stackable(self, scenario) and has_shear_surface(scenario.column.section)

    def answer_stack(self, scenario: ColumnImpact, refused: Flags) -> Answers:
        """Answers to a stack of impacts, see `models.batch`; none of those that are `refused`."""
        return _answer_stack(self, scenario, refused)

    def refused(self, scenario: ColumnImpact) -> Any:
        """Whether the domain refuses an impact; flags of a stack."""
        column = scenario.column
        return buckles(scenario) | panel_refused(self.surface(column), column.properties)

    def _hinge_findings(self, scenario: ColumnScenario) -> list[Finding]:
        column = scenario.column
        if not has_shear_surface(column.section):
            return [finding("no-plane-webs", name=column.section.name)]
        if flows(self, column.steel) and not has_webs(column.section):
            return [finding("no-flanges", name=column.section.name)]
        surface = self.surface(column)
        lengths = {"below": column.length_below, "above": column.length_above}
        findings = panel_findings(surface, column.properties)
        return findings + stub_findings(surface, lengths)

    def _springs(self, column: Column) -> Springs:
        return beam_springs(column, self.surface(column).record["stiffness"], sliding=True)

    def _strength(self, column: Column, bars: Any) -> None:
        surface = self.surface(column)
        N, M = surface.squash_load, surface.plastic_moment
        bars["web"], bars["sliding"] = surface.record, True
        bars["squash_loads"], bars["plastic_moments"] = np.vstack((N, N)).T, np.vstack((M, M)).T
        if flows(self, column.steel):
            bars["law"] = panel_law(surface)


def _stackable(model: FourDof | FourDofShear, scenario: ColumnScenario) -> bool:
    if not isinstance(scenario, ColumnImpact) or scenario.striker.crushes or scenario.acceleration:
        return False
    return model.time_step is None and not flows(model, scenario.column.steel)


def _answer_stack(model: FourDof | FourDofShear, scenario: ColumnImpact, refused: Flags) -> Answers:
    """Answers to a stack: those whose ledger is open are followed again, as single ones are."""
    struck = with_hit_mass(scenario, model.hit_mass)
    column, striker = struck.column, struck.striker
    count = len(refused)
    table, q = model.table_of(column, count)
    codes = np.where(refused, UNKNOWN, SURVIVES)
    numbers, errors = np.full((count, len(march.SCALARS)), np.nan), np.zeros(count)
    given, which = spread(struck.input_energy, count), np.flatnonzero(codes == SURVIVES)
    nearly = march.NEARLY if along_tangent(table[0]) else 0.0
    for refinement in range(PACES):
        drive = *model.pace(struck, refinement), striker.mass, striker.velocity, striker.restitution
        drives = np.stack([spread(each, count) for each in (*drive, 0.0)], axis=1)
        march.impacts(table, q, drives, given, nearly, which, codes, numbers, errors)
        which = which[(codes[which] == SURVIVES) & ~(errors[which] < model.BALANCE)]
        if not len(which):
            break
    codes[which] = UNKNOWN
    values = dict(zip(march.SCALARS, numbers.T, strict=True)) | {"input_energy": given}

    def collapse(i: int) -> CollapseError:
        return collapsed(table[i], {"q": numbers[i, :4], "time": numbers[i, 4]})

    return Answers.of(codes, values, collapse)
