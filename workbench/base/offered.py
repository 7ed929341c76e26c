"""Entry points: models, verbs, kinds of scenarios, chapters and figures by other packages."""

from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from workbench.base.errors import InputError


def offered(group: str) -> list[EntryPoint]:
    """Entry points of a group ``workbench.<group>``, sorted by name; nothing is imported."""
    return list(_installed(f"workbench.{group}"))


@cache
def _installed(group: str) -> list[EntryPoint]:
    """Entry points of a group, read once: that goes through all installed packages (5 ms)."""
    # A distribution may be seen twice (an editable install on the path and its metadata).
    unique = {(p.name, p.value): p for p in entry_points(group=group)}
    return [unique[key] for key in sorted(unique)]


@cache
def companion(group: str, name: str) -> Any:
    """Object that an installed package offers under a name, imported now.

    Raises `InputError` if none does.
    """
    for point in offered(group):
        if point.name == name:
            return point.load()
    text = "is offered by no installed package"
    raise InputError(f"workbench.{group}", name, text, "install one that does")
