from __future__ import annotations

import pickle
import textwrap
from pathlib import Path

import pytest

from workbench.base.errors import InputError
from workbench.study import load_study, run_study

STUDY = """
    from dataclasses import dataclass
    from toy_models import Spring
    from workbench.base.datafiles import data_directory
    from workbench.scenarios import load_scenario
    from workbench.study import Case, Study

    @dataclass(frozen=True)
    class Own(Spring):
        '''Defined in the study file itself.'''

    scenario = load_scenario(data_directory() / "published" / "heng2017_impact_column.toml")
    study = Study(
        name="own", title="t", question="q", cases=(Case("c", scenario),),
        models={"own": Own()}, reference="own",
    )
"""


def write(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(textwrap.dedent(text))
    return path


def test_by_name_by_path_and_with_hyphens(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write(tmp_path / "studies" / "my_study.py", STUDY)
    monkeypatch.chdir(tmp_path)
    for name in ("my_study", "my-study", "studies/my_study.py", path):
        loaded = load_study(name)
        assert loaded.study.name == "own"
        assert loaded.file == path


@pytest.mark.thorough
def test_models_of_the_study_file_reach_worker_processes(tmp_path: Path) -> None:
    loaded = load_study(write(tmp_path / "own_models.py", STUDY))
    model = loaded.study.models["own"]
    assert pickle.loads(pickle.dumps(model)) == model
    summary = run_study(loaded.study, tmp_path, jobs=1, file=loaded.file)
    assert summary.outcomes == {"ok": 1}


def test_an_unknown_name_has_the_nearest_known_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write(tmp_path / "studies" / "column_study.py", STUDY)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=r"did you mean column_study.*one of \d+ names"):
        load_study("colum_study")
    with pytest.raises(InputError, match="there is no such file"):
        load_study("studies/nothing.py")


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("syntax", "study = = 1\n", "SyntaxError"),
        ("importing", "import no_such_module\n", "line 1: ModuleNotFoundError"),
        ("nothing", "x = 1\n", "must define study = Study"),
        ("wrong", "study = 3\n", "must define study = Study"),
        ("leaves", "x = 1\nraise SystemExit(2)\n", "line 2: SystemExit: 2"),
        (
            "invalid",
            "from workbench.base.errors import InputError\n"
            "raise InputError('a.b', 1, 'must be 2')\n",
            "a.b = 1: must be 2",
        ),
    ],
)
def test_a_file_that_is_no_study(tmp_path: Path, name: str, text: str, message: str) -> None:
    path = write(tmp_path / f"bad_{name}.py", text)
    for _ in range(2):  # the second time must not find half a module
        with pytest.raises(InputError, match=message):
            load_study(path)
