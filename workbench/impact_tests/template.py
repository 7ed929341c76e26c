"""The template of a table of impact tests."""

from pathlib import Path

from workbench.impact_tests.schema import IMPACTS
from workbench.studs.templates import templates_in

(TEMPLATE,) = templates_in(Path(__file__).with_name("templates.toml"), IMPACTS).values()
