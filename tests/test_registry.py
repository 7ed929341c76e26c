from __future__ import annotations

from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from workbench.base import offered
from workbench.base.errors import InputError
from workbench.models import base


@pytest.fixture
def plugins(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Four-dof beside third-party entries that are broken, each in its own way."""
    (tmp_path / "toy_plugin_that_exits.py").write_text("raise SystemExit('no licence')")
    monkeypatch.syspath_prepend(tmp_path)
    points = [
        ("four-dof", "workbench.models.four_dof:FourDof"),
        ("missing-module", "no_such_module:Model"),
        ("leaves-the-house", "toy_plugin_that_exits:Model"),
        ("missing-class", "workbench.models.four_dof:Nothing"),
        ("no-dataclass", "workbench.base.errors:InputError"),
        ("no-model", "workbench.steel.materials:Steel"),
        ("other-name", "workbench.models.four_dof:FourDof"),
        ("twice", "workbench.models.four_dof:FourDof"),
        ("twice", "workbench.models.base:Model"),
    ]
    entries = [EntryPoint(name, value, "workbench.models") for name, value in points]
    monkeypatch.setattr(offered, "entry_points", lambda group: [*entries, entries[0]])
    monkeypatch.setattr(offered, "_installed", offered._installed.__wrapped__)


def test_our_own_models_are_registered() -> None:
    names = base.model_names()
    assert names == sorted(names)
    assert {"four-dof", "single-dof", "energy-estimate", "fiber-corotational", "published"} <= set(
        names
    )


@pytest.mark.usefixtures("plugins")
def test_broken_plugins_are_reported_not_fatal() -> None:
    problems = {offer.name: offer.problem for offer in base.offers()}
    assert problems.pop("four-dof") == ""
    assert {name: text.partition(":")[0] for name, text in problems.items()} == {
        "missing-module": "ModuleNotFoundError on import",
        "leaves-the-house": "SystemExit on import",
        "missing-class": "AttributeError on import",
        "no-dataclass": "workbench.base.errors",
        "no-model": "workbench.steel.materials",
        "other-name": "workbench.models.four_dof",
        "twice": "several distributions provide it",
    }
    assert "declares no name, version" in problems["no-model"]
    assert "calls itself 'four-dof'" in problems["other-name"]
    for name in problems:
        with pytest.raises(InputError, match="cannot be used"):
            base.make_model(name)


@pytest.mark.usefixtures("plugins")
def test_listing_names_imports_nothing() -> None:
    assert "missing-module" in base.model_names()


def test_an_unknown_name_gets_the_nearest_and_where_all_are() -> None:
    with pytest.raises(InputError, match=r"is not known.*did you mean single-dof\?"):
        base.make_model("singel-dof")
    with pytest.raises(InputError, match=r"installed again\); `workbench models` lists all"):
        base.make_model("xyzzy")


def test_options_are_checked_by_name_and_value() -> None:
    model = base.make_model("four-dof", {"alpha": 1, "beta": 1.3})
    assert model == base.model_kind("four-dof")(alpha=1.0, beta=1.3)
    with pytest.raises(InputError, match="did you mean beta"):
        base.make_model("four-dof", {"betta": 1.3})
    with pytest.raises(InputError, match="beta"):
        base.make_model("four-dof", {"beta": 0.9})
