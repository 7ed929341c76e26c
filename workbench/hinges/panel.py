"""The N-M-V domain of sections with webs, and panels whose webs yield in shear."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from workbench.arrays import Array
from workbench.fields import Choice, Declared, Instance, checked
from workbench.hinges import panel_kernels
from workbench.materials import Steel
from workbench.sections import ISection, Rectangle, RectangularTube, Section

SHEAR_DEPTHS = ("centre", "clear")


def has_webs(section: Section) -> bool:
    """Whether a section has plane webs between flanges."""
    return isinstance(section.shape, ISection | RectangularTube)


def has_shear_surface(section: Section) -> bool:
    """Whether the N-M-V domain of a section is known: plane webs, or a solid rectangle."""
    return has_webs(section) or isinstance(section.shape, Rectangle)


@dataclass(frozen=True)
class ShearSurface(Declared, table="shear_surface"):
    """Admissible N, M and V of flanges and webs: |M| <= M_c(|N|, |V|), |V| <= V_pl.

    Uniform shear stress in the webs, none in the flanges, von Mises: a lower bound of limit
    analysis, convex, and without shear the exact envelope of the plates. Against the exact set of
    one shear rate per section it lacks up to 0.015 M_p (HEB 220), 0.033 M_p (IPE 300). Root
    fillets carry no shear: they belong to the flanges, as plates that keep the area and the plastic
    modulus of the section (`Section.flange_plates`), within 0.2 % of its exact envelope.

    A solid rectangle has that exact set itself, as uniform shear stress would lack 0.144 M_p.

    Arguments: `section` with webs, or a solid rectangle; `steel`; `depth` of the webs that carries
    shear, between the flanges' centre lines or clear between them. Raises `InputError`.
    """

    section: Section = checked(Instance(Section))
    steel: Steel = checked(Instance(Steel), Steel())
    depth: str = checked(Choice(SHEAR_DEPTHS), "centre")

    def check(self) -> None:
        """Refuse sections of other kinds."""
        if not has_shear_surface(self.section):
            raise self.refusal("section", "must have plane webs or be a solid rectangle")

    @cached_property
    def record(self) -> Any:
        """The section as the kernels take it."""
        shape, f_y = self.section.shape, self.steel.yield_stress
        if isinstance(shape, Rectangle):
            return self._solid(shape)
        upright, flange = shape.plates
        area = upright * (shape.height - (2.0 if self.depth == "clear" else 1.0) * flange)
        b, flange = self.section.flange_plates
        clear, between = shape.height - 2.0 * flange, shape.height - flange
        web = np.zeros(1, panel_kernels.WEB)[0]
        web["shear"], web["stiffness"] = (
            area * self.steel.shear_yield_stress,
            area * self.steel.shear_modulus,
        )
        web["web_axial"], web["web_moment"] = upright * clear * f_y, upright * clear**2 * f_y / 4.0
        web["flange_axial"], web["flange_moment"] = (
            2.0 * b * flange * f_y,
            b * flange * between * f_y,
        )
        web["half_web"], web["half_height"] = clear / 2.0, shape.height / 2.0
        web["flanges"] = 2.0 * b * f_y
        return web

    def _solid(self, shape: Rectangle) -> Any:
        """The record of a solid rectangle: all web, 5/6 of it stiff in shear."""
        area, f_y = shape.height * shape.width, self.steel.yield_stress
        web = np.zeros(1, panel_kernels.WEB)[0]
        web["shear"] = area * self.steel.shear_yield_stress
        web["stiffness"] = 5.0 / 6.0 * area * self.steel.shear_modulus
        web["web_axial"], web["web_moment"] = area * f_y, area * shape.height * f_y / 4.0
        web["half_web"] = web["half_height"] = shape.height / 2.0
        web["solid"] = True
        return web

    @property
    def shear_resistance(self) -> float:
        """Plastic shear resistance V_pl of the webs, in N."""
        return float(self.record["shear"])

    @property
    def squash_load(self) -> float:
        """Plastic axial resistance without shear, in N."""
        return float(self.record["flange_axial"] + self.record["web_axial"])

    @cached_property
    def plastic_moment(self) -> float:
        """Plastic moment (N m) of what it is made of, without axial and shear force."""
        return float(self.moment_capacity(0.0, 0.0))

    @property
    def flange_mechanism(self) -> float:
        """Work (J) per radian of a panel whose flanges bend as plates at both ends, b t^2 f_y.

        Panels leave it out.
        """
        _, flange = self.section.shape.plates  # none in a solid rectangle
        return float(self.section.shape.width * flange**2 * self.steel.yield_stress)

    @property
    def web_slenderness(self) -> float:
        """Clear height over thickness of one web; 0 of a solid rectangle."""
        if isinstance(self.section.shape, Rectangle):
            return 0.0
        upright, flange = self.section.shape.plates
        one = upright / (2.0 if isinstance(self.section.shape, RectangularTube) else 1.0)
        return (self.section.height - 2.0 * flange) / one

    def one_shear_rate(self, shear_share: ArrayLike) -> Array:
        """Exact moment capacity (N m) without axial force beside shares V / V_pl of the clear web.

        The web has one shear rate and plane sections: with the ratio s of the strain rate at its
        edge to the shear rate, V / V_pl = asinh(s) / s and M_w(s) / M_w = sqrt(1 + 1 / s^2) -
        asinh(s) / s^2. The uniform shear stress of the domain is a lower bound of it.
        """
        s = np.geomspace(1e-3, 1e6, 4000)
        share, web = np.arcsinh(s) / s, np.sqrt(1.0 + 1.0 / s**2) - np.arcsinh(s) / s**2
        wanted = np.asarray(shear_share, float)
        left = np.interp(wanted, [0.0, *share[::-1], 1.0], [1.0, *web[::-1], 0.0])
        return np.asarray(self.record["flange_moment"] + self.record["web_moment"] * left)

    def moment_capacity(self, axial_force: ArrayLike, shear_force: ArrayLike) -> Array:
        """M_c (N m) beside axial and shear forces (N) of any shapes that fit; NaN outside."""
        web = self.record
        n, v = np.broadcast_arrays(np.abs(axial_force), np.abs(shear_force) / web["shear"])
        rho = np.sqrt(np.maximum(1.0 - v**2, 0.0))
        moments = np.empty(n.shape)
        for i in np.ndindex(n.shape):
            moments[i] = panel_kernels.moment_capacity(web, n[i], rho[i])[0]
        inside = (v <= 1.0) & (n <= web["flange_axial"] + rho * web["web_axial"])
        return np.where(inside, moments, np.nan)
