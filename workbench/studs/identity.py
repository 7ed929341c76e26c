"""Which rows a fit has used, so that they cannot validate it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from workbench.errors import InputError

_CONTENT = [
    *("diameter_mm", "height_mm", "embedment_mm", "fcm_MPa", "fu_MPa", "shear_kN", "tension_kN"),
    *("slip_at_max_mm", "predamage_level"),
]
_ENOUGH = 4  # equal numbers that two different tests do not share by chance
_MISSING = -1.0  # stands for a number that is not reported: no cell can hold it
Row = tuple[tuple[str, str], tuple[float, ...]]


@dataclass(frozen=True)
class RowIdentity:
    """Names (campaign, specimen) of rows, and the numbers that give a renamed row away."""

    names: frozenset[tuple[str, str]]
    contents: frozenset[tuple[float, ...]]

    @property
    def campaigns(self) -> frozenset[str]:
        """Campaigns of the rows."""
        return frozenset(campaign for campaign, _ in self.names)

    def refuse_overlap(self, table: pd.DataFrame) -> None:
        """Refuse a table that holds one of these rows, also under another name.

        Raises `InputError`: a fit is not validated by the rows it was made of.
        """
        for name, content in _rows(table):
            telling = sum(value != _MISSING for value in content) >= _ENOUGH
            renamed = name[0] not in self.campaigns and telling and content in self.contents
            if name in self.names or renamed:
                how = "equals a row of the fit under other names"
                how = "was used for the fit" if name in self.names else how
                advice = "validate on tests that the fit has not seen, or leave campaigns out of it"
                raise InputError("validation", " ".join(name), how, advice)


def identity_of(table: pd.DataFrame) -> RowIdentity:
    """The identity of the rows of a table of tests."""
    rows = _rows(table)
    return RowIdentity(frozenset(n for n, _ in rows), frozenset(content for _, content in rows))


def _rows(table: pd.DataFrame) -> list[Row]:
    pairs = zip(table["campaign"], table["specimen"], strict=True)
    names = [(str(a).strip().casefold(), str(b).strip().casefold()) for a, b in pairs]
    numbers = table.reindex(columns=_CONTENT).to_numpy(float)
    contents = np.where(np.isfinite(numbers), numbers, _MISSING).tolist()
    return [(name, tuple(content)) for name, content in zip(names, contents, strict=True)]
