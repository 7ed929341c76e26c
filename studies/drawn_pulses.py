"""How far every model is off under pulses, on members drawn at random.

Rolled sections with and without fillets, tubes and squares of five steels, on five kinds of
supports, with and without axial load, under a line load or a force at 0.15 to 0.5 of the length.
Pulses of four shapes are a twentieth to ten periods long, of a size that takes an elastic-plastic
mass of the member to a ductility of 0.5 to 15. Others rise: ramps to a force that stays, and tables
of forces. The reference is the fiber beam whose web yields.
The peaks are the data of the error model.
"""

import sys
from collections.abc import Iterator
from dataclasses import replace
from itertools import chain
from math import exp, log, pi, sqrt

import numpy as np

from workbench.cli import main
from workbench.extras.practice.biggs import Biggs
from workbench.extras.practice.catenary import Izzuddin, TrilinearCatenary, YinWang
from workbench.extras.practice.charts import pressure_impulse
from workbench.models.references.fiber_beams import FiberReissner, FiberShear
from workbench.models.single_dof import SingleDof
from workbench.models.superelements import FlexibleSuperelement, RigidSuperelement
from workbench.scenarios import Column, MemberPulse, Pulse
from workbench.steel.materials import Steel
from workbench.steel.sections import find, rectangular_tube, square
from workbench.study import Case, Figure, Study

SEED, MEMBERS, RISING_SEED, RISING, QUICK = 27, 440, 71, 140, 12
POINTS = 0.55  # share of the members that a force presses, the others a line load
BEAMS, REFINEMENTS = 10, 16  # every so many members have them
REFERENCE, REFINED, BEAM = "web-yielding beam", "web-yielding beam, refined", "fiber beam"
REDUCED = {
    "flexible superelements": FlexibleSuperelement(),
    "rigid superelements": RigidSuperelement(),
    "SDOF analytic": SingleDof(),
    "Biggs": Biggs(),
    "Izzuddin": Izzuddin(),
    "Yin-Wang": YinWang(),
    "tri-linear catenary": TrilinearCatenary(),
}
models = {
    REFERENCE: FiberShear(levels=1),
    REFINED: FiberShear(levels=2),
    BEAM: FiberReissner(levels=1),
    **REDUCED,
}
SECTIONS = (
    *(find(name) for name in ("IPE 200", "IPE 240", "IPE 300", "IPE 400")),
    *(find(name) for name in ("HEA 180", "HEA 260", "HEB 160", "HEB 220", "HEB 300")),
    rectangular_tube(0.15, 0.15, 0.008),
    rectangular_tube(0.25, 0.15, 0.01),
    square(0.12),
)
STEELS = (355e6, 355e6, 235e6, 275e6, 460e6)  # yield stress, Pa
SHAPES = ("rectangular", "triangular", "exponential", "friedlander")
ENDS = (  # base, head, spring (N/m)
    *(("clamped", "guided", 0.0), ("clamped", "pinned", 0.0), ("pinned", "pinned", 0.0)),
    *(("clamped", "fixed", 0.0), ("pinned", "pinned", 1e8)),
)
PLATES = 4  # every so many members are without root fillets
TABLES = (  # factors of tables: a rise, two blows, suction behind a blow
    *((0.0, 1.0, 0.0), (0.0, 1.0, 0.5, 0.0), (1.0, 0.2, 0.7, 0.0), (0.0, 0.6, 0.2, 1.0, 0.0)),
    *((1.0, 0.0, -0.3, 0.0), (0.2, 1.0, 0.0, -0.2, 0.0)),
)


def rising(force: float, lasts: float, rng: np.random.Generator) -> Pulse:
    """A ramp up to a force that stays, below the drawn one, or a table with that largest force.

    Arguments: the largest `force` (N, or N/m); what a rectangular pulse of it `lasts`, in s.
    """
    if rng.random() < 0.4:
        return Pulse("ramp", float(f"{force:.4g}"), float(f"{lasts:.4g}"))
    factors = TABLES[rng.integers(len(TABLES))]
    times = np.cumsum([0.0, *rng.uniform(0.3, 1.0, len(factors) - 1)])
    sizes = np.abs(factors)
    times *= lasts / float(np.trapezoid(sizes, times))
    return Pulse("table", float(f"{force:.4g}"), times=tuple(np.round(times, 6)), factors=factors)


