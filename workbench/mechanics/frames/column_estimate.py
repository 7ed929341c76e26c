"""Column estimate: the single column that an engineer puts in the place of a frame around it.

Axial load, an elastic spring along the column, a mass at its head and the supports of its ends,
all from elastic analyses for unit loads; and from limit analyses, where these estimates end.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from math import inf, sqrt

import numpy as np

from workbench.base.arrays import Array
from workbench.base.errors import InputError, OutOfDomainError
from workbench.mechanics.frames import out_of_domain
from workbench.mechanics.frames.collapse import collapse_factor, collapse_mechanism
from workbench.mechanics.frames.elastic import (
    HEAD_MASSES,
    ColumnLine,
    ElasticFrame,
    column_line,
    dead_load_state,
    mass_of_head,
)
from workbench.mechanics.frames.structure import dead_loads
from workbench.responses import Finding, finding
from workbench.scenarios import (
    Column,
    ColumnImpact,
    Frame,
    FrameImpact,
    FrameStriker,
    Load,
    frame_scenario,
)
from workbench.scenarios.parts import OVERRIDES

HEADS = ("joined", "pinned")
BENT = 0.1  # of the plastic moment, by dead loads at the ends of the column
SAME = 1e-3  # relative difference of collapse loads that counts as none
SWAYED = 0.08  # of a peak, missing by an estimate; a little below what counts as an error


@dataclass(frozen=True)
class ColumnEstimate:
    """The `column` that stands for a frame, and what it leaves out.

    `line` of the frame that it replaces; `restraint_limit` (N), force of its spring at which the
    frame without the column collapses (None: dead loads alone do that); collapse loads (N) of
    `frame_resistance` and `column_resistance` under a force in place of the striker (None:
    likewise); `bent`, largest moment of the dead loads at its ends over the plastic moment;
    elastic flexibility (m/N) of frame and column there, `yielding` (None of the frame: it moves
    without resistance); `softening` (N/m), what the mechanism of the frame loses of its resistance
    to the dead loads per displacement there.
    """

    column: ColumnImpact
    line: ColumnLine
    restraint_limit: float | None
    frame_resistance: float | None
    column_resistance: float | None
    bent: float
    yielding: tuple[float | None, float]
    softening: float

    @property
    def _energy(self) -> float:
        """Energy (J) after a first collision with the lumped mass of the column."""
        lumped = self.column.column.properties.impact_mass / self.column.striker.mass
        return self.column.input_energy / (1.0 + lumped)

    @property
    def fall(self) -> float:
        """Energy after the hit over that which the frame takes until its dead loads carry it on.

        A rigid-plastic mechanism that resists R - c w falls from w = R / c on, R^2 / 2c. Zero where
        the column's own mechanism governs.
        """
        ratio, resistance = self.collapse_ratio, self.frame_resistance
        if not ratio or not resistance or ratio > 1.0 - SAME:
            return 0.0
        return 2.0 * max(self.softening, 0.0) * self._energy / resistance**2

    @property
    def collapse_ratio(self) -> float | None:
        """Collapse load of the frame over that of the column; 1: it is the column's mechanism."""
        if self.frame_resistance is None or self.column_resistance is None:
            return None
        return self.frame_resistance / self.column_resistance

    @property
    def swayed(self) -> float | None:
        """Share of the peak that is missing as the ends neither sway nor turn, by energies.

        The energy after the hit goes into a spring that yields at the collapse load: of the column,
        and with the flexibility and the collapse load of the frame. Joints that are heavy hold
        still at first, so that it may be less. None where dead loads alone bring the collapse.
        """
        frame, column = self.yielding
        if frame is None or self.column_resistance is None or self.frame_resistance is None:
            return None
        energy = self._energy
        limits = self.column_resistance, min(self.frame_resistance, self.column_resistance)
        alone, whole = (
            sqrt(2.0 * energy * soft)
            if energy < 0.5 * limit**2 * soft
            else 0.5 * limit * soft + energy / limit
            for soft, limit in zip((column, frame), limits, strict=True)
        )
        return 1.0 - alone / whole

    def findings(self) -> Iterator[Finding]:
        """Findings on the estimated values, and on effects that they leave out."""
        column, line = self.column.column, self.line
        spring = f"an elastic spring of {column.restraint_stiffness / 1e6:.4g} MN/m"
        held = {"fixed": "no axial movement", "guided": spring, "pinned": spring}[column.head]
        yield finding(
            "estimate",
            base=line.base,
            head=line.head,
            support=column.base,
            held=f"{column.head}, {held}",
            axial=column.axial_load / 1e3,
            mass=column.head_mass,
        )
        ratio = self.collapse_ratio
        if ratio is None:
            yield finding("ends-without-resistance")
        elif abs(ratio - 1.0) < SAME:
            yield finding("ends-of-own-mechanism")
        else:
            yield finding("ends-of-frame", ratio=ratio, which="small" if ratio < 1.0 else "large")
        missing = self.swayed
        if missing is None or missing > SWAYED:
            share = "much" if missing is None else f"up to {100.0 * missing:.0f} %"
            yield finding("sway", missing, share=share)
        if self.fall > 1.0:
            yield finding("fall", self.fall, ratio=self.fall)
        if self.bent > BENT:
            yield finding("dead-moments", share=self.bent)

    def restraint_findings(self, force: float) -> Iterator[Finding]:
        """Whether the spring carried a `force` (N) beyond the collapse of the frame."""
        limit = self.restraint_limit
        if limit is not None and force > limit:
            yield finding("restraint", force=force / 1e3, limit=limit / 1e3)


