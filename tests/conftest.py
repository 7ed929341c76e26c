"""Shared fixtures: the thesis column, the switch for long studies, and kernels compiled once."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest
from hypothesis import HealthCheck, settings
from hypothesis.internal.conjecture import providers
from threadpoolctl import threadpool_limits
from toy_models import Spring

from workbench.base.datafiles import data_directory
from workbench.models import frame_model
from workbench.scenarios import Column, ColumnImpact, Striker, load_scenario
from workbench.steel.sections import find
from workbench.study import Case, Study
from workbench.study.runner import THREAD_VARIABLES

pytest_plugins = ["claims"]

# The same examples in every run, and no clock: a change fails because of the change, not because
# of the day or of what else the machine has to do (`too_slow` is a clock as well).
settings.register_profile(
    "repeatable",
    derandomize=True,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
    max_examples=30,
)
settings.register_profile("long", settings.get_profile("repeatable"), max_examples=100)
settings.load_profile("repeatable")
# Nor because of what other tests have loaded: the library else draws numbers that stand in the
# modules of this package, so that an example depended on which of them were imported before it.
providers.is_local_module_file = lambda _path: False


# all that tests compile for seconds beside what `workbench warm` compiles, so that no worker has to
KERNELS = (
    "force-based-beam",
    "fiber-hinge",
    "soft-impact",
    "giberson",
    "rigid-superelement",
    "shell",
)


def pytest_configure(config: pytest.Config) -> None:
    """Compile kernels into the cache before workers start, each of which would compile them all.

    Bytecode is kept as kernels are, whatever the environment says: tests start many processes.
    Each has one thread, as workers of studies have: small eigenvalue problems take up to fifty
    times as long where the threads of several processes wait for each other.
    """
    os.environ.update(dict.fromkeys(THREAD_VARIABLES, "1"))
    threadpool_limits(1, user_api="blas")
    if config.getoption("--run-slow"):
        settings.load_profile("long")
    if getattr(config.option, "numprocesses", None) and not hasattr(config, "workerinput"):
        os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
        code = "from workbench.cli import main; main()"
        subprocess.run([sys.executable, "-c", code, "warm", *KERNELS])


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--run-slow", action="store_true", help="run the long studies too")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if config.getoption("--run-slow"):
        return
    for item in items:
        if "slow" in item.keywords:
            item.add_marker(pytest.mark.skip(reason="long study: run with --run-slow"))


@pytest.fixture(scope="session")
def thesis_impact() -> ColumnImpact:
    """HEB 220 hit 0.8 m above its base at 15 m/s (Heng 2017, section 5.2)."""
    return load_scenario(data_directory() / "published" / "heng2017_impact_column.toml")


@pytest.fixture(scope="session")
def clamped_impact() -> ColumnImpact:
    """HEB 220 clamped at both ends, hit at mid-height at 25 m/s (Heng 2017, section 5.1)."""
    return load_scenario(data_directory() / "published" / "heng2017_clamped_column.toml")


@pytest.fixture(scope="session")
def parked() -> ColumnImpact:
    """HEA 240 of a car park, hit by 2 t at 10 m/s 0.6 m above its base under 600 kN, all pinned."""
    column = Column(find("HEA 240"), 0.6, 2.9, base="pinned", head="pinned", axial_load=6e5)
    return ColumnImpact("car park", column, Striker(2000.0, 10.0))


@pytest.fixture
def few_load_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """Static paths in 200 load steps, for what does not depend on how finely they are cut."""
    monkeypatch.setattr(frame_model, "PUSH_STEPS", 200)


@pytest.fixture
def toy_study(thesis_impact: ColumnImpact) -> Study:
    """Three impacts, a ladder of three levels and one reduced model: 12 cells."""
    return Study(
        name="toy",
        title="Toy",
        question="Does the runner run?",
        cases=tuple(
            Case(f"v{v}", thesis_impact.at_velocity(v), parameters={"velocity": v})
            for v in (10.0, 15.0, 20.0)
        ),
        models={
            "soft": Spring(stiffness=4e6),
            "coarse": Spring(error=0.08),
            "middle": Spring(error=0.08, level=1),
            "fine": Spring(error=0.08, level=2),
        },
        reference="fine",
        ladder=("coarse", "middle", "fine"),
        quick_models=("soft", "middle", "fine"),
    )
