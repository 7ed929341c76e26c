"""The report of a fit to tests on studs: the answer and its grade, what it rests on, the tests.

Made of the tables that `workbench fit --json` prints and of the rows of the input; nothing is
fitted here. One self-contained HTML file or PDF, and the numbers of every figure as CSV beside it.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd

from workbench.base.errors import InputError
from workbench.report.chapters.studs import Head, of_fit
from workbench.report.drawing.sheet import Drawing, drawn
from workbench.report.figures import plot_of, stud_figures
from workbench.report.gallery import Plate, to_csv
from workbench.report.page.documents import Document, render_html, render_pdf
from workbench.report.page.formatting import brief, count
from workbench.report.page.markdown import (
    ABSENT,
    Cell,
    PageColumn,
    Picture,
    Table,
    definitions,
    literal,
    paragraph,
)
from workbench.responses.build import provenance
from workbench.studs.fit_protocol import Tables
from workbench.studs.schema import NO_PREDAMAGE, TESTS
from workbench.study.definition import Figure
from workbench.study.store import own_directory, write_atomically

_RENDERERS = {"html": lambda content: render_html(content).encode(), "pdf": render_pdf}
_TITLES = {
    "stud-strength": "Shear strength of headed studs",
    "load-slip": "Load and slip of headed studs",
    "residual": "What is left of headed studs after damage",
    "interaction": "Tension and shear of headed studs together",
    "few-tests": "Characteristic values of few tests on headed studs",
}
_FIGURES = {  # by kind: key, title, caption
    "stud-scatter": (
        *("prediction", "Prediction"),
        "Measured over predicted strength; below the line a prediction is unsafe.",
    ),
    "stud-residuals": (
        *("residuals", "Residuals"),
        "What the formula of least scatter misses: a trend in a variable is one that it lacks.",
    ),
    "stud-curves": (
        *("curves", "Curves"),
        "Load over its largest value: the laws with their bands over the tests.",
    ),
    "stud-guideline": (
        *("left", "What is left"),
        "Share that is left; the band ends where the tested damage ends, beyond it the line is an "
        "extrapolation.",
    ),
    "stud-interaction": (
        *("interaction", "Law"),
        "Tension and shear over the resistances under one of them alone.",
    ),
}
_SOFTWARE = ("workbench", "commit", "requirements_lock", "python", "numpy", "scipy")
_NAMES = ["campaign", "specimen"]
_MOST_COLUMNS = 8  # beside the name, on paper; more stand in a further table
_PRINTED = 100
# how rows came about, which the file tells
_HIDDEN = ("licence", "source_locator", "reference", "fcm_basis", "fu_basis", "connector")
_LEFT = {  # of tests after pre-damage: columns of the fit, as they are read
    "level": "damage D",
    "ratio": "left R",
    "uncertainty": "u(R) by its reference",
    "reference": "reference",
    "reference_tests": "tests behind it",
}
Drawn = tuple[str, str, str, Drawing]  # key, title, caption


def write(
    head: Head, tables: Tables, rows: Sequence[pd.DataFrame], targets: Mapping[str, Path]
) -> dict[str, Path]:
    """Write reports of a fit; returns what was written, by words.

    Arguments: `head`, what was asked, and `tables` of the answer; `rows`, the fitted and the unseen
    rows of the input (schema `TESTS` or `POINTS`); `targets`, paths by format, html or pdf. Equal
    input gives equal bytes: no time, no path. Raises `InputError` for what cannot be written.
    """
    head = {**head, "tables": [Path(name).name for name in head["tables"]]}
    figures = list(_figures(tables))
    written: dict[str, Path] = {}
    numbers = {key: drawing.data for key, _, _, drawing in figures if drawing.canvas is not None}
    numbers["tests"] = pd.concat(rows).dropna(axis="columns", how="all")
    for kind, target in targets.items():
        try:
            folder = own_directory(target.parent, f"{target.stem}-curves")
            for key, data in numbers.items():
                write_atomically(folder / f"{key}.csv", to_csv(data).encode())
            document = _document(head, tables, rows, figures, folder.name)
            write_atomically(target, _RENDERERS[kind](document))
        except OSError as error:
            reason = error.strerror or "unknown reason"
            raise InputError("--report", str(target), f"cannot be written: {reason}") from error
        written |= {f"report ({kind})": target, f"its curves ({kind})": folder}
    return written


def _document(
    head: Head,
    tables: Tables,
    rows: Sequence[pd.DataFrame],
    figures: Sequence[Drawn],
    folder: str,
) -> Document:
    record = provenance()
    options = {k: v if isinstance(v, list) else [v] for k, v in head["options"].items()}
    pictures = [
        (key, title, _picture(key, title, caption, drawing, folder))
        for key, title, caption, drawing in figures
    ]
    text = of_fit(
        "report",
        head,
        tables,
        size=_size(head, tables),
        options=", ".join(f"{name} = {', '.join(map(str, v))}" for name, v in options.items()),
        figures=pictures,
        tests=literal(list(_tests(head, tables, pd.concat(rows), folder))),
        software=[(n.replace("_", " "), f"`{record[n]}`") for n in _SOFTWARE if n in record],
    )
    made = ", ".join(f"{name} {record[name]}" for name in _SOFTWARE[:2] if name in record)
    facts = (_size(head, tables), f"table: {' and '.join(head['tables'])}", made)
    held = {key: picture for key, _, picture in pictures}
    return Document(_TITLES[head["fit"]], "Evaluation of tests", facts, text, held)


def _picture(key: str, title: str, caption: str, drawing: Drawing, folder: str) -> Picture:
    picture = Plate(Figure(key, "", title, caption), drawing).picture()
    return replace(picture, files=tuple(f"{folder}/{Path(name).name}" for name in picture.files))


def _figures(tables: Tables) -> Iterator[Drawn]:
    """The figures of the fits, and how every test moves them."""
    names = list(dict.fromkeys(tables["fit"]["of"])) if "fit" in tables else []
    best = tables["ranking"]["of"].iloc[0] if "ranking" in tables else ""
    kinds = dict.fromkeys(tables["figures"]["kind"]) if names else ()
    for kind in kinds:
        shown = [best] if kind == "stud-residuals" else names
        yield *_FIGURES[kind], drawn(plot_of(kind), {n: _of(tables, n) for n in shown})
    moved = tables.get("influence", pd.DataFrame())
    if len(moved):
        several = moved.groupby("of")["answer"].transform("nunique") > 1
        panel = moved["of"].where(~several, moved["of"] + ", " + moved["answer"])
        panels = {str(name): rows for name, rows in moved.groupby(panel, sort=False)}
        caption = "Change of the answer when one test is left out, all else kept."
        drawing = drawn(stud_figures.influence, panels)
        yield "influence", "Influence of single tests", caption, drawing


def _of(tables: Tables, name: str) -> Tables:
    """The tables of one of several answers."""
    return {
        key: table[table["of"] == name].drop(columns="of") if "of" in table else table
        for key, table in tables.items()
        if "of" not in table or (table["of"] == name).any()
    }


def _size(head: Head, tables: Tables) -> str:
    """How much was fitted."""
    if "fit" not in tables:
        return count(len(tables["groups"]), "group") + " of nominally equal tests"
    what = "curves" if head["fit"] == "load-slip" else "tests"
    most = tables["fit"].iloc[int(tables["fit"][what].argmax())]
    after = " after pre-damage" if head["fit"] == "residual" else ""
    if not most["campaigns"]:
        return f"no {what}{after}"
    campaigns = count(len(most["campaigns"].split(", ")), "campaign")
    return f"{count(int(most[what]), what[:-1])}{after} of {campaigns}"


# -- the tests as they stand in the table ---------------------------------------------------------


def _tests(head: Head, tables: Tables, rows: pd.DataFrame, folder: str) -> Iterator[object]:
    """Tests in words where all rows of the input are the same, then every row with its use."""
    yield paragraph(f"All columns of all rows are in `{folder}/tests.csv`.")
    if head["fit"] == "load-slip":
        yield _curves(tables)
        return
    rows = rows.assign(use="in the table" if head["fit"] == "few-tests" else "not used")
    for key, use in (("tests", "fitted"), ("judged", "unseen")):
        if key in tables:
            used = pd.MultiIndex.from_frame(tables[key][_NAMES])
            rows.loc[pd.MultiIndex.from_frame(rows[_NAMES]).isin(used), "use"] = use
    if (rows["use"] == "not used").all():
        yield paragraph(f"None of the {len(rows)} rows entered the answer.")
        return
    if head["fit"] in ("residual", "interaction"):
        alone = rows["predamage"] == NO_PREDAMAGE
        alone = rows["test"] != "combined" if head["fit"] == "interaction" else alone
        campaigns = set(rows.loc[rows["use"] != "not used", "campaign"])
        rows.loc[alone & rows["campaign"].isin(campaigns), "use"] = "companion"
    if head["fit"] == "residual":
        for name, left in tables["tests"].groupby("of", sort=False):
            titles = {key: f"{name}: {words}" for key, words in _LEFT.items()}
            rows = rows.merge(left[[*_NAMES, *_LEFT]].rename(columns=titles), "left", _NAMES)
    defaults = {name: TESTS.column(name).blank for name in TESTS.names}
    known = [
        str(name)
        for name, column in rows.items()
        if name not in (*_NAMES, *_HIDDEN)
        and (column.notna() & (column != defaults.get(str(name), "")) & (column != "")).any()
    ]
    same = [name for name in known if len(set(rows[name].astype(str))) == 1]
    if len(set(rows["campaign"])) == 1:
        same.insert(0, "campaign")
    yield definitions((_title(name), _cell(rows[name].iloc[0]).text) for name in same)
    names = [name for name in reversed(_NAMES) if name not in same]
    varying = [name for name in known if name not in same]
    parts = -(-len(varying) // _MOST_COLUMNS) or 1
    each = max(-(-len(varying) // parts), 1)
    for start in range(0, max(len(varying), 1), each):
        part = [*names, *varying[start : start + each]]
        columns = [_column(name, rows[name].dtype == float) for name in part]
        more = "" if start == 0 else ", further columns"
        caption = f"The tests as they stand in the table{more}; a dash is not reported."
        yield Table.of(f"tests-{start}", caption, columns, rows, _PRINTED)


def _title(name: str) -> str:
    """The name of a column with its unit in brackets."""
    if name in TESTS.names:
        column = TESTS.column(name)
        unit = column.unit.replace("kg/m3", "kg/m³")
        return column.base.replace("_", " ") + (f" ({unit})" if unit else "")
    return name.removeprefix("x_").replace("_", " ")


def _column(name: str, numeric: bool) -> PageColumn:
    return PageColumn(_title(name), numeric, of=lambda row: _cell(row[name]))


def _cell(value: Any) -> Cell:
    if value == "" or pd.isna(value):
        return ABSENT
    return Cell(brief(value), value) if isinstance(value, float) else Cell(str(value))


def _curves(tables: Tables) -> Table:
    """One row per curve, with the misfit of every law."""
    curves = tables["curves"].assign(specimen=tables["curves"][_NAMES].agg(" ".join, axis=1))
    misfits = curves.pivot_table("rms", "specimen", "of", sort=False)
    values = {
        "points": curves["points"].astype(float),
        "largest load (kN)": 1e-3 * curves["strength"],
        "slip there (mm)": 1e3 * curves["slip_at_max"],
        "stiffness, chord from 10 to 40 % (kN/mm)": 1e-6 * curves["chord_stiffness"],
    }
    rows = curves[["specimen"]].assign(**values).drop_duplicates("specimen")
    rows = rows.merge(misfits.add_prefix("misfit, ").reset_index(), on="specimen")
    columns = [_column(str(name), name != "specimen") for name in rows.columns]
    caption = "The curves that were fitted; misfit of the load over its largest value."
    return Table.of("curves", caption, columns, rows, _PRINTED)
