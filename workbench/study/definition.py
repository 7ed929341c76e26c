"""A study: cases, models, the reference among them, what is compared, and the gates."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from math import isfinite
from numbers import Real
from typing import TYPE_CHECKING, Any, TypeVar

from workbench.base.catalogue import DATA as DATA
from workbench.base.errors import InputError, one_line
from workbench.base.fields import Choice, did_you_mean
from workbench.responses import VARIABLES
from workbench.responses.uncertainty import level_names
from workbench.scenarios import Scenario
from workbench.study.assessment import METRICS, Gate, Scope
from workbench.study.assessment.variations import Budget

if TYPE_CHECKING:
    from workbench.models.base import Model


def holds_data(model: Model) -> bool:
    """Whether a model gives printed or measured numbers: looking them up costs nothing."""
    return model.name in DATA


_NAMED = 8  # cases that the note on the quick form names
LONGEST = 120  # characters of a name that stands in tables, legends and file names
_KEY = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,79}")


@dataclass(frozen=True)
class Case:
    """One scenario of a study.

    Parameters
    ----------
    name : str
        Unique in the study.
    scenario : Scenario
        What happens.
    figure : str
        Key of the figure that shows it.
    models : tuple of str
        Labels that answer it; empty: all.
    parameters : mapping
        Coordinates of a sweep, names with unit and values.
    quick : bool
        Whether the quick form of the study keeps it.

    Examples
    --------
    >>> impact = wb.impact(wb.Column("HEB 220", 2.0, 2.0), mass=1500, velocity=5)
    >>> wb.Case("slow", impact, parameters={"velocity (m/s)": 5.0}).models
    ()
    """

    name: str
    scenario: Scenario
    figure: str = ""
    models: tuple[str, ...] = ()
    parameters: Mapping[str, Any] = field(default_factory=dict)
    quick: bool = True


def varied_case(case: str, variation: str) -> str:
    """Name of the case that is varied for the budget of another one."""
    return f"{case}: {variation}"


@dataclass(frozen=True)
class Figure:
    """A figure of the report.

    Parameters
    ----------
    key : str
        Name, by which cases choose it.
    kind : str
        One that `workbench.report` draws: ``history``, ``force-displacement``, ``peaks``,
        ``interaction``, ``energy``, ``sweep``, ...
    title : str
        Heading.
    caption : str
        What is seen, and where it was published.
    models : tuple of str
        Labels that it shows; empty: all.
    options : mapping
        Drawing options of its kind.

    Examples
    --------
    >>> wb.Figure("peaks", "peaks", "Peaks", "Of all models.").kind
    'peaks'
    """

    key: str
    kind: str
    title: str
    caption: str
    models: tuple[str, ...] = ()
    options: Mapping[str, Any] = field(default_factory=dict)


T = TypeVar("T", Case, Figure, Budget)


@dataclass(frozen=True)
class Study:
    """Everything that `workbench run`, `report` and `validate` need; defined in a Python file.

    Parameters
    ----------
    name : str
        Safe as the name of a file.
    title, question : str
        Heading of the report and what it answers.
    cases : tuple of Case
        Scenarios with their names.
    models : mapping
        Models by label.
    reference : str
        Label of the model that the others are held against.
    ladder : tuple of str
        Labels of the reference from coarse to fine, each at half the element size and step of the
        one before, the last being the reference; for one that makes no coarser runs by itself.
    references : tuple of str
        Labels from best to worst: the best inside its domain counts in each case; empty: the
        reference.
    groups : mapping
        Cases that the answer tells apart, names of cases by name; empty: one group.
    quantities : tuple of str
        Variables of responses that are compared.
    gates, figures, budgets : tuple of Gate, Figure, Budget
        Criteria, pictures, and answers whose errors are budgeted: their varied runs are stored,
        and compared with nothing else.
    decisive : str
        Key of the figure of the first page; empty: the first that shows all cases at once.
    quick_models : tuple of str
        Labels that the quick form keeps; empty: all.
    notes : tuple of str
        Paragraphs of the report: what is reconstructed, inferred or outside a domain.
    whole : Study, optional
        The study of which it is the quick form.

    Raises
    ------
    InputError
        For labels or names that do not fit together, and for unknown metrics.

    Examples
    --------
    >>> case = wb.Case("slow", wb.impact(wb.Column("HEB 220", 2.0, 2.0), mass=1500, velocity=5))
    >>> model = wb.make_model("four-dof")
    >>> study = wb.Study("mine", "Mine", "How far?", (case,), {"4 dof": model}, reference="4 dof")
    >>> [label for _, label in study.cells()]
    ['4 dof']
    """

    name: str
    title: str
    question: str
    cases: tuple[Case, ...]
    models: Mapping[str, Model]
    reference: str
    ladder: tuple[str, ...] = ()
    references: tuple[str, ...] = ()
    groups: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    quantities: tuple[str, ...] = ("peak_displacement", "time_of_peak", "residual_displacement")
    gates: tuple[Gate, ...] = ()
    figures: tuple[Figure, ...] = ()
    decisive: str = ""
    budgets: tuple[Budget, ...] = ()
    quick_models: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    whole: Study | None = field(default=None, repr=False, compare=False)

    def __post_init__(self) -> None:
        self._check_parts()
        self._check_references()

    def _check_parts(self) -> None:
        """Refuse names, types, quantities and bounds that cannot be meant."""
        kinds = {"cases": Case, "gates": Gate, "figures": Figure, "budgets": Budget}
        for name, kind in kinds.items():
            for value in getattr(self, name):
                if not isinstance(value, kind):
                    text = f"must hold nothing but {kind.__name__}"
                    raise InputError(f"study.{name}", value, text)
        _file_safe("study.name", self.name)
        for case in self.cases:
            _named("case.name", case.name)
            for axis, value in case.parameters.items():
                _named("case.parameters", axis)
                if isinstance(value, Real) and not isfinite(value):
                    raise InputError(f"case.parameters[{axis!r}]", value, "must be finite")
        for label in self.models:
            _named("study.models", label)
        keys = [figure.key for figure in self.figures]
        for key in keys:
            _file_safe("figure.key", key)
            if keys.count(key) > 1:
                text = "must be unique: figures are files of that name"
                raise InputError("figure.key", key, text)
        for quantity in self.quantities:
            _known("study.quantities", quantity)
        for gate in self.gates:
            metric = METRICS.get(gate.metric)
            # metrics of a run have quantities of their own
            if metric is None or metric.scope is not Scope.RUN:
                _known("gate.quantity", gate.quantity)
            bound: Any = gate.bound
            if not isinstance(bound, Real) or not isfinite(bound) or bound <= 0.0:
                raise InputError("gate.bound", bound, "must be a finite number above 0")

    def _check_references(self) -> None:
        """Refuse cases, labels and metrics that the study does not have."""
        names = [case.name for case in self.cases]
        for name in names:
            if names.count(name) > 1:
                raise InputError("study.cases", name, "case names must be unique")
        for where, of in (
            ("gate", [g.cases for g in self.gates]),
            ("group", self.groups.values()),
            ("budget", [[budget.case] for budget in self.budgets]),
        ):
            for name in (name for cases in of for name in cases):
                if name not in names:
                    raise InputError(f"{where}.cases", name, "is not a case of the study")
        if self.decisive and self.decisive not in {figure.key for figure in self.figures}:
            raise InputError("study.decisive", self.decisive, "is not a figure of the study")
        labels = [*self.ladder, *self.references, *self.quick_models, self.reference]
        labels += [label for case in self.cases for label in case.models]
        labels += [label for budget in self.budgets for label in budget.models]
        labels += [label for figure in self.figures for label in figure.models]
        labels += [label for gate in self.gates for label in (gate.model, gate.against)]
        for label in labels:
            Choice(tuple(self.models)).check("study label", label)
        for gate in self.gates:
            Choice(tuple(METRICS)).check("gate.metric", gate.metric)
            if METRICS[gate.metric].scope is Scope.RUN and gate.model != gate.against:
                raise InputError("gate.against", gate.against, f"must be {gate.model} as well")
        if self.ladder and self.ladder[-1] != self.reference:
            raise InputError("study.ladder", self.ladder, "must end with the reference")

    @property
    def ranked(self) -> tuple[str, ...]:
        """The references from best to worst."""
        return self.references or (self.reference,)

    @property
    def steps(self) -> tuple[str, ...]:
        """Columns of the ladder table, coarse to fine.

        The meshes that stand behind each answer of the reference, else the labels of the ladder.
        """
        levels = int(getattr(self.models[self.reference], "levels", 1))
        return level_names(levels) if levels > 1 else self.ladder

    def cells(self) -> Iterator[tuple[Case, str]]:
        """Every case with every label that is to answer it, in a fixed order."""
        for case, label in self._pairs():
            if case.scenario.KIND in self.models[label].answers:
                yield case, label

    def varied_cells(self) -> Iterator[tuple[Case, str, Model]]:
        """The varied runs of all budgets: cases of their own, every label, who answers as it.

        Raises `InputError` for a budget of what is no impact on a column.
        """
        for budget in self.budgets:
            scenario = next(case.scenario for case in self.cases if case.name == budget.case)
            for key, varied in budget.variations(scenario).items():
                case = Case(varied_case(budget.case, key), varied)
                for label in budget.models:
                    yield case, label, budget.solver(key, self.models[label])

    def unsupported(self) -> dict[tuple[str, str], list[str]]:
        """Cases of kinds that the model of a label does not answer.

        Keys are (label, kind of scenario), values names of cases.
        """
        left: dict[tuple[str, str], list[str]] = {}
        for case, label in self._pairs():
            if case.scenario.KIND not in self.models[label].answers:
                left.setdefault((label, case.scenario.KIND), []).append(case.name)
        return left

    def _pairs(self) -> Iterator[tuple[Case, str]]:
        for case in self.cases:
            yield from ((case, label) for label in self.models if label in (case.models or [label]))

    def quickened(self) -> Study:
        """The quick form: fewer cases and models, the same path.

        Gates, cases and figures that lost all their models go. Raises `InputError` if neither
        the reference nor a level of its ladder is kept.
        """
        keep = set(self.quick_models) or set(self.models)
        models = {label: model for label, model in self.models.items() if label in keep}
        ladder = tuple(label for label in self.ladder if label in keep)
        if self.reference not in keep and not ladder:
            text = "must keep a level of the reference"
            raise InputError("study.quick_models", self.quick_models, text)

        def kept(labels: tuple[str, ...]) -> tuple[str, ...]:
            return tuple(label for label in labels if label in keep)

        def shown(parts: Iterable[T]) -> tuple[T, ...]:
            """Parts with the labels that are kept; those that lose all of theirs go."""
            pairs = ((part, kept(part.models)) for part in parts)
            return tuple(replace(p, models=labels) for p, labels in pairs if labels or not p.models)

        cases = shown(case for case in self.cases if case.quick)
        names = {case.name for case in cases}
        gates = tuple(
            replace(gate, cases=tuple(n for n in gate.cases if n in names))
            for gate in self.gates
            if {gate.model, gate.against} <= keep and (not gate.cases or names & set(gate.cases))
        )
        figures = shown(self.figures)
        budgets = shown(b for b in self.budgets if b.models and b.case in names)
        groups = {
            group: tuple(name for name in of if name in names) for group, of in self.groups.items()
        }
        left_out = {
            "models": [label for label in self.models if label not in keep],
            "cases": [case.name for case in self.cases if case.name not in names],
        }
        if len(left_out["cases"]) > _NAMED:
            left_out["cases"] = [f"({len(left_out['cases'])} of {len(self.cases)})"]
        parts = "; ".join(f"{what} {', '.join(which)}" for what, which in left_out.items() if which)
        count = f"{len(gates)} of {len(self.gates)} gates"
        note = f"Quick form, {count}. Left out: {parts or 'nothing'}."
        return replace(
            self,
            name=f"{self.name}-quick",
            notes=(*self.notes, note),
            whole=self,
            cases=cases,
            models=models,
            reference=self.reference if self.reference in keep else ladder[-1],
            ladder=ladder,
            references=kept(self.references),
            groups={group: of for group, of in groups.items() if of},
            decisive=self.decisive if self.decisive in {f.key for f in figures} else "",
            gates=gates,
            figures=figures,
            budgets=budgets,
            quick_models=(),
        )


def _named(where: str, name: Any) -> None:
    if not isinstance(name, str) or not name.strip() or one_line(name, len(name)) != name:
        raise InputError(where, name, "must be a text in one line that is not empty")
    if len(name) > LONGEST:
        raise InputError(where, f"{name[:40]}...", f"has {len(name)} characters, at most {LONGEST}")


def _file_safe(where: str, name: Any) -> None:
    if not isinstance(name, str) or not _KEY.fullmatch(name):
        text = "must be at most 80 letters, digits, dots, dashes and underscores: files have it"
        raise InputError(where, str(name)[:80], text)


def _known(where: str, quantity: Any) -> None:
    if quantity not in VARIABLES and "." not in str(quantity):
        advice = did_you_mean(str(quantity), list(VARIABLES), "see docs/reference/columns.md")
        raise InputError(where, str(quantity)[:80], "is not a variable of responses", advice)
