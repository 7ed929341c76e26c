"""Runs of decks by CalculiX, and histories from the tables that it prints."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from workbench.extras.exchange.deck import DeckChoices, MoreNodes, deck_text, flight
from workbench.extras.exchange.meshes import MESHES
from workbench.scenarios import ColumnImpact

PROGRAM = shutil.which("ccx")
needs_calculix = pytest.mark.skipif(
    PROGRAM is None, reason="CalculiX is not installed: apt install calculix-ccx"
)


def answer(scenario: ColumnImpact, choices: DeckChoices, folder: Path) -> np.ndarray:
    """Time from the hit on in s; displacement of what is struck and of the axis in m: (3, steps).

    The axis is the mean of the struck section along the hit. Raises CalledProcessError.
    """
    choices.check_scenario(scenario)
    column, angle = scenario.column, scenario.angle_from_height
    mesh = MESHES[choices.mesh](column, choices.refinement)
    (folder / "column.inp").write_text(deck_text(scenario, mesh, choices), encoding="utf-8")
    command, threads = [str(PROGRAM), "-i", "column"], {"OMP_NUM_THREADS": "1"}
    subprocess.run(
        command, cwd=folder, check=True, capture_output=True, env={**os.environ, **threads}
    )
    heading = r"displacements .* time +(\S+)\n\n((?: +\d+(?: +\S+){3}\n)+)"
    face, rows = MoreNodes.after(mesh).face, []
    areas = mesh.areas(column.length_below)
    way = np.array([np.cos(angle), 0.0, -np.sin(angle)])
    for time, table in re.findall(heading, (folder / "column.dat").read_text()):
        moved = np.zeros((len(mesh.places) + 4, 3))
        for row in table.splitlines():
            number, *values = row.split()
            moved[int(number)] = [float(value) for value in values]
        axis = areas @ moved[1:-3] @ way / areas.sum()
        rows.append((float(time) - flight(column), moved[face, 0], axis))
    return np.array(rows).T
