"""Predictions over the inputs that a test leaves open: their part of the validation uncertainty.

ASME V&V 20 holds an error against what is measured, input and numerical together. Each input goes
to both ends of its range alone; the larger change of a quantity is its half-width, and half-widths
of inputs add as squares. Ends of a uniform range count as if they held 95 %: wider, never narrower.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import hypot, inf, isfinite
from typing import Any

from workbench.extras.intake.impact_tests.measured import Measured
from workbench.extras.intake.impact_tests.rows import MEASURED
from workbench.models.base import make_model, on_one_mesh, options_of, signature
from workbench.responses import Outcome, Response, outcome_of, set_attributes
from workbench.responses.uncertainty import INPUT_WIDTHS

_SHOWN = ("name", "version", "answers", "assumptions", "sources", "domain", "judged", "levels")


@dataclass(frozen=True)
class Propagated:
    """A model whose answer to a test has half-widths by the inputs that the test leaves open.

    `of`, its registered name, and `options`, as JSON; for all else it is that model. The attribute
    `input_uncertainty` of its response (JSON: quantity to half-width in SI) has none of a quantity
    that is not known at an end, as where the member does not survive there.
    """

    of: str
    options: str = "{}"

    def __post_init__(self) -> None:
        model: Any = make_model(self.of, json.loads(self.options))
        shown = {name: getattr(model, name) for name in _SHOWN if hasattr(model, name)}
        self.__dict__.update(shown, _model=model)

    @property
    def data_digest(self) -> str:
        """Hash of the tables of tests, so that stored answers follow their ranges."""
        return Measured().data_digest

    def simulate(self, scenario: Any) -> Response:
        """Answer a scenario, and a test at the ends of its open inputs too."""
        model: Any = self.__dict__["_model"]
        response: Response = model.simulate(scenario)
        response.attrs.update(signature(self, scenario))  # type: ignore[arg-type]
        test = Measured().test(scenario)
        if test is None or not test.open or outcome_of(response) is not Outcome.OK:
            return response
        alone, widths = on_one_mesh(model), {}
        ends = [
            [alone.simulate(replace(end, duration=scenario.duration)) for end in both]
            for both in test.open.values()
        ]
        for quantity in (each for each in MEASURED if each in response):
            widest = [max(_change(response, end, quantity) for end in both) for both in ends]
            widths[quantity] = hypot(*widest) if isfinite(max(widest)) else None
        set_attributes(response, **{INPUT_WIDTHS: widths})
        return response


def _change(response: Response, end: Response, quantity: str) -> float:
    """How far a quantity is at an end of an input, infinite where it is not known there."""
    if outcome_of(end) is not Outcome.OK or quantity not in end:
        return inf
    return abs(float(end[quantity]) - float(response[quantity]))


def over_inputs(models: Mapping[str, Any]) -> dict[str, Propagated]:
    """Models by label, each over the open inputs of tests."""
    options = {label: json.dumps(options_of(m), sort_keys=True) for label, m in models.items()}
    return {label: Propagated(model.name, options[label]) for label, model in models.items()}
