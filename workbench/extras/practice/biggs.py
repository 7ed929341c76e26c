"""Biggs' equivalent single degree of freedom, stage by stage (Biggs 1964; UFC 3-340-02).

Beside it, direct shear: the ends of a member slide over their supports (Krauthammer and others,
told by Heng 2017, chapter 4; the paper was not at hand). Nothing couples them to flexure but its
dynamic reaction V,

    m_s s'' + R_s(s) = V(t),   m_s = m L / 2,

m_s what either end has of the member that slides as a whole under a line load. R_s of a rolled
section is that of its web, elastic over the height h and then plastic: V_pl at s = h tau_y / G.
"""

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from workbench.base.arrays import Array
from workbench.base.errors import Collapse, CollapseError
from workbench.base.errors import Mechanism as Fall
from workbench.base.fields import checked
from workbench.mechanics.impact.integrator import follow
from workbench.mechanics.impact.pace import Pace
from workbench.models.energy_estimate import energy_to_absorb
from workbench.models.hit_mass import light_impact_mass
from workbench.models.resistance import Resistance, ResistanceCurve, mechanism_of
from workbench.models.resistance import curve as events
from workbench.models.resistance.columns import STAGES, digest, given_curve, is_given
from workbench.models.resistance.curve import straight_pieces
from workbench.models.resistance.kernels import PIECE
from workbench.models.resistance.shapes import (
    AXIAL,
    AXIAL_HELP,
    NONE,
    SECTION,
    Stage,
    stages_of,
)
from workbench.models.single_dof import SingleDof, march
from workbench.models.single_dof.model import Pushed, no_striker, pulse_response, under_pulse
from workbench.responses import Finding, Response, finding, findings_of, set_findings
from workbench.scenarios import Column, ColumnImpact, ColumnScenario, MemberPulse
from workbench.scenarios.pulse import UNIFORM

WEB = "web"
DIRECT_SHEAR = Resistance((NONE, WEB))
_PARTS = 64  # of the period of the mass that slides
_PLACES = ("base", "hit", "head")  # nodes of the beam


