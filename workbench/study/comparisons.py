"""Comparing the answers of one case, with the numerical uncertainty that goes with each number.

The uncertainty of a side is that of its own coarser runs, if it made some. Otherwise the reference
of the study has that of its ladder of labels (unknown without one), published or measured numbers
the half-width stated with them, a sample that of its interval. Any other side, a reduced
model, counts as exact: its discretisation is part of what is judged; a note says where no side has
an uncertainty of its own.

For scalar quantities the two sides combine as ASME V&V 20 does. Metrics of histories and curves
are evaluated with every run of a side; these values give their interval by the same rules.
Metrics of a response alone are numbers about the run: they have no interval.
"""

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from math import hypot
from typing import Any, NamedTuple

from workbench.base.errors import Collapse, InputError
from workbench.responses import Outcome, Response, attribute, collapse_of, findings_of, outcome_of
from workbench.responses import uncertainty as numerical
from workbench.responses.uncertainty import DATA_WIDTHS, INPUT_WIDTHS, SAMPLE_WIDTHS
from workbench.study.assessment import METRICS, Ladder, Metric, Scope, ladder
from workbench.study.assessment.metric import sides
from workbench.study.definition import Case, Study
from workbench.study.tables import Row, counts, numbers, texts

LADDER_COLUMNS = (
    numbers("order", "extrapolated", "uncertainty", "relative")
    | counts("converging", "accepted")
    | texts("note")
)
_OF_THE_RUN = "a number about the run itself"
_EXACT = "no side has an estimate of its own numerical error; counted as zero"

Known = tuple[float | None, str]  # half-width (None: unknown) and a note on where it comes from


@dataclass(frozen=True)
class CaseAnswers:
    """The stored `responses` of one case by label; `asked` are all labels that are to answer."""

    study: Study
    case: Case
    asked: tuple[str, ...]
    responses: Mapping[str, Response]

    def ok(self, label: str) -> Response | None:
        """The response of a label, if it answered."""
        response = self.responses.get(label)
        if response is None or outcome_of(response) is not Outcome.OK:
            return None
        return response

    def collapse(self, label: str) -> Collapse | None:
        """How the structure of a label collapses, if it does."""
        response = self.responses.get(label)
        return None if response is None else collapse_of(response)

    def why_not(self, label: str) -> str:
        """Why there is no answer of a label."""
        response = self.responses.get(label)
        if label not in self.asked:
            return f"the study does not ask {label}"
        if response is None:
            return f"{label} has not been run"
        collapse = collapse_of(response)
        if collapse is not None:
            return f"{label}: {collapse} ({collapse.mechanism}, {', '.join(collapse.parts)})"
        refusals = [finding.text for finding in findings_of(response) if finding.refusal]
        reason = refusals[0] if refusals else response.attrs["message"]
        return f"{label}: {outcome_of(response)}, {reason}"

    def levels(self) -> list[str]:
        """Labels of the ladder that answered, coarse to fine, without a gap up to the finest."""
        levels: list[str] = []
        for label in reversed(self.study.ladder):
            if self.ok(label) is None:
                break
            levels.insert(0, label)
        return levels


def quantity_ladder(answers: CaseAnswers, quantity: str) -> Ladder | None:
    """The ladder of a scalar quantity of the reference; None if fewer than two levels have it."""
    values: list[float] = []
    for label in reversed(answers.levels()):
        response = answers.ok(label)
        if response is None or quantity not in response:
            break
        values.insert(0, float(response[quantity]))
    return ladder(values) if len(values) > 1 else None


def of_side(answers: CaseAnswers, label: str, quantity: str) -> Known:
    """Half-width of a scalar of one side, with that of the inputs which a test leaves open."""
    (own, note), response = _of_numbers(answers, label, quantity), answers.responses[label]
    if own is None or INPUT_WIDTHS not in response.attrs:
        return own, note
    width = numerical.uncertainty_of(response, quantity, INPUT_WIDTHS)
    return None if width is None else hypot(own, width), joined(note, f"{label}: open inputs")


def _of_numbers(answers: CaseAnswers, label: str, quantity: str) -> Known:
    """Half-width of a scalar of one side at the inputs of the scenario."""
    response = answers.responses[label]
    if _refined(response):
        note = f"{label}: {own_note(response, quantity)}"
        return numerical.uncertainty_of(response, quantity), note
    if label == answers.study.reference:
        levels = quantity_ladder(answers, quantity)
        if levels is not None:
            return levels.uncertainty, f"ladder of {label}: {levels.note}"
        if not {DATA_WIDTHS, SAMPLE_WIDTHS} & response.attrs.keys():
            return None, _no_ladder(label)
    for kind, source, missing in (
        (SAMPLE_WIDTHS, "interval over the tests or samples", ": one test has no interval"),
        (DATA_WIDTHS, "uncertainty of the data", f" states no uncertainty of {quantity}"),
    ):
        if kind in response.attrs:
            width = numerical.uncertainty_of(response, quantity, kind)
            return width, f"{label}{missing}" if width is None else f"{label}: {source}"
    if numerical.WIDTHS in response.attrs:
        return None, f"{label}: {own_note(response, quantity)}"
    return 0.0, ""


