"""Cost of the column models, measured side by side in one run.

Prints the median wall time of one impact of the thesis column (15 m/s, 0.1 s followed) after
compilation, and its ratio to the SDOF column. Nothing here passes or fails.
"""

from __future__ import annotations

from statistics import median
from time import perf_counter

from workbench.datafiles import data_directory
from workbench.models.energy_estimate import EnergyEstimate
from workbench.models.four_dof import FourDof, FourDofShear
from workbench.models.single_dof import SingleDof
from workbench.references.fiber_corotational import FiberCorotational
from workbench.scenarios import load_scenario

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
    for turn in range(50):  # interleaved, so that a drift of the machine meets all alike
        for label, (model, runs) in MODELS.items():
            if turn < runs:
                start = perf_counter()
                model.simulate(impact)
                times[label].append(perf_counter() - start)
    base = median(times["SDOF cubic"])
    print(f"{'model':<20}{'median':>12}{'ratio':>12}")
    for label, values in times.items():
        print(f"{label:<20}{1e3 * median(values):>9.2f} ms{median(values) / base:>12.1f}")


if __name__ == "__main__":
    main()
