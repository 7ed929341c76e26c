"""A stud and the concrete around it, for the mechanical model; the studs of a table of tests.

**Second part.** The stud as a fiber beam on a bearing foundation, with its anchorage, as a
structure.

The stud lies along x, from the flange (x = 0) to the head; u is along x, v along the slip. Besides
the nodes of the stud there are the flange, which drives v, and the cone of concrete above the head.

    flange --slide-- base ==== shank in bearings ==== head --pressure-- cone --crack-- slab
    flange --collar-- slab      flange --contact-- cone (its surface carries the flange)

The flange turns nothing and moves with the base along x. While it rests on the slab the pull on the
head closes over the contact, so that the cone is not loaded; when the flange is lifted, it is.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi, sqrt
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from workbench.base.arrays import Indices
from workbench.base.errors import InputError, OutOfDomainError
from workbench.base.fields import Declared, Number, checked
from workbench.mechanics.structures.assembly import PlanarAssembly, graded_lengths
from workbench.mechanics.structures.elements import Bars, ElementGroup, StepEnergies, StepRequest
from workbench.mechanics.structures.fibers import BeamSection
from workbench.mechanics.structures.fibers.section import FiberBeams, LinearHardening
from workbench.studs.formulas import SHEAR_MODELS
from workbench.studs.mechanical import kernels
from workbench.studs.schema import HEADED, USUAL
from workbench.studs.tables import (
    HEAD_DIAMETER,
    HEAD_HEIGHT,
    Array,
    concrete_modulus,
    specimens,
)

LENGTH = Number(1e-3, 1.0, "m", advice="lengths are in metres")
STRESS = Number(1e6, 3e9, "Pa", advice="stresses are in Pa: 30 MPa is 30e6")
STEEL_MODULUS, SHEAR_MODULUS, DENSITY = 210e9, 81e9, 7850.0
COLLAR_DIAMETER, COLLAR_HEIGHT = 1.25, 0.27  # usual, ISO 13918, as shares of the diameter
LEAST_SLENDERNESS = 4.0 - 1e-9  # height over diameter: a stockier stud may pry out
YIELD_SHARE = 0.8  # of the tensile strength, where the yield stress was not measured


@dataclass(frozen=True)
class Stud(Declared, table="stud"):
    """A headed stud in a solid slab.

    Arguments: `diameter` and `height` in m; mean `concrete_strength` and `concrete_modulus`,
    `ultimate_strength` in Pa; `yield_stress` (None: 0.8 of the ultimate strength) in Pa; sizes of
    head and weld collar in m (None: usual proportions of ISO 13918).
    """

    diameter: float = checked(LENGTH)
    height: float = checked(LENGTH)
    concrete_strength: float = checked(STRESS)
    concrete_modulus: float = checked(Number(3e9, 9e10, "Pa"))
    ultimate_strength: float = checked(STRESS)
    yield_stress: float | None = checked(STRESS, optional=True)
    head_diameter: float | None = checked(LENGTH, optional=True)
    head_height: float | None = checked(LENGTH, optional=True)
    collar_diameter: float | None = checked(LENGTH, optional=True)
    collar_height: float | None = checked(Number(0.0, 0.05, "m"), optional=True)

    def check(self) -> None:
        """Refuse what the fields cannot be together."""
        for name, share in (
            ("head_diameter", HEAD_DIAMETER), ("head_height", HEAD_HEIGHT),
            ("collar_diameter", COLLAR_DIAMETER), ("collar_height", COLLAR_HEIGHT),
        ):  # fmt: skip
            if getattr(self, name) is None:
                object.__setattr__(self, name, share * self.diameter)
        if self.yield_stress is None:
            object.__setattr__(self, "yield_stress", YIELD_SHARE * self.ultimate_strength)
        if not self.head_diameter > self.diameter:  # type: ignore[operator]
            raise self.refusal("head_diameter", "must exceed the diameter")
        if self.height < LEAST_SLENDERNESS * self.diameter:
            reason = f"must be {LEAST_SLENDERNESS:g} diameters or more"
            raise self.refusal("height", reason, "stockier studs may pry out: no model of that")
        if self.embedment < 2.0 * self.diameter:
            raise self.refusal("height", "must leave an embedment of two diameters or more")

    @classmethod
    def of_concrete(
        cls, diameter: float, height: float, concrete_strength: float, ultimate_strength: float
    ) -> Stud:
        """A stud in concrete of 4733 sqrt(fc) MPa modulus (ACI 318); arguments in m and Pa."""
        modulus = float(concrete_modulus(concrete_strength))
        return cls(diameter, height, concrete_strength, modulus, ultimate_strength)

    @property
    def title(self) -> str:
        """Its sizes and strengths in words."""
        size = f"{1e3 * self.diameter:.4g} x {1e3 * self.height:.4g} mm"
        strengths = (self.concrete_strength / 1e6, self.ultimate_strength / 1e6)
        return f"{size}, f_c {strengths[0]:.3g} MPa, f_u {strengths[1]:.3g} MPa"

    @property
    def area(self) -> float:
        """Area of the shank in m2."""
        return 0.25 * pi * self.diameter**2

    @property
    def head_area(self) -> float:
        """Area of the head that presses on the concrete, in m2."""
        return 0.25 * pi * (float(self.head_diameter or 0.0) ** 2 - self.diameter**2)

    @property
    def embedment(self) -> float:
        """Effective embedment, from the slab's surface to the underside of the head, in m."""
        return self.height - float(self.head_height or 0.0)

    @property
    def tensile_strength(self) -> float:
        """Tensile strength of the shank, A_s f_u, in N."""
        return self.area * self.ultimate_strength

    @property
    def shear_strength(self) -> float:
        """Plastic shear strength of the shank, A_s f_u / sqrt(3), in N (von Mises)."""
        return self.tensile_strength / sqrt(3.0)

    @property
    def largest_shear(self) -> float:
        """Largest shear of a push-out, in N, whatever the bearing of the shank gives.

        The tensile strength of the shank, and the concrete term of the mean form of EN 1994-1-1
        (splitting and crushing of the slab, which no part of the mechanism knows).
        """
        sizes = (self.diameter, self.height, self.concrete_strength, self.concrete_modulus)
        return min(self.tensile_strength, float(SHEAR_MODELS["roik-mean"].concrete(*sizes)))


