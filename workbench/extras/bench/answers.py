"""Answers to the bench: the table that models and people give alike, and kept submissions.

``columns.csv`` beside this file declares the columns; lengths and times may have any unit that the
name of the column says. What is submitted is read as data, and never run.
"""

import re
from collections.abc import Collection, Iterator
from functools import partial
from pathlib import Path

import pandas as pd
import tomli_w

from workbench import __version__
from workbench.base.datafiles import open_input, own_data_directory
from workbench.base.errors import InputError
from workbench.base.fields import Number, did_you_mean
from workbench.base.tables import read_cells
from workbench.extras.intake.conversion import convert, examined_from, find
from workbench.extras.intake.mapping import Mapping
from workbench.studs.schema import Row, RowFinding, TableSchema, declared, known
from workbench.study.store import own_directory, write_atomically
from workbench.study.tables import csv_bytes

PEAK, WIDTH, SECONDS = "peak_displacement_m", "half_width_m", "wall_time_s"
TABLE, ABOUT, FOLDER = "answers.csv", "submission.toml", "bench"
LARGEST = 2_000_000  # bytes
_COLUMNS = declared("answers", Path(__file__).with_name("columns.csv"))
# names begin with a letter or a digit and hold no sign that a page or a spreadsheet reads
_NAMED = re.compile(r"[^\W_][\w .,:;()+/@&=-]{0,79}")


def named(field: str, text: str) -> str:
    """A name that stands on pages and in tables. Raises `InputError` for one that cannot."""
    if not _NAMED.fullmatch(text) or not text.isprintable():
        rule = "must be 1 to 80 letters, digits, spaces and . , : ; ( ) + / @ & = - _"
        raise InputError(field, text[:80], rule, "begin with a letter or a digit")
    return text


def _contradictions(cases: Collection[str], row: Row) -> Iterator[RowFinding]:
    """Contradictions within a row whose cells are possible one by one."""
    peak, outcome = known(row, PEAK), str(row["outcome"])
    if row["case"] not in cases:
        advice = did_you_mean(str(row["case"]), cases, "`workbench bench list` names all")
        yield "case", row["case"], "is no case of the bench", advice
    if outcome == "ok" and peak is None:
        yield PEAK, "", "must be given where the outcome is ok", ""
    if outcome != "ok" and peak is not None:
        yield PEAK, peak, f"is no answer where the outcome is {outcome}", "leave it empty"
    if known(row, WIDTH) is not None and peak is None:
        yield WIDTH, row[WIDTH], "is the half-width of no peak", "leave it empty"
    if row.get("model"):
        try:
            named("model", str(row["model"]))
        except InputError as error:
            yield "model", error.value, error.allowed, error.advice


def read_answers(path: Path, cases: Collection[str], name: str = "") -> pd.DataFrame:
    """Answers in a file, in SI: a row for every case and model.

    Arguments: names of the `cases`; `name` of the series where the file holds one alone, before
    that of the model where it holds several. Raises `InputError` with the line, the column, its
    value and what is allowed.
    """
    if name:
        named("name", name)
    open_input(path, path.name, LARGEST).close()
    table = TableSchema("answers", _COLUMNS, rules=partial(_contradictions, cases))
    cells = read_cells(path, lambda text: find(text, table) is not None)
    rows = examined_from(convert(cells, table, Mapping(), {}), table).accept()
    twice = rows[rows.duplicated(["case", "model"])]
    if len(twice):
        who = ", ".join(filter(None, twice.iloc[0][["case", "model"]]))
        raise InputError(path.name, who, "stands twice", "a model answers a case once")
    if name:
        rows["model"] = [f"{name}: {model}" if model else name for model in rows["model"]]
    if not all(rows["model"]):
        raise InputError(path.name, "", "does not say whose answers these are", "add model")
    words = [column.name for column in _COLUMNS if not isinstance(column.rule, Number)]
    return rows[[column.name for column in _COLUMNS]].astype(dict.fromkeys(words, "str"))


def answer_bytes(rows: pd.DataFrame) -> bytes:
    """Answers as CSV, numbers with six digits."""
    for name in (PEAK, WIDTH, SECONDS):
        rows = rows.assign(**{name: rows[name].map("{:.6g}".format).astype(float)})
    return csv_bytes(rows)


def submit(
    path: Path, name: str, contact: str, cases: Collection[str], taken: Collection[str] = ()
) -> tuple[Path, pd.DataFrame]:
    """Keep answers under a name: the folder that holds them, and their rows.

    Raises `InputError`, with nothing written, for a file that is not in order and for a name that
    is `taken`, by a model of the workbench or before.
    """
    about = {"name": named("--name", name), "contact": named("--contact", contact)}
    if name.lower() in map(str.lower, taken):
        raise InputError("--name", name, "is a model of the workbench", "say who answers")
    rows = read_answers(path, cases, name)
    slug = re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")[:60] or "submission"
    folder = own_data_directory() / FOLDER / slug
    if folder.exists():
        advice = "give it a name of its own, or remove that folder"
        raise InputError("--name", name, f"is taken: {folder} exists", advice)
    own_directory(folder.parent, slug)
    content = {**about, "workbench": __version__}
    write_atomically(folder / TABLE, answer_bytes(rows))
    write_atomically(folder / ABOUT, tomli_w.dumps(content).encode())  # last: now it counts
    return folder, rows


def submissions(cases: Collection[str]) -> Iterator[pd.DataFrame]:
    """Answers of all submissions that are kept. Raises `InputError` for those spoilt since."""
    for file in sorted((own_data_directory() / FOLDER).glob(f"*/{ABOUT}")):
        yield read_answers(file.with_name(TABLE), cases)
