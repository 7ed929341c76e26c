"""`workbench doctor`: is this environment fit for work, and what to do if it is not."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import NamedTuple

from workbench.base.datafiles import can_write
from workbench.cli.output import Answer, option, verb
from workbench.report.page.markdown import Block, Cell, Table, paragraph


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
        "libraries": _libraries,
        "kernel cache": _kernel_cache,
        "store": partial(_store, Path(store)),
        "models": _models,
        "physics": _physics,
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


def _libraries() -> Iterator[Check]:
    import re
    from importlib import metadata

    lock = Path(__file__).resolve().parents[2] / "requirements.lock"
    if not lock.is_file():
        detail = "no lock file beside this installation: versions are not pinned"
        yield Check("libraries", "warn", detail, "work from the source tree: make .venv")
        return
    wanted = dict(re.findall(r"(?m)^([A-Za-z0-9._-]+)==([^\s;\\]+)", lock.read_text()))
    differing = []
    for name, version in wanted.items():
        with suppress(metadata.PackageNotFoundError):  # extras
            if (installed := metadata.version(name)) != version:
                differing.append(f"{name} {installed} (locked {version})")
    remedy = "pip install -r requirements.lock"
    yield _judged("libraries", "as locked", "; ".join(differing), remedy, "warn")


def _kernel_cache() -> Iterator[Check]:
    from workbench.base.compiled import cache_folder, usual_folder

    usual = usual_folder()
    problem = "" if cache_folder() == usual else f"{usual} cannot be written: temporary"
    remedy = "set NUMBA_CACHE_DIR to a directory that can be written"
    yield _judged("kernel cache", "can be written", problem, remedy, "warn")


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


def _models() -> Iterator[Check]:
    from workbench.models.base import offers
    from workbench.responses.build import DISTRIBUTION

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

    from workbench.mechanics.frames.members import shear_stiffness
    from workbench.models.base import make_model
    from workbench.responses import energy_error
    from workbench.scenarios import Column, ColumnImpact, Striker
    from workbench.steel.sections import find

    column = Column(find("HEB 220"), length_below=2.0, length_above=2.0)
    scenario = ColumnImpact("self-check", column, Striker(mass=1500.0, velocity=0.5), duration=0.03)
    # a clamped column: 192 EI / L^3 in series with its shear
    length, steel, properties = column.length, column.steel, column.properties
    bending = 192.0 * steel.elastic_modulus * properties.second_moment / length**3
    flexibility = 1.0 / bending + length / (4.0 * shear_stiffness(column.strength_section, steel))
    momentum, mass = 1500.0 * 0.5, 1500.0 + properties.impact_mass
    expected = momentum * sqrt(flexibility / mass)
    response = make_model("four-dof").simulate(scenario)
    peak, energy = float(response["peak_displacement"]), energy_error(response)
    fine = energy is not None and energy < 1e-6 and abs(peak / expected - 1.0) < 2e-3
    detail = f"elastic peak {1e3 * peak:.4g} mm, closed form {1e3 * expected:.4g} mm; "
    detail += f"energy error {energy:.1e}"
    remedy = "run make test; compare the libraries with the lock file"
    yield _judged("physics four-dof", detail, "" if fine else detail, remedy)
