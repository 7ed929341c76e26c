"""The verbs, put together."""

from collections.abc import Callable
from typing import Annotated, Any

import typer

from workbench import __version__
from workbench.cli import data, doctor, fit, models, simulate, studies

_SUMMARY = """How far can each reduced model of a steel structure under impact be trusted?

Exit status: 0 done, 1 a gate failed or a cell did not converge, 2 bad input.
"""


def build() -> Callable[..., Any]:
    """The command-line application, as a function of its arguments."""
    app = typer.Typer(
        add_completion=False,
        help=_SUMMARY,
        rich_markup_mode=None,  # rich takes longer to import than the rest of --help
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    )
    app.callback(invoke_without_command=True)(_root)
    app.command("models")(models.models)
    app.command("simulate")(simulate.simulate)
    app.command("run")(studies.run)
    app.command("status")(studies.status)
    app.command("report")(studies.report)
    app.command("validate")(studies.validate)
    app.add_typer(fit.app, name="fit")
    app.add_typer(data.app, name="data")
    app.command("doctor")(doctor.doctor)
    command: Callable[..., Any] = typer.main.get_command(app)
    return command


def _root(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False,
) -> None:
    if version:
        typer.echo(__version__)
    elif context.invoked_subcommand is None:
        typer.echo(context.get_help())