@dataclass(frozen=True)
class Biggs(SingleDof):
    """Equivalent mass and resistance of every stage, by integrating the deflected shape."""

    axial: str = checked(AXIAL, SECTION, help=AXIAL_HELP)
    direct_shear: str = checked(
        DIRECT_SHEAR, NONE, help="resistance to the slip of either end under a line load"
    )
    resistance: ClassVar[str] = STAGES  # type: ignore[misc]
    rotational_stiffness: ClassVar[None] = None  # type: ignore[misc]
    rate_factor: ClassVar[None] = None  # type: ignore[misc]
    interaction: ClassVar[str] = SECTION  # type: ignore[misc]
    hit_mass: ClassVar[str] = "shape"  # type: ignore[misc]

    name: ClassVar[str] = "biggs"
    version: ClassVar[int] = 4
    unused: ClassVar[tuple[str, ...]] = ("column.head_mass", "column.restraint_stiffness")
    crushing: ClassVar[bool] = False  # the energy says which mass is hit
    assumptions: ClassVar[tuple[str, ...]] = (
        "The member moves in the shape that its load makes statically, another one for each stage: "
        "elastic, elastic with hinges, mechanism with hinges at clamped ends and the impact point.",
        "Flexure alone: the axial load lowers the plastic moment and does nothing else, there is "
        "no second-order work and no catenary action.",
        "A striker meets the mass of the stage to which its energy takes the member; one that is "
        "given as the impact mass counts as it is, under a pulse what it is more than a third of "
        "the member moves with the impact point.",
        "Elastic unloading with the initial stiffness; no shear, no local buckling, no strain-rate "
        "effect.",
    )

    @property
    def sources(self) -> tuple[str, ...]:  # type: ignore[override]
        """Bibliography keys of the model, and of direct shear if asked."""
        extra = () if self.direct_shear == NONE else ("krauthammer1986",)
        return ("heng2017", "biggs1964", "ufc3-340-02", *extra)

    @property
    def data_digest(self) -> str:
        """Hash of the points of `direct_shear` ("": none)."""
        return digest(self.direct_shear)

    def domain(self, scenario: ColumnScenario) -> list[Finding]:
        """Findings of `single-dof`; a refusal of direct shear unless a line load acts alone."""
        findings = super().domain(scenario)
        if self.direct_shear != NONE and getattr(scenario, "load", None) != UNIFORM:
            findings.append(finding("direct-shear-of-line-loads", kind=scenario.KIND))
        light = light_impact_mass(scenario) if isinstance(scenario, MemberPulse) else []
        return findings + light

    def stages(self, column: Column, uniform: bool = False) -> tuple[Stage, ...]:
        """Stages under a force at the impact point, or under a `uniform` line load."""
        return stages_of(column, self.axial, uniform)

    def curve(self, column: Column, uniform: bool = False) -> ResistanceCurve:
        """Resistance curve of the stages, as in `single-dof`. Raises `OutOfDomainError`."""
        return stage_curve(column, self.stages(column, uniform), uniform)

    def with_mass(self, scenario: ColumnImpact) -> ColumnImpact:
        """The impact with the mass (kg) of the stage to which the energy of the blow leads."""
        column, curve = scenario.column, self.curve(scenario.column)
        if column.impact_mass is not None:
            return scenario
        total = column.properties.mass_per_length * column.length
        for stage in reversed(self.stages(column)):
            column = replace(column, impact_mass=stage.mass_factor * total)
            heavier = replace(scenario, column=column)
            if energy_to_absorb(heavier) >= curve.work(stage.start):
                break
        return heavier

    def pushed(self, scenario: MemberPulse) -> Pushed:
        """System that a pulse moves: mass K_LM M of each stage against the resistance to its load.

        A line load does the work of K_L times it, another K_L in each stage: energies of the member
        are not those of the equivalent system then.
        """
        column, uniform = scenario.column, scenario.load == UNIFORM
        total = column.properties.mass_per_length * column.length
        stages, share = self.stages(column, uniform), _share(uniform)
        masses = [
            share * (stage.load_mass_factor * total + column.attached_mass / stage.load_factor)
            for stage in stages
        ]
        # a larger mass keeps the momentum, a smaller one the velocity
        carried = [min(1.0, m0 / m1) for m0, m1 in zip((masses[0], *masses), masses, strict=False)]
        moved = zip((stage.start for stage in stages), masses, carried, strict=True)
        return Pushed(
            *(self.curve(column, uniform), tuple(moved), share * scenario.whole, not uniform),
            self.radiation_damping,
        )

    def _solve(self, scenario: ColumnScenario) -> Response:
        if not isinstance(scenario, MemberPulse):
            return super()._solve(scenario)
        stages = self.stages(scenario.column, scenario.load == UNIFORM)
        attached = scenario.column.attached_mass / scenario.column.properties.mass_per_length

        def known(values: dict[str, Any]) -> dict[str, Any]:
            resisted = values["force"] / _share(scenario.load == UNIFORM)
            moved = values["displacement"], resisted, values["load"]
            uniform = scenario.load == UNIFORM
            return {"reaction": dynamic_reactions(stages, uniform, *moved, attached)}

        response = pulse_response(scenario, self.pushed(scenario), known)
        if self.direct_shear != NONE:
            time, reaction = response["time"].values, response["reaction"]
            slip = slips(scenario.column, self.direct_shear, time, reaction.values)
            meaning = {"units": "m", "long_name": "slip of the support behind the segment"}
            response["direct_shear.slip"] = (reaction.dims, slip, meaning)
            warnings = [*findings_of(response), finding("slip", 1e3 * float(abs(slip).max()))]
            set_findings(response, warnings)
        return response


