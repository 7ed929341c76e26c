"""Measured impacts on steel members: their schema, tests as scenarios, and as a side of studies."""

from workbench.extras.intake.impact_tests.rows import IMPACTS as IMPACTS
from workbench.extras.intake.impact_tests.rows import impact_tests as impact_tests
from workbench.extras.intake.impact_tests.rows import scenario_of as scenario_of
