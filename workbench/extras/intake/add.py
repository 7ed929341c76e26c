"""Adding a table to the user's own data: everything is checked before anything is written."""

import hashlib
import re
import tomllib
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd
import tomli_w

from workbench import __version__
from workbench.base.catalogue import ANSWERS, CATALOGUE, SYNTHETIC, Dataset, datasets, datasets_in
from workbench.base.datafiles import data_directory, own_data_directory
from workbench.base.errors import InputError
from workbench.base.tables import FOUND_OUT, Reading, read_cells
from workbench.extras.intake.answers import check_new, held
from workbench.extras.intake.conversion import convert, examined_from
from workbench.extras.intake.kinds import KINDS, Kind, kind_of, names_column, rows_of
from workbench.extras.intake.mapping import Mapping, check_stated, read_mapping
from workbench.scenarios import Scenario, to_toml
from workbench.study.store import locked, write_atomically
from workbench.study.tables import for_spreadsheets

_NAME = re.compile(r"[a-z0-9][a-z0-9-]{0,59}")
_MARK = "SYNTHETIC"
_PROVENANCE = ("licence", "year", "role")
_SHOWN = 8  # doubts in a message
_PATIENCE = 60.0  # s to wait for others who add a table


@dataclass(frozen=True)
class Added:
    """Result of an addition: `entry` of the table in the catalogue and how many `rows` it has.

    `notes`, how columns were read; `doubts`, what was accepted all the same; `already`, whether
    the same table was there, so that nothing was written; `read`, whether the catalogue reads the
    folder.
    """

    entry: Dataset
    rows: int
    notes: tuple[str, ...]
    doubts: tuple[str, ...]
    already: bool
    read: bool

    @property
    def then(self) -> str:
        """Advice on the next step with the table."""
        kind = KINDS[self.entry.kind]
        fitted = kind.fit.format(path=self.entry.path) if self.entry.role == "calibrate" else ""
        return ", or ".join(part for part in (kind.then, fitted) if part)


def add_table(
    path: Path,
    *,
    mapping: Path | Mapping | None = None,
    scenario: Scenario | None = None,
    kind: str | None = None,
    into: Path | None = None,
    name: str | None = None,
    despite_doubts: bool = False,
    how: Reading = FOUND_OUT,
) -> Added:
    """Add a table of tests to the data of the user.

    Arguments: `path` of the table and of its `mapping` file, or what that says; the `scenario` that
    the answer of another program is to; `kind`, one of `KINDS`; `into`, the folder (default: the
    one that the catalogue reads); `name` in the catalogue; `despite_doubts`, take what looks
    absurd; `how` to read the table. Raises `InputError`, with nothing written.
    """
    statements = read_mapping(mapping) if isinstance(mapping, Path) else mapping or Mapping()
    folder = own_data_directory() if into is None else into
    if folder.resolve().is_relative_to(data_directory().resolve()):
        text = "holds the data that come with the workbench, which are read only"
        raise InputError("--into", str(folder), text, "name another folder")
    mapped = {*(statements.columns or {}), *statements.ignore}
    cells = read_cells(path, lambda name: name in mapped or names_column(name), how)
    fixed = (*(statements.columns or {}).values(), *(statements.constants or {}))
    which = kind_of([*cells.header, *fixed], kind or statements.kind)
    if which == ANSWERS and scenario is None:
        raise InputError(path.name, None, "answers no scenario", "see workbench data add-answer")
    converted = convert(cells, KINDS[which].table, statements, _common(statements, KINDS[which]))
    found = examined_from(converted, KINDS[which].table)
    rows, notes = found.accept(), (*converted.notes, *found.notes[len(cells.notes) :])
    entry = _entry(path, which, statements, rows, notes)
    entry = replace(entry, name=_name(name or statements.name, path), folder=str(folder))
    entry = replace(entry, file=f"{entry.name}.csv")
    if scenario is not None:
        entry = replace(entry, asked=tomllib.loads(to_toml(scenario)))
        held(entry, rows)
    if entry.role == SYNTHETIC:  # every output shows the name of the campaign
        campaigns = rows["campaign"].str.removeprefix(_MARK).str.strip()
        rows = rows.assign(campaign=_MARK + " " + campaigns)
    shown = for_spreadsheets(rows[_filled(rows)])
    content = shown.to_csv(index=False, float_format="%.12g", lineterminator="\n").encode()
    judge = partial(_judged, entry, rows, content, path.name, despite_doubts)
    already, doubts = judge()  # refused before a folder is made
    kept: list[str] = []
    if already is None:
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with locked(folder / ".lock", _PATIENCE):
                already, doubts = judge()  # another may have added since
                if already is None:
                    entry, kept = _write(entry, doubts, content)
        except OSError as error:
            text = f"cannot be written: {error.strerror}"
            raise InputError("--into", str(folder), text) from error
    read = folder.resolve() == own_data_directory().resolve()
    if already is not None:
        return Added(already, len(rows), (), (), True, read)
    return Added(entry, len(rows), (*notes, *kept), doubts, False, read)


def _common(statements: Mapping, kind: Kind) -> dict[str, str]:
    """Statements of the mapping on all rows, as cells of the columns of the schema."""
    given = {kind.source: statements.source, "licence": statements.licence, "role": statements.role}
    if statements.role == SYNTHETIC:
        given["origin"] = SYNTHETIC
        if "role" in kind.table.names and SYNTHETIC not in kind.table.words("role"):
            given["role"] = "verify"  # neither fitted nor validated by
    given["year"] = None if statements.year is None else str(statements.year)
    known = set(kind.table.names)
    return {name: cell for name, cell in given.items() if cell is not None and name in known}


