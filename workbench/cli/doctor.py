"""`workbench doctor`: is this environment fit for work, and what to do if it is not."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, NamedTuple

import typer

from workbench.cli.output import Json, print_json, print_table


class Check(NamedTuple):
    """Result of one check: `state` is ok, warn or fail; a `remedy` goes with the last two."""

    name: str
    state: str
    detail: str
    remedy: str = ""


def doctor(
    store: Annotated[
        str, typer.Option("--store", metavar="DIR", help="Directory of the result stores.")
    ] = "reports",
    as_json: Json = False,
) -> int:
    """Check environment and science, with remedies.

    Exit status 1 if a check fails; warnings leave it at 0.
    """
    checks = [
        *_guarded("Python", _python),
        *_guarded("libraries", _libraries),
        *_guarded("kernel cache", _kernel_cache),
        *_guarded("threads", _threads),
        *_guarded("store", lambda: _store(Path(store))),
        *_guarded("data catalogue", _data),
        *_guarded("models", _models),
        *_guarded("physics", _physics),
        *_guarded("physics of references", _references),
    ]
    failed = any(check.state == "fail" for check in checks)
    if as_json:
        print_json({"failed": failed, "checks": [check._asdict() for check in checks]})
    else:
        print_table([(check.state, check.name, check.detail) for check in checks])
        for check in checks:
            if check.remedy:
                print(f"{check.name}: {check.remedy}")
    return 1 if failed else 0


def _guarded(name: str, check: Callable[[], list[Check]]) -> list[Check]:
    """A check that itself breaks is a finding, not a traceback."""
    try:
        return check()
    except Exception as error:
        detail = f"{type(error).__name__}: {error}"
        return [Check(name, "fail", detail, "install the workbench again from its lock file")]


def _python() -> list[Check]:
    version = ".".join(map(str, sys.version_info[:3]))
    if sys.maxsize < 2**32:
        return [Check("Python", "fail", f"{version}, 32 bits", "use a 64-bit Python")]
    return [Check("Python", "ok", version)]


def _libraries() -> list[Check]:
    import re
    from importlib import metadata

    lock = Path(__file__).resolve().parents[2] / "requirements.lock"
    if not lock.is_file():
        detail = "no lock file beside this installation: versions are not pinned"
        return [Check("libraries", "warn", detail, "work from the source tree: make .venv")]
    wanted = dict(re.findall(r"(?m)^([A-Za-z0-9._-]+)==([^\s;\\]+)", lock.read_text()))
    differing, missing = [], []
    for name, version in wanted.items():
        try:
            found = metadata.version(name)
        except metadata.PackageNotFoundError:
            missing.append(name)
            continue
        if found != version:
            differing.append(f"{name} {found} (locked {version})")
    needed = {
        re.split(r"[^A-Za-z0-9._-]", text)[0].lower()
        for text in metadata.requires("workbench") or ()
        if "extra ==" not in text
    }
    absent = [name for name in missing if name.lower() in needed]
    remedy = "pip install -r requirements.lock"
    if absent:
        return [Check("libraries", "fail", "not installed: " + ", ".join(absent), remedy)]
    if differing:
        return [Check("libraries", "warn", "; ".join(differing), remedy)]
    present = len(wanted) - len(missing)
    return [Check("libraries", "ok", f"{present} libraries as locked")]


def _kernel_cache() -> list[Check]:
    import os
    import tempfile

    given = os.environ.get("NUMBA_CACHE_DIR")
    package = Path(__file__).resolve().parents[1]
    directory = Path(given) if given else package / "hinges" / "__pycache__"
    try:
        directory.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=directory):
            pass
    except OSError:
        remedy = "set NUMBA_CACHE_DIR to a directory that can be written"
        detail = "cannot be written: every process compiles all kernels anew"
        return [Check("kernel cache", "warn", detail, remedy)]
    return [Check("kernel cache", "ok", "can be written")]


def _threads() -> list[Check]:
    import numpy as np
    from threadpoolctl import threadpool_info, threadpool_limits

    np.ones((2, 2)) @ np.ones((2, 2))
    pools = threadpool_info()
    with threadpool_limits(1):
        stuck = [pool["internal_api"] for pool in threadpool_info() if pool["num_threads"] > 1]
    if stuck:
        remedy = "set OMP_NUM_THREADS=1 before a run"
        return [Check("threads", "warn", f"{', '.join(stuck)} cannot be limited", remedy)]
    shown = ", ".join(f"{pool['internal_api']} {pool['num_threads']}" for pool in pools)
    return [Check("threads", "ok", f"{shown or 'no thread pools'}; one each in workers")]


def _store(root: Path) -> list[Check]:
    import shutil
    import tempfile

    nearest = next(p for p in (root.resolve(), *root.resolve().parents) if p.exists())
    remedy = "choose another directory with --store"
    try:
        with tempfile.TemporaryFile(dir=nearest):
            pass
    except OSError:
        return [Check("store", "fail", f"{root} cannot be written", remedy)]
    free = shutil.disk_usage(nearest).free / 1e9
    state = "fail" if free < 0.1 else "warn" if free < 1.0 else "ok"
    advice = "free some disk space" if state != "ok" else ""
    return [
        Check("store", "ok", f"{root} can be written"),
        Check("disk", state, f"{free:.3g} GB free", advice),
    ]


def _data() -> list[Check]:
    from workbench.evidence import check, datasets

    problems = check()
    if problems:
        remedy = "restore the data directory; `workbench data check` lists all problems"
        detail = f"{len(problems)} problems, first: {problems[0]}"
        return [Check("data catalogue", "fail", detail, remedy)]
    return [Check("data catalogue", "ok", f"{len(datasets())} datasets in order")]


def _models() -> list[Check]:
    from workbench.registry import offers

    found = offers()
    checks = [
        Check(
            f"model {offer.name}",
            "fail" if offer.distribution == "workbench" else "warn",
            offer.problem,
            f"install {offer.distribution} again, or remove it",
        )
        for offer in found
        if offer.kind is None
    ]
    usable = len(found) - len(checks)
    return [Check("models", "ok" if usable else "fail", f"{usable} can be used"), *checks]


def _physics() -> list[Check]:
    """Soft elastic impact at mid-height: momentum, 192 EI / L^3 and energy give the peak."""
    from math import sqrt

    from workbench.registry import make_model
    from workbench.scenarios import Column, ColumnImpact, Striker
    from workbench.sections import find

    column = Column(find("HEB 220"), length_below=2.0, length_above=2.0)
    striker = Striker(mass=1500.0, velocity=0.5)
    scenario = ColumnImpact("self-check", column=column, striker=striker, duration=0.03)
    properties = column.properties
    stiffness = 192.0 * column.steel.elastic_modulus * properties.second_moment / column.length**3
    mass = striker.mass + properties.impact_mass
    peak = striker.mass * striker.velocity / sqrt(mass * stiffness)
    checks = []
    for name in ("single-dof", "four-dof"):
        response = make_model(name).simulate(scenario)
        found = float(response["peak_displacement"])
        error = abs(found / peak - 1.0)
        energy = float(abs(response["balance_error"]).max()) / scenario.input_energy
        fine = error < 2e-3 and energy < 1e-6
        detail = (
            f"elastic peak {found * 1e3:.4g} mm, closed form {peak * 1e3:.4g} mm; "
            f"energy error {energy:.1e}"
        )
        remedy = "" if fine else "run make test; compare the libraries with the lock file"
        checks.append(Check(f"physics {name}", "ok" if fine else "fail", detail, remedy))
    return checks


def _references() -> list[Check]:
    """Small push at mid-height: 192 EI / L^3 in series with the shear stiffness, and energy."""
    from workbench.references.column_beams import shear_stiffness
    from workbench.registry import make_model
    from workbench.scenarios import Column, ColumnPushover
    from workbench.sections import find

    column = Column(find("HEB 220"), length_below=2.0, length_above=2.0)
    scenario = ColumnPushover("self-check", column=column, displacement=1e-3)
    bending = column.steel.elastic_modulus * column.strength_section.second_moment
    flexibility = column.length**3 / (192.0 * bending)
    flexibility += column.length / (4.0 * shear_stiffness(column))
    force = scenario.displacement / flexibility
    checks = []
    for name in ("fiber-reissner", "fiber-corotational"):
        mesh = {"smallest_element": 0.1, "largest_element": 0.1, "refinement": 0, "levels": 1}
        response = make_model(name, mesh).simulate(scenario)
        found = float(response["force"][-1])
        energy = float(abs(response["balance_error"]).max() / response["input_energy"])
        fine = abs(found / force - 1.0) < 5e-3 and energy < 1e-6
        detail = (
            f"elastic force {found / 1e3:.4g} kN, closed form {force / 1e3:.4g} kN; "
            f"energy error {energy:.1e}"
        )
        remedy = "" if fine else "run make test; compare the libraries with the lock file"
        checks.append(Check(f"physics {name}", "ok" if fine else "fail", detail, remedy))
    return checks
