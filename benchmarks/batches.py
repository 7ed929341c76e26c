"""Cost of an impact in a batch of different columns or frames, and what threads make of it.

Prints per model the CPU time of a row by one thread, the time of a single call over it, and the
wall time of one thread over that of two and of all; then the memory of the process. The columns
have sections, lengths, steels, loads and strikers of their own. Frames are those of Heng 2017,
figure 5.13, followed for 0.05 s with one bar per member in the setting that takes least time within
1 % of its own converged peak: hit by different strikers, and of different steels too. Nothing here
passes or fails.
"""

from __future__ import annotations

import os
import resource
import tomllib
from dataclasses import replace
from time import perf_counter, process_time

import numpy as np

from workbench.base.datafiles import data_directory
from workbench.models.base import make_model
from workbench.models.batch import simulate_many
from workbench.models.superelements import RigidSuperelement
from workbench.scenarios import FrameImpact, load_scenario, to_toml
from workbench.scenarios.varied import Varied

ROWS = {
    "energy-estimate": 100_000,
    "single-dof": 100_000,
    "soft-impact": 4_000,
    "four-dof": 4_000,
    "four-dof-shear": 1_000,
    "rigid-superelement": 200,
    "flexible-superelement": 200,
}
FRAMES = 1_000
ONE_BAR = RigidSuperelement(elements=1, rotational_stiffness=6.0, accuracy=0.1)
SINGLES = 20
SECTIONS = np.array(["HEB 220", "HEB 300", "IPE 300", "HEA 200", "IPE 400"])
TABLES = {
    "kind": "column-impact",
    "column": {"section": "HEB 220", "length_below": 1.0, "length_above": 3.0},
    "striker": {"mass": 1000.0, "velocity": 10.0},
    "time": {"duration": 0.15},
}


def drawn(count: int) -> Varied:
    """Different columns and strikers."""
    rng = np.random.default_rng(1)
    return Varied(
        TABLES,
        {
            ("column", "section"): rng.choice(SECTIONS, count),
            ("column", "length_below"): rng.uniform(0.8, 2.5, count),
            ("column", "length_above"): rng.uniform(1.0, 3.0, count),
            ("column", "axial_load"): rng.uniform(0.0, 3e5, count),
            ("steel", "yield_stress"): rng.uniform(235e6, 460e6, count),
            ("striker", "mass"): rng.uniform(300.0, 2500.0, count),
            ("striker", "velocity"): rng.uniform(3.0, 12.0, count),
        },
    )


def frames(count: int, steels: bool) -> Varied:
    """The frame of Heng 2017 hit by different strikers; with `steels`, of different strength."""
    impact = load_scenario(data_directory() / "published" / "heng2017_frame.toml")
    assert isinstance(impact, FrameImpact)
    rng = np.random.default_rng(2)
    by_key = {
        ("striker", "mass"): rng.uniform(1000.0, 2000.0, count),
        ("striker", "velocity"): rng.uniform(30.0, 50.0, count),
    }
    if steels:
        by_key["steel", "yield_stress"] = rng.uniform(235e6, 460e6, count)
    return Varied(tomllib.loads(to_toml(replace(impact, duration=0.05))), by_key)


def main() -> None:
    """Measure all models in turn."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1
    threads = sorted({1, 2, cores})
    asked = [(name, make_model(name), drawn(count)) for name, count in ROWS.items()]
    asked += [("frames, strikers", ONE_BAR, frames(FRAMES, False))]
    asked += [("frames, steels too", ONE_BAR, frames(FRAMES, True))]
    print(f"{'model':<22}{'rows':>9}{'CPU us/row':>12}{'single/row':>12}   1 thread / {threads}")
    for name, model, scenarios in asked:
        count = len(scenarios)
        simulate_many(model, scenarios[:20])  # compile
        begin = process_time()
        for row in range(SINGLES):
            model.simulate(scenarios[row])
        single = (process_time() - begin) / SINGLES
        walls, row = [], 0.0
        for number in threads:
            begin, start = process_time(), perf_counter()
            simulate_many(model, scenarios, number)
            walls.append(perf_counter() - start)
            row = row or (process_time() - begin) / count
        speeds = "  ".join(f"{walls[0] / wall:.2f}" for wall in walls)
        print(f"{name:<22}{count:>9}{1e6 * row:>12.1f}{single / row:>12.1f}   {speeds}")
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print(f"most memory: {peak / 1e3:.0f} MB")


if __name__ == "__main__":
    main()