def _entry(
    path: Path, which: str, statements: Mapping, rows: pd.DataFrame, notes: Sequence[str]
) -> Dataset:
    """The entry of the catalogue, still without a name. Raises `InputError`."""
    kind = KINDS[which]
    stated = {"source": kind.source} | {name: name for name in _PROVENANCE}
    fields: dict[str, Any] = {name: getattr(statements, name) for name in stated}
    for name, column in stated.items():
        if fields[name] is None and which != ANSWERS:
            values = list(dict.fromkeys(rows[column])) if column in rows else []
            values = [value for value in values if value not in ("", None)]
            if not values or (rows[column] == "").any():
                advice = f"give it in the column {column} or in a mapping file"
                raise InputError(f"{path.name}, {name}", None, "is missing", advice)
            if name == "role" and len(values) > 1:
                raise InputError(f"{path.name}, role", ", ".join(values), "must be one for a table")
            whole = (f"{value:g}" if isinstance(value, float) else str(value) for value in values)
            fields[name] = "; ".join(whole)
    for column in {kind.source, "licence"} & set(rows):
        for line, text in enumerate(rows[column], start=1):
            check_stated(f"{path.name}, row {line}, column {column}", text)
    campaigns = ", ".join(dict.fromkeys(rows.get("campaign", ())))
    words = " ".join(which.replace("-", " ").split())
    meanings = {column.name: column.meaning for column in kind.table.columns}
    digest = hashlib.sha256(path.read_bytes()).hexdigest()[:16]
    made = f"{path.name} (sha256 {digest}) by workbench data add, {__version__}"
    return Dataset(
        name="unnamed",
        title=statements.title or f"{words.capitalize()} of {campaigns}"[:2000],
        file="unnamed.csv",
        source=fields["source"][:2000],
        licence=fields["licence"][:2000],
        role=fields["role"],
        uncertainty=statements.uncertainty or kind.uncertainty,
        columns={n: meanings.get(n, "column of the source") for n in _filled(rows)},
        units="as the column names say; empty cells mean not reported",
        key=statements.key or "",
        kind=which,
        year=str(fields["year"] or ""),
        made="; ".join([made, *notes])[:2000],
    )


def _name(given: str | None, path: Path) -> str:
    """The `given` name in the catalogue, or that of the file. Raises `InputError`."""
    name = given or re.sub(r"[^a-z0-9]+", "-", path.stem.casefold()).strip("-")[:60]
    if not _NAME.fullmatch(name):
        text = "must be lower-case letters, digits and hyphens"
        raise InputError("--name", name, text, "it names the table in the catalogue")
    return name


def _filled(rows: pd.DataFrame) -> list[str]:
    return [str(name) for name in rows if not (rows[name].isna() | rows[name].eq("")).all()]


def _judged(
    entry: Dataset, rows: pd.DataFrame, content: bytes, name: str, despite_doubts: bool
) -> tuple[Dataset | None, tuple[str, ...]]:
    """The table of the catalogue that holds the same rows, if there is one, else the doubts.

    Raises `InputError` if another table has the name, and for doubts that are not accepted.
    """
    there, kind = Path(entry.folder) / CATALOGUE, KINDS[entry.kind]
    beside = (*datasets(), *(datasets_in(there) if there.is_file() else ()))
    others = {other.name: other for other in beside}
    alike = [other for other in others.values() if other.kind == entry.kind]
    for other in alike:
        same = other.path.is_file() and other.path.read_bytes() == content
        if same and other.asked == entry.asked and (not entry.asked or other.title == entry.title):
            return other, ()
        check_new(entry, other)
    if entry.name in others:
        text = "is the name of another table of the catalogue"
        advice = "choose one with --name, or remove the old entry and its file"
        raise InputError("--name", entry.name, text, advice)
    doubts = [finding.text for finding in kind.suspicions(rows)]
    for other in alike if entry.asked is None else ():
        old, mark = rows_of(other), f"{other.name}: "
        both = pd.concat([old.assign(campaign=mark + old["campaign"]), rows])
        doubts += (
            f"{second} holds the same numbers as {first}"
            for first, second in kind.copies(both)
            if first.startswith(mark) and not second.startswith(mark)
        )
    if doubts and not despite_doubts:
        more = f"; and {len(doubts) - _SHOWN} more" if len(doubts) > _SHOWN else ""
        advice = "correct the table, or take it as it is with --despite-doubts"
        raise InputError(name, None, f"looks wrong: {'; '.join(doubts[:_SHOWN])}{more}", advice)
    return None, tuple(doubts)


def _write(entry: Dataset, doubts: Sequence[str], content: bytes) -> tuple[Dataset, list[str]]:
    """The table first, then the catalogue that names it: a table without a name is never read.

    A file that stands there already is the user's: the table goes beside it. Gives the entry as
    it is written, and the files that were kept.
    """
    if doubts:
        accepted = "; ".join(doubts)[:800]
        entry = replace(entry, uncertainty=f"{entry.uncertainty}; taken despite: {accepted}")
    kept = []
    while True:
        with suppress(FileExistsError):
            entry.path.touch(exist_ok=False)  # from here on no one else takes the name
            break
        kept.append(f"{entry.path} was there and is left as it is")
        entry = replace(entry, file=f"{entry.name}-{len(kept) + 1}.csv")
    fields, path = asdict(entry), Path(entry.folder) / CATALOGUE
    given = {name: fields[name] for name in fields if fields[name] and name != "folder"}
    block = tomli_w.dumps({"dataset": [given]})
    try:
        before = path.read_text(encoding="utf-8") if path.is_file() else ""
        write_atomically(entry.path, content)
        write_atomically(path, f"{before.rstrip()}\n\n{block}".lstrip().encode())
    except BaseException:
        entry.path.unlink(missing_ok=True)
        raise
    return entry, kept
