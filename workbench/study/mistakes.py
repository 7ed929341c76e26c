"""Mistakes in a study that would otherwise show after its cells have run, or never."""

from __future__ import annotations

import re
from collections.abc import Mapping
from math import isfinite
from numbers import Real
from typing import Any

from workbench.assessment import METRICS, Scope
from workbench.errors import InputError
from workbench.fields import did_you_mean
from workbench.responses import VARIABLES

LONGEST = 120  # characters of a name that stands in tables, legends and file names
_KEY = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,79}")


def refuse_mistakes(study: Any, kinds: Mapping[str, type[Any]]) -> None:
    """Raise `InputError` for names, types, quantities and bounds of a `Study` that cannot be meant.

    `kinds`: what a field of the study holds, by its name.
    """
    for name, kind in kinds.items():
        for value in getattr(study, name):
            if not isinstance(value, kind):
                raise InputError(f"study.{name}", value, f"must hold nothing but {kind.__name__}")
    _file_safe("study.name", study.name)
    for case in study.cases:
        _named("case.name", case.name)
        for axis, value in case.parameters.items():
            _named("case.parameters", axis)
            if isinstance(value, Real) and not isfinite(value):
                raise InputError(f"case.parameters[{axis!r}]", value, "must be finite")
    for label in study.models:
        _named("study.models", label)
    keys = [figure.key for figure in study.figures]
    for key in keys:
        _file_safe("figure.key", key)
        if keys.count(key) > 1:
            raise InputError("figure.key", key, "must be unique: figures are files of that name")
    for quantity in study.quantities:
        _known("study.quantities", quantity)
    for gate in study.gates:
        metric = METRICS.get(gate.metric)
        if metric is None or metric.scope is not Scope.RUN:  # these have quantities of their own
            _known("gate.quantity", gate.quantity)
        bound: Any = gate.bound
        if not isinstance(bound, Real) or not isfinite(bound) or bound <= 0.0:
            raise InputError("gate.bound", bound, "must be a finite number above 0")


def _named(where: str, name: Any) -> None:
    if not isinstance(name, str) or not name.strip():
        raise InputError(where, name, "must be a text that is not empty")
    if len(name) > LONGEST:
        raise InputError(where, f"{name[:40]}...", f"has {len(name)} characters, at most {LONGEST}")


def _file_safe(where: str, name: Any) -> None:
    if not isinstance(name, str) or not _KEY.fullmatch(name):
        text = "must be at most 80 letters, digits, dots, dashes and underscores: files have it"
        raise InputError(where, str(name)[:80], text)


def _known(where: str, quantity: Any) -> None:
    if quantity not in VARIABLES and "." not in str(quantity):
        advice = did_you_mean(str(quantity), list(VARIABLES), "see docs/user-guide.md")
        raise InputError(where, str(quantity)[:80], "is not a variable of responses", advice)
