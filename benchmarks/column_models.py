"""Cost of the column models, measured side by side in one run.

Prints the median wall time of one impact of the thesis column (15 m/s, 0.1 s followed) after
compilation, its ratio to the SDOF column, and what solving alone takes; then the four-DOF column
against OpenSeesPy, if that is installed (extra `cross-check`). Nothing here passes or fails.
"""

from __future__ import annotations

from statistics import median
from time import perf_counter

import opensees

from workbench.datafiles import data_directory
from workbench.models.energy_estimate import EnergyEstimate
from workbench.models.four_dof import FourDof, FourDofShear
from workbench.models.single_dof import SingleDof
from workbench.references.fiber_corotational import FiberCorotational
from workbench.scenarios import ColumnImpact, load_scenario

MODELS = {
    "energy estimate": (EnergyEstimate(), 50),
    "SDOF cubic": (SingleDof(), 50),
    "SDOF analytic": (SingleDof(resistance="analytic"), 50),
    "4-DOF": (FourDof(), 20),
    "4-DOF with panels": (FourDofShear(), 20),
    "energy with panels": (EnergyEstimate(resistance="panel"), 10),
    "4-DOF explicit": (FourDof(integrator="moreau"), 20),
    "fiber coarse": (FiberCorotational(levels=1, refinement=-1), 3),
    "fiber medium": (FiberCorotational(levels=1, refinement=0), 3),
}


def main() -> None:
    """Measure all models in turn and print medians and ratios."""
    impact = load_scenario(data_directory() / "published" / "heng2017_impact_column.toml")
    for model, _ in MODELS.values():
        model.simulate(impact)  # compile
    times: dict[str, list[float]] = {label: [] for label in MODELS}
    solving: dict[str, list[float]] = {}
    for turn in range(50):  # interleaved, so that a drift of the machine meets all alike
        for label, (model, runs) in MODELS.items():
            if turn < runs:
                start = perf_counter()
                response = model.simulate(impact)
                times[label].append(perf_counter() - start)
                if "solve_time" in response.attrs:
                    solving.setdefault(label, []).append(response.attrs["solve_time"])
    base = median(times["SDOF cubic"])
    print(f"{'model':<20}{'median':>12}{'ratio':>12}{'solving':>12}")
    for label, values in times.items():
        spent = f"{1e3 * median(solving[label]):.3f} ms" if label in solving else ""
        print(
            f"{label:<20}{1e3 * median(values):>9.2f} ms{median(values) / base:>12.1f}{spent:>12}"
        )
    against_opensees(impact)


def against_opensees(impact: ColumnImpact) -> None:
    """Cheapest answers within 1 % of their own converged peak: the four-DOF column, OpenSeesPy."""
    own = FourDof(time_step=1e-5).simulate(impact)["peak_displacement"]
    answer = FourDof().simulate(impact)
    error = float(answer["peak_displacement"] / own) - 1.0
    spent = median(FourDof().simulate(impact).attrs["solve_time"] for _ in range(50))
    print(f"\n{'4-DOF, solving':<28}{error:>8.2%}{1e3 * spent:>10.2f} ms")
    for kind in ("hinges", "fibers"):
        try:
            converged = opensees.column(impact, kind, 4000)
            for steps in (100, 200, 400, 800):
                error = opensees.column(impact, kind, steps) / converged - 1.0
                if abs(error) < 0.01:
                    break
            times = []
            for _ in range(9):
                start = perf_counter()
                opensees.column(impact, kind, steps)
                times.append(perf_counter() - start)
        except (ImportError, RuntimeError) as failure:
            print(f"OpenSeesPy, {kind}: {failure}")
            continue
        label, slower = f"OpenSeesPy, {kind}, {steps} steps", median(times) / spent
        print(f"{label:<28}{error:>8.2%}{1e3 * median(times):>10.2f} ms, {slower:.0f} times")


if __name__ == "__main__":
    main()
