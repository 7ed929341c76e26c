"""Which rows a fit has used, so that they cannot validate it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from workbench.errors import InputError

_CONTENT = (
    "diameter_mm", "height_mm", "embedment_mm", "fcm_MPa", "fu_MPa", "shear_kN", "tension_kN",
    "slip_at_max_mm", "predamage_level",
)  # fmt: skip
_ENOUGH = 4  # equal numbers that two different tests do not share by chance


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
        for name, content in zip(_names(table), _contents(table), strict=True):
            same = name in self.names
            renamed = (
                name[0] not in self.campaigns
                and sum(np.isfinite(content)) >= _ENOUGH
                and _hashable(content) in self.contents
            )
            if same or renamed:
                how = (
                    "was used for the fit" if same else "equals a row of the fit under other names"
                )
                raise InputError(
                    "validation", " ".join(name), how,
                    "validate on tests that the fit has not seen, or leave campaigns out of it",
                )  # fmt: skip


def identity_of(table: pd.DataFrame) -> RowIdentity:
    """The identity of the rows of a table of tests."""
    contents = (_hashable(content) for content in _contents(table))
    return RowIdentity(frozenset(_names(table)), frozenset(contents))


def _names(table: pd.DataFrame) -> list[tuple[str, str]]:
    pairs = zip(table["campaign"], table["specimen"], strict=True)
    return [(str(a).strip().casefold(), str(b).strip().casefold()) for a, b in pairs]


def _contents(table: pd.DataFrame) -> list[tuple[float, ...]]:
    columns = [
        table[c].to_numpy(float) if c in table.columns else np.full(len(table), np.nan)
        for c in _CONTENT
    ]
    return [tuple(row) for row in np.column_stack(columns).tolist()]


def _hashable(content: tuple[float, ...]) -> tuple[float, ...]:
    # NaN is not equal to itself: missing numbers become a value that no cell can hold
    return tuple(value if np.isfinite(value) else -1.0 for value in content)