def joined(*notes: str) -> str:
    """Notes of both sides in one."""
    return "; ".join(dict.fromkeys(text for text in notes if text)) or _EXACT


def own_note(response: Response, quantity: str) -> str:
    """Note of a response on its own numerical uncertainty of a quantity."""
    basis = attribute(response, numerical.BASIS)
    known = basis["quantities"].get(quantity)
    if known is None:
        return f"its numerical uncertainty of {quantity} was not asked for"
    if numerical.uncertainty_of(response, quantity) is None:
        return _said(basis) or known["note"]
    return f"refinement of its own, {known['note']}"


def _runs(answers: CaseAnswers, label: str) -> Mapping[str, Response]:
    """The runs behind one side that tell its numerical uncertainty, its answer last."""
    response = answers.responses[label]
    if _refined(response):
        return dict(numerical.variants(response))
    if label == answers.study.reference:
        return {level: answers.responses[level] for level in answers.levels()}
    return {}


def _spread(answers: CaseAnswers, label: str, quantity: str, values: Mapping[str, float]) -> Known:
    """Half-width of a metric that one side gives, from its `values` over the runs of that side."""
    response, what = answers.responses[label], f"the metric over {label}"
    if _refined(response):
        if numerical.CURVES.get(quantity) not in response:
            return None, f"{label} keeps no {quantity} of its coarser runs: uncertainty unknown"
        directions = numerical.directions_of(response)
        if not directions:
            return None, f"{label}: {_said(attribute(response, numerical.BASIS))}"
        estimate = numerical.estimate(directions, values)
        return estimate.width, f"refinement of {what}: {estimate.note}"
    if label == answers.study.reference:
        if len(values) < 2 or len(values) < len(answers.levels()):
            return None, _no_ladder(label)
        levels = ladder(list(values.values()))
        return levels.uncertainty, f"ladder of {what}: {levels.note}"
    if numerical.WIDTHS in response.attrs:
        return None, f"{label}: one mesh only, numerical uncertainty unknown"
    if DATA_WIDTHS in response.attrs:
        return None, f"{label} states no uncertainty of its history"
    return 0.0, ""


def _refined(response: Response) -> bool:
    """Whether a response tried coarser meshes of its own."""
    return len(attribute(response, numerical.BASIS).get("levels", ())) > 1


def _said(basis: Mapping[str, Any]) -> str:
    """The statements of a refinement in one line, without those that another one repeats."""
    statements = list(dict.fromkeys(basis["statements"]))
    repeated = {a for a in statements for b in statements if a != b and a in b}
    return "; ".join(text for text in statements if text not in repeated)


def _no_ladder(label: str) -> str:
    return f"{label} has no refinement ladder in this case: uncertainty unknown"


@dataclass(frozen=True)
class PairComparison:
    """A metric between two answers.

    `error` is the value of the metric, with its `uncertainty` (None: unknown) and a `note` on that;
    for scalar quantities also both numbers that were compared, in SI; from `low` to `high` where
    an interval over tests is known, which may be skewed.
    """

    error: float
    uncertainty: float | None
    note: str
    value: float | None = None
    against_value: float | None = None
    low: float | None = None
    high: float | None = None


class Compared(NamedTuple):
    """A quantity of two labels as the metrics of a scope take it.

    `both`, of their answers; `runs`, of every run behind the one side and the other, by label.
    """

    answers: CaseAnswers
    model: str
    against: str
    quantity: str
    both: Any
    runs: Mapping[str, Mapping[str, Any]]


def compared(
    answers: CaseAnswers, model: str, against: str, quantity: str, scope: Scope
) -> Compared:
    """A quantity of two labels of a case. Raises `InputError` if a side cannot know it."""
    for label in (model, against):
        if answers.ok(label) is None:
            raise InputError("answer", answers.case.name, answers.why_not(label))
    response, reference = answers.responses[model], answers.responses[against]
    both = sides(scope, response, reference, quantity)
    runs: dict[str, dict[str, Any]] = {model: {}, against: {}}
    if scope in (Scope.HISTORY, Scope.CURVE):
        for label, behind in runs.items():
            for name, run in _runs(answers, label).items():
                pair = (run, reference) if label == model else (response, run)
                with suppress(InputError):  # a run that does not know the quantity leaves a gap
                    behind[name] = sides(scope, *pair, quantity)
    return Compared(answers, model, against, quantity, both, runs)


