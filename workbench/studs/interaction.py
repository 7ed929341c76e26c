"""Tension with shear: laws of what is left of one under the other, and tests of both.

Tension and shear are over the resistances of equal studs under one of them alone.
"""

from collections.abc import Callable

import numpy as np
import pandas as pd

from workbench.studs.quantities import Array
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
    """Rows (campaign, specimen, tension, shear) of the combined tests of a table; may be empty.

    Both are over the mean resistance of the undamaged pull-outs and push-outs of the same campaign
    and diameter; a combined test without both companions is left out.
    """
    usable = table[(table["use_for_fit"] == 1.0) & (table["predamage"] == NO_PREDAMAGE)]
    both = usable[usable["test"] == "combined"]
    equal = ["campaign", "diameter_mm"]
    result = both[["campaign", "specimen"]].copy()
    for kind, name in (("pull-out", "tension"), ("push-out", "shear")):
        alone = usable[usable["test"] == kind].groupby(equal)[f"{name}_kN"].mean()
        own = alone.reindex(pd.MultiIndex.from_frame(both[equal])).to_numpy(float)
        result[name] = both[f"{name}_kN"].to_numpy(float) / own
    known = np.isfinite(result[["tension", "shear"]].to_numpy(float)).all(axis=1)
    complete: pd.DataFrame = result[known].reset_index(drop=True)
    return complete