def dynamic_reactions(
    stages: tuple[Stage, ...],
    uniform: bool,
    displacement: Array,
    force: Array,
    load: Array,
    attached: float = 0.0,
) -> Array:
    """Reactions (2, times) of both supports, from resistance and load over time.

    A mass at the impact point is as heavy as the `attached` length (m) of the member.

    Biggs 1964, section 5.3: inertia forces have the shape of the stage, and the moments at ends and
    impact point are those of the resistance. Both bars in equilibrium, vertically and about the
    support, give both reactions, the shear forces beside the impact point and the size of the
    inertia.
    """
    furthest = np.maximum.accumulate(np.abs(displacement))
    turns = np.append(True, furthest[1:] > furthest[:-1])  # farther than ever, either way
    last = np.maximum.accumulate(np.where(turns, np.arange(len(force)), 0))
    side = np.where(displacement[last] < 0.0, -1.0, 1.0)
    now = np.searchsorted([stage.start for stage in stages], furthest, side="right") - 1
    elastic = stages[0].rates
    reactions = np.zeros((2, len(force)))
    for number, stage in enumerate(stages):
        here = now == number
        base, hit, head = stage.shape.nodes
        reached = stage.load + stage.stiffness * (furthest[here] - stage.start)
        moments = stage.moments + np.outer(reached - stage.load, stage.rates)
        moments += np.outer(side[here] * force[here] - reached, elastic)  # taken off since
        moments *= side[here, None]
        (below, at_below), (above, at_above) = stage.shape.inertia(0, 1), stage.shape.inertia(1, 2)
        line = 1.0 / (head - base) if uniform else 0.0
        # reactions down, shear forces of the impact point on either bar, inertia; all along the
        # load
        balance = np.array(
            [
                [-1.0, 0.0, 1.0, 0.0, -below],
                [0.0, 0.0, hit - base, 0.0, -below * (at_below - base)],
                [0.0, -1.0, 0.0, 1.0, -above],
                [0.0, 0.0, 0.0, head - hit, -above * (head - at_above)],
                [0.0, 0.0, 1.0, 1.0, attached],
            ]
        )
        pressed = line * np.array([hit - base, (hit - base) ** 2 / 2.0, head - hit])
        pressed = np.append(pressed, line * (head - hit) ** 2 / 2.0)
        right = np.zeros((5, int(here.sum())))
        right[:4] = -np.outer(pressed, load[here])
        right[1] += moments[:, 1] - moments[:, 0]
        right[3] += moments[:, 1] - moments[:, 2]
        right[4] = 0.0 if uniform else load[here]
        reactions[:, here] = np.linalg.solve(balance, right)[:2]
    return reactions


def _share(uniform: bool) -> float:
    """Of a load, what acts at the impact point of rigid bars."""
    return 0.5 if uniform else 1.0


def stage_curve(column: Column, stages: tuple[Stage, ...], uniform: bool) -> ResistanceCurve:
    """Resistance (N) to a force, or to half of a `uniform` load, over the displacement there."""
    mechanism = mechanism_of(column, uniform=uniform)
    pieces = np.zeros(len(stages), PIECE)
    before: frozenset[int] = frozenset()
    for piece, stage in zip(pieces, stages, strict=True):
        piece["start"], piece["c"][:2] = stage.start, (stage.load, stage.stiffness)
        piece["c"] *= _share(uniform)
        if stage.stiffness == 0.0:
            piece["event"] = events.LOAD
        elif stage.hinges:
            piece["event"] = events.YIELDS
            place = _PLACES[min(stage.hinges - before)]
            piece["group"] = mechanism.groups.index(place)
        before = stage.hinges
    return ResistanceCurve(STAGES, mechanism, pieces, stages[1].start)


def slip_resistance(column: Column, law: str) -> ResistanceCurve:
    """Resistance (N) of a support over the slip (m): `law` web or the points of a CSV file."""
    mechanism = mechanism_of(column, uniform=True)
    if is_given(law):
        return given_curve(mechanism, law)
    steel, force = column.steel, column.properties.shear_resistance
    strain = steel.yield_stress / np.sqrt(3.0) / steel.shear_modulus
    elastic = float(strain * column.section.height)
    pieces = straight_pieces(elastic * np.arange(3.0), force * np.array([0.0, 1.0, 1.0]))
    return ResistanceCurve(WEB, mechanism, pieces, elastic)


def slips(column: Column, law: str, time: Array, reactions: Array) -> Array:
    """Slip (2, times) in m of both ends under `reactions` (2, times) in N at equal `time` (s).

    Raises `CollapseError` where an end has slid beyond its resistance: it is sheared off.
    """
    curve = slip_resistance(column, law)
    mass = 0.5 * column.properties.mass_per_length * column.length
    period = 2.0 * np.pi * np.sqrt(mass / curve.pieces["c"][:, 1].max())
    parts = max(1, int(np.ceil(_PARTS * time[1] / period)))
    fine = np.linspace(0.0, time[-1], (len(time) - 1) * parts + 1)
    limit, slid = min(curve.lost_at, curve.end), []
    for end, reaction in zip(("base", "head"), reactions, strict=True):
        force = np.interp(fine, time, reaction)
        stages, means = np.array([(0.0, mass, 1.0)]), 0.5 * (force[1:] + force[:-1])
        drive = no_striker(curve.elastic_limit, limit, mass)
        pace = Pace.equal(fine[-1], fine[1], len(means))
        run = follow(under_pulse, (curve.pieces, stages, means, 0.0), pace, drive, march.RECORD)
        if run.collapsed:
            fallen = Collapse(Fall.SHEAR, (end,), limit, float(run.records["time"][-1]))
            raise CollapseError(fallen, f"the {end} slides beyond its resistance to direct shear")
        slid.append(run.records["displacement"][::parts])
    return np.array(slid)