@dataclass(frozen=True)
class Surroundings(Declared, table="surroundings"):
    """Parameters of the concrete around a stud.

    Calibrated on push-out tests (`calibrate`): `bearing_factor`, bearing strength of concrete over
    its cylinder strength; `foundation_factor`, foundation modulus per length over the modulus of
    concrete; `slide_capacity`, shear slide at rupture over the diameter.
    Assumed: `friction` between flange and slab; `head_factor`, pressure under the head over
    cylinder strength at pull-through; `cone_factor`, mean factor of the cone; `cone_peak` and
    `cone_end`, opening of the cone at its peak and at nearly zero load over the embedment;
    `cone_loss`, share of bearing strength and stiffness (shank, collar, head) that a fully formed
    cone takes away; `rupture_strain`, mean axial plastic strain at rupture.
    """

    bearing_factor: float = checked(Number(0.5, 40.0), 6.0)
    foundation_factor: float = checked(Number(0.01, 10.0), 0.5)
    slide_capacity: float = checked(Number(0.01, 2.0), 0.3)
    friction: float = checked(Number(0.0, 1.0), 0.4)
    head_factor: float = checked(Number(2.0, 40.0), 12.0)
    cone_factor: float = checked(Number(5.0, 30.0), 16.8)
    cone_peak: float = checked(Number(1e-4, 0.05), 0.005)
    cone_end: float = checked(Number(1e-3, 0.5), 0.06)
    cone_loss: float = checked(Number(0.0, 1.0), 0.5)
    rupture_strain: float = checked(Number(0.01, 0.5), 0.12)

    def check(self) -> None:
        """Refuse what the fields cannot be together."""
        if self.cone_end <= self.cone_peak:
            raise self.refusal("cone_end", "must exceed cone_peak")


