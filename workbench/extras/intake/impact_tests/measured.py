"""Measured impacts as a model: they answer exactly the scenarios that were tested."""

import hashlib
import json
from dataclasses import dataclass, replace
from typing import ClassVar

from workbench.base.errors import CollapseError, OutOfDomainError
from workbench.base.fields import Text, checked
from workbench.extras.intake.impact_tests.rows import ImpactTest, impact_tests, tables
from workbench.models.base import Answering
from workbench.responses import Finding, Response, build_response, finding, set_attributes
from workbench.scenarios import ColumnImpact, Scenario

_PROVENANCE = ("name", "title", "source", "licence", "year", "role", "uncertainty")


@dataclass(frozen=True)
class Measured(Answering):
    """Impact tests of the data catalogue. Option: `dataset`, one table of them (all by default).

    The response holds the measured scalars only; attribute `data_uncertainty` has the half-widths
    of their 95 % intervals (JSON: quantity to half-width in SI), `data` the tests and where they
    are from.
    """

    dataset: str | None = checked(Text(), optional=True)

    name: ClassVar[str] = "measured"
    version: ClassVar[int] = 1
    judged: ClassVar[bool] = False
    answers: ClassVar[tuple[str, ...]] = (ColumnImpact.KIND,)
    assumptions: ClassVar[tuple[str, ...]] = (
        "Numbers as the laboratory gives them; they answer only the scenarios that were tested.",
        "Tests of one scenario answer with their mean.",
        "Rows of role synthetic are made numbers: they show the form and validate nothing.",
    )

    def check(self) -> None:
        """Refuse a dataset that holds no impact tests."""
        tables(self.dataset)

    @property
    def sources(self) -> tuple[str, ...]:
        """Bibliography keys of the tables, as far as the bibliography has them."""
        return tuple(dict.fromkeys(key for entry in tables(self.dataset) for key in entry.keys))

    @property
    def data_digest(self) -> str:
        """Hash of the tables and of where they are from, so that stored cells follow changes."""
        digest = hashlib.sha256()
        for entry in tables(self.dataset):
            digest.update(entry.path.read_bytes())
            digest.update(json.dumps([getattr(entry, name) for name in _PROVENANCE]).encode())
        return digest.hexdigest()[:16]

    def domain(self, scenario: Scenario) -> list[Finding]:
        """Refuse what was not tested, and say where numbers are made."""
        test = self.test(scenario)
        if test is None:
            names = ", ".join(entry.name for entry in tables(self.dataset))
            return [finding("no-test", names=names)]
        if 0 < test.collapsed < len(test.names):
            ended = f"{test.collapsed} of {len(test.names)} collapsed"
            return [finding("tests-disagree", ended=ended)]
        if test.synthetic:
            return [finding("synthetic")]
        return []

    def test(self, scenario: Scenario) -> ImpactTest | None:
        """The test of a scenario, None where it was not tested."""
        if not isinstance(scenario, ColumnImpact):
            return None
        for test in impact_tests(self.dataset):
            # how long a response is followed is not part of what was tested
            if scenario == replace(test.scenario, name=scenario.name, duration=scenario.duration):
                return test
        return None

    def _solve(self, scenario: Scenario) -> Response:
        test = self.test(scenario)
        if test is None:
            raise OutOfDomainError("nothing was measured for this scenario")
        if test.collapse is not None:
            raise CollapseError(test.collapse, "the member did not survive the test")
        response = build_response({name: value for name, (value, _) in test.measured.items()})
        widths = {name: width for name, (_, width) in test.measured.items()}
        set_attributes(response, data_uncertainty=widths)
        entries = [{name: getattr(entry, name) for name in _PROVENANCE} for entry in test.entries]
        sources = {"tests": test.names, "campaign": test.campaign, "datasets": entries}
        set_attributes(response, data=sources)
        return response
