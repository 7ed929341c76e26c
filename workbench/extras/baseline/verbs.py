"""`workbench baseline`: whether all models say what they said, and why they say it."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

import typer

from workbench.base.errors import InputError
from workbench.cli.output import Answer, Jobs, at_work, option, processes, verb
from workbench.report.page.markdown import bullets, paragraph

app = typer.Typer(
    help="Numbers of all models, and why they change.",
    rich_markup_mode=None,
    no_args_is_help=False,
)
Kept = Annotated[
    str | None, option("Table, its plan beside it.  [default: shipped]", ..., "FILE.csv", "--table")
]


@app.command("check")
@verb
def check(
    release: bool = option("Stored tables too: none of other versions.", False, flag="--release"),
    table: Kept = None,
    jobs: Jobs = None,
) -> Answer:
    """Compare what all models answer with the numbers that are kept.

    Exit status 1 where one differs by more than steps leave open, 0.1 %, or ends otherwise.
    """
    return _compared(table, jobs, "", release)


@app.command("mint")
@verb
def mint(
    reason: str = option("Why numbers change, in a line."), table: Kept = None, jobs: Jobs = None
) -> Answer:
    """Take over what differs now, with the date and a reason.

    Exit status 1, and nothing written, where numbers move under the version that they had.
    """
    if not reason.strip() or not reason.isprintable():
        raise InputError("--reason", reason, "must say in a line why numbers change")
    return _compared(table, jobs, f"{datetime.now(UTC):%Y-%m-%d} {reason.strip()}", False)


def _compared(table: str | None, jobs: int | None, reason: str, release: bool) -> Answer:
    """Differences between now and a table, which takes them over if there is a reason."""
    from workbench.base.datafiles import data_directory
    from workbench.extras.baseline import baseline
    from workbench.study.store import write_atomically

    kept = data_directory() / "baselines.csv" if table is None else Path(table)
    reasons, before = baseline.read_baselines(kept)
    workers = processes(jobs)
    with at_work("the baselines at work"):
        now = baseline.numbers_now(kept.with_suffix(".toml"), workers)
    changes = list(baseline.changes(before, now))
    texts = list(dict.fromkeys(text for text, *_ in changes))
    stale = baseline.of_other_versions() if release else []
    bad = stale or (not all(sound for *_, sound in changes) if reason else texts)
    if reason and changes and not bad:
        write_atomically(kept, baseline.minted([*reasons, reason], before, now))
    end = f"written to {kept}" if reason and not bad else "nothing is written"
    end = f"{len(now)} numbers, {len(changes)} differ; {end}."
    blocks = (*([bullets([*texts, *stale])] * bool(texts or stale)), paragraph(end))
    content = {"numbers": len(now), "differences": texts, "of_other_versions": stale}
    return Answer(content, blocks, int(bool(bad)))