NEEDED = ("diameter", "height", "concrete_strength", "concrete_modulus", "ultimate_strength")


def stud_of(row: pd.Series) -> Stud:
    """The stud of a row of a table of tests. Raises `InputError` for missing values."""
    test = specimens(pd.DataFrame([row]))
    values = {name: float(getattr(test, name)[0]) for name in NEEDED}
    for name, value in values.items():
        if not np.isfinite(value):
            where = f"{row['campaign']} {row['specimen']}"
            raise InputError(f"{where}: {name}", None, "must be known for the mechanical model")
    sizes = ("head_diameter", "collar_diameter", "collar_height")
    optional = {"yield_stress": 1e6 * row["fy_MPa"], **{n: 1e-3 * row[f"{n}_mm"] for n in sizes}}
    return Stud(**values, **{n: float(v) for n, v in optional.items() if np.isfinite(v)})


# by how much (a share) the studs of a table may differ in the columns of `USUAL` and still are one
ALIKE = np.array([0.02, 0.02, 0.1, 0.1])


class TableStud(NamedTuple):
    """A `stud` of a table, in how many `tests`, and what is `assumed` of it (words)."""

    stud: Stud
    tests: int
    assumed: str


def studs_of(
    table: pd.DataFrame, given: Mapping[str, float | None]
) -> tuple[list[TableStud], list[str]]:
    """The different headed studs of a table with their mean values, that of most tests first.

    And why the model refuses others. Raises `InputError` where it refuses all.
    Arguments: `given`, values by column (those of `USUAL`, None: not given) that count instead of
    those of the table. What neither tells is taken from `USUAL`, and said to be assumed.
    """
    stated = {name: value for name, value in given.items() if value is not None}
    rows = table[table["connector"] == HEADED].reindex(columns=list(USUAL)).astype(float)
    rows = (rows if len(rows) else pd.DataFrame([dict.fromkeys(USUAL, np.nan)])).assign(**stated)
    known = rows.dropna(subset=[name for name in USUAL if rows[name].notna().any()])
    known = rows if known.empty else known
    assumed = [f"{name} {USUAL[name]:g}" for name in USUAL if known[name].isna().any()]
    groups: list[list[Array]] = []
    for values in known.fillna(USUAL).to_numpy(float):
        same = (g for g in groups if np.all(np.abs(values / g[0] - 1.0) <= ALIKE))
        if (group := next(same, None)) is None:
            groups.append(group := [])
        group.append(values)
    groups.sort(key=len, reverse=True)
    means = [np.mean(group, axis=0) * (1e-3, 1e-3, 1e6, 1e6) for group in groups]
    studs, refused = [], []
    for mean, group in zip(means, groups, strict=True):
        try:
            stud = Stud.of_concrete(*mean.tolist())
        except InputError as error:
            refused.append(error)
        else:
            studs.append(TableStud(stud, len(group) if len(table) else 0, ", ".join(assumed)))
    if not studs:
        raise refused[0]
    return studs, [str(error) for error in refused]


AXIAL, LATERAL = 0, 1  # component u along the stud, v across it
GROUND = -1


class Link(NamedTuple):
    """One link: nodes and component it joins, law and parameters.

    `grounded`: the link joins the first node to the ground, and the second is only a neighbour of
    it (an element group of the structures floor has two nodes); `sign` of the deformation s =
    sign (q_first - q_second); `stiffness` K in N/m, `strength` F in N; `peak` and `end`
    deformation of the cone in m.
    """

    law: int
    first: int
    second: int
    component: int
    stiffness: float
    strength: float = np.inf
    sign: float = 1.0
    peak: float = 1.0
    end: float = 2.0
    grounded: bool = False


