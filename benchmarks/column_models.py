"""Cost of the column models, measured side by side in one run.

Prints the median wall time of one impact of the thesis column (15 m/s, 0.1 s followed) after
compilation, its ratio to the SDOF column, the least time of solving (of lumped columns from the
kept springs or resistance to the records, of frames the steps) and of all else: findings, response,
provenance, of frames their structure too. Then the cost of the strain rate, and the four-DOF column
against OpenSeesPy, if that is installed (extra `cross-check`), at last an oblique hit with models
in space against both. Nothing here passes or fails.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from math import inf, radians
from statistics import median
from time import perf_counter, process_time

import opensees

from workbench.base.datafiles import data_directory
from workbench.models.energy_estimate import EnergyEstimate
from workbench.models.four_dof import FourDof, FourDofShear
from workbench.models.references.fiber_beams import FiberCorotational
from workbench.models.references.fiber_space import FiberSpace
from workbench.models.seven_dof import SevenDof
from workbench.models.single_dof import SingleDof
from workbench.models.strain_rate import with_rate
from workbench.models.superelement_space import SuperelementSpace
from workbench.models.superelements import FlexibleSuperelement, RigidSuperelement
from workbench.scenarios import ColumnImpact, load_scenario
from workbench.steel.materials import MILD_STEEL

MODELS = {
    "energy estimate": (EnergyEstimate(), 50),
    "SDOF cubic": (SingleDof(resistance="cubic"), 50),
    "SDOF analytic": (SingleDof(), 50),
    "4-DOF": (FourDof(), 20),
    "4-DOF with panels": (FourDofShear(), 20),
    "energy with panels": (EnergyEstimate(resistance="panel"), 10),
    "rigid superelement": (RigidSuperelement(), 20),
    "flexible superelement": (FlexibleSuperelement(), 20),
    "fiber coarse": (FiberCorotational(levels=1, refinement=-1), 3),
    "fiber medium": (FiberCorotational(levels=1, refinement=0), 3),
}
OBLIQUE = {  # in space; how often they solve the hit
    "7-DOF": (SevenDof(), 20),
    "superelement in space": (SuperelementSpace(), 5),
    "one bar per side, accuracy 0.1": (SuperelementSpace(elements=1, accuracy=0.1), 20),
    "fibers in space, coarse": (FiberSpace(levels=1, refinement=-1), 1),
    "fibers in space, medium": (FiberSpace(levels=1, refinement=0), 1),
}
DEGREES = 45.0  # of the oblique hit, off the web
LADDER = (25, 50, 75, 100, 150, 200, 400, 800)  # equal steps of an impact


def main() -> None:
    """Measure all models in turn and print medians and ratios."""
    impact = load_scenario(data_directory() / "published" / "heng2017_impact_column.toml")
    for model, _ in MODELS.values():
        model.simulate(impact)  # compile
    times: dict[str, list[float]] = {label: [] for label in MODELS}
    solving: dict[str, list[float]] = {label: [] for label in MODELS}
    for turn in range(50):  # interleaved, so that a drift of the machine meets all alike
        for label, (model, runs) in MODELS.items():
            if turn < runs:
                start = perf_counter()
                response = model.simulate(impact)
                times[label].append(perf_counter() - start)
                solving[label].append(response.attrs.get("solve_time", 0.0))
    base = median(times["SDOF cubic"])
    print(f"{'model':<22}{'median':>12}{'ratio':>12}{'solving':>14}{'on top':>14}")
    for label, values in times.items():
        solved = solving[label]
        spent = f"{1e3 * min(solved):.3f} ms" if max(solved) else ""
        rest = f"{1e3 * min(t - s for t, s in zip(values, solved, strict=True)):.3f} ms"
        print(
            f"{label:<22}{1e3 * median(values):>9.2f} ms{median(values) / base:>12.1f}"
            f"{spent:>14}{rest:>14}"
        )
    cost_of_rate(impact)
    against_opensees(impact)
    oblique(impact)


def cost_of_rate(impact: ColumnImpact) -> None:
    """Least times of an answer with a rate law over those without, of one factor and of bars."""
    rated = with_rate(impact, MILD_STEEL)
    hard = replace(rated.column.steel, hardening_modulus=2.1e9)
    hardened = replace(rated, column=replace(rated.column, steel=hard))
    for model in (FourDof(), FourDofShear()):
        bars = replace(model, rate_level="bars")
        cells = (model, impact), (model, rated), (bars, rated), (bars, hardened)
        spent: list[list[float]] = [[] for _ in cells]
        for _ in range(30):
            for times, (each, scenario) in zip(spent, cells, strict=True):
                start = process_time()
                each.simulate(scenario)
                times.append(process_time() - start)
        base, *rest = (min(times) for times in spent)
        factor, flowing, both = (each / base for each in rest)
        print(f"{model.name:<22}factor {factor:.2f}, bars {flowing:.1f}, hardening too {both:.1f}")


def oblique(impact: ColumnImpact) -> None:
    """Least processor times of answers to an oblique hit, and of OpenSeesPy's fibers in space.

    Ratios to the four-DOF column, hit along its web, and to OpenSeesPy, solving alone, in the equal
    steps that keep 1 % of its own converged peak in least time.
    """
    turned = replace(impact, striker=replace(impact.striker, angle=radians(DEGREES)))
    cells = {"4-DOF, along the web": (FourDof(), impact, 50)}
    cells |= {label: (model, turned, runs) for label, (model, runs) in OBLIQUE.items()}
    times: dict[str, float] = {}
    peaks: dict[str, float] = {}
    for label, (model, scenario, runs) in cells.items():
        peaks[label] = float(model.simulate(scenario)["peak_displacement"])  # compile
        spent = []
        for _ in range(runs):
            start = process_time()
            model.simulate(scenario)
            spent.append(process_time() - start)
        times[label] = min(spent)
    label, other = "OpenSeesPy in space", inf
    try:
        other = cheapest(f"{label}, steps", partial(opensees.column, turned, "fibers"), 2000, 3)
    except (ImportError, RuntimeError) as failure:
        print(f"{label}: {failure}")
    base = times["4-DOF, along the web"]
    for label, spent in times.items():
        print(
            f"{label:<32}{peaks[label]:>7.4f} m{1e3 * spent:>10.2f} ms{spent / base:>12.1f} "
            f"times the 4-DOF column, {spent / other:.4f} of OpenSeesPy"
        )


def against_opensees(impact: ColumnImpact) -> None:
    """Cheapest answers within 1 % of their own converged peak: the four-DOF column, OpenSeesPy.

    Both take equal steps, solving alone is timed, and all finer ones have to be within 1 % too.
    """

    def four_dof(steps: float) -> tuple[float, float]:
        answer = FourDof(time_step=impact.duration / steps).simulate(impact)
        return float(answer["peak_displacement"]), float(answer.attrs["solve_time"])

    base = cheapest("4-DOF, equal steps", four_dof, 10_000, 200)
    by_error = [FourDof().simulate(impact).attrs["solve_time"] for _ in range(200)]
    print(f"{'4-DOF, steps by error (0.1 %)':<32}{1e3 * min(by_error):>18.3f} ms")
    for kind in ("hinges", "fibers"):
        try:
            spent = cheapest(
                f"OpenSeesPy, {kind}, steps", partial(opensees.column, impact, kind), 4000, 30
            )
        except (ImportError, RuntimeError) as failure:
            print(f"OpenSeesPy, {kind}: {failure}")
            continue
        print(
            f"{'':<32}{spent / base:>18.0f} times the 4-DOF column, "
            f"{spent / min(by_error):.0f} by error"
        )


def cheapest(
    label: str,
    solve: Callable[[float], tuple[float, float]],
    finest: float,
    repeats: int,
    settings: Sequence[float] = LADDER,
) -> float:
    """Least seconds of a setting within 1 % of the peak of the `finest`, as finer ones; printed.

    `solve` gives the peak and the seconds of a setting, numbers of equal steps if nothing else.
    """
    converged, _ = solve(finest)
    good: dict[float, tuple[float, float]] = {}
    for setting in settings:
        try:
            spent, peak = min(solve(setting)[::-1] for _ in range(repeats))
        except RuntimeError:
            peak, spent = inf, inf
        if abs(peak / converged - 1.0) >= 0.01:
            good.clear()
        else:
            good[setting] = spent, peak
    if not good:
        raise RuntimeError("no setting keeps 1 %")
    setting = min(good, key=lambda each: good[each][0])
    spent, peak = good[setting]
    error = peak / converged - 1.0
    print(f"{f'{label}, {setting:g}':<32}{error:>8.2%}{1e3 * spent:>10.3f} ms")
    return spent


if __name__ == "__main__":
    main()