def judged(given: Compared, metric: Metric) -> PairComparison:
    """A metric with its uncertainty. Raises `InputError` where it does not exist."""
    answers, model, against, quantity, both, runs = given
    value = metric.compute(both)
    if metric.scope is Scope.RUN:
        return PairComparison(value, 0.0, _OF_THE_RUN)
    if metric.spread is None:  # histories and curves: from the values with every run of a side
        widths: list[float | None] = []
        notes = []
        for label in (model, against):
            values = {}
            for name, run in runs[label].items():
                with suppress(InputError):
                    values[name] = metric.compute(run)
            width, note = _spread(answers, label, quantity, values)
            widths.append(width)
            notes.append(note)
        known = [width for width in widths if width is not None]
        return PairComparison(value, hypot(*known) if len(known) == 2 else None, joined(*notes))
    own_width, note = of_side(answers, model, quantity)
    other_width, other_note = of_side(answers, against, quantity)
    sampled = numerical.sampled_interval(answers.responses[model], quantity)
    ends: list[float] = []
    if sampled is not None and other_width == 0.0:
        ends = sorted(metric.compute(both._replace(value=end)) for end in sampled)
    width = metric.half_width(both.value, both.reference, own_width, other_width)
    return PairComparison(value, width, joined(note, other_note), both.value, both.reference, *ends)


def compare(
    answers: CaseAnswers, model: str, against: str, quantity: str, metric: Metric
) -> PairComparison:
    """A metric between two labels of a case, with its uncertainty.

    Raises `InputError` where the metric does not exist, for instance for an absent quantity.
    """
    return judged(compared(answers, model, against, quantity, metric.scope), metric)


def comparison_rows(answers: CaseAnswers, best: str | None = None) -> Iterator[Row]:
    """Rows of every label of a case against the reference, the data and what gates ask for.

    Also against the `best` of several references.
    """
    study = answers.study
    data = [label for label, r in answers.responses.items() if DATA_WIDTHS in r.attrs]
    asked = [gate.against for gate in study.gates if gate.against != gate.model]
    curve, scope = "displacement", Scope.HISTORY
    if answers.case.scenario.STATIC:
        curve, scope = "force", Scope.CURVE
    judging = [(quantity, [METRICS["relative_error"]]) for quantity in study.quantities]
    judging += [(curve, [metric for metric in METRICS.values() if metric.scope is scope])]
    for against in dict.fromkeys([study.reference, *data, *asked, best or study.reference]):
        for model in answers.responses:
            if model == against or (model in data and against in data):
                continue
            who = {"case": answers.case.name, **answers.case.parameters, "model": model}
            for quantity, metrics in judging:
                what = {"against": against, "quantity": quantity}
                with suppress(InputError):  # one side cannot know the quantity
                    given = compared(answers, model, against, quantity, metrics[0].scope)
                    for metric in metrics:
                        with suppress(InputError):  # a metric may not exist
                            of_metric = {"metric": metric.name, **vars(judged(given, metric))}
                            yield {**who, **what, **of_metric}


def ladder_row(answers: CaseAnswers, quantity: str) -> Row | None:
    """The row of the ladder table; None if the case has no ladder.

    The meshes that stand behind the reference's own answer come first; a study may instead give
    labels.
    """
    finest = answers.ok(answers.study.reference)
    if finest is not None and numerical.directions_of(finest):
        return _own_ladder(answers.case, finest, quantity)
    present = [label for label in answers.study.ladder if label in answers.responses]
    static = answers.case.scenario.STATIC  # has no peak in time
    if len(present) < 2 or (static and not any(quantity in answers.responses[p] for p in present)):
        return None
    row: dict[str, object] = {"case": answers.case.name, "quantity": quantity}
    for label in present:
        response = answers.ok(label)
        if response is not None and quantity in response:
            row[label] = float(response[quantity])
    levels = quantity_ladder(answers, quantity)
    if levels is None:
        failed = [answers.why_not(label) for label in present if answers.ok(label) is None]
        missing = [label for label in present if label not in row]
        row["note"] = "; ".join(failed) or f"{quantity} is absent in {', '.join(missing)}"
        return row
    return {**row, **{name: getattr(levels, name) for name in LADDER_COLUMNS}}


def _own_ladder(case: Case, response: Response, quantity: str) -> Row | None:
    """The row of the ladder table from the runs behind a response; None without the quantity."""
    table = attribute(response, numerical.BASIS)["quantities"].get(quantity)
    if table is None:
        return None
    width = numerical.uncertainty_of(response, quantity)
    value = float(response[quantity])
    return {
        "case": case.name,
        "quantity": quantity,
        **table["values"],
        **{name: table.get(name) for name in LADDER_COLUMNS},
        "uncertainty": width,
        "relative": None if width is None or value == 0.0 else width / abs(value),
        "note": own_note(response, quantity),
    }