class LinkState(NamedTuple):
    """States (links, 2), see the kernels; forces in N, their slopes in N/m, deformations in m."""

    inner: Array
    force: Array
    slope: Array
    deformation: Array


class LinkTables(NamedTuple):
    """Links as arrays: dofs (or `GROUND`), sign, law, and `parameters` K, F, peak, end."""

    first: Indices
    second: Indices
    sign: Array
    law: Indices
    parameters: Array


class Links(ElementGroup):
    """All links of a stud; `factor` and `cap` may be set between steps."""

    _old: LinkState
    _new: LinkState

    def __init__(self, links: list[Link]) -> None:
        count = len(links)
        state = LinkState(np.zeros((count, 2)), *np.zeros((3, count)))
        super().__init__([[link.first, link.second] for link in links], state)
        self.links = tuple(links)
        self.factor = np.ones(count)
        self.cap = np.ones(count)

    def place(self, bars: Bars) -> None:
        """Take its place in a structure; links have no length."""
        super().place(bars)
        columns: Any = Link._make(map(np.array, zip(*self.links, strict=True)))
        rows, near, far = np.arange(len(self.links)), columns.component, 3 + columns.component
        laws = (columns.stiffness, columns.strength, columns.peak, columns.end)
        self._tables = LinkTables(
            bars.dofs[rows, near],
            np.where(columns.grounded, GROUND, bars.dofs[rows, far]),
            columns.sign,
            columns.law,
            np.column_stack(laws),
        )
        entry = np.stack([7 * near, 6 * near + far, 6 * far + near, 7 * far], axis=1)
        self._chosen: Indices = bars.positions[rows[:, None], entry]

    def assemble(self, step: StepRequest) -> None:
        """Add forces and tangent of a static step; keep the trial state."""
        if step.dynamic:
            raise OutOfDomainError("the links of a stud are made for statics")
        kernels.evaluate(step.end, self._tables, self.factor, self.cap, self._old, self._new)
        kernels.scatter(step.force, step.band, self._tables, self._chosen, self._new)

    def account(self, weight: float) -> StepEnergies:
        """Energies of the step by the trapezoidal rule; stored is f^2 / 2 K."""
        old, new = self._old, self._new
        work = 0.5 * (new.force + old.force) * (new.deformation - old.deformation)
        slope = self._tables.parameters[:, 0] * self.factor
        stored = 0.5 * new.force**2 / slope
        before = 0.5 * old.force**2 / slope
        lost = float(np.sum(work - (stored - before)))
        return StepEnergies(float(np.sum(stored)), lost, 0.0, lost)

    @property
    def state(self) -> LinkState:
        """The committed state."""
        return self._old


LAYERS = 16
SMALLEST_SHARE, LARGEST_SHARE = 0.2, 0.6  # element lengths over the diameter
STIFF = 30.0  # contact and slide over the axial stiffness of a diameter of shank: nearly rigid
BOND_SHARE = 0.01  # bond of the shank over its tensile strength
RUPTURE_STRETCH = 2.0  # diameters from the base over which the axial strain is averaged


def round_section(stud: Stud) -> BeamSection:
    """Layers of the round shank; hardening from yield to the ultimate strength at 15 % strain."""
    angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, LAYERS + 1)
    r = 0.5 * stud.diameter
    # exact areas and centroids of the strips between heights r sin(angle)
    area = np.diff(r * r * (angle + np.sin(angle) * np.cos(angle)))
    first = np.diff(-2.0 / 3.0 * r**3 * np.cos(angle) ** 3)
    yield_stress = float(stud.yield_stress or stud.ultimate_strength)
    hardening = max((stud.ultimate_strength - yield_stress) / 0.15, 1e-5 * STEEL_MODULUS)
    return BeamSection(
        first / area,
        area,
        LinearHardening(STEEL_MODULUS, yield_stress, hardening),
        DENSITY * stud.area,
        shear_stiffness=0.9 * SHEAR_MODULUS * stud.area,
    )


