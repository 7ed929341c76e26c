"""`workbench new`: templates of tables and files, to be redirected into a file and filled."""

import sys

import typer

from workbench.cli.output import Answer, Json, option, verb

app = typer.Typer(help="Print a template to fill in.", rich_markup_mode=None, no_args_is_help=False)


def _printed(text: str, as_json: bool) -> Answer:
    """The template as it is: no line of a file may be wrapped."""
    if not as_json:
        sys.stdout.write(text)
    return Answer({"template": text})


@app.command("impact-tests")
@verb
def impact_tests(as_json: Json = False) -> Answer:
    """A table of impact tests on steel members, commented, with an example: for `data add`."""
    from workbench.impact_tests.schema import TEMPLATE

    return _printed(TEMPLATE.text, as_json)


@app.command("mapping")
@verb
def mapping(as_json: Json = False) -> Answer:
    """A mapping file for a published table, for `workbench data add --mapping`."""
    from workbench.intake.mapping import TEMPLATE

    return _printed(TEMPLATE.read_text(encoding="utf-8"), as_json)


@app.command("studs")
@verb
def studs(
    kind: str = option(
        "strength, load-slip, residual, fatigue, combined or deck.", "strength", "NAME"
    ),
    as_json: Json = False,
) -> Answer:
    """A table of tests on studs, commented, with an example: for `workbench fit`."""
    from workbench.studs.templates import template

    return _printed(template(kind), as_json)
