"""The impacted column as two rigid bars and four generalized hinges, with four unknowns.

Heng 2017, section 5.1: hinges at the base (1), on both sides of the impact point (2, 3) and at the
head (4). Their rotational stiffnesses make the bars the elastic column under a force at the impact
point (`elastic_springs`; the thesis: 6 EI / l of a bar of length l, 3 EI / l at the impact point if
the bar's other end is pinned); the hinges of a bar share its axial stiffness EA / l. The impact
mass m1 (a third of the column) sits at the impact point, the head mass at the head. Derivation:
`kinematics`, `statics`, `march`, in this order.

**Second part.** The two models of two rigid bars: hinges that see N and M, and panels that see V as
well.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from math import inf
from time import perf_counter
from typing import Any, ClassVar

import numpy as np

from workbench.base.arrays import Array, Flags
from workbench.base.errors import Collapse, CollapseError, Mechanism, OutOfDomainError, SolverError
from workbench.base.fields import Choice, Flag, Number, checked
from workbench.mechanics.frames.collapse import COLLAPSE_SIDEWAYS
from workbench.mechanics.frames.members import shear_stiffness
from workbench.mechanics.frames.runs import resting
from workbench.mechanics.impact.integrator import FollowedImpact, follow, followed, histories_of
from workbench.mechanics.impact.pace import Pace
from workbench.models.base import Answering
from workbench.models.batch import SURVIVES, UNKNOWN, BatchAnswers
from workbench.models.domain import (
    buckles,
    buckling_findings,
    count_finding,
    panel_findings,
    panel_refused,
    shear_findings,
    stub_findings,
)
from workbench.models.elastic_springs import Springs, beam_springs, thesis_springs
from workbench.models.four_dof import march, statics
from workbench.models.four_dof.kinematics import U2, V
from workbench.models.four_dof.march import NEARLY, along_tangent
from workbench.models.hit_mass import HIT_MASS, THESIS, WAVES, with_hit_mass
from workbench.models.strain_rate import FACTOR, RATE_LEVELS, check_bars, flows
from workbench.responses import VARIABLES, Finding, Response, build_response, finding, open_share
from workbench.responses.histories import balance_error
from workbench.scenarios import Column, ColumnImpact, ColumnPushover, ColumnScenario
from workbench.scenarios.varied import spread
from workbench.steel.hinges import (
    ShearSurface,
    YieldSurface,
    has_bar_law,
    has_shear_surface,
    has_webs,
)
from workbench.steel.hinges.interaction import fitted_exponents
from workbench.steel.hinges.panel_elements import bar_law, panel_law

HINGES = ("base", "hit-below", "hit-above", "head")
_BARS, _PLACES = np.array(march.HINGES).T
SEGMENTS = ("below", "above")
_NAMES: dict[str, Any] = {"hinges": HINGES, "segments": SEGMENTS}
_PUSH_STEP = 1.25e-4  # of the length, changes the static force by less than 0.02 %
_SHORTEST_STEP = 1e-8  # s
PACES = 5  # of which the next is taken where the ledger is open
_MOST_STEPS = 1_000_000  # of a record; all of it and what is made of it take some 1 GB
_FIRST = 0.005  # step after an impact over the inverse of the axial frequency
_FEWEST, _RECORDS = 50, 2000  # steps; parts of the duration that are recorded by themselves


@dataclass(frozen=True)
class RigidBars(Answering):
    """Columns of two rigid bars and four hinges; models say how hinges yield.

    Shared options: `rotational_stiffness`: factor c of c EI / l of a hinge (the thesis: 6; None:
    springs that make the bars the elastic column under a force at the impact point); `time_step` in
    s (None: controlled by the error, some 0.1 % of the peak, until the balance closes to 1e-6);
    `hit_mass`: a third of the column (thesis), or what of it shares the velocity of the striker at
    once (waves); `rate_level`, of a steel with a rate law: a factor on the yield stress, or bars
    that flow and harden point by point (without rate and hardening the model is the same).
    """

    rotational_stiffness: float | None = checked(Number(0.1, 1e6), optional=True)
    time_step: float | None = checked(Number(_SHORTEST_STEP, 1.0, "s"), optional=True)
    hit_mass: str = checked(HIT_MASS, THESIS)
    rate_level: str = checked(Choice(RATE_LEVELS), FACTOR)

    name: ClassVar[str]
    version: ClassVar[int] = 5
    answers: ClassVar[tuple[str, ...]] = (ColumnImpact.KIND, ColumnPushover.KIND)
    assumptions: ClassVar[tuple[str, ...]] = (
        "Two rigid bars; all flexibility and plasticity in four generalized hinges.",
        "Springs that give the deflection and the moments of the elastic column under a force at "
        "the impact point, shear and axial load included; those of the thesis, 6EI/l (option "
        "rotational_stiffness), leave shear out and are too stiff for an eccentric hit.",
        "At most one third of the column's mass acts at the impact point; waves are left out.",
    )
    sources: ClassVar[tuple[str, ...]] = ("heng2017",)
    # without and with restitution: error, that of the vibration, flow
    _CONTROL: ClassVar[tuple[tuple[float, float, float], ...]] = (
        (1e-4, 4e-3, 0.85),
        (2e-5, 2e-4, 0.3),
    )
    crushing: ClassVar[bool] = True
    marches: ClassVar[Any] = march
    BALANCE: ClassVar[float] = 1e-6  # of the input energy, in which the ledger closes

    def check(self) -> None:
        """Refuse options that viscoplastic bars do not know."""
        super().check()
        check_bars(self)

    def _strength(self, column: Column, bars: Any) -> None:
        """Write the strength of the hinges into the column of the kernels."""
        raise NotImplementedError

    def _tables(self, column: Column) -> statics.Tables:
        return statics.VISCOPLASTIC if flows(self, column.steel) else statics.HINGES

    def _springs(self, column: Column) -> Springs:
        """Rotational springs of the elastic column."""
        raise NotImplementedError

    def _hinge_findings(self, scenario: ColumnScenario) -> list[Finding]:
        """Where the yielding of the hinges stops applying."""
        raise NotImplementedError

    def domain(self, scenario: ColumnScenario) -> list[Finding]:
        """Findings on the domain of hinges, the Euler load, the number of equal steps."""
        findings = buckling_findings(scenario) + self._hinge_findings(scenario)
        if any(finding.refusal for finding in findings):
            return findings
        if isinstance(scenario, ColumnImpact):
            step = self._fixed_step(scenario)
            if step is not None:
                findings += count_finding(scenario.duration, step, _MOST_STEPS)
        return findings

    def _solve(self, scenario: ColumnPushover | ColumnImpact) -> Response:
        if isinstance(scenario, ColumnPushover):
            return self._pushover(scenario)
        return self._impact(scenario)

    def bars(self, column: Column) -> tuple[Any, Array]:
        """The column as the kernels take it, and its preloaded (straight) state q."""
        bars, q = self._bars_of(column)
        return bars[0], q

    def _bars_of(self, column: Column) -> tuple[Any, Array]:
        """Bars of the column in a table of one row: kernels are called faster with tables."""
        kept, q = _kept(self, column)
        return np.frombuffer(bytearray(kept), self._tables(column).column), q[0].copy()

    def table_of(self, column: Column, count: int = 1) -> tuple[Any, Array]:
        """Bars of a stack of `count` columns: tables of them and their states (count, 4)."""
        properties = column.properties
        bars = np.zeros(count, self._tables(column).column)
        lengths, stiffness = bars["lengths"], bars["stiffness"]
        lengths[:, 0], lengths[:, 1] = column.length_below, column.length_above
        axial = spread(column.steel.elastic_modulus * properties.area, count)[:, None] / lengths
        factor = self.rotational_stiffness
        springs = self._springs(column) if factor is None else thesis_springs(column, factor)
        base, below, above, head = (1.0 / spread(each, count) for each in springs)
        stiffness[:, 0] = np.stack([axial[:, 0], base, below], axis=1)
        stiffness[:, 1] = np.stack([axial[:, 1], head, above], axis=1)
        bars["pinned"] = stiffness[:, :, 1:] == 0.0
        bars["flexibility"][:, :, [0, 1, 3]] = np.divide(
            1.0, stiffness, out=np.zeros(stiffness.shape), where=stiffness > 0.0
        )
        self._strength(column, bars)
        bars["free_head"] = column.head != "fixed"
        bars["spring"] = bars["free_head"] * column.restraint_stiffness
        bars["load"] = column.axial_load
        bars["mass"][:, 0] = bars["mass"][:, 1] = properties.impact_mass
        bars["mass"][:, 3] = column.head_mass
        force, flexibility = bars["load"], np.sum(1.0 / axial, axis=1)
        bars["unstressed"] = -force * flexibility
        zero = np.zeros(count)
        return bars, np.stack([zero, -force / axial[:, 0], zero, -force * flexibility], axis=1)

    def _fixed_step(self, scenario: ColumnImpact) -> float | None:
        """The time step (s) of all steps, or None where the error controls them."""
        return None if self.time_step is None else min(self.time_step, scenario.duration / 20)

    def pace(self, scenario: ColumnImpact, refinement: int) -> Pace:
        """Pace of the impact; each `refinement` quarters tolerances, first and longest step."""
        duration, step = scenario.duration, self._fixed_step(scenario)
        if step is not None:
            step = duration / int(np.ceil(duration / step))
            return Pace.equal(duration, step, 64 * _MOST_STEPS)
        column = scenario.column
        axial = column.steel.elastic_modulus * column.properties.area
        square = axial * (1.0 / column.length_below + 1.0 / column.length_above)
        first = _FIRST * np.sqrt(column.properties.impact_mass / square)
        share, control = 0.25**refinement, np.array(self._CONTROL)
        bounces = np.asarray(scenario.striker.rebounds, int)
        error, vibration, flow = share * control[bounces].T
        longest = share * duration / _FEWEST
        first = np.minimum(share * first, longest)
        spacing = duration / _RECORDS
        pace = Pace(duration, first, longest, error, vibration, flow, spacing, _MOST_STEPS)
        return followed(pace, scenario.striker, column.properties.impact_mass)

    def pushed(
        self, column: Column, displacement: float, least: float = -inf
    ) -> tuple[dict[str, Array], dict[str, Any]]:
        """The records of a pushed column, by name, and their histories.

        Arguments: the `displacement` to which it is pushed (m); the force (N) below which the push
        may end, `least`. Raises `SolverError` where equilibrium is lost before.
        """
        if column.steel.rate is not None:  # no time passes
            column = replace(column, steel=replace(column.steel, rate=None))
        bars, q = self.bars(column)
        steps = max(200, int(np.ceil(displacement / (_PUSH_STEP * column.length) - 1e-9)))
        path = np.linspace(0.0, displacement, steps + 1)[1:]
        tables = self._tables(column)
        records = np.zeros(steps + 1, tables.state)
        records["q"][0] = q
        records["stress"][0, :, 0] = -column.axial_load
        work = np.zeros(1, tables.work)[0]
        status, last, residual = statics.pushover(bars, path, least, records, work)
        if status != statics.OK:
            where, tried = f"displacement {path[last]:.5g} m", "increments down to 1/1024"
            raise SolverError(where, residual, tried)
        histories = histories_of(records[: last + 2])
        return histories, _histories(column, bars, histories)

    def _pushover(self, scenario: ColumnPushover) -> Response:
        column = scenario.column
        records, values = self.pushed(column, scenario.displacement)
        force, values["elastic"] = values["force"], records["elastic"]
        pieces = 0.5 * (force[1:] + force[:-1]) * np.diff(values["displacement"])
        external = np.concatenate([[0.0], np.cumsum(pieces)])
        values["external_work"] = external + _dead_work(column, records)
        values["input_energy"] = external[-1]
        return build_response(values, steps=len(force), **_NAMES)

    def _impact(self, scenario: ColumnImpact) -> Response:
        started, weight = perf_counter(), scenario.dead_force
        scenario = with_hit_mass(scenario, self.hit_mass)
        error = np.inf
        for refinement in range(PACES):
            bars, run = self._march(scenario, self.pace(scenario, refinement), weight)
            records = run.histories
            values: dict[str, Any] = {n: h for n, h in records.items() if n in VARIABLES}
            values["external_work"] = records["external_work"] - records["external_work"][0]
            values["input_energy"] = scenario.input_energy
            balance = values["balance_error"] = np.asarray(balance_error(values, static=False))
            error = open_share(balance, scenario.input_energy, float(records["elastic"][0]))
            if self._fixed_step(scenario) is not None or error < self.BALANCE:
                break
        else:
            raise SolverError("the energy balance", error, "tolerances and steps down to a 256th")
        solved = perf_counter() - started
        values |= self._values(scenario.column, bars, run)
        residual, warnings = resting(scenario)
        values |= run.peak(scenario.striker.rebounds) | residual
        response = build_response(values, time=records["time"], warnings=warnings, **_NAMES)
        response.attrs |= {"solve_time": solved, "dead_displacement": float(bars["sag"])}
        return response

    def _values(self, column: Column, bars: Any, run: FollowedImpact) -> dict[str, Any]:
        """Histories of a followed impact beside those of all impacts."""
        turned = march.turned(bars, run.records)
        return _histories(column, bars, run.histories) | {"plastic_rotation": turned}

    def _strike(self, bars: Any, scenario: ColumnImpact) -> None:
        """Write where the hit comes from into the `bars`: in a plane nothing."""

    def _march(
        self, scenario: ColumnImpact, pace: Pace, weight: float
    ) -> tuple[Any, FollowedImpact]:
        """The bars, under their `weight` (N), and the records of one run; raises as `simulate`."""
        striker = scenario.striker
        (table, q), tables = self._bars_of(scenario.column), self._tables(scenario.column)
        states, room = np.zeros(2, tables.state), np.zeros(1, tables.work)
        states["q"][0] = q
        if weight:
            steel = replace(scenario.column.steel, rate=None, hardening_modulus=None)
            still = self.table_of(replace(scenario.column, steel=steel))
            if not march.lie(*still, weight, table, states):
                raise OutOfDomainError("the column does not carry its own weight")
        if march.along_tangent(table[0]):
            room["finish_below"] = march.NEARLY if pace.error < inf else march.CLOSELY
        drive = striker.mass, striker.velocity, striker.restitution, 0.0
        given = table, states, room
        run = follow(march.impact, given, pace, drive, march.RECORD, striker, scenario.acceleration)
        if run.collapsed:
            raise collapsed(table[0], run.records[-1])
        return table[0], run


@lru_cache(maxsize=256)
def _kept(model: RigidBars, column: Column) -> tuple[bytes, Array]:
    """The bars of a column, for the next strike: records of many fields are slow to copy."""
    bars, q = model.table_of(column)
    return bars.tobytes(), q


def collapsed(bars: Any, state: Any) -> CollapseError:
    """How the column has collapsed in the last record of a run, the `state`."""
    lengths, reached, time = bars["lengths"], float(state["q"][V]), float(state["time"])
    left = np.array(march.chords(lengths, state["q"]))
    turned, reached = abs(reached) / np.minimum(lengths, left), reached - float(bars["sag"])
    if turned.max() > COLLAPSE_SIDEWAYS:
        bar = SEGMENTS[int(turned.argmax())]
        reason = (
            f"the segment {bar} the impact point has turned, nine tenths of its length sideways"
        )
        return CollapseError(Collapse(Mechanism.GEOMETRY, (bar,), reached, time), reason)
    loss = 1.0 - left.sum() / lengths.sum()
    reason = f"the bars have been squashed by {100.0 * loss:.3g} % of their length"
    return CollapseError(Collapse(Mechanism.SQUASH, SEGMENTS, reached, time), reason)


def _dead_work(column: Column, records: dict[str, Array]) -> Array:
    """Work of the axial load, in J."""
    head = records["q"][U2]
    return np.asarray(-column.axial_load * (head - head[0]))


def _histories(column: Column, bars: Any, records: dict[str, Array]) -> dict[str, Any]:
    """Histories of pushovers and impacts: displacements, forces, shear of the two bars."""
    v, u1, _, u2 = records["q"]
    stress = records["stress"]
    resistance, slides = column.properties.shear_resistance, {}
    if bars["sliding"]:
        shear, resistance = np.abs(stress[:, 3]), bars["web"]["shear"]
        slides["sliding"] = records["plastic"][:, 3]
    else:
        along = np.stack([column.length_below + u1, column.length_above + u2 - u1])
        shear = np.abs(stress[:, 1] - stress[:, 2]) / np.hypot(along, v)
    return {
        **slides,
        "displacement": v - bars["sag"],
        "force": records["force"],
        "shortening": -u2,
        "dissipated": records["dissipated"],
        "axial_force": stress[_BARS, 0],
        "moment": stress[_BARS, _PLACES],
        "shear_utilisation": shear.max(axis=1) / resistance,
    }


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
        return stackable(self, scenario)

    def answer_stack(self, scenario: ColumnImpact, refused: Flags) -> BatchAnswers:
        """Answers to a stack of impacts, see `models.batch`; none of those that are `refused`."""
        return answer_stack(self, scenario, refused)

    def refused(self, scenario: ColumnImpact) -> Any:
        """Whether the domain refuses an impact; flags of a stack."""
        return buckles(scenario)

    def _hinge_findings(self, scenario: ColumnScenario) -> list[Finding]:
        section = scenario.column.section
        if flows(self, scenario.column.steel) and not has_bar_law(section):
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
        return stackable(self, scenario) and has_shear_surface(scenario.column.section)

    def answer_stack(self, scenario: ColumnImpact, refused: Flags) -> BatchAnswers:
        """Answers to a stack of impacts, see `models.batch`; none of those that are `refused`."""
        return answer_stack(self, scenario, refused)

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


def stackable(model: RigidBars, scenario: ColumnScenario) -> bool:
    """Whether a model answers such impacts in stacks."""
    if not isinstance(scenario, ColumnImpact) or scenario.striker.crushes or scenario.acceleration:
        return False
    return model.time_step is None and not flows(model, scenario.column.steel)


def answer_stack(model: Any, scenario: ColumnImpact, refused: Flags) -> BatchAnswers:
    """Answers to a stack: those whose ledger is open are followed again, as single ones are."""
    struck = with_hit_mass(scenario, model.hit_mass)
    column, striker = struck.column, struck.striker
    count = len(refused)
    (table, q), march = model.table_of(column, count), model.marches
    model._strike(table, struck)
    codes = np.where(refused, UNKNOWN, SURVIVES)
    numbers, errors = np.full((count, len(march.SCALARS)), np.nan), np.zeros(count)
    given, which = spread(struck.input_energy, count), np.flatnonzero(codes == SURVIVES)
    nearly = NEARLY if along_tangent(table[0]) else 0.0
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

    return BatchAnswers.of(codes, values, collapse)
