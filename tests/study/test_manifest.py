from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import pytest
from toy_models import Spring

from workbench.base.errors import InputError
from workbench.scenarios import ColumnImpact
from workbench.study import Case, Store, Study, cells_of, run_study, survey
from workbench.study.cells import ingredients_of, key_of


def reasons(study: Study, root: Path) -> dict[str, str]:
    return {
        entry.cell.name: entry.reason
        for entry in survey(study, cells_of(study), Store(root / study.name))
        if entry.reason
    }


@pytest.fixture
def small(toy_study: Study) -> Study:
    return dataclasses.replace(
        toy_study,
        cases=toy_study.cases[:1],
        models={"soft": Spring(stiffness=4e6), "fine": Spring()},
        ladder=(),
        quick_models=(),
    )


def changed(study: Study, **options: float) -> Study:
    return dataclasses.replace(study, models={**study.models, "soft": Spring(**options)})


def test_never_ran(small: Study, tmp_path: Path) -> None:
    assert reasons(small, tmp_path) == {"v10.0/soft": "never ran", "v10.0/fine": "never ran"}


def test_nothing_to_do_has_no_reason(small: Study, tmp_path: Path) -> None:
    run_study(small, tmp_path, jobs=0)
    assert reasons(small, tmp_path) == {}


def test_a_changed_option_is_named_with_both_values(small: Study, tmp_path: Path) -> None:
    run_study(small, tmp_path, jobs=0)
    other = changed(small, stiffness=3e6, level=2)
    assert reasons(other, tmp_path) == {
        "v10.0/soft": "option level 0 -> 2; option stiffness 4000000.0 -> 3000000.0"
    }
    # the manifest of the new study keeps the reason, also when that run was cut short
    run_study(other, tmp_path, jobs=0, only="fine")
    assert reasons(other, tmp_path)["v10.0/soft"].startswith("option level 0 -> 2")
    run_study(other, tmp_path, jobs=0)
    assert reasons(other, tmp_path) == {}
    assert "answered" not in (tmp_path / "toy" / "manifest.json").read_text()


def test_a_changed_scenario_is_named_key_by_key(small: Study, tmp_path: Path) -> None:
    run_study(small, tmp_path, jobs=0)
    impact = small.cases[0].scenario
    lighter = dataclasses.replace(
        impact, column=dataclasses.replace(impact.column, axial_load=2e5)
    ).at_velocity(11.0)
    other = dataclasses.replace(small, cases=(Case("v10.0", lighter),))
    expected = (
        "scenario changed: column.axial_load 500000.0 -> 200000.0, striker.velocity 10.0 -> 11.0"
    )
    assert reasons(other, tmp_path) == {"v10.0/soft": expected, "v10.0/fine": expected}


def test_a_new_name_of_a_scenario_changes_nothing(small: Study, tmp_path: Path) -> None:
    run_study(small, tmp_path, jobs=0)
    renamed = dataclasses.replace(small.cases[0].scenario, name="other words")
    other = dataclasses.replace(small, cases=(Case("v10.0", renamed),))
    assert reasons(other, tmp_path) == {}


def test_versions_and_data_are_named(
    small: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run_study(small, tmp_path, jobs=0)
    with monkeypatch.context() as patch:
        patch.setattr(Spring, "version", 2)
        assert set(reasons(small, tmp_path).values()) == {"model version 1 -> 2"}
    with monkeypatch.context() as patch:
        patch.setattr(Spring, "data_digest", "abc", raising=False)
        assert set(reasons(small, tmp_path).values()) == {"the data have changed"}
    with monkeypatch.context() as patch:
        patch.setattr("workbench.study.cells.provenance", lambda: {"workbench": "9.9"})
        (text,) = set(reasons(small, tmp_path).values())
        assert text.startswith("workbench version")
        assert text.endswith("-> 9.9")


def test_another_reading_of_histories_is_named(
    small: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run_study(small, tmp_path, jobs=0)
    with monkeypatch.context() as patch:
        patch.setattr(ColumnImpact, "READING", ColumnImpact.READING + 1)
        statements = reasons(small, tmp_path)
        assert set(statements.values()) == {"other quantities are read off histories"}
    monkeypatch.setattr("workbench.study.cells.TABLE_DIGEST", "a scalar more")
    statements = reasons(small, tmp_path)
    assert set(statements.values()) == {"the table of response variables has changed"}


def test_every_ingredient_changes_the_key(thesis_impact: ColumnImpact) -> None:
    ingredients = ingredients_of(thesis_impact, Spring())
    key = key_of(ingredients)
    assert len(key) == 20
    for name in ingredients:
        assert key_of({**ingredients, name: "other"}) != key, name
    assert key_of(dict(reversed(ingredients.items()))) == key


def test_the_manifest_describes_the_study(small: Study, tmp_path: Path) -> None:
    run_study(small, tmp_path, jobs=0)
    manifest = json.loads((tmp_path / "toy" / "manifest.json").read_text())
    assert manifest["cases"][0]["parameters"] == {"velocity": 10.0}
    assert 'kind = "column-impact"' in manifest["cases"][0]["scenario"]
    assert manifest["labels"]["soft"] == {
        "model": "toy-spring",
        "version": 1,
        "options": dataclasses.asdict(small.models["soft"]),
        "assumptions": ["Linear spring, no mass but the striker's."],
        "sources": [],
    }
    assert [entry["key"] for entry in manifest["cells"]] == [c.key for c in cells_of(small)]
    assert manifest["provenance"]["numpy"]


def test_a_broken_manifest_is_refused_with_advice(small: Study, tmp_path: Path) -> None:
    run_study(small, tmp_path, jobs=0)
    (tmp_path / "toy" / "manifest.json").write_text("[]")
    with pytest.raises(InputError, match="remove it and run again"):
        reasons(small, tmp_path)
