"""One to three tests by EN 1990 D.8.4: a characteristic value from a scatter known beforehand.

Nominally equal tests make a group: push-outs of undamaged studs, whose shear counts, and tests
after one level of damage, of which the share of the undamaged strength or stiffness counts.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pandas as pd

from workbench.errors import InputError
from workbench.studs.damage import damage_of
from workbench.studs.damaged import QUANTITIES, damaged_rows
from workbench.studs.quantities import Array, undamaged_headed_studs
from workbench.studs.schema import NO_PREDAMAGE
from workbench.studs.series import equal_tests, title_of
from workbench.studs.statistics.annex_d import FEW_DEVIATION, MOST_FEW, few_tests_factor


class Few(NamedTuple):
    """A group of one to three tests: `mean` (N, or a share) and `characteristic` value.

    `kind`, ``shear`` or the share that is left; `factor` eta_k; `deviation`, of the farthest from
    the mean; `refusal`, why there is no value.
    """

    name: str
    kind: str
    tests: int
    mean: float
    deviation: float
    factor: float | None
    characteristic: float | None
    refusal: str


def evaluate_few(table: pd.DataFrame, variation: float) -> list[Few]:
    """Every group of nominally equal tests of a table, evaluated or refused with the reason.

    Arguments: `table` (schema `TESTS`); `variation`, V_r known from earlier tests. Raises
    `InputError` for a table without a test that a fit may use.
    """
    found = [_few(*each, variation) for each in _groups(table)]
    if not found:
        undamaged_headed_studs(table)  # says why none is left
    return found


def _groups(table: pd.DataFrame) -> Iterator[tuple[str, str, Array]]:
    """Name, kind and values of every group."""
    try:
        undamaged = undamaged_headed_studs(table, "any")
    except InputError:
        undamaged = table.iloc[:0]
    for group in equal_tests(undamaged):
        yield title_of(group), "shear", 1e3 * group["shear_kN"].to_numpy(float)
    damaged = table.assign(predamage_measure=damage_of(table)["measure"])
    damaged = damaged[damaged["predamage"] != NO_PREDAMAGE]
    kinds = damaged[["predamage", "predamage_measure"]].drop_duplicates()
    for quantity in QUANTITIES:
        for kind in kinds.itertuples(index=False):
            rows = damaged_rows(table, quantity, *kind)
            for level, own in rows.groupby("level", sort=True):
                for group in equal_tests(own):
                    name = f"{title_of(group)}, {' '.join(kind)} {level:.3g}"
                    yield name, f"{quantity} left", group["ratio"].to_numpy(float)


def _few(name: str, kind: str, values: Array, variation: float) -> Few:
    count, mean = len(values), float(np.mean(values))
    deviation = float(np.max(np.abs(values / mean - 1.0)))
    factor, refusal = None, ""
    if count > MOST_FEW:
        refusal = f"more than {MOST_FEW} tests tell their own scatter: D.8.2, by the other fits"
    elif deviation > FEW_DEVIATION:
        refusal = f"{100 * deviation:.0f} % off the mean: two or three tests must lie within 10 %"
    else:
        factor = few_tests_factor(count, variation)
    characteristic = None if factor is None else factor * mean
    return Few(name, kind, count, mean, deviation, factor, characteristic, refusal)
