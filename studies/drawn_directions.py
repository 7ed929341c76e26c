"""How far superelements in space are off where a column is hit from the side, on drawn columns.

Columns and strikes are those of `which_model`, at 3 to 87 degrees off the web and with the ends of
the weak axis drawn apart; webs that yield in shear are left out, as fibers in space have none. The
reference is the column of fibers in space. The peaks are data of the error model.
"""

import sys
from collections.abc import Iterator
from dataclasses import replace
from math import radians

import numpy as np
from which_model import SECTIONS, drawn

from workbench.cli import main
from workbench.models.references.fiber_space import FiberSpace
from workbench.models.superelement_space import SuperelementSpace
from workbench.scenarios import ColumnImpact
from workbench.steel.sections import find
from workbench.study import Case, Figure, Study
from workbench.study.error_model.error_table import DEMAND, features

SEED, COLUMNS, QUICK = 53, 160, 2
LIGHT, ANGLES, SHARES = 0.3, (3.0, 87.0), (-0.1, 0.6)  # light strikers; degrees; P/Npl
MOST = 0.75  # V/Vpl of the mechanism
SLENDER = 0.5  # largest share of the Euler load about the weak axis
REFERENCE = "fibers in space"
models = {REFERENCE: FiberSpace(refinement=0, levels=1), "in space": SuperelementSpace()}
UNIVERSAL = ("UC 203x203x60", "UC 254x254x107", "UB 305x165x40")
DRAWN = (*SECTIONS[:-1], *map(find, UNIVERSAL))


def drawn_columns(seed: int, count: int) -> Iterator[ColumnImpact]:
    """Columns hit off their web, the same of a seed however many."""
    rng, number = np.random.default_rng(seed), 0
    while number < count:
        point, part = rng.random(14), rng.random(4)
        impact = drawn(point, 1 + number % 4, bool(part[0] < LIGHT), DRAWN, SHARES)
        if features(impact)[DEMAND] > MOST:
            continue
        degrees = round(ANGLES[0] + part[1] * (ANGLES[1] - ANGLES[0]), 1)
        column, striker = impact.column, impact.striker.changed(angle=radians(degrees))
        if part[2] < 0.3:
            column = column.changed(base_weak="pinned" if part[3] < 0.5 else "clamped")
        load = min(column.axial_load, SLENDER * column.euler_load("weak"))
        column = column.changed(axial_load=load)
        name = f"{number:03d} {column.section.name.replace(' without fillets', ', plates')}, "
        name += f"{column.length_below:.2f} + {column.length_above:.2f} m, {degrees:g} degrees, "
        name += f"{striker.velocity:.1f} m/s, {striker.mass:.0f} kg"
        lasts = 2.0 * impact.duration  # weak ways are longer
        yield replace(impact, name=name, column=column, striker=striker, duration=lasts)
        number += 1


cases = tuple(
    Case(impact.name, impact, quick=number < QUICK)
    for number, impact in enumerate(drawn_columns(SEED, COLUMNS))
)
study = Study(
    name="drawn_directions",
    title="Columns hit off their web: superelements in space on drawn ones",
    question="How far are superelements in space off fibers in space?",
    cases=cases,
    models=models,
    reference=REFERENCE,
    quantities=("peak_displacement", "residual_displacement"),
    figures=(Figure("peaks", "peaks", "Peaks against fibers in space", "By case."),),
    decisive="peaks",
)

if __name__ == "__main__":
    main(["run", __file__, *sys.argv[1:]])
