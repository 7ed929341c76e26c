"""How many functions of the package (code objects) one answer and one figure call."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import pytest

import workbench
from workbench.models.base import make_model
from workbench.scenarios import load_scenario
from workbench.study import Case, Figure, Study, run_study
from workbench.study.assessor import assess

ROOT = str(Path(workbench.__file__).parent)
SCENARIO = load_scenario(Path(ROOT).parent / "data/published/heng2017_impact_column.toml")
MOST_OF_AN_ANSWER, MOST_OF_A_FIGURE = 60, 250
MOST_WITH_ADVICE, MOST_MODULES = 350, 40
KINDS = ("structure", "history", "deformed", "peaks", "energy", "cost", "interaction")


def touched(call: Callable[[], Any]) -> set[CodeType]:
    """Code objects of the package that a call runs."""
    codes: set[CodeType] = set()

    def note(frame: FrameType, event: str, _: object) -> None:
        if event == "call" and frame.f_code.co_filename.startswith(ROOT):
            codes.add(frame.f_code)

    sys.setprofile(note)
    try:
        call()
    finally:
        sys.setprofile(None)
    return codes


def names(codes: set[CodeType]) -> list[str]:
    return sorted(f"{Path(code.co_filename).name} {code.co_qualname}" for code in codes)


def test_a_closed_formula_touches_few_functions() -> None:
    model = make_model("energy-estimate")
    model.simulate(SCENARIO)
    codes = touched(lambda: model.simulate(SCENARIO))
    assert len(codes) <= MOST_OF_AN_ANSWER, names(codes)


@pytest.mark.parametrize("name", ["four-dof", "flexible-superelement"])
def test_an_answer_with_advice_touches_few_functions(name: str) -> None:
    workbench.simulate(SCENARIO, name)
    codes = touched(lambda: workbench.simulate(SCENARIO, name))
    assert len(codes) <= MOST_WITH_ADVICE, names(codes)
    assert len({code.co_filename for code in codes}) <= MOST_MODULES, names(codes)


# what an answer on the command line has no use for
IDLE = (
    *("matplotlib", "scipy.stats", "scipy.interpolate", "scipy.io", "skfem", "typst", "openpyxl"),
    *("workbench.study.definition", "workbench.studs", "workbench.extras.uncertainty"),
    *("workbench.report.build", "workbench.report.drawing"),
    *(
        "workbench.models.references",
        "workbench.extras.intake.impact_tests",
        "workbench.extras.uncertainty.verbs.serve",
    ),
)


@pytest.mark.thorough
def test_an_answer_on_the_command_line_loads_what_it_needs() -> None:
    code = f"""if True:
        import sys
        from workbench.cli import run
        file = "{ROOT}/../data/published/heng2017_impact_column.toml"
        assert run(["simulate", file, "--model", "four-dof"]) == 0
        print([name for name in {IDLE} if name in sys.modules], file=sys.stderr)
    """
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr.splitlines()[-1] == "[]"


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> Any:
    from workbench.study.assessor import read_assessment

    root = tmp_path_factory.mktemp("two-cells")
    models = {name: make_model(name) for name in ("four-dof", "single-dof")}
    case, quantities = Case("hit", SCENARIO), ("peak_displacement",)
    study = Study("two", "Two cells", "Which?", (case,), models, "four-dof", quantities=quantities)
    directory = run_study(study, root, jobs=0).directory
    assess(study, root)
    return read_assessment(directory, study)


@pytest.mark.thorough
@pytest.mark.parametrize("kind", KINDS)
def test_a_figure_touches_few_functions(stored: Any, kind: str) -> None:
    from workbench.report.drawing.sheet import Request
    from workbench.report.drawing.style import looks
    from workbench.report.figures import draw
    from workbench.report.gallery import to_svg
    from workbench.study.assessor import read_assessment

    study = stored.study
    fresh = read_assessment(stored.directory, study)

    def picture() -> str:
        figure = Figure(kind, kind, kind, kind)
        labels = tuple(study.models)
        request = Request(study, figure, fresh, study.cases, labels, looks(study))
        return to_svg(draw(request).canvas, kind)

    codes = touched(picture)
    assert len(codes) <= MOST_OF_A_FIGURE, names(codes)
