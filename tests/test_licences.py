"""Licences: packages of the lock file, listed in docs/licences.md, and data all say one."""

from __future__ import annotations

import re
from importlib import metadata
from pathlib import Path

import pytest

import workbench
from workbench.base.catalogue import Dataset, datasets, load

TREE = Path(workbench.__file__).resolve().parents[1]
LOCKED = re.findall(r"(?m)^([\w.-]+)==", (TREE / "requirements.lock").read_text("utf-8"))
BINDING = re.compile(r"(?<!L)GPL|Affero|GNU General Public")  # what uses it would have to follow


def licence(name: str) -> str:
    about = metadata.metadata(name)
    said = (about.get("License-Expression") or about.get("License") or "").strip()
    kinds = [c.split(" :: ")[-1] for c in about.get_all("Classifier", []) if "License ::" in c]
    return said if said and len(said) < 100 else "; ".join(kinds)


def needed(*extras: str) -> set[str]:
    """Names of all packages that ours needs to run, with its extras, through others too."""
    waiting, found = [("steel-impact-workbench", {"", *extras})], set()
    while waiting:
        package, wanted = waiting.pop()
        for line in metadata.requires(package) or []:
            name, extra = re.split(r"[^\w.-]", line)[0], re.search(r"extra == .([\w-]+)", line)
            name = name.lower().replace("_", "-")
            if (extra[1] if extra else "") in wanted and name in LOCKED and name not in found:
                found.add(name)
                waiting.append((name, {""}))
    return found


def test_every_package_of_the_lock_is_listed_with_its_licence() -> None:
    run, app = needed(), needed("app")
    rows = [
        f"| {n} | {licence(n)} | {'run' if n in run else 'app' if n in app else 'tools'} |"
        for n in LOCKED
    ]
    page = (TREE / "docs" / "licences.md").read_text("utf-8")
    assert re.findall(r"(?m)^\| [a-z][\w.-]* \|.*", page)[1:] == rows  # after its head
    assert not [row for row in rows if "|  |" in row]
    assert not [row for row in rows if BINDING.search(row)]
    assert BINDING.search("AGPL-3.0")
    assert not BINDING.search("LGPL-2.1; GNU Lesser General Public License")


@pytest.mark.parametrize("each", datasets(), ids=lambda each: each.name)
def test_every_dataset_and_every_row_that_has_its_own_says_a_licence(each: Dataset) -> None:
    assert len(each.licence) > 2
    if "licence" in each.columns:
        assert load(each.name)["licence"].str.len().gt(2).all()
