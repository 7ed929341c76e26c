"""How far single degrees of freedom are off under pulses, on members drawn at random.

Rolled sections as they come, fillets included, on five kinds of supports, with and without axial
load, under pulses of four shapes: a twentieth to ten periods long, of a size that takes an
elastic-plastic mass of the member to a ductility of 0.5 to 15. The reference is the fiber beam
whose web yields. `python studies/drawn_pulses.py rules` writes the regions in which models warn.
"""

import csv
import sys
from itertools import product
from math import exp, inf, log, pi, sqrt
from pathlib import Path

import numpy as np

from workbench.cli import main
from workbench.datafiles import data_directory
from workbench.evidence.measured import ductility
from workbench.models.practice.biggs import Biggs
from workbench.models.practice.catenary import Izzuddin, TrilinearCatenary, YinWang
from workbench.models.practice.charts import pressure_impulse
from workbench.models.single_dof import SingleDof
from workbench.references.fiber_shear import FiberShear
from workbench.responses import outcome_of, warnings_of
from workbench.scenarios import Column, MemberPulse, Pulse
from workbench.sections import find
from workbench.study import Case, Figure, Study

COLUMNS = ("model", "load", "least", "most", "count", "low", "high", "bias", "p5", "p95")
DUCTILITIES = (0.0, 1.05, inf)  # ends of the regions
SEED, MEMBERS, QUICK = 27, 320, 12
REFERENCE = "web-yielding beam"
REDUCED = {
    "SDOF analytic": SingleDof(),
    "Biggs": Biggs(),
    "Izzuddin": Izzuddin(),
    "Yin-Wang": YinWang(),
    "tri-linear catenary": TrilinearCatenary(),
}
models = {REFERENCE: FiberShear(levels=1), **REDUCED}
SECTIONS = ("IPE 240", "IPE 300", "IPE 400", "HEA 180", "HEA 260", "HEB 220", "HEB 300")
SHAPES = ("rectangular", "triangular", "exponential", "friedlander")
ENDS = (  # base, head, spring (N/m)
    *(("clamped", "guided", 0.0), ("clamped", "pinned", 0.0), ("pinned", "pinned", 0.0)),
    *(("clamped", "fixed", 0.0), ("pinned", "pinned", 1e8)),
)


def drawn(number: int, rng: np.random.Generator) -> Case:
    """A member under a pulse."""
    base, head, spring = ENDS[rng.integers(len(ENDS))]
    section = find(SECTIONS[rng.integers(len(SECTIONS))])
    shape, load = SHAPES[rng.integers(len(SHAPES))], ("point", "uniform")[rng.integers(2)]
    length = float(f"{section.height * rng.uniform(14.0, 32.0):.3g}")
    place = 0.5 if rng.random() < 0.6 else rng.uniform(0.3, 0.5)
    below = float(f"{place * length:.4g}")
    squash = section.area * 355e6
    axial = float(f"{rng.uniform(0.02, 0.25) * squash:.3g}") if rng.random() < 0.4 else 0.0
    column = Column(
        section,
        below,
        length - below,
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
    duration = min(10.0, float(f"{pulse.whole / pulse.peak + (3.0 + wanted) * period:.3g}"))
    name = f"{number}: {section.name} {base}-{head}, {load}, {shape}, {lasts:.2g} T"
    parameters = {"length over period": lasts, "force over mechanism": force}
    scenario = MemberPulse(name, column, pulse, load, duration)
    return Case(name, scenario, parameters=parameters, quick=number < QUICK)


generator = np.random.default_rng(SEED)
cases = tuple(drawn(number, generator) for number in range(MEMBERS))
study = Study(
    name="drawn_pulses",
    title="Single degrees of freedom under pulses",
    question="How far are single-degree-of-freedom models off under pulses, and where?",
    cases=cases,
    models=models,
    reference=REFERENCE,
    quantities=("peak_displacement",),
    figures=(
        Figure("structure", "structure", "The members", "One of them."),
        Figure("peaks", "peaks", "Peaks of every model against the web-yielding beam", "By case."),
    ),
    decisive="peaks",
)


def exact_peaks() -> dict[str, float]:
    """Peaks (m) of the reference by case, inside its domain."""
    found = {}
    for case in cases:
        response = models[REFERENCE].simulate(case.scenario)
        if "peak_displacement" in response and not any(f.outside for f in warnings_of(response)):
            found[case.name] = float(response["peak_displacement"])
    return found


def rules(peaks: dict[str, float]) -> None:
    """Write what was measured in each region, of members of which a model says nothing else."""
    ratios: dict[tuple[str, str, int], list[float]] = {}
    for case in cases:
        if case.name not in peaks:
            continue
        exact = peaks[case.name]
        for model in REDUCED.values():
            answer = model.simulate(case.scenario)
            if outcome_of(answer).value != "ok" or warnings_of(answer):
                continue
            top = float(answer["displacement"].max())
            region = int(np.searchsorted(DUCTILITIES, ductility(answer), side="right")) - 1
            ratios.setdefault((model.name, case.scenario.load, region), []).append(top / exact)
    path = Path(data_directory()) / "validation" / "pulses.csv"
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, COLUMNS, lineterminator="\n")
        writer.writeheader()
        regions = range(len(DUCTILITIES) - 1)
        for name, load, region in product(
            (m.name for m in REDUCED.values()), ("point", "uniform"), regions
        ):
            found = np.array(ratios.get((name, load, region), []))
            if len(found):
                ends = DUCTILITIES[region : region + 2]
                off = (found < 0.9).sum(), (found > 1.1).sum()
                spread = [f"{x:.4g}" for x in np.quantile(found, (0.5, 0.05, 0.95))]
                row = (name, load, *ends, len(found), *off, *spread)
                writer.writerow(dict(zip(COLUMNS, row, strict=True)))


if __name__ == "__main__":
    if sys.argv[1:] == ["rules"]:
        rules(exact_peaks())
    else:
        main(["run", __file__, *sys.argv[1:]])
