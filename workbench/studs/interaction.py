"""Tension with shear: laws of what is left of one under the other, and tests of both.

Tension and shear are over the resistances of equal studs under one of them alone.
"""

from collections.abc import Callable

import numpy as np
import pandas as pd

from workbench.errors import InputError
from workbench.studs.quantities import Array, equal_studs
from workbench.studs.schema import NO_PREDAMAGE


def _power(exponent: float) -> Callable[[Array], Array]:
    """t^p + v^p = 1."""
    return lambda t: np.maximum(1.0 - t**exponent, 0.0) ** (1.0 / exponent)


# shear (n,) that is left at tensions (n,) from 0 on; none is left beyond the tension resistance
INTERACTIONS: dict[str, Callable[[Array], Array]] = {
    "five-thirds": _power(5.0 / 3.0),  # AISC 360-22, I8.3c
    "linear": _power(1.0),
    # t + v <= 1.2, of ACI 318 and the PCI handbook (recalled, not read again)
    "trilinear": lambda t: np.where(t > 1.0, 0.0, np.clip(1.2 - t, 0.0, 1.0)),
}


def combined_tests(table: pd.DataFrame) -> pd.DataFrame:
    """Rows (campaign, specimen, tension, shear, companions) of the combined tests; may be empty.

    Both are over the mean resistance of the undamaged pull-outs and push-outs of the same campaign
    and diameter, in concrete of about the same strength; a combined test without both is left out.
    `companions`, how many tests the scarcer of the two has.
    """
    usable = table[(table["use_for_fit"] == 1.0) & (table["predamage"] == NO_PREDAMAGE)]
    rows = []
    for _, row in usable[usable["test"] == "combined"].iterrows():
        found: dict[str, object] = {name: row[name] for name in ("campaign", "specimen", "origin")}
        alike, counts = equal_studs(usable, row), []
        for kind, name in (("pull-out", "tension"), ("push-out", "shear")):
            alone = alike.loc[alike["test"] == kind, f"{name}_kN"].astype(float).dropna()
            counts.append(len(alone))
            found[name] = float(row[f"{name}_kN"]) / alone.mean()
        rows.append({**found, "companions": min(counts)})
    names = ["campaign", "specimen", "origin", "tension", "shear", "companions"]
    complete = pd.DataFrame(rows, columns=names).dropna(subset=["tension", "shear"])
    return complete.reset_index(drop=True)


def borne(tests: pd.DataFrame, tension: Array, shear: Array) -> Array:
    """Distance (n,) of a curve (m,) from the origin in the direction of every test.

    Raises `InputError` for tests beside the curve.
    """
    angle = np.arctan2(shear, tension)
    order = np.argsort(angle)
    radius = np.hypot(shear, tension)[order]
    wanted = np.arctan2(tests["shear"].to_numpy(float), tests["tension"].to_numpy(float))
    if wanted.min() < angle.min() - 1e-9 or wanted.max() > angle.max() + 1e-9:
        raise InputError("tests", float(wanted.min()), "lie outside the curve of the law")
    return np.asarray(np.interp(wanted, angle[order], radius))
