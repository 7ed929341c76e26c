"""Cells of a study: one scenario answered by one model, and the key that identifies the answer."""

import fnmatch
import hashlib
import json
import pickle
from dataclasses import dataclass
from typing import Any

from workbench.errors import InputError
from workbench.models.base import Model, on_one_mesh, options_of
from workbench.responses import provenance
from workbench.responses.variables import TABLE_DIGEST
from workbench.scenarios import Scenario, scenario_hash
from workbench.study.definition import Study
from workbench.study.store import Ingredients

STORE_FORMAT = 3


@dataclass(frozen=True)
class Cell:
    """A case answered by a label.

    Arguments: `case` and `label`, names in the study; `scenario` and `model`; `ingredients`,
    everything that the answer depends on; `key`, their hash, under which the answer is stored.
    """

    case: str
    label: str
    scenario: Scenario
    model: Model
    ingredients: Ingredients
    key: str

    @property
    def name(self) -> str:
        """``case/label``, as patterns and messages use it."""
        return f"{self.case}/{self.label}"

    @property
    def version(self) -> int:
        """Version of the model that answers, or has answered."""
        return int(self.ingredients["model_version"])


def ingredients_of(scenario: Scenario, model: Model) -> dict[str, Any]:
    """Everything that an answer depends on: scenario, model, options, data, versions.

    A model whose answer rests on data files says so by an attribute `data_digest`, a kind of
    scenario whose histories all models read in another way than once, by `READING`.
    Raises `InputError` for options that JSON cannot hold.
    """
    options = options_of(model)
    try:
        options = json.loads(json.dumps(options, sort_keys=True, allow_nan=False))
    except (TypeError, ValueError) as error:
        said = f"of {model.name} cannot be stored: {error}"
        raise InputError("model options", options, said) from error
    reading = getattr(scenario, "READING", 0)
    return {
        **({"reading": reading} if reading else {}),
        "scenario": scenario_hash(scenario),
        "model": model.name,
        "model_version": model.version,
        "options": options,
        "data": str(getattr(model, "data_digest", "")),
        "package": provenance()["workbench"],
        "store_format": STORE_FORMAT,
        "variables": TABLE_DIGEST,
    }


def key_of(ingredients: Ingredients) -> str:
    """SHA-256 of the ingredients in canonical form, as 20 hexadecimal digits."""
    text = json.dumps(ingredients, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:20]


def cells_of(study: Study) -> list[Cell]:
    """All cells of a study, each checked so that no run begins that cannot end.

    Raises `InputError` for models that do not keep the contract, for options that cannot be stored
    or models that cannot be sent to a worker process and for a study without cells.
    """
    for label, model in study.models.items():
        field = f"study.models[{label!r}]"
        if isinstance(model, type) or not isinstance(model, Model):
            text, advice = "must be a model object", "see workbench.models.base.Model"
            raise InputError(field, model, text, advice)
        try:
            pickle.dumps(model)
        except Exception as error:
            text = f"cannot be sent to a worker process: {error}"
            advice = "define its class at the top of a module"
            raise InputError(field, type(model).__name__, text, advice) from error
    cells = []
    asked = [(case, label, study.models[label]) for case, label in study.cells()]
    for case, label in study.varied_cells():
        asked.append((case, label, on_one_mesh(study.models[label])))
    for case, label, model in asked:
        ingredients = ingredients_of(case.scenario, model)
        cells.append(Cell(case.name, label, case.scenario, model, ingredients, key_of(ingredients)))
    if not cells:
        raise InputError("study", study.name, "has no cell: no model answers any of its cases")
    return cells


def select(cells: list[Cell], pattern: str | None) -> list[Cell]:
    """Cells whose case, label or ``case/label`` matches a shell pattern (None: all).

    Raises `InputError` if nothing matches.
    """
    if pattern is None:
        return cells
    chosen = [
        cell
        for cell in cells
        if any(fnmatch.fnmatchcase(name, pattern) for name in (cell.case, cell.label, cell.name))
    ]
    if not chosen:
        shown = ", ".join(dict.fromkeys([c.case for c in cells] + [c.label for c in cells]))
        raise InputError("--only", pattern, f"matches no cell; cases and labels are {shown}")
    return chosen
