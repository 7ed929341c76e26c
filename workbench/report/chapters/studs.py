"""Pages on studs: the template ``studs.jinja`` over the tables of fits and of stored answers.

Words and columns stand in the template; what is left to code is the shape of the tables.
"""

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from textwrap import wrap
from typing import Any

import pandas as pd

from workbench.base.tables import plain_rows
from workbench.report.page import formatting
from workbench.report.page.bibliography import cited
from workbench.report.page.markdown import Cell, Markdown, PageColumn, Table
from workbench.report.page.page import Page
from workbench.responses import Finding
from workbench.studs.fit_protocol import Tables, ranked
from workbench.studs.formulas import FORMULAS
from workbench.studs.load_slip import LAWS
from workbench.studs.relations import ANCHORED, RELATIONS

Head = Mapping[str, Any]  # what was asked of a fit
Row = dict[str, Any]
LEVELS = (0.25, 0.5, 0.75, 1.0)  # of damage
_GRADE_WIDTH = 30  # characters of a line


def records(table: pd.DataFrame) -> list[Row]:
    """The rows of a data frame; None where nothing is known, and for a column that is not there."""
    return [defaultdict(lambda: None, row) for row in plain_rows(table)]


def page(part: str, tables: Tables, **values: Any) -> Markdown:
    """The blocks that a macro of ``studs.jinja`` makes of tables.

    `values`: names that the macros know, besides the rows `t` and what makes blocks of them.
    """

    def table(
        key: str, caption: str, rows: list[Row], *columns: Any, printed: int | None = None,
        always: bool = False,
    ) -> Table | None:  # fmt: skip
        made = Table.of(key, caption, [_column(*each) for each in columns], rows, printed)
        return made if rows or always else None

    words: Page = Page(
        __file__,
        t=defaultdict(list, {key: records(table) for key, table in _shown(tables).items()}),
        of=lambda rows, name: [row for row in rows if row["of"] == name],
        part=lambda macro, /, **more: words.blocks(macro, **more),
        table=table,
        left_table=_left_table(tables, "head" in values),
        formulas=_sourced(FORMULAS),
        load_slip_laws=_sourced(LAWS),
        relations_of_damage=lambda: [(n, e.formula) for n, e in (RELATIONS | ANCHORED).items()],
        **values,
    )
    return words.blocks(part)


def _sourced(known: Mapping[str, Any]) -> Callable[[Iterable[str]], list[tuple[str, str]]]:
    """Formulas or laws by their keys: how they are called, and the formula with its sources."""
    return lambda keys: [
        (getattr(e, "label", e.name), f"{e.formula} {' '.join(map(cited, e.keys))}")
        for e in (known[key] for key in keys)
    ]


def _span(row: Row, source: str) -> Cell:
    low, high = row[f"{source}low"], row[f"{source}high"]
    if low is None and high is None:
        return Cell("not known", tone="doubt")
    ends = ("open" if end is None else formatting.number(end, 3) for end in (low, high))
    return Cell(" to ".join(ends))


_FORMS: dict[Any, Callable[[Any], Cell | str | int | None]] = {
    "": lambda value: value,
    "count": lambda value: None if value is None else int(value),
    "share": formatting.share,
    "percent": lambda value: formatting.valued(value, formatting.percent),
    "kN": lambda value: formatting.valued(value, 4, factor=1e-3),
    "mm": lambda value: formatting.valued(value, 3, factor=1e3),
    "covered": lambda value: (
        Cell("too few to tell", tone="doubt") if value is None else formatting.share(value)
    ),
}


def _column(title: str, source: Any, form: Any = "", width: float = 1.0) -> PageColumn:
    """A column of the template: the column of the rows that it shows, the form of its numbers."""

    def cell(row: Row) -> Cell | str | int | None:
        if form == "words":
            return str(source)
        if form == "span":
            return _span(row, source)
        if isinstance(form, int):
            return formatting.valued(row[source], form)
        names = [source] if isinstance(source, str) else source
        return _FORMS[form](next((row[name] for name in names if row[name] is not None), None))

    return PageColumn(title, form not in ("", "words"), width, cell)


