"""What every verb has in common: ``--json``, the text on a terminal, the exit status."""

import functools
import inspect
import json
import os
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from workbench.content.tree import Block
from workbench.datafiles import check_library
from workbench.errors import InputError

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


def option(text: str, default: Any = ..., metavar: str | None = None, flag: str = "") -> Any:
    """An option of a verb: what it does, its default, how its value and its flag are called.

    Without a default it must be given. The flag is that of the name unless one is given; what is
    there or not has one flag.
    """
    return typer.Option(default, *([flag] if flag else []), metavar=metavar, help=text)


ENDINGS = ("csv", "nc", "parquet", "xlsx")  # of answers as a table
Names = list[str] | None  # of an option that may be given more than once
Json = Annotated[bool, option("Print one JSON object.", flag="--json")]


class InterruptedByUserError(Exception):
    """The user ended a verb; the message says what is left behind."""


class Answer(NamedTuple):
    """What a verb found: the `content` of its JSON object, the same as `blocks`, its exit status.

    `blocks` may be a generator: it does no work where JSON is asked for.
    """

    content: Mapping[str, Any]
    blocks: Iterable[Block] = ()
    status: int = 0


@contextmanager
def at_work(words: str, seconds: float = 2.0) -> Iterator[None]:
    """Say on the error stream what is at work, once, if it takes longer than some seconds."""

    def say() -> None:
        text = f"workbench: {words} for {seconds:g} s; the first run of a model compiles it"
        print(text, file=sys.stderr, flush=True)

    timer = threading.Timer(seconds, say)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def verb(function: Callable[..., Answer]) -> Callable[..., int]:
    """A function as a verb: it gets the option ``--json``, prints its answer, returns the status.

    A function that has a parameter `as_json` itself gets it.
    """
    signature = inspect.signature(function, eval_str=True)
    wants_json = "as_json" in signature.parameters

    @functools.wraps(function)
    def answered(*arguments: Any, as_json: bool = False, **options: Any) -> int:
        if wants_json:
            options["as_json"] = as_json
        answer = function(*arguments, **options)
        if as_json:
            escaped = not str(sys.stdout.encoding).lower().startswith("utf")
            json.dump(answer.content, sys.stdout, indent=2, ensure_ascii=escaped, allow_nan=False)
            sys.stdout.write("\n")
        else:
            from workbench.content.terminal import show

            show(*answer.blocks)
        return answer.status

    if not wants_json:
        kind = inspect.Parameter.KEYWORD_ONLY
        option = inspect.Parameter("as_json", kind, default=False, annotation=Json)
        signature = signature.replace(parameters=[*signature.parameters.values(), option])
    answered.__signature__ = signature  # type: ignore[attr-defined]
    return answered


def processes(jobs: int | None) -> int:
    """How many processes a flag asks for; without it one for each core. Raises `InputError`."""
    from workbench.fields import Number

    count = os.cpu_count() or 1 if jobs is None else jobs
    return int(Number(1, 512, integer=True).check("--jobs", count))


def write_answers(target: Path, table: "pd.DataFrame", dataset: "xr.Dataset") -> None:
    """Write answers as a `table`, or as the `dataset` of netCDF, by the ending."""
    from workbench.study.store import to_netcdf_bytes, write_atomically
    from workbench.study.tables import table_bytes

    ending = target.suffix.lower()[1:]
    content = to_netcdf_bytes(dataset) if ending == "nc" else table_bytes(table, ending)
    write_atomically(target, content)


def writable(flag: str, name: str, *endings: str, inputs: Iterable[str | None] = ()) -> Path:
    """A file that a flag names for output, which ends in one of `endings` and is no input.

    Raises `InputError` where it cannot be one.
    """
    path = Path(name)
    if path.exists() and any(
        path.samefile(each) for each in inputs if each and Path(each).exists()
    ):
        raise InputError(flag, name, "is a file that is read here", "name another one")
    if path.is_dir():
        raise InputError(flag, name, "is a directory", "name a file")
    if path.exists() and not path.is_file():
        raise InputError(flag, name, "is a pipe or a device", "name a file")
    if not path.parent.is_dir():
        raise InputError(flag, name, f"there is no directory {path.parent}", "make it first")
    if not os.access(path.parent, os.W_OK):
        raise InputError(flag, name, f"the directory {path.parent} cannot be written")
    ending = path.suffix.lower()[1:]
    if ending not in endings:
        raise InputError(flag, name, f"must end in {' or '.join(endings)}")
    check_library(ending, flag)  # before the work, not after it
    return path
