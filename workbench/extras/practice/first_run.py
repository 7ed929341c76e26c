"""`workbench warm`: kernels compiled at set-up, in processes at once, before answers wait for them.

What is compiled holds for this processor and this version alone, so that no package can bring it.
"""

from __future__ import annotations

import sys
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import fields, replace
from multiprocessing import get_context
from typing import Annotated, Any

import typer

from workbench.cli.output import Answer, Jobs, Names, processes, verb

# of the first page and of the flagship: models of a group share kernels, the dearest come first
GROUPS = (
    *(("flexible-superelement",), ("seven-dof",), ("four-dof-shear", "four-dof")),
    *(("solid-plane-stress",), ("fiber-reissner", "fiber-shear"), ("fiber-corotational",)),
    ("single-dof", "energy-estimate", "biggs"),
)
Further = Annotated[Names, typer.Argument(metavar="[MODEL]...", help="Further models.")]


@verb
def warm(models: Further = None, jobs: Jobs = None) -> Answer:
    """Compile kernels once, so that no answer waits for it.

    Those of the first page and of the flagship study; others follow when their model first answers.
    """
    from workbench.models.base import model_kind

    asked = {model_kind(name).name: None for name in models or ()}
    groups = [*GROUPS, *((name,) for name in asked if not any(name in each for each in GROUPS))]
    begin = time.monotonic()
    with ProcessPoolExecutor(processes(jobs), mp_context=get_context("spawn")) as pool:
        at_work = [pool.submit(compile_kernels, group) for group in groups]
        for done, future in enumerate(as_completed(at_work), 1):
            names, seconds = ", ".join(future.result()), time.monotonic() - begin
            print(f"kernels {done} of {len(groups)}: {names}, {seconds:.0f} s", file=sys.stderr)
    return Answer({"groups": groups, "seconds": time.monotonic() - begin})


def compile_kernels(names: tuple[str, ...]) -> tuple[str, ...]:
    """Answer short cases by the named models, in turn; their kernels are then on the disk."""
    from threadpoolctl import threadpool_limits

    from workbench.api.answers import simulate
    from workbench.base.datafiles import data_directory
    from workbench.models.base import make_model, model_kind
    from workbench.models.strain_rate import with_rate
    from workbench.scenarios import ColumnPushover, frame_scenario, load_scenario
    from workbench.steel.materials import GRADES
    from workbench.study.error_model.error_table import ANCHOR

    hit: Any = load_scenario(data_directory() / "published" / "heng2017_impact_column.toml")
    brief = replace(hit, duration=1e-3)
    push = ColumnPushover("push", hit.column, 1e-3)
    rated = with_rate(brief, GRADES["S355"][1])
    with threadpool_limits(1):
        for name in names:
            one_mesh = "levels" in {field.name for field in fields(model_kind(name))}
            model = make_model(name, {"levels": 1} if one_mesh else {})
            for scenario in (brief, rated, push, frame_scenario(brief)):
                if scenario.KIND in model.answers:
                    model.simulate(scenario)
            if name == ANCHOR:  # with all that judges an answer
                simulate(hit)
    return names