def _shown(tables: Tables) -> Tables:
    """Tables as they are read, in units of the trade."""
    shown, fit = dict(tables), tables.get("fit", pd.DataFrame())
    if "d8" in shown and "model" in fit:
        shown["d8"] = shown["d8"].merge(fit[["of", "model"]].drop_duplicates("of"), on="of")
        shown["trends"] = shown["parameters"].query("parameter != 'bias'")
    if "factor" in shown.get("parameters", ()):
        free = shown["parameters"].query("sigma == sigma")
        scaled = free[["value", "low", "high"]].astype(float).div(free["factor"], axis=0)
        unit = free["unit"].map(lambda unit: f" ({unit})" if unit else "")
        free = free.assign(**scaled, words=free["parameter"].str.replace("_", " ") + unit)
        shown["laws"] = free.merge(fit[["of", "median_rms"]].drop_duplicates("of"), on="of")
    if "design" in shown:
        shown["design"] = shown["design"].assign(last=~shown["design"]["of"].duplicated("last"))
    if "groups" in shown:
        shear = shown["groups"]["kind"] == "shear"
        loads = shown["groups"][["mean", "characteristic"]].astype(float)
        loads = loads.mul(shear.map({True: 1e-3, False: 1.0}), axis=0)
        kind = shown["groups"]["kind"].mask(shear, "shear (kN)")
        shown["groups"] = shown["groups"].assign(**loads, kind=kind)
    return shown


def _left_table(tables: Tables, graded: bool) -> Table | None:
    """Table of the rest after damage at some levels, with the grade of the evidence.

    One grade of all stands once where the page is `graded`.
    """
    if "curve" not in tables or "left" not in tables["curve"]:
        return None
    curves, fits = tables["curve"].groupby("of", sort=False), records(tables["fit"])
    fits = [fit for fit in fits if fit["measure"]]
    top = max(float(curve["level"].max()) for _, curve in curves)
    levels = (*LEVELS, top) if top > LEVELS[-1] else LEVELS

    def left(level: float) -> Callable[[Row], Cell]:
        def cell(fit: Row) -> Cell:
            curve = curves.get_group(fit["of"])
            (at,) = records(curve.loc[[(curve["level"] - level).abs().idxmin()]])
            text = formatting.number(at["left"], 3)
            if at["extrapolated"]:
                return Cell(f"{text}\nextrapolated", at["left"], tone="bad")
            if None not in (at["left"], at["low"]):
                ends = (formatting.number(at[name], 2) for name in ("low", "high"))
                text += f"\n({' to '.join(ends)})"
            return Cell(text, at["left"])

        return cell

    def damage(fit: Row) -> str:
        kind = ", ".join(fit[key] for key in ("quantity", "predamage", "measure"))
        return f"{kind}\n{fit['stud']}" if fit["stud"] else kind

    def grade(fit: Row) -> Cell:
        lines = wrap(f"{fit['grade']}; {fit['holds']}", _GRADE_WIDTH, break_on_hyphens=False)
        return Cell("\n".join(lines), tone="" if fit["validated"] else "bad")

    columns = (
        PageColumn("what is left", width=2.4, of=damage),
        *(PageColumn(f"level {level:g}", True, 1.1, left(level)) for level in levels),
        PageColumn("relation", width=1.1, of="relation"),
        PageColumn("grade", width=2.6, of=grade),
    )
    if graded and len({(fit["grade"], fit["holds"]) for fit in fits}) == 1:
        columns = columns[:-1]
    return Table.of("design-residual", "", columns, fits)


# -- the pages of a fit --------------------------------------------------------------------------


def _warnings(tables: Tables) -> dict[str, list[str]]:
    """Every warning once, the decisive ones first, by the answers that it is of ("": of all)."""
    if "findings" not in tables:
        return {}
    owners: dict[Finding, list[str]] = {}
    for row in records(tables["findings"]):
        owners.setdefault(Finding.from_dict(row), []).append(row["of"])
    count, warnings = tables["fit"]["of"].nunique(), {"": list[str]()}
    for each in ranked(owners):
        names = dict.fromkeys(owners[each])
        warnings.setdefault("" if len(names) == count else "; ".join(names), []).append(str(each))
    return warnings


def of_fit(part: str, head: Head, tables: Tables, **values: Any) -> Markdown:
    """The pages of a fit: ``shown`` on a terminal, the sections of a ``report``."""
    inputs = ("shipped tables" if name == "shipped" else name for name in head["tables"])
    values |= {"sources": " and ".join(inputs), "warnings": _warnings(tables)}
    return page(part, tables, head=head, confidence=head["confidence"], **values)
