"""Common ground of verbs: options, ``--json``, text, files, the exit status."""

import functools
import inspect
import json
import os
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, overload

import typer

from workbench.base.datafiles import check_library, open_input
from workbench.base.errors import InputError
from workbench.report.page.markdown import Block, paragraph

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
PICTURES = ("png", "svg", "pdf")
Names = list[str] | None  # of an option that may be given more than once


def _readable(name: str) -> str:
    """Name of a scenario file that can be opened: seen before anything heavy is imported."""
    open_input(Path(name), "scenario file").close()
    return name


ScenarioFile = Annotated[
    str, typer.Argument(metavar="SCENARIO.toml", help="Scenario file.", callback=_readable)
]
Settings = Annotated[Names, option("Override a value of the scenario.", ..., "KEY=VALUE", "--set")]
Options = Annotated[Names, option("Set an option of the model.", ..., "KEY=VALUE", "--option")]
Jobs = Annotated[int | None, option("Processes.  [default: one for each core]", flag="--jobs")]
# how tables of people are read: fields of `Reading`
SHEET = option("Sheet of a workbook.  [default: the only one with rows]", None, "NAME", "--sheet")
SEP = option("What separates columns: , ; or tab.  [default: found out]", None, "SIGN", "--sep")
DECIMAL = option(
    "Decimal sign of the table: . or ,  [default: found out]", None, "SIGN", "--decimal"
)
Json = Annotated[bool, option("Print one JSON object.", flag="--json")]
GROUPS = {  # verbs with verbs of their own
    "fit": "Fit laws of studs to a table of tests.",
    "new": "Print a template to start from.",
    "data": "Show, check and extend the data catalogue.",
}


def group_of(name: str) -> typer.Typer:
    """Application of one of GROUPS, to which its module adds the verbs."""
    return typer.Typer(help=GROUPS[name], rich_markup_mode=None, no_args_is_help=False)


class InterruptedByUserError(Exception):
    """The user ended a verb; the message says what is left behind."""


class Answer(NamedTuple):
    """Result of a verb: the `content` of its JSON object, the same as `blocks`, its exit status.

    `blocks` may be a generator: it does no work where JSON is asked for. `files` were written, by
    what they are (None: not asked for).
    """

    content: Mapping[str, Any]
    blocks: Iterable[Block] = ()
    status: int = 0
    files: Mapping[str, Path | None] = {}


@contextmanager
def at_work(words: str, seconds: float = 2.0) -> Iterator[Callable[[str], None]]:
    """Say on the error stream what is at work after some seconds, and again ever more rarely.

    Yields a function that takes how far it has come.
    """
    ended, progress = threading.Event(), [""]

    def say() -> None:
        elapsed, pause = 0.0, seconds
        while not ended.wait(pause):
            elapsed += pause
            pause = min(4.0 * pause, 60.0)
            text = f"workbench: {words} for {elapsed:g} s{progress[-1]}"
            compiles = "; the first run of a model compiles it" if _is_compiling() else ""
            print(f"{text}{compiles}", file=sys.stderr, flush=True)

    threading.Thread(target=say, daemon=True).start()
    try:
        yield lambda text: progress.append(f", {text}")
    finally:
        ended.set()


def _is_compiling() -> bool:
    """Whether some thread of this process is in the compiler of numba."""
    for frame in sys._current_frames().values():
        caller: FrameType | None = frame
        while caller is not None:
            if caller.f_globals.get("__name__") == "numba.core.compiler":
                return True
            caller = caller.f_back
    return False


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
            from workbench.report.page.terminal import show

            files = ((what, file) for what, file in answer.files.items() if file)
            show(*answer.blocks, *(paragraph(f"The {what} is in {file}.") for what, file in files))
        return answer.status

    if not wants_json:
        kind = inspect.Parameter.KEYWORD_ONLY
        option = inspect.Parameter("as_json", kind, default=False, annotation=Json)
        signature = signature.replace(parameters=[*signature.parameters.values(), option])
    answered.__signature__ = signature  # type: ignore[attr-defined]
    return answered


def processes(jobs: int | None) -> int:
    """How many processes a flag asks for; without it one for each core. Raises `InputError`."""
    from workbench.base.fields import Number

    count = os.cpu_count() or 1 if jobs is None else jobs
    return int(Number(1, 512, integer=True).check("--jobs", count))


def write_answers(target: Path, table: "pd.DataFrame", dataset: "xr.Dataset") -> None:
    """Write answers as a `table`, or as the `dataset` of netCDF, by the ending."""
    from workbench.study.store import to_netcdf_bytes, write_atomically
    from workbench.study.tables import table_bytes

    ending = target.suffix.lower()[1:]
    content = to_netcdf_bytes(dataset) if ending == "nc" else table_bytes(table, ending)
    write_atomically(target, content)


def pairs_of(flag: str, texts: list[str] | None, like: str = "beta=1.3") -> dict[str, Any]:
    """Values by name from texts of a flag that look `like` this. Raises `InputError`."""
    from workbench.scenarios import parse_value

    pairs = {}
    for text in texts or ():
        name, equals, value = text.partition("=")
        if not equals or not name.strip():
            raise InputError(flag, text, f"must look like {like}")
        pairs[name.strip()] = parse_value(value.strip())
    return pairs


@overload
def writable(flag: str, name: str, *endings: str, inputs: Iterable[str | None] = ...) -> Path: ...
@overload
def writable(
    flag: str, name: str | None, *endings: str, inputs: Iterable[str | None] = ...
) -> Path | None: ...
def writable(
    flag: str, name: str | None, *endings: str, inputs: Iterable[str | None] = ()
) -> Path | None:
    """A file that a flag names for output, which ends in one of `endings` and is no input.

    None where it names none. Raises `InputError` where it cannot be one.
    """
    if name is None:
        return None
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
