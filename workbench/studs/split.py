"""Which rows calibrate and which validate: by campaign, never the same rows twice."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from workbench.errors import InputError
from workbench.fields import did_you_mean


def campaigns_of(*tables: pd.DataFrame) -> list[str]:
    """Names of the campaigns of tables, in the order in which they appear."""
    return list(dict.fromkeys(str(name) for table in tables for name in table["campaign"]))


def split_table(
    table: pd.DataFrame,
    calibrate: Sequence[str] = (),
    validate: Sequence[str] = (),
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Rows that a fit may use, and rows that it is judged by (either may be empty).

    Arguments: `table` (schema `TESTS` or `POINTS`); campaigns to `calibrate` (empty: all that do
    not validate) and to `validate`. Rows whose role is not calibrate are never fitted; those whose
    role is validate are held out with the others. Raises `InputError` where a campaign is to do
    both, or has no row that may be fitted.
    """
    for campaign in (name for name in validate if name in calibrate):
        reason = "calibrates too: a fit is not validated by its own rows"
        advice = "validate on campaigns that the fit has not seen"
        raise InputError("validate", campaign, reason, advice)
    held = table["campaign"].isin(list(validate))
    used = named = table["campaign"].isin(list(calibrate)) if calibrate else ~held
    if "role" in table.columns:
        used = named & (table["role"] == "calibrate")
        held |= table["role"] == "validate"
    if calibrate and named.any() and not used.any():
        reason = "has no row whose role is calibrate"
        advice = "rows that validate or verify are never fitted"
        raise InputError("calibrate", ", ".join(calibrate), reason, advice)
    return table[used].reset_index(drop=True), table[held].reset_index(drop=True)


def check_campaigns(wanted: Sequence[str], *tables: pd.DataFrame) -> None:
    """Refuse names of campaigns that no table has. Raises `InputError` with the nearest name."""
    known = campaigns_of(*tables)
    for name in wanted:
        if name not in known:
            allowed = "must be one of " + ", ".join(known)
            raise InputError("campaign", name, allowed, did_you_mean(name, known))


def joined(tables: Sequence[pd.DataFrame], *, unique: bool = True) -> pd.DataFrame:
    """Several tables of one schema below each other.

    `unique`: refuse a specimen that stands in two of them (`InputError`).
    """
    seen: set[tuple[str, str]] = set()
    for part in tables if unique else ():
        names = set(zip(part["campaign"], part["specimen"], strict=True))
        for campaign, specimen in sorted(seen & names):
            advice = "give the campaign another name, or leave one table out"
            raise InputError("tables", f"{campaign} {specimen}", "stands in two tables", advice)
        seen |= names
    return pd.concat(tables, ignore_index=True) if len(tables) > 1 else tables[0]
