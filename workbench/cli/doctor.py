"""`workbench doctor`: is this environment fit for work, and what to do if it is not."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from workbench.base.datafiles import can_write
from workbench.cli.output import Answer, option, verb
from workbench.report.page.markdown import Block, Cell, Table, paragraph

if TYPE_CHECKING:
    from workbench.responses import Response
    from workbench.scenarios import ColumnScenario


class Check(NamedTuple):
    """Result of one check: `state` is ok, warn or fail; a `remedy` goes with the last two."""

    name: str
    state: str
    detail: str
    remedy: str = ""


def _judged(name: str, fine: str, problem: str, remedy: str, state: str = "fail") -> Check:
    """A check whose result is `fine`, or a `problem` (empty: none) with its remedy."""
    return Check(name, state, problem, remedy) if problem else Check(name, "ok", fine)


@verb
def doctor(
    store: str = option("Directory of the result stores.", "reports", "DIR"),
) -> Answer:
    """Check environment and science, with remedies.

    Exit status 1 if a check fails; warnings leave it at 0.
    """
    named: dict[str, Callable[[], Iterator[Check]]] = {
        "Python": _python,
        "libraries": _libraries,
        "kernel cache": _kernel_cache,
        "threads": _threads,
        "store": partial(_store, Path(store)),
        "data catalogue": _data,
        "models": _models,
        "physics": _physics,
        "physics of references": _references,
    }
    checks = [each for name, check in named.items() for each in _guarded(name, check)]
    failed = any(check.state == "fail" for check in checks)
    content = {"failed": failed, "checks": [check._asdict() for check in checks]}
    return Answer(content, _blocks(checks), int(failed))


def _blocks(checks: list[Check]) -> Iterator[Block]:
    tones = {"ok": "good", "warn": "doubt", "fail": "bad"}
    columns = {
        "state": lambda check: Cell(check.state, tone=tones[check.state]),
        "check": "name",
        "what it saw": "detail",
    }
    yield Table.of("checks", "", columns, checks)
    yield from (paragraph(f"{check.name}: {check.remedy}") for check in checks if check.remedy)


def _guarded(name: str, check: Callable[[], Iterator[Check]]) -> list[Check]:
    """A check that itself breaks is a finding, not a traceback."""
    try:
        return list(check())
    except Exception as error:
        detail = f"{type(error).__name__}: {error}"
        return [Check(name, "fail", detail, "install the workbench again from its lock file")]


def _python() -> Iterator[Check]:
    version = ".".join(map(str, sys.version_info[:3]))
    problem = f"{version}, 32 bits" if sys.maxsize < 2**32 else ""
    yield _judged("Python", version, problem, "use a 64-bit Python")


def _libraries() -> Iterator[Check]:
    import re
    from importlib import metadata

    from workbench.responses.provenance import DISTRIBUTION

    lock = Path(__file__).resolve().parents[2] / "requirements.lock"
    if not lock.is_file():
        detail = "no lock file beside this installation: versions are not pinned"
        yield Check("libraries", "warn", detail, "work from the source tree: make .venv")
        return
    wanted = dict(re.findall(r"(?m)^([A-Za-z0-9._-]+)==([^\s;\\]+)", lock.read_text()))
    installed: dict[str, str] = {}
    for name in wanted:
        with suppress(metadata.PackageNotFoundError):
            installed[name] = metadata.version(name)
    needed = {
        re.split(r"[^A-Za-z0-9._-]", text)[0].lower()
        for text in metadata.requires(DISTRIBUTION) or ()
        if "extra ==" not in text
    }
    absent = [name for name in wanted if name not in installed and name.lower() in needed]
    differing = [
        f"{name} {version} (locked {wanted[name]})"
        for name, version in installed.items()
        if version != wanted[name]
    ]
    problem = f"not installed: {', '.join(absent)}" if absent else "; ".join(differing)
    fine, remedy = f"{len(installed)} libraries as locked", "pip install -r requirements.lock"
    yield _judged("libraries", fine, problem, remedy, "fail" if absent else "warn")


def _kernel_cache() -> Iterator[Check]:
    from workbench.base.compiled import usual_folder

    problem = "" if can_write(usual_folder()) else f"{usual_folder()} cannot be written: temporary"
    remedy = "set NUMBA_CACHE_DIR to a directory that can be written"
    yield _judged("kernel cache", "can be written", problem, remedy, "warn")


def _threads() -> Iterator[Check]:
    import numpy as np
    from threadpoolctl import threadpool_info, threadpool_limits

    np.ones((2, 2)) @ np.ones((2, 2))
    pools = threadpool_info()
    with threadpool_limits(1):
        stuck = [pool["internal_api"] for pool in threadpool_info() if pool["num_threads"] > 1]
    shown = ", ".join(f"{pool['internal_api']} {pool['num_threads']}" for pool in pools)
    fine = f"{shown or 'no thread pools'}; one each in workers"
    problem = f"{', '.join(stuck)} cannot be limited" if stuck else ""
    yield _judged("threads", fine, problem, "set OMP_NUM_THREADS=1 before a run", "warn")


def _store(root: Path) -> Iterator[Check]:
    import shutil

    nearest = next(p for p in (root.resolve(), *root.resolve().parents) if p.exists())
    problem = "" if can_write(nearest) else f"{root} cannot be written"
    remedy = "choose another directory with --store"
    yield _judged("store", f"{root} can be written", problem, remedy)
    if not problem:
        free = shutil.disk_usage(nearest).free / 1e9
        state = "fail" if free < 0.1 else "warn" if free < 1.0 else "ok"
        advice = "free some disk space" if state != "ok" else ""
        yield Check("disk", state, f"{free:.3g} GB free", advice)


def _data() -> Iterator[Check]:
    from workbench.study.error_model import check, datasets

    problems = check()
    problem = f"{len(problems)} problems, first: {problems[0]}" if problems else ""
    remedy = "restore the data directory; `workbench data check` lists all problems"
    fine = "" if problem else f"{len(datasets())} datasets in order"
    yield _judged("data catalogue", fine, problem, remedy)


def _models() -> Iterator[Check]:
    from workbench.models.registry import offers
    from workbench.responses.provenance import DISTRIBUTION

    broken = [offer for offer in offers() if offer.kind is None]
    usable = len(offers()) - len(broken)
    yield Check("models", "ok" if usable else "fail", f"{usable} can be used")
    for offer in broken:
        state = "fail" if offer.distribution == DISTRIBUTION else "warn"
        remedy = f"install {offer.distribution} again, or remove it"
        yield Check(f"model {offer.name}", state, offer.problem, remedy)


def _physics() -> Iterator[Check]:
    """Soft elastic impact at mid-height: momentum, flexibility and energy give the peak."""
    from math import sqrt

    from workbench.models.registry import make_model
    from workbench.scenarios import Column, ColumnImpact, Striker
    from workbench.steel.sections import find

    column = Column(find("HEB 220"), length_below=2.0, length_above=2.0)
    striker = Striker(mass=1500.0, velocity=0.5)
    scenario = ColumnImpact("self-check", column=column, striker=striker, duration=0.03)
    properties = column.properties
    mass = striker.mass + properties.impact_mass
    flexibility = _flexibility(scenario, properties.second_moment)
    peak = striker.mass * striker.velocity * sqrt(flexibility / mass)
    for name in ("single-dof", "four-dof"):
        response = make_model(name).simulate(scenario)
        value = float(response["peak_displacement"])
        yield _compared(name, "elastic peak", (1e3 * value, 1e3 * peak, "mm"), 2e-3, response)


def _flexibility(scenario: ColumnScenario, second_moment: float) -> float:
    """Of a clamped column hit at mid-height (m/N): 192 EI / L^3 in series with its shear."""
    from workbench.mechanics.frames.members import shear_stiffness

    column = scenario.column
    bending = 192.0 * column.steel.elastic_modulus * second_moment / column.length**3
    shear = 4.0 * shear_stiffness(column.strength_section, column.steel) / column.length
    return float(1.0 / bending + 1.0 / shear)


def _references() -> Iterator[Check]:
    """Small push at mid-height, and energy."""
    from workbench.models.registry import make_model
    from workbench.scenarios import Column, ColumnPushover
    from workbench.steel.sections import find

    column = Column(find("HEB 220"), length_below=2.0, length_above=2.0)
    scenario = ColumnPushover("self-check", column=column, displacement=1e-3)
    force = scenario.displacement / _flexibility(scenario, column.strength_section.second_moment)
    mesh = {"smallest_element": 0.1, "largest_element": 0.1, "refinement": 0, "levels": 1}
    for name in ("fiber-reissner", "fiber-corotational"):
        response = make_model(name, mesh).simulate(scenario)
        value = float(response["force"][-1])
        yield _compared(name, "elastic force", (value / 1e3, force / 1e3, "kN"), 5e-3, response)


def _compared(
    name: str, what: str, pair: tuple[float, float, str], tolerance: float, response: Response
) -> Check:
    """A value of a model beside its closed form and their unit, and the energy of the run."""
    value, expected, unit = pair
    from workbench.responses import energy_error

    energy = energy_error(response)
    fine = energy is not None and energy < 1e-6 and abs(value / expected - 1.0) < tolerance
    detail = f"{what} {value:.4g} {unit}, closed form {expected:.4g} {unit}; "
    detail += f"energy error {energy:.1e}"
    problem = "" if fine else detail
    remedy = "run make test; compare the libraries with the lock file"
    return _judged(f"physics {name}", detail, problem, remedy)
