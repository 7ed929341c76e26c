"""The command line: ``workbench VERB ...``. Nothing heavy is imported before a verb runs."""

import codecs
import gc
import os
import re
import signal
import sys
import unicodedata
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from importlib import import_module
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Annotated, Any

from workbench.base.errors import InputError, WorkbenchError, message_of, shown
from workbench.base.offered import offered

_SUMMARY = """How far can each reduced model of a steel structure under impact be trusted?

Exit status: 0 done, 1 a gate failed or a cell did not converge, 2 bad input.
"""
_PLAIN = {
    **{"±": "+/-", "−": "-", "–": "-", "—": "-", "─": "-", "×": "x", "·": ".", "→": "->"},
    **{"≤": "<=", "≥": ">=", "√": "sqrt ", "∞": "inf", "½": "1/2", "µ": "u", "ß": "ss"},
}
_RAISED = re.compile("[⁰¹²³⁴-⁹⁻]+")  # exponents
DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and exit: 0 done, 1 a gate or a cell failed, 2 bad input.

    Bad input is one line on the error stream, without a traceback; an interrupt ends with 130.
    """
    gc.set_threshold(500_000)  # imports make many objects that stay: to go through them takes long
    _prepare()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # else deaf beside a shell
    status = run(sys.argv[1:] if arguments is None else arguments)
    gc.freeze()  # else the end of the process goes through all of them, several times
    sys.exit(status)


def run(arguments: Sequence[str]) -> int:
    """Run the command line and return the exit status."""
    from workbench.cli.output import InterruptedByUserError

    try:
        application = _application(*arguments[:1])
        status = application(list(arguments), prog_name="workbench", standalone_mode=False)
        sys.stdout.flush()
        if status == INTERRUPTED:  # what the argument parser makes of Ctrl-C
            raise InterruptedByUserError("interrupted")
        return status if isinstance(status, int) else DONE
    except InputError as error:
        return _say(str(error), BAD_INPUT)
    except WorkbenchError as error:
        return _say(str(error), FAILED)
    except (InterruptedByUserError, KeyboardInterrupt) as error:
        return _say(str(error) or "interrupted", INTERRUPTED)
    except BrokenPipeError:
        _drop_output()  # its reader has gone, as in `workbench models | head`: no fault of ours
        return FAILED
    except OSError as error:
        what = "standard output" if error.filename is None else shown(str(error.filename))
        if error.filename is None:
            _drop_output()
        reason = error.strerror or message_of(error)
        return _say(f"{what}: {reason}; make room there or name another place", BAD_INPUT)
    except Exception as error:
        # errors of the argument parser; its classes have no common public base in all versions
        if not hasattr(error, "format_message"):
            raise
        return _say(error.format_message(), BAD_INPUT)


_VERBS: dict[str, tuple[str, ...]] = {  # by module; one with verbs of its own is an `app`
    "models": ("models", "advise"),
    "simulate": ("simulate", "limit", "sweep"),
    "studies": ("run", "status", "report", "validate"),
    "fit": (),
    "new": (),
    "data": (),
    "doctor": ("doctor",),
}


def _application(verb: str = "") -> Callable[..., Any]:
    """All verbs as one function of the arguments; only that of a `verb` that there is."""
    import typer

    from workbench import __version__
    from workbench.cli.output import GROUPS, group_of

    app = typer.Typer(
        add_completion=False,
        help=_SUMMARY,
        rich_markup_mode=None,  # rich takes longer to import than the rest of --help
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    )

    @app.callback(invoke_without_command=True)
    def root(
        context: typer.Context,
        version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False,
    ) -> None:
        if version:
            typer.echo(__version__)
        elif context.invoked_subcommand is None:
            typer.echo(context.get_help())

    points = offered("verbs")
    home = [module for module, verbs in _VERBS.items() if verb in (verbs or (module,))]
    if home or verb in {point.name for point in points}:
        points = [point for point in points if point.name.partition(".")[0] == verb]
    else:
        home = list(_VERBS)
    groups = {}
    if verb in ("-h", "--help"):  # names groups, not what is in them
        groups = {name: group_of(name) for name in GROUPS}
        home = [module for module in home if module not in groups]
        points = [point for point in points if "." not in point.name]
    for module in home:
        room = import_module(f"workbench.cli.{module}")
        for name in _VERBS[module]:
            app.command(name)(getattr(room, name))
        if not _VERBS[module]:
            groups[module] = room.app
    for point in points:
        _add(point, app, groups)
    for name, group in groups.items():
        app.add_typer(group, name=name)
    command: Callable[..., Any] = typer.main.get_command(app)
    return command


def _add(point: EntryPoint, app: Any, groups: Mapping[str, Any]) -> None:
    """Add a verb of another package: a function or a group; ``data.add`` to the group of that name.

    One that cannot be imported says so when it is asked.
    """
    group, _, name = point.name.rpartition(".")
    try:
        loaded = point.load()
    except Exception as error:  # a third-party import may fail in any way
        problem = f"cannot be used: {type(error).__name__} on import: {message_of(error)}"

        def loaded() -> None:
            """Verb of another package that cannot be imported."""
            raise InputError("verb", point.name, problem, f"install the package of {point.value}")

    if hasattr(loaded, "registered_commands"):
        app.add_typer(loaded, name=name)
    else:
        groups.get(group, app).command(name)(loaded)


def _drop_output() -> None:
    """Let what is still to be printed go nowhere, so that the end of the process says no more."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _say(text: str, status: int) -> int:
    with suppress(OSError):  # its reader has gone
        print("workbench: " + " ".join(text.split()), file=sys.stderr)
    return status


def _prepare() -> None:
    """Let both streams replace what they cannot encode, a closed one lead nowhere; find a home."""
    codecs.register_error("workbench", _replaced)
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, Path(os.devnull).open("w", encoding="utf-8"))  # noqa: SIM115
        getattr(sys, name).reconfigure(errors="workbench")
    with suppress(RuntimeError):  # an account without a home
        home = Path.home()
        if os.access(cache if (cache := home / ".cache").is_dir() else home, os.W_OK):
            return
    from workbench.base.datafiles import private_folder

    os.environ["HOME"] = str(private_folder())  # libraries keep theirs there and fail or warn else


def plain(text: str) -> str:
    """A text in ASCII: signs as programmers write them, Greek letters by name, ? for the rest."""
    return "".join(map(_letter, _RAISED.sub(lambda match: f"^{match[0]}", text)))


def _letter(letter: str) -> str:
    whole = unicodedata.normalize("NFKD", _PLAIN.get(letter, letter))
    known = "".join(_PLAIN.get(part, part) for part in whole).encode("ascii", "ignore").decode()
    name = unicodedata.name(letter, "")
    return known or (name.split()[-1].lower() if name.startswith("GREEK") else "?")


def _replaced(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return plain(error.object[error.start : error.end]), error.end
