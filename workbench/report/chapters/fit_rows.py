"""The tests behind a fit as they stand in the table: every row with its name and its use."""

from collections.abc import Iterator, Sequence
from typing import Any

import pandas as pd

from workbench.content.formatting import brief, valued
from workbench.content.tree import ABSENT, Block, Cell, Column, Definitions, Paragraph, Table
from workbench.report.chapters.fit_answer import contents_of
from workbench.report.chapters.stud_tables import KILO, MILLI, Content, Finder, value_of
from workbench.studs.schema import NO_PREDAMAGE, TESTS

_NAMES = ["campaign", "specimen"]
_UNITS = {
    **{"_kN_per_mm": "kN/mm", "_kg_per_m3": "kg/m³", "_mm": "mm", "_MPa": "MPa", "_kN": "kN"},
    "_Hz": "Hz",
}
_MOST_COLUMNS = 8  # beside the name, on paper; more stand in a further table
# how rows came about, which the file tells
_HIDDEN = ("licence", "source_locator", "reference", "fcm_basis", "fu_basis", "connector")
_PRINTED = 100
_CURVES = (  # of a load-slip fit: entry of a curve, title, factor
    ("strength", "largest load (kN)", KILO),
    ("slip_at_max", "slip there (mm)", MILLI),
    ("chord_stiffness", "stiffness, chord from 10 to 40 % (kN/mm)", 1e-6),
)


def tests(result: Content, tables: Sequence[pd.DataFrame], file: str) -> Iterator[Block]:
    """What is the same in all rows of the tables, then every row; `file` holds all columns."""
    yield Paragraph(f"All columns of all rows are in `{file}`.")
    if result["fit"] == "load-slip":
        yield from _curves(result)
        return
    rows = pd.DataFrame(pd.concat(tables))
    uses = _uses(result) if "groups" not in result else dict.fromkeys(_keys(rows), "in the table")
    if not uses:
        yield Paragraph(f"None of the {len(rows)} rows entered the answer.")
        return
    companions = {
        "residual": rows["predamage"] == NO_PREDAMAGE,
        "interaction": rows["test"] != "combined",
    }
    if result["fit"] in companions:
        own = rows["campaign"].isin([campaign for campaign, _ in uses])
        uses |= dict.fromkeys(_keys(rows[companions[result["fit"]] & own]), "companion")
    for content in contents_of(result) if result["fit"] == "residual" else ():
        rows = rows.merge(_left(content), "left", _NAMES)
    rows["use"] = [uses.get(key, "not used") for key in _keys(rows)]
    shown = (str(name) for name in rows if name not in (*_NAMES, *_HIDDEN))
    told = [name for name in shown if _told(rows[name])]
    same = [name for name in told if len(set(rows[name].astype(str))) == 1]
    if len(set(rows["campaign"])) == 1:
        same.insert(0, "campaign")
    yield Definitions(tuple((_title(name), _cell(rows[name].iloc[0]).text) for name in same))
    names = [name for name in _NAMES if name not in same][::-1]
    varying = [name for name in told if name not in same]
    parts = -(-len(varying) // _MOST_COLUMNS) or 1
    each = -(-len(varying) // parts)
    for start in range(0, max(len(varying), 1), max(each, 1)):
        part = [*names, *varying[start : start + each]]
        columns = [Column(_title(name), rows[name].dtype == float, 1.0, name) for name in part]
        records = [
            {str(name): _cell(value) for name, value in row.items()}
            for row in rows[part].to_dict("records")
        ]
        more = "" if start == 0 else ", further columns"
        caption = f"The tests as they stand in the table{more}; a dash is not reported."
        yield Table.of(f"tests-{start}", caption, columns, records, _PRINTED)


def _left(content: Content) -> pd.DataFrame:
    """Damage, what is left with the uncertainty by its reference, and the reference."""
    words = ("damage D", "left R", "u(R) by its reference", "reference", "tests behind it")
    keys = ("level", "ratio", "uncertainty", "reference", "reference_tests")
    rows = pd.DataFrame(content["tests"], columns=[*_NAMES, *keys]).astype(
        dict.fromkeys(keys, float)
    )
    quantity = content["fit"]["quantity"]
    return rows.set_axis([*_NAMES, *(f"{quantity}: {each}" for each in words)], axis="columns")


def _uses(result: Content) -> dict[tuple[str, str], str]:
    """What each row was used for, by campaign and specimen."""
    found = {}
    for content in contents_of(result):
        for key, use in (("judged", "unseen"), ("tests", "fitted")):
            for row in content.get(key) or ():
                found[row["campaign"], row["specimen"]] = use
    return found


def _keys(rows: pd.DataFrame) -> list[tuple[str, str]]:
    return list(zip(rows["campaign"], rows["specimen"], strict=True))


def _told(column: pd.Series) -> bool:
    """Whether a column says anything that an empty one would not."""
    name = str(column.name)
    default = TESTS.column(name).blank if name in TESTS.names else ""
    return bool((column.notna() & (column != default) & (column.astype(str) != "")).any())


def _title(name: str) -> str:
    for ending, unit in _UNITS.items():
        if name.endswith(ending):
            return f"{name.removesuffix(ending).replace('_', ' ')} ({unit})"
    return name.removeprefix("x_").replace("_", " ")


def _cell(value: Any) -> Cell:
    if value == "" or value is None or value != value:
        return ABSENT
    if isinstance(value, float):
        return Cell(brief(value), value)
    return Cell(str(value))


def _curves(result: Content) -> Iterator[Block]:
    """One row per curve, with the misfit of every law."""

    def name(row: Content) -> str:
        return f"{row['campaign']} {row['specimen']}"

    def misfit(law: Content) -> Finder:
        known = {name(row): row["rms"] for row in law["curves"]}  # of those that it was fitted to
        return lambda row: valued(known.get(name(row)), 3)

    laws = contents_of(result)
    columns = (
        Column("specimen", width=1.6, of=name),
        Column("points", True, 0.7, lambda row: int(row["points"])),
        *(Column(title, True, of=value_of(key, 3, factor)) for key, title, factor in _CURVES),
        *(Column(f"misfit, {law['fit']['law']}", True, of=misfit(law)) for law in laws),
    )
    caption = "The curves that were fitted; misfit of the load over its largest value."
    yield Table.of("curves", caption, columns, laws[0]["curves"], _PRINTED)