def estimate_column(scenario: FrameImpact, head_mass: str, head: str) -> ColumnEstimate:
    """The column that stands for a frame under impact.

    Arguments: `head_mass`, rule for the mass that moves with the head, out of `HEAD_MASSES`;
    `head`, ``joined`` (as the joint there says) or ``pinned``. Raises `OutOfDomainError` where
    there is no such column.
    """
    frame, striker = scenario.frame, scenario.striker
    towards = -1.0 if striker.direction.startswith("-") else 1.0
    strike = Load(striker.node, **{striker.direction[-1]: towards})
    impact, line, axial, bent = _column(scenario, head_mass, head)
    alone = frame_scenario(impact).frame
    swaying = collapse_mechanism(frame, [strike], dead_loads(frame))
    return ColumnEstimate(
        impact,
        line,
        collapse_factor(frame, line.pull(1.0), (*dead_loads(frame), *line.pull(axial)), line.rest),
        None if swaying is None else swaying.factor,
        collapse_factor(alone, [Load("hit", x=1.0)], dead_loads(alone)),
        bent,
        (_yielding(frame, strike), _yielding(alone, Load("hit", x=1.0)) or 0.0),
        0.0 if swaying is None else swaying.softening(frame, dead_load_state(frame).axial),
    )


def column_like(scenario: FrameImpact) -> ColumnImpact | None:
    """The struck column of a frame by the rules that go without saying, None if it is none."""
    striker = scenario.striker
    column = _column_of_unit(scenario.frame, striker.node, striker.direction)
    if column is None:
        return None
    return replace(column, striker=striker.alone)


@lru_cache(maxsize=64)
def _column_of_unit(frame: Frame, node: str, direction: str) -> ColumnImpact | None:
    """The column, the same for all strikers of a frame."""
    striker = FrameStriker(1.0, 1.0, node=node, direction=direction)
    scenario = FrameImpact("unit", frame, striker, 1.0, any(frame.gravity))
    try:
        return _column(scenario, HEAD_MASSES[0], HEADS[0])[0]
    except OutOfDomainError:
        return None


def _column(
    scenario: FrameImpact, head_mass: str, head: str
) -> tuple[ColumnImpact, ColumnLine, float, float]:
    """The column, its line, and the dead load state of that, see `_dead_state`."""
    frame, line = scenario.frame, column_line(scenario)
    if head == "pinned":
        line = replace(line, fixed=(line.fixed[0], False))
    flexibility, shape = _opening(line)
    if flexibility == 0.0 and not line.fixed[1]:
        if head == "pinned" or not line.fixed[0]:
            raise out_of_domain("pinned-fixed-head")
        line = line.turned()
    axial, bent = _dead_state(line)
    member = frame.member(line.members[0])
    extra = frame.node(scenario.striker.node).mass
    try:
        column = Column(
            member.section,
            line.below,
            line.above,
            frame.steel,
            fillets=frame.fillets,
            base="clamped" if line.fixed[0] else "pinned",
            head="fixed" if flexibility == 0.0 else "guided" if line.fixed[1] else "pinned",
            axial_load=-axial,
            restraint_stiffness=0.0 if flexibility in (0.0, inf) else 1.0 / flexibility,
            head_mass=0.0 if flexibility == 0.0 else mass_of_head(head_mass, line, shape),
            **{key: getattr(member, key) for key in (*OVERRIDES, "axis")},
        )
        if extra > 0.0:
            column = replace(column, impact_mass=column.properties.impact_mass + extra)
    except InputError as error:
        raise OutOfDomainError(f"there is no such column: {error}") from error
    sense = {"-y": "down", "+y": "up"}.get(scenario.striker.direction)
    impact = ColumnImpact(
        f"{scenario.name}: column {line.base} to {line.head}"[:120],
        column,
        scenario.striker.alone,
        scenario.duration,
        sense,
        bool(scenario.acceleration) if sense else None,
    )
    return impact, line, axial, bent


def _yielding(frame: Frame, load: Load) -> float | None:
    """Elastic displacement (m/N) of a unit load along it; None where it meets no resistance."""
    elastic = ElasticFrame(frame)
    force = elastic.load([load])
    moved = elastic.displacement(force)
    return None if moved is None else float(force @ moved)


def _opening(line: ColumnLine) -> tuple[float, Array | None]:
    """How far unit forces draw both ends together once the column is gone (m/N), and the shape.

    Displacements (dofs,) of the shape are those per displacement of the head along the column.
    Infinite, without a shape, where nothing resists.
    """
    rest = ElasticFrame(line.frame, line.rest)
    load = rest.load(line.pull(1.0))
    moved = rest.displacement(load)
    if moved is None:
        return inf, None
    along = float(rest.load(line.pull(1.0)[:1]) @ moved)
    shape = moved / along if along > 0.0 else None
    return float(load @ moved) + line.softness, shape


def _dead_state(line: ColumnLine) -> tuple[float, float]:
    """Axial force (N, tension positive) and end moment over plastic moment under dead loads."""
    frame = line.frame
    elastic = ElasticFrame(frame, springs=False)
    moved = elastic.displacement(elastic.load(dead_loads(frame)))
    if moved is None:
        raise out_of_domain("moves-under-dead-loads")
    axial, moments = elastic.end_forces(moved)
    names = [member.name for member in frame.members]
    hinges = [2 * names.index(name) + side for name in line.members for side in (0, 1)]
    plastic = frame.properties(line.members[0]).plastic_moment
    return float(np.mean(axial[hinges])), float(np.max(np.abs(moments[hinges]))) / plastic
