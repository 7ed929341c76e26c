"""Models by name: what the installed distributions offer under ``workbench.models``."""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import EntryPoint
from typing import Any

from workbench.base.errors import InputError
from workbench.base.fields import did_you_mean
from workbench.base.offered import offered
from workbench.models.base import Model, with_options

GROUP = "models"  # of the entry points that offer models
_NEW = " (a new entry point counts once its package is installed again)"
_DECLARED = ("name", "version", "answers", "assumptions", "sources", "domain", "simulate")


@dataclass(frozen=True, slots=True)
class Offer:
    """One registered model: its `name`, its class `kind`, or the `problem` that hides it.

    Exactly one of `kind` and `problem` is set; `distribution` says who provides it.
    """

    name: str
    distribution: str
    kind: type[Any] | None
    problem: str = ""


def model_names() -> list[str]:
    """Names of all registered models, sorted; nothing is imported."""
    return sorted({point.name for point in offered(GROUP)})


def offers() -> list[Offer]:
    """Every registered model, imported; one that cannot be used carries its problem."""
    return [_offer(name) for name in model_names()]


def model_kind(name: str) -> type[Any]:
    """The class of the model `name`.

    Raises `InputError` for an unknown name (with the nearest known one) and for a model that is
    registered but cannot be imported or does not keep the contract.
    """
    known = model_names()
    if name not in known:
        near = did_you_mean(name, known)
        text = f"is not known{_NEW}; {near}".removesuffix("; ")
        raise InputError("model", name, text, "`workbench models` lists all")
    offer = _offer(name)
    if offer.kind is None:
        text = f"cannot be used: {offer.problem}"
        raise InputError("model", name, text, "see `workbench doctor`")
    return offer.kind


def make_model(name: str, options: Mapping[str, Any] | None = None) -> Model:
    """A model with its options set.

    Raises `InputError` for an unknown name, an unknown option or a value it does not allow.
    """
    model: Model = with_options(model_kind(name), options or {})
    return model


def _offer(name: str) -> Offer:
    points = [point for point in offered(GROUP) if point.name == name]
    provider = ", ".join(sorted({p.dist.name if p.dist else "unknown" for p in points}))
    return Offer(name, provider, *_load(name, points))


def _load(name: str, points: list[EntryPoint]) -> tuple[type[Any] | None, str]:
    if len(points) > 1:
        targets = " and ".join(sorted(point.value for point in points))
        return None, f"several distributions provide it: {targets}"
    try:
        kind = points[0].load()
    except (Exception, SystemExit) as error:  # a third-party import may fail in any way
        return None, f"{type(error).__name__} on import: {error}"
    missing = [item for item in _DECLARED if not hasattr(kind, item)]
    if not isinstance(kind, type) or not dataclasses.is_dataclass(kind):
        return None, f"{points[0].value} is not a dataclass"
    if missing:
        return None, f"{points[0].value} declares no {', '.join(missing)}"
    if kind.name != name:  # type: ignore[attr-defined]
        return None, f"{points[0].value} calls itself {kind.name!r}"  # type: ignore[attr-defined]
    return kind, ""
