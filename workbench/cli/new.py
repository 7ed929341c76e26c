"""`workbench new`: templates of tables and files, to be redirected into a file and filled."""

import sys
from typing import Annotated

import typer

from workbench.cli.output import Answer, Json, verb

app = typer.Typer(help="Print a template to fill in.", rich_markup_mode=None, no_args_is_help=False)
_MAPPING = """\
# What a table of tests holds, for `workbench data add TABLE.csv --mapping THIS.toml`.
# Without source and licence nothing is taken.
title = ""
source = ""        # publication, table or figure
licence = ""       # of the numbers, such as CC BY 4.0
year = 2026
role = "validate"  # calibrate, validate, verify; synthetic for made numbers
# uncertainty = "how well the numbers are known"
# kind = "stud-tests"  # or impact-tests; else told from the columns
# ignore = ["remarks"]  # columns of the table that are left out
# missing = ["-", "n/a"]  # what stands for a number that was not reported

[columns]          # column of the table = column of the workbench
# "Pu" = "shear_kN"

[units]            # of columns whose unit neither their name nor a row of units says
# "Pu" = "kip"

[constants]        # columns of the workbench that are the same in all rows
# test = "push-out"
"""


def _printed(text: str, as_json: bool) -> Answer:
    """The template as it is: no line of a file may be wrapped."""
    if not as_json:
        sys.stdout.write(text)
    return Answer({"template": text})


@app.command("impact-tests")
@verb
def impact_tests(as_json: Json = False) -> Answer:
    """A table of impact tests on steel members, commented, with an example: for `data add`."""
    from workbench.impact_tests.template import TEMPLATE

    return _printed(TEMPLATE.text, as_json)


@app.command("mapping")
@verb
def mapping(as_json: Json = False) -> Answer:
    """A mapping file for a published table, for `workbench data add --mapping`."""
    return _printed(_MAPPING, as_json)


@app.command("studs")
@verb
def studs(
    kind: Annotated[
        str,
        typer.Option(
            metavar="NAME", help="strength, load-slip, residual, fatigue, combined or deck."
        ),
    ] = "strength",
    as_json: Json = False,
) -> Answer:
    """A table of tests on studs, commented, with an example: for `workbench fit`."""
    from workbench.studs.templates import template

    return _printed(template(kind), as_json)
