"""The conformance kit: it passes models that keep the contract and catches each way not to."""

from __future__ import annotations

import dataclasses
import itertools
from dataclasses import dataclass
from typing import Any, ClassVar

import pytest
from toy_models import Spring, Troubled

from workbench.responses import Finding, Response, build_response, failed_response
from workbench.responses.outcome import Outcome
from workbench.scenarios import ColumnImpact
from workbench.testing import check_model, problems_of


@dataclass(frozen=True)
class Good(Spring):
    """A spring to break."""

    unused: ClassVar[tuple[str, ...]] = (
        *("column.*", "steel.*", "striker.restitution", "striker.direction"),
    )


def broken(**members: Any) -> Any:
    """The spring with some of its members replaced."""
    kind = type("Broken", (Good,), {"__doc__": "A broken spring.", **members})
    frozen = dataclass(frozen=True)(kind)
    # pickle finds classes by module and name
    frozen.__module__ = __name__
    frozen.__qualname__ = "Broken"
    globals()["Broken"] = frozen
    return frozen()


def changed(change: Any) -> Any:
    """The spring with its response changed afterwards."""

    def simulate(self: Good, scenario: Any) -> Response:
        response = Good.simulate(self, scenario)
        return change(response) if "displacement" in response else response

    return broken(simulate=simulate)


def scaled(name: str, factor: float) -> Any:
    return changed(lambda r: r.assign({name: (r[name] * factor).assign_attrs(r[name].attrs)}))


def without(*names: str) -> Any:
    def drop(response: Response) -> Response:
        for name in names:
            del response.attrs[name]
        return response

    return changed(drop)


def with_attribute(**attributes: Any) -> Any:
    return changed(lambda r: r.assign_attrs(**attributes))


counter = itertools.count()


@dataclass(frozen=True)
class ListOption(Good):
    """Turns its option into something that JSON changes."""

    numbers: tuple[int, ...] = (1, 2)


@dataclass
class Thawed:
    """Not frozen."""


CASES: dict[str, tuple[Any, str]] = {
    "no docstring": (broken(__doc__=None), "must have a docstring"),
    "name": (broken(name="Toy Spring"), "name must be a word"),
    "version": (broken(version=0), "version must be a whole number"),
    "answers": (broken(answers=()), "answers must not be empty"),
    "answers text": (broken(answers="column-impact"), "answers must be a tuple"),
    "assumptions": (broken(assumptions=()), "assumptions must not be empty"),
    "no domain": (broken(domain=None), "has no domain"),
    "option name": (
        broken(**{"__annotations__": {"sources": "tuple[str, ...]"}, "sources": ()}),
        "sources must be a class variable",
    ),
    "options": (ListOption(), "options change in a round trip"),
    "raises": (
        broken(simulate=lambda self, scenario: 1 / 0),
        "simulate raised ZeroDivisionError",
    ),
    "random": (
        changed(lambda r: r.assign_attrs(message=str(next(counter)))),
        "two runs of the same scenario differ",
    ),
    "ledger": (
        changed(lambda r: r.assign(balance_error=r["balance_error"] + 1.0)),
        "energy ledger is open by 1 J",
    ),
    "wrong sum": (scaled("kinetic", 1.001), "balance_error is not what the energies leave"),
    "dissipation": (
        changed(
            lambda r: r.assign(dissipated=-(r["time"] * 1e4).assign_attrs(r["dissipated"].attrs))
        ),
        "dissipated decreases",
    ),
    "no input": (
        changed(lambda r: r.drop_vars("input_energy")),
        "balance_error without input_energy",
    ),
    "peak": (scaled("peak_displacement", 1.1), "is not that of its history"),
    "no peak": (changed(lambda r: r.drop_vars(["peak_displacement", "time_of_peak"])), "no peak"),
    "units": (
        changed(lambda r: r.assign(impulse=1.0)),
        "'impulse' lacks units",
    ),
    "unknown": (changed(lambda r: r.assign(colour=1.0)), "'colour' is not a standard one"),
    "nan": (scaled("velocity", float("nan")), "not finite"),
    "unsigned": (without("scenario_hash", "wall_time"), "does not carry scenario_hash, wall_time"),
    "other model": (with_attribute(model="another"), "names another model"),
    "other scenario": (with_attribute(scenario_hash="0"), "names another scenario"),
    "silent": (
        changed(
            lambda r: failed_response(Outcome.NOT_CONVERGED, "").assign_attrs(
                {**r.attrs, "outcome": "not-converged", "message": "sorry"}
            )
        ),
        "comes without a sentence",
    ),
    "failed with numbers": (
        with_attribute(outcome="not-converged", message="it did not converge at all"),
        "comes with variables",
    ),
    "empty": (
        changed(lambda r: build_response({}).assign_attrs(r.attrs)),
        "outcome ok comes without a single variable",
    ),
    "refusal ignored": (
        broken(
            domain=lambda self, s: [Finding("a", "never", refusal=True)],
            simulate=lambda self, s: Good().simulate(s),
        ),
        "domain refuses the scenario but simulate answers it",
    ),
    "warning lost": (
        broken(
            domain=lambda self, s: [Finding("a", "beware")],
            simulate=lambda self, s: Good().simulate(s),
        ),
        "the warning 'beware' of domain is missing",
    ),
    "foreign": (
        broken(simulate=lambda self, s: self._solve(s)),
        "a foreign kind of scenario ends in ok",
    ),
    "never answers": (Troubled("solver"), "answers none of the given scenarios"),
    "thawed": (Thawed(), "must be an instance of a frozen dataclass"),
}


@pytest.mark.parametrize("case", CASES)
def test_each_breach_is_caught(case: str, thesis_impact: ColumnImpact) -> None:
    model, text = CASES[case]
    if "Broken" in type(model).__name__:
        globals()["Broken"] = type(model)
    problems = problems_of(model, [thesis_impact])
    assert any(text in problem for problem in problems), problems
    with pytest.raises(AssertionError, match="breaks the contract"):
        check_model(model, [thesis_impact])


def test_a_good_model_passes(thesis_impact: ColumnImpact) -> None:
    check_model(Good(), [thesis_impact, thesis_impact.at_velocity(20.0)])
    check_model(Good(stiffness=5e4), [thesis_impact])  # with a warning
    assert problems_of(broken(), [thesis_impact]) == []


def test_a_foreign_scenario_in_the_list_is_said(thesis_impact: ColumnImpact) -> None:
    other = dataclasses.replace(thesis_impact)
    problems = problems_of(broken(answers=("column-pushover",)), [other])
    assert any("kind that it does not answer" in problem for problem in problems)


def test_inputs_that_change_nothing_are_named(thesis_impact: ColumnImpact) -> None:
    problems = problems_of(
        broken(unused=("column.*", "steel.*", "striker.direction")), [thesis_impact]
    )
    assert problems == ["striker.restitution changes nothing: use it, or name it in `unused`"]