def drawn(number: int, rng: np.random.Generator, rises: bool = False) -> MemberPulse:
    """A member under a pulse, one that `rises` or not."""
    base, head, spring = ENDS[rng.integers(len(ENDS))]
    section = SECTIONS[rng.integers(len(SECTIONS))]
    section = section if number % PLATES else section.without_fillets()
    steel = Steel(yield_stress=STEELS[rng.integers(len(STEELS))])
    shape = SHAPES[rng.integers(len(SHAPES))]
    load = "point" if rng.random() < POINTS else "uniform"
    length = float(f"{section.height * rng.uniform(9.0, 32.0):.3g}")
    place = 0.5 if rng.random() < 0.3 else rng.uniform(0.15, 0.5)
    below = float(f"{place * length:.4g}")
    below, above = (below, length - below)[:: 1 if rng.random() < 0.5 else -1]
    squash = section.area * steel.yield_stress
    axial = float(f"{rng.uniform(0.02, 0.25) * squash:.3g}") if rng.random() < 0.4 else 0.0
    column = Column(
        *(section, below, above, steel),
        base=base,
        head=head,
        axial_load=axial,
        restraint_stiffness=spring,
    )
    first, *_, last = Biggs().stages(column, load == "uniform")
    mass = first.load_mass_factor * column.properties.mass_per_length * length
    period = 2.0 * pi * sqrt(mass / first.stiffness)
    lasts, wanted = exp(rng.uniform(log(0.05), log(10.0))), exp(rng.uniform(log(0.5), log(15.0)))
    force = pressure_impulse(shape, wanted, (lasts,))[0].force
    peak = force * last.load / (length if load == "uniform" else 1.0)
    pulse = Pulse(shape, float(f"{peak:.4g}"), float(f"{lasts * period:.4g}"))
    end = pulse.whole / pulse.peak
    if rises:
        stays = rng.uniform(0.3, 0.95) * last.load / (length if load == "uniform" else 1.0)
        pulse = rising(peak, lasts * period, rng)
        pulse = replace(pulse, peak=float(f"{stays:.4g}")) if pulse.shape == "ramp" else pulse
        shape, end = pulse.shape, pulse.end
    duration = min(10.0, float(f"{end + (3.0 + wanted) * period:.3g}"))
    name = f"{number:03d} {section.name.replace(' without fillets', ', plates')} {base}-{head}, "
    name += f"{load}, {shape}, {lasts:.2g} T"
    return MemberPulse(name, column, pulse, load, duration)


def drawn_members(
    seed: int, count: int, rises: bool = False, first: int = 0
) -> Iterator[MemberPulse]:
    """Members under pulses, that rise or not, the same of a seed however many."""
    rng = np.random.default_rng(seed)
    yield from (drawn(number, rng, rises) for number in range(first, first + count))


def case_of(number: int, scenario: MemberPulse) -> Case:
    """The case of a drawn member: its name, its models and references, and its parameters.

    Pulses that rise have anchor and truth alone.
    """
    column, rises = scenario.column, number >= MEMBERS
    present = dict.fromkeys(REDUCED, not rises) | {BEAM: number % BEAMS == 0 and not rises}
    present["flexible superelements"] = True
    present[REFINED] = number % REFINEMENTS == 5 and not rises
    return Case(
        scenario.name,
        scenario,
        models=tuple(label for label in models if present.get(label, True)),
        parameters={"length below over length": column.length_below / column.length},
        quick=number < QUICK,
    )


members = chain(drawn_members(SEED, MEMBERS), drawn_members(RISING_SEED, RISING, True, MEMBERS))
cases = tuple(case_of(*pair) for pair in enumerate(members))
study = Study(
    name="drawn_pulses",
    title="Members under pulses: every model on drawn ones",
    question="How far is every model off under pulses, and where?",
    cases=cases,
    models=models,
    reference=REFERENCE,
    references=(REFINED, REFERENCE, BEAM),
    groups={
        load: tuple(case.name for case in cases if case.scenario.load == load)
        for load in ("point", "uniform")
    },
    quantities=("peak_displacement", "residual_displacement", "peak_force"),
    figures=(
        Figure("structure", "structure", "The members", "One of them."),
        Figure("peaks", "peaks", "Peaks of every model against the web-yielding beam", "By case."),
    ),
    decisive="peaks",
)

if __name__ == "__main__":
    main(["run", __file__, *sys.argv[1:]])
