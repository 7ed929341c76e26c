"""The page in a notebook: `wb.explore`."""

import tomllib
from pathlib import Path
from typing import Any

from workbench.base.datafiles import open_input
from workbench.extras.app import check_panel
from workbench.scenarios import Scenario, to_toml
from workbench.scenarios.files import LARGEST_FILE


def explore(scenario: Scenario | Path | str | None = None) -> Any:
    """Explore a scenario in a notebook: the form, answers and pictures of `workbench app`.

    Parameters
    ----------
    scenario : Scenario, Path or str, optional
        What happens, or the path of its file; by default a new column.

    Returns
    -------
    panel.viewable.Viewable
        The page, which a notebook shows; models work in processes of their own.

    Raises
    ------
    InputError
        Where Panel is not installed, and for a file that cannot be read.

    Examples
    --------
    >>> hit = wb.impact(wb.Column("HEB 220", 0.8, 3.2), mass=1500, velocity=5)
    >>> wb.explore(hit)  # doctest: +SKIP
    """
    check_panel("explore")
    from workbench.extras.app.desk import Desk
    from workbench.extras.app.form import read_tables
    from workbench.extras.app.page import ExplorerPage

    tables = None
    if isinstance(scenario, Path | str):
        with open_input(Path(scenario), "scenario file", LARGEST_FILE) as stream:
            tables = read_tables(stream.read())
    elif scenario is not None:
        tables = tomllib.loads(to_toml(scenario))
    return ExplorerPage(tables, Desk()).parts()