class StudStructure:
    """A stud in its slab, ready to be driven. `refinement` halves the elements so often."""

    def __init__(self, stud: Stud, around: Surroundings, refinement: int = 0) -> None:
        self.stud, self.around = stud, around
        d = stud.diameter
        lengths = graded_lengths(stud.embedment, SMALLEST_SHARE * d, LARGEST_SHARE * d)
        lengths = np.repeat(lengths, 2**refinement) / 2**refinement
        self.depth: Array = np.concatenate([[0.0], np.cumsum(lengths)])
        self.tributary = np.convolve(lengths, [0.5, 0.5])
        count = len(lengths)
        self.head, self.flange, self.cone = count, count + 1, count + 2
        nodes = np.stack([np.arange(count), np.arange(1, count + 1)], axis=1)
        self.beams = FiberBeams(nodes, np.zeros(count, dtype=np.int64), [round_section(stud)])
        self.links = Links(self._make_links())
        # flange and cone have no place of their own; chords of no length would upset tolerances
        x = np.concatenate([self.depth, [-d, stud.embedment + d]])
        self.assembly = PlanarAssembly(
            np.stack([x, np.zeros_like(x)], axis=1), [self.beams, self.links]
        )
        dof = self.assembly.dof
        self.slip_dof, self.uplift_dof = dof(self.flange, "v"), dof(0, "u")
        self._shank_dofs = np.array([dof(node, "u") for node in range(self.head + 1)])
        self._cone_dof = dof(self.cone, "u")
        # the concrete of a node reaches half its length up; that of the base lies below it alone
        self._above = np.concatenate([[self.tributary[0]], 0.5 * self.tributary[1:]])
        stretched = self.depth[1:] <= RUPTURE_STRETCH * d + 1e-12
        fibers = self.beams.sections[0].area
        self._stretch = np.outer(lengths * stretched, fibers) / (lengths @ stretched * fibers.sum())
        self.assembly.hold(
            [dof(0, "rotation"), dof(self.flange, "u"), dof(self.flange, "rotation"),
             dof(self.cone, "v"), dof(self.cone, "rotation"), self.slip_dof]
        )  # fmt: skip
        self.update()

    @property
    def cone_strength(self) -> float:
        """Mean strength of the concrete cone, k sqrt(f_c) h_ef^1.5 (EN 1992-4, N and mm)."""
        stud = self.stud
        root = np.sqrt(stud.concrete_strength / 1e6)
        return float(self.around.cone_factor * root * (1e3 * stud.embedment) ** 1.5)

    def _make_links(self) -> list[Link]:
        stud, around = self.stud, self.around
        d, fc, ec = stud.diameter, stud.concrete_strength, stud.concrete_modulus
        modulus = around.foundation_factor * ec
        pressure = around.bearing_factor * fc
        rigid = STIFF * STEEL_MODULUS * stud.area / d
        collar_d, collar_h = float(stud.collar_diameter or d), float(stud.collar_height or 0.0)
        head = stud.head_area
        cone = self.cone_strength
        peak = around.cone_peak * stud.embedment
        bearing = [(modulus * share, pressure * d * share) for share in self.tributary]
        links = [
            Link(kernels.BEARING, node, abs(node - 1), LATERAL, *laws, grounded=True)
            for node, laws in enumerate(bearing)
        ]
        places = range(len(links), len(links) + 5)
        self.slide, self.collar, self.pressure, self.crack, self.contact = places
        return [
            *links,
            Link(kernels.SLIDE, self.flange, 0, LATERAL, rigid, stud.shear_strength),
            Link(kernels.BEARING, self.flange, 0, LATERAL, modulus * max(collar_h, 1e-6),
                 pressure * collar_d * max(collar_h, 1e-6), grounded=True),
            # u of the head falls when it is pulled: the cone is the first end
            Link(kernels.BEARING, self.cone, self.head, AXIAL, ec * np.sqrt(head),
                 around.head_factor * fc * head),
            Link(kernels.CONE, self.cone, self.head, AXIAL, 2.0 * cone / peak, cone, -1.0,
                 peak, around.cone_end * stud.embedment, grounded=True),
            Link(kernels.CONTACT, 0, self.cone, AXIAL, rigid),
            # bond of the shank: little, but it keeps a stud in place that has come loose
            Link(kernels.SLIDE, self.cone, self.head, AXIAL, 0.1 * ec * np.sqrt(head),
                 BOND_SHARE * stud.tensile_strength),
        ]  # fmt: skip

    # -- what follows the committed state ----------------------------------------------------

    @property
    def uplift(self) -> float:
        """Uplift of the flange, in m."""
        return -float(self.assembly.displacement[self.uplift_dof])

    @property
    def base_tension(self) -> float:
        """Axial force in the shank at its base, in N."""
        return float(self.beams.local_forces[0, 0])

    @property
    def head_crushed(self) -> bool:
        """Whether the pressure under the head has come to its limit."""
        limit = self.links.links[self.pressure].strength
        return bool(self.links.state.force[self.pressure] > 0.97 * limit)

    @property
    def anchorage_exhausted(self) -> bool:
        """Whether the cone or the pressure under the head has come to its limit."""
        opened = float(self.links.state.deformation[self.crack])
        return opened > 0.8 * self.links.links[self.crack].peak or self.head_crushed

    @property
    def cone_damage(self) -> float:
        """Share of the cone's strength that is lost for good, 0 to 1."""
        opened = float(self.links.state.inner[self.crack, 0])
        link = self.links.links[self.crack]
        if opened <= link.peak:
            return 0.0
        left, _ = kernels.cone_envelope(opened, link.strength, link.peak, link.end)
        return float(1.0 - left / link.strength)

    @property
    def ruptured(self) -> bool:
        """Whether the shank is torn: shear slide and axial stretch, each over its capacity, add.

        The plastic slide at the base counts over the diameter, the plastic strain as the mean over
        two diameters from the base.
        """
        slide = abs(float(self.links.state.inner[self.slide, 0])) / self.stud.diameter
        strain = max(float(np.sum(self.beams.plastic_strains * self._stretch)), 0.0)
        around = self.around
        return slide / around.slide_capacity + strain / around.rupture_strain >= 1.0

    def update(self) -> None:
        """Take embedment, damage of the cone and the tension in the shank over into the links.

        They lag behind by one step, so steps must be small.
        """
        u = self.assembly.displacement
        # a node that is drawn out of the concrete has no bearing
        depth = self.depth + u[self._shank_dofs] - u[self._cone_dof]
        share = np.clip((depth + self._above) / self.tributary, 0.0, 1.0)
        # a broken cone bears less and gives more: strength and stiffness fall together
        loss = 1.0 - self.around.cone_loss * self.cone_damage
        self.links.factor[: self.head + 1] = np.maximum(share * loss, 1e-9)
        height = float(self.stud.collar_height or 0.0)
        gap = max(-float(self.links.state.deformation[self.contact]), 0.0)
        left = max(1.0 - gap / height, 0.0) if height > 0.0 else 0.0
        self.links.factor[self.collar] = max(left * loss, 1e-9)
        self.links.cap[self.pressure] = max(loss, 0.05)
        ratio = self.base_tension / self.stud.tensile_strength
        if abs(ratio) >= 1.0:
            raise OutOfDomainError("the shank is loaded beyond its tensile strength")
        self.links.cap[self.slide] = max(np.sqrt(1.0 - ratio * ratio), 0.02)

    def friction(self) -> float:
        """Friction between flange and slab while it slips, in N."""
        return self.around.friction * max(float(self.links.state.force[self.contact]), 0.0)
