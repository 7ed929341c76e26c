"""The two models of two rigid bars: hinges that see N and M, and panels that see V as well."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np

from workbench.fields import Choice, Flag, Number, checked
from workbench.frames.members import shear_stiffness
from workbench.hinges import ShearSurface, YieldSurface, has_shear_surface, has_webs
from workbench.hinges.interaction import SHEAR_DEPTHS
from workbench.hinges.rate import bar_law, panel_law
from workbench.materials import Steel
from workbench.models.domain import panel_findings, shear_findings, stub_findings
from workbench.models.elastic_springs import Springs, beam_springs
from workbench.models.four_dof import kinematics
from workbench.models.four_dof.rigid_bars import RigidBars
from workbench.models.hit_mass import HIT_MASS, WAVES
from workbench.models.strain_rate import flows
from workbench.responses import Finding, finding
from workbench.scenarios import Column, ColumnScenario
from workbench.sections import Section

_SHEARED = 0.15  # mean sliding over length from which a solid's flanges carry tension
_KINEMATICS = {"chord": kinematics.CHORD, "section": kinematics.SECTION}


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
        fitted = YieldSurface.fit(column.strength_section, column.steel, decimals=1)
        return YieldSurface(
            properties.squash_load,
            properties.plastic_moment,
            fitted.alpha if self.alpha is None else self.alpha,
            fitted.beta if self.beta is None else self.beta,
        )

    def _hinge_findings(self, scenario: ColumnScenario) -> list[Finding]:
        section = scenario.column.section
        if flows(self, scenario.column.steel) and not has_shear_surface(section):
            return [finding("no-plane-webs", name=section.name)]
        return shear_findings(scenario)

    def _springs(self, column: Column) -> Springs:
        section = column.strength_section
        return beam_springs(column, shear_stiffness(section, column.steel))

    def _strength(self, column: Column, bars: Any) -> None:
        surface = self.surface(column)
        bars["squash_loads"], bars["plastic_moments"] = surface.axial_bounds, surface.moment_bounds
        bars["alpha"], bars["beta"] = surface.alpha, surface.beta
        bars["small_rotations"] = self.small_rotations
        if flows(self, column.steel):
            N, M = surface.squash_load, surface.plastic_moment
            bars["law"] = bar_law(column.strength_section, column.steel, N, M)


@dataclass(frozen=True)
class FourDofShear(RigidBars):
    """Four-DOF column whose webs yield in shear and slide.

    Options: `kinematics`: sliding stretches a bar (chord, as in a solid) or does not (section, as
    in `fiber-shear`); `web_depth`, what of the webs carries shear: between the centre lines of the
    flanges, as in a solid, or clear, as in `fiber-shear`; `hit_mass`, waves by default.
    """

    kinematics: str = checked(Choice(tuple(_KINEMATICS)), "chord")
    web_depth: str = checked(Choice(SHEAR_DEPTHS), "centre")
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
        return _surface_of(column.strength_section, column.steel, self.web_depth)

    def _hinge_findings(self, scenario: ColumnScenario) -> list[Finding]:
        column = scenario.column
        if not has_shear_surface(column.section):
            return [finding("no-plane-webs", name=column.section.name)]
        if flows(self, column.steel) and not has_webs(column.section):
            return [finding("no-flanges", name=column.section.name)]
        surface = self.surface(column)
        lengths = {"below": column.length_below, "above": column.length_above}
        findings = panel_findings(surface, column.properties, "the column")
        return findings + stub_findings(surface, lengths)

    def _reached(self, column: Column, values: dict[str, Any]) -> list[Finding]:
        lengths = np.array([[column.length_below], [column.length_above]])
        sheared = float(np.max(np.abs(values["sliding"]) / lengths))
        if self.kinematics == "chord" or sheared <= _SHEARED:
            return []
        return [finding("sliding", sheared, least=_SHEARED)]

    def _springs(self, column: Column) -> Springs:
        return beam_springs(column, float(self.surface(column).record["stiffness"]), sliding=True)

    def _strength(self, column: Column, bars: Any) -> None:
        bars["web"] = self.surface(column).record
        bars["sliding"], web = _KINEMATICS[self.kinematics], bars["web"]
        bars["squash_loads"] = web["flange_axial"] + web["web_axial"]
        bars["plastic_moments"] = web["flange_moment"] + web["web_moment"]
        if flows(self, column.steel):
            bars["law"] = panel_law(self.surface(column))


@lru_cache(maxsize=64)
def _surface_of(section: Section, steel: Steel, depth: str) -> ShearSurface:
    return ShearSurface(section, steel, depth)
