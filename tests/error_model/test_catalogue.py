"""The data catalogue is complete, and published numbers answer only their own scenario."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from workbench.base.catalogue import check, dataset, datasets, load
from workbench.base.errors import InputError
from workbench.models.published import Published
from workbench.responses import Outcome, outcome_of


def test_every_dataset_is_described_and_present() -> None:
    assert check() == []
    assert len(datasets()) >= 3
    for entry in datasets():
        assert len(load(entry.name)) > 0


def test_columns_and_their_descriptions_must_agree(tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("WORKBENCH_DATA", str(tmp_path))
    (tmp_path / "own.csv").write_text("a,b\n1,2\n")
    text = (
        '[[dataset]]\nname = "own"\nfile = "own.csv"\ntitle = "Own"\nsource = "me"\n'
        'licence = "none"\nrole = "verify"\nuncertainty = "none"\n'
    )
    catalogue = tmp_path / "catalogue.toml"
    catalogue.write_text(f'{text}[dataset.columns]\na = "one"\nc = "three"\n')
    problems = [text for text in check() if "own" in text]
    assert problems == [
        "dataset own: column b is not described",
        "dataset own: column c is missing in the file",
    ]


def test_every_table_of_tests_names_its_works() -> None:
    from workbench.report.page.bibliography import bibliography

    for entry in datasets():
        if entry.file.startswith("studs/"):
            assert entry.keys
            assert set(entry.keys) <= set(bibliography())


def test_unknown_names_suggest_the_nearest() -> None:
    with pytest.raises(InputError, match="did you mean heng2017-figure-5-9"):
        dataset("heng2017-figure-5-8")
    with pytest.raises(InputError, match="must be one of"):
        Published("heng2017-figure-5-9", "TL beam")


def test_published_answers_its_scenario_only(thesis_impact) -> None:
    response = Published("heng2017-figure-5-9", "4-DOF nonlinear yield surface").simulate(
        thesis_impact.at_velocity(20.0)
    )
    assert float(response["peak_displacement"]) == 0.324
    assert json.loads(response.attrs["data_uncertainty"]) == {"peak_displacement": 0.0005}
    longer = replace(thesis_impact.at_velocity(10.0), duration=0.2, name="longer")
    assert (
        float(
            Published("heng2017-figure-5-9", "4-DOF nonlinear yield surface").simulate(longer)[
                "peak_displacement"
            ]
        )
        == 0.0901
    )
    for other in (
        thesis_impact.at_velocity(12.0),
        replace(thesis_impact, column=replace(thesis_impact.column, axial_load=0.0)),
    ):
        refused = Published("heng2017-figure-5-9", "4-DOF nonlinear yield surface").simulate(other)
        assert outcome_of(refused) is Outcome.OUT_OF_DOMAIN
        assert "no number for this scenario" in refused.attrs["message"]


def test_a_changed_table_changes_the_digest() -> None:
    one, two = (
        Published("heng2017-figure-5-9", "4-DOF nonlinear yield surface"),
        Published("heng2017-figure-5-4", "TL beam model"),
    )
    assert one.data_digest != two.data_digest
