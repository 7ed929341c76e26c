"""Where people build and the plain draw seldom comes: one stratum of drawn columns for each place.

Columns close to collapse, pressed by up to 0.7 of the squash load, of round tubes, bent about the
weak axis, hit by fronts that crush, and of steel that feels its strain rate: the law of the grade
with the nearest yield stress, its reference rate drawn between the ends of 90 % of such steels.
Columns and strikes are else those of `which_model`. The beam whose webs yield judges, and with it
the fiber beam: where one collapses and the other stands neither is the truth alone. The peaks are
data of the error model, as are those of `which_model`.
"""

import sys
from collections.abc import Iterator
from dataclasses import replace
from itertools import count, islice
from math import exp, isfinite, log, sqrt
from typing import Any

import numpy as np
from which_model import SECTIONS, drawn, stratified

from workbench.base.errors import OutOfDomainError
from workbench.cli import main
from workbench.models.domain import shear_demand
from workbench.models.references.fiber_beams import FiberReissner, FiberShear
from workbench.models.resistance import column_curve
from workbench.models.strain_rate import with_rate
from workbench.models.superelements import FlexibleSuperelement
from workbench.scenarios import ColumnImpact
from workbench.steel.sections import ISection, circular_tube
from workbench.study import Case, Figure, Study
from workbench.study.assessment.variations import rate_law

REFERENCE, BEAM = "web-yielding beam", "fiber beam"
models = {
    REFERENCE: FiberShear(levels=1),
    BEAM: FiberReissner(levels=1),
    "flexible superelements": FlexibleSuperelement(),
}
SIZES = ((0.1143, 0.0063), (0.1683, 0.008), (0.2191, 0.008), (0.273, 0.0125), (0.3239, 0.01))
ROUND = tuple(circular_tube(*size) for size in SIZES)
OPEN = tuple(each for each in SECTIONS if isinstance(each.shape, ISection))
WEAK = tuple(each.about("weak") for each in OPEN)
EVERY = (*OPEN[::2], *WEAK[::4], *ROUND[::2], *SECTIONS[-4:])
NEAR, PRESSED, TUBES, FLANGES, FRONTS = "near collapse", "pressed", "round", "weak axis", "front"
RATES = "rate"
STRATA = {  # columns, sections, share of the squash load
    NEAR: (360, EVERY, (0.05, 0.7)),
    PRESSED: (160, (*SECTIONS, *ROUND), (0.35, 0.75)),
    TUBES: (150, ROUND, (-0.1, 0.5)),
    FLANGES: (150, WEAK, (-0.1, 0.5)),
    FRONTS: (140, (*SECTIONS, *ROUND), (-0.1, 0.4)),
    RATES: (252, (), ()),
}
SEED, LIGHT, QUICK = 47, 0.35, 2
MARGINS = 0.7, 1.2  # velocity over that of a collapse by hand
SPEEDS = 0.7, 40.0  # m/s
SOFT = (0.03, 1.0)  # work of a front under the resistance of the mechanism, over the energy


def near_collapse(impact: ColumnImpact, margin: float) -> ColumnImpact | None:
    """The hit at a `margin` to the velocity from which the analytic resistance is lost."""
    column, striker = impact.column, impact.striker
    try:
        curve = column_curve(column, None, "analytic")
    except OutOfDomainError:
        return None
    lost = curve.lost_at
    if not isfinite(lost) or lost > 0.5 * min(column.length_below, column.length_above):
        return None
    added = 1.0 + column.properties.impact_mass / striker.mass
    velocity = margin * sqrt(2.0 * added * float(curve.work(lost)) / striker.mass)
    lasts = min(6.0 * lost / velocity + 0.05, 3.0)
    slow_or_fast = not SPEEDS[0] < velocity < SPEEDS[1]
    return None if slow_or_fast else impact.at_velocity(velocity).changed(duration=lasts)


def with_law(impact: Any, rng: np.random.Generator) -> Any:
    """The hit on a steel with a drawn rate law."""
    law = rate_law(impact)
    rate = exp(rng.uniform(log(law.slow), log(law.fast)))
    return with_rate(
        impact, replace(law, reference_rate=float(f"{rate:.3g}"), slow=None, fast=None)
    )


def hits_of(seed: int, kind: str) -> Iterator[ColumnImpact]:
    """Struck columns of one stratum, without end but for strain rate, whose cells hold so many."""
    rng = np.random.default_rng([seed, list(STRATA).index(kind)])
    if kind == RATES:
        quotas = np.full((3, 3), -(-STRATA[kind][0] // 9))
        hits = [with_law(impact, rng) for impact, _ in stratified(seed, quotas)]
        yield from (hits[place] for place in rng.permutation(len(hits)))
        return
    _, sections, shares = STRATA[kind]
    for number in count(1):
        point, part = rng.random(14), rng.random(3)
        light = bool(part[0] < LIGHT) and kind != NEAR
        impact = drawn(point, number, light, sections, shares)
        if kind == NEAR:
            at_margin = near_collapse(impact, MARGINS[0] + part[1] * (MARGINS[1] - MARGINS[0]))
            if at_margin is None:
                continue
            impact = at_margin
        elif kind == FRONTS:
            force = sum(min(each, 1.0) for each in shear_demand(impact).values())
            force *= impact.column.properties.shear_resistance
            work = impact.input_energy * exp(log(SOFT[0]) + part[1] * log(SOFT[1] / SOFT[0]))
            striker = impact.striker.changed(restitution=0.0, stiffness=0.5 * force**2 / work)
            impact = impact.changed(striker=striker, duration=2.0 * impact.duration)
        yield impact


def drawn_columns(seed: int, kind: str, most: int) -> Iterator[ColumnImpact]:
    """So many struck columns of one stratum, with their names; few are the first of many."""
    for number, impact in enumerate(islice(hits_of(seed, kind), most)):
        column, hit = impact.column, impact.striker
        name = f"{kind} {number:03d} {column.section.name.replace(' without fillets', ', plates')}"
        name += f", {column.length_below:.2f} + {column.length_above:.2f} m, "
        name += f"{hit.velocity:.1f} m/s, {hit.mass:.0f} kg"
        yield replace(impact, name=name)


cases = tuple(
    Case(
        impact.name,
        impact,
        models=tuple(
            each for each in models if each != BEAM or (kind in (NEAR, PRESSED) and not number % 2)
        ),
        quick=number < QUICK,
    )
    for kind, (most, *_) in STRATA.items()
    for number, impact in enumerate(drawn_columns(SEED, kind, most))
)
study = Study(
    name="drawn_columns",
    title="Columns where people build: close to collapse, pressed, round, weak, softly hit",
    question="How far is the anchor of the error model off there?",
    cases=cases,
    models=models,
    reference=REFERENCE,
    references=(REFERENCE, BEAM),
    groups={
        kind: tuple(case.name for case in cases if case.name.startswith(kind)) for kind in STRATA
    },
    quantities=("peak_displacement", "residual_displacement"),
    figures=(Figure("peaks", "peaks", "Peaks against the web-yielding beam", "By case."),),
    decisive="peaks",
)

if __name__ == "__main__":
    main(["run", __file__, *sys.argv[1:]])
