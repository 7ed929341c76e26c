"""Tables of tests in use: shipped, joined, split by campaign, not validated by their own rows."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from workbench.base.catalogue import STUD_POINTS, STUD_TESTS, Dataset, dataset, datasets
from workbench.base.errors import InputError
from workbench.base.fields import Choice, did_you_mean
from workbench.studs.quantities import Array
from workbench.studs.reading import examine
from workbench.studs.schema import POINTS, TESTS, Table

SHIPPED = {
    "stud-push-out": TESTS,
    "stud-pull-out": TESTS,
    "stud-other-connectors": TESTS,
    "stud-load-slip": POINTS,
    "stud-unload-reload": POINTS,
}


def shipped(name: str) -> pd.DataFrame:
    """A table of the stud schemas by its catalogue name, added ones too. Raises `InputError`."""
    schemas = table_schemas()
    Choice(tuple(schemas)).check("dataset", name)
    return examine(dataset(name).path, schemas[name]).accept()


def added(kind: str = STUD_TESTS) -> tuple[Dataset, ...]:
    """The tables of tests, or of another `kind`, that the user has added to the catalogue."""
    return tuple(e for e in datasets() if e.kind == kind and e.name not in SHIPPED)


def table_schemas() -> dict[str, Table]:
    """The schema of every table on studs in the catalogue, by its name."""
    kinds = {STUD_TESTS: TESTS, STUD_POINTS: POINTS}
    own = {entry.name: schema for kind, schema in kinds.items() for entry in added(kind)}
    return {**SHIPPED, **own}


def check_tables() -> list[str]:
    """Problems of the shipped stud tables, one sentence each; empty when all is well."""
    problems: list[str] = []
    for name, table in SHIPPED.items():
        try:
            wrong = examine(dataset(name).path, table).problems
            problems += [f"dataset {name}: {problem.error()}" for problem in wrong]
        except InputError as error:
            problems.append(f"dataset {name}: {error}")
    return problems


def campaigns_of(*tables: pd.DataFrame) -> list[str]:
    """Names of the campaigns of tables, in the order in which they appear."""
    return list(dict.fromkeys(str(name) for table in tables for name in table["campaign"]))


def own_rows(table: pd.DataFrame) -> pd.DataFrame:
    """Rows of campaigns that no shipped table of tests holds: the user's own."""
    tables = (shipped(name) for name, schema in SHIPPED.items() if schema is TESTS)
    return table[~table["campaign"].isin(campaigns_of(*tables))]


def split_table(
    table: pd.DataFrame, calibrate: Sequence[str] = (), validate: Sequence[str] = ()
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
    known = tuple(campaigns_of(*tables))
    for name in wanted:
        Choice(known, did_you_mean(name, known)).check("campaign", name)


def joined(tables: Sequence[pd.DataFrame], *, unique: bool = True) -> pd.DataFrame:
    """Several tables of one schema below each other.

    `unique`: refuse a specimen that stands in two of them (`InputError`).
    """
    rows = pd.concat(tables, ignore_index=True) if len(tables) > 1 else tables[0]
    names = rows["campaign"].str.cat(rows["specimen"], sep=" ")
    for name in sorted(names[rows.duplicated(["campaign", "specimen"])] if unique else ()):
        advice = "give the campaign another name, or leave one table out"
        raise InputError("tables", name, "stands in two tables", advice)
    return rows


LOOP = 0.02  # of the largest load: a larger fall with the slip going back is no noise


def recorded(points: pd.DataFrame) -> pd.DataFrame:
    """Points of single specimens that a fit may use, with the `branch` that each record tells.

    Points are in the order of the test. Unloading and reloading before the largest load is
    ``later loading``. In a curve without any label what follows the largest load is ``post-peak``
    while the slip grows, and later loading where it goes back.
    """
    kept = (points["single_specimen"] == 1.0) & (points["on_envelope"] == 1.0)
    kept &= (points["use_for_fit"] == 1.0) & (points["branch"] != "low-load reading")
    rows, branch = points[kept], points["branch"][kept].copy()
    for _, curve in rows.groupby(["campaign", "specimen"], sort=False):
        slip, load = (curve[name].to_numpy(float) for name in ("slip_mm", "load_kN"))
        place, peak = np.arange(len(load)), int(np.argmax(load))
        farthest, top = (np.maximum.accumulate(each) for each in (slip, load))
        first = np.diff(top, prepend=-np.inf) > 0.0
        last = np.maximum.accumulate(np.where(first, place, 0))  # point of the envelope before
        falls = (load < top - LOOP * load[peak]) & (slip < farthest) & (place < peak)
        later = np.isin(last, last[falls]) & ~first
        if (curve["branch"] == "").all():
            onward = np.diff(farthest, prepend=-np.inf) > 0.0
            branch[curve.index[(place > peak) & onward]] = "post-peak"
            later |= (place > peak) & ~onward
        branch[curve.index[later]] = "later loading"
    return rows.assign(branch=branch)


def first_loading(points: pd.DataFrame, *, falling: bool) -> pd.DataFrame:
    """Points that belong to the first loading of single specimens, with loads and slips in SI.

    Unloading and reloading, mean curves and doubtful points (`use_for_fit` 0) are left out, and the
    `falling` branch unless it is wanted. Raises `InputError` if nothing is left.
    """
    rows = recorded(points)
    kept = ~rows["branch"].isin(["later loading", *["post-peak"] * (not falling)])
    if not kept.any():
        raise InputError("points", len(points), "hold no point of a first loading to be fitted")
    rows = rows[kept]
    slip, load = 1e-3 * rows["slip_mm"].astype(float), 1e3 * rows["load_kN"].astype(float)
    return rows[["campaign", "specimen"]].assign(slip=slip, load=load)


def points_of(fitted: pd.DataFrame, unseen: pd.DataFrame) -> pd.DataFrame:
    """First loading of fitted and `unseen` curves (schema `POINTS`) to their ends, in SI."""
    parts = ((fitted, False), (unseen, True))
    known = [
        first_loading(each, falling=True).assign(unseen=new) for each, new in parts if len(each)
    ]
    return pd.concat(known, ignore_index=True)


def curves_of(
    points: pd.DataFrame, *, falling: bool
) -> Iterator[tuple[dict[str, str], Array, Array]]:
    """Names, slips (m) and loads (N) of every curve of a table (schema `POINTS`)."""
    used = first_loading(points, falling=falling)
    for (campaign, specimen), curve in used.groupby(["campaign", "specimen"], sort=False):
        names = {"campaign": str(campaign), "specimen": str(specimen)}
        yield names, curve["slip"].to_numpy(float), curve["load"].to_numpy(float)


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


def same_contents(table: pd.DataFrame) -> list[tuple[str, str]]:
    """Names of rows that hold the same load and other numbers, enough of them to be one test."""
    names = table[["campaign", "specimen"]].to_numpy(str)
    return copies(
        (" ".join(name), content)
        for (_, content), name in zip(_rows(table), names, strict=True)
        if sum(value != _MISSING for value in content) >= _ENOUGH
    )


def copies(named: Iterable[tuple[str, tuple[float, ...]]]) -> list[tuple[str, str]]:
    """Names of equal contents, each with the first name of its content."""
    seen: dict[tuple[float, ...], str] = {}
    pairs = ((seen.setdefault(content, name), name) for name, content in named)
    return [(first, name) for first, name in pairs if first != name]


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
