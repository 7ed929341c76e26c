"""Cases of the impact bench: scenario, reference, and the seal of half of the references.

A folder of ``data/bench`` holds the scenario and ``case.toml``: who computed the reference, with
what, and the answer or its commitment, the SHA-256 of salt, name of the case and text of the
answer. Salt and sealed answers stand in the key of the organiser, outside of the repository.
"""

import hashlib
import json
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from workbench.base.datafiles import data_directory, open_input
from workbench.base.errors import InputError
from workbench.scenarios import Scenario, load_scenario, scenario_hash

CASE, SCENARIO = "case.toml", "scenario.toml"
LARGEST_KEY = 200_000  # bytes
SURVIVES, FALLS = "ok", "collapse"


class ReferenceAnswer(NamedTuple):
    """The answer of a reference: `outcome`, ``ok`` or ``collapse``; `peak` displacement in m.

    `half_width` of its numerical interval, by grid convergence, which ASME V&V 20 takes as 95 %.
    """

    outcome: str
    peak: float = 0.0
    half_width: float = 0.0

    @property
    def table(self) -> dict[str, Any]:
        """The answer as ``case.toml`` holds it."""
        numbers = {"peak_displacement": self.peak, "half_width": self.half_width}
        return {"outcome": self.outcome} | (numbers if self.outcome == SURVIVES else {})

    @property
    def text(self) -> str:
        """The canonical text, of which the seal is made."""
        return json.dumps(self.table, sort_keys=True)


def reference_of(table: Mapping[str, Any]) -> ReferenceAnswer:
    """The answer in a table as `ReferenceAnswer.table` gives it."""
    numbers = (table.get(name, 0.0) for name in ("peak_displacement", "half_width"))
    return ReferenceAnswer(table["outcome"], *numbers)


def commitment(salt: str, name: str, text: str) -> str:
    """The seal of a reference: nobody without the `salt` can tell or change its `text`."""
    return hashlib.sha256(f"{salt}\n{name}\n{text}".encode()).hexdigest()


@dataclass(frozen=True)
class BenchCase:
    """A case: `name` and `group`, the `scenario`, and in words the `model` of the reference.

    `reference` is None where it is sealed: then `seal` is its commitment.
    """

    name: str
    group: str
    scenario: Scenario
    model: str
    reference: ReferenceAnswer | None
    seal: str


def bench_directory() -> Path:
    """The folder of the cases that come with the workbench."""
    return data_directory() / "bench"


def load_bench(directory: Path | None = None) -> tuple[BenchCase, ...]:
    """All cases of a folder, by name. Raises `InputError` for one that is not what it was."""
    files = sorted((directory or bench_directory()).glob(f"*/{CASE}"))
    return tuple(_case(file) for file in files)


def _case(file: Path) -> BenchCase:
    place = file.with_name(SCENARIO)
    content, scenario = tomllib.loads(file.read_text(encoding="utf-8")), load_scenario(place)
    if content["scenario"] != scenario_hash(scenario):
        reason = "is not the scenario that the reference answered"
        raise InputError("bench", str(place), reason, "restore the file")
    solver, answer = content["model"], content["reference"]
    options = ", ".join(f"{name} = {value}" for name, value in solver["options"].items())
    model = f"{solver['name']} {solver['version']}" + f" ({options})" * bool(options)
    seal = answer.get("commitment", "")
    reference = None if seal else reference_of(answer)
    return BenchCase(file.parent.name, content["group"], scenario, model, reference, seal)


def opened(cases: Iterable[BenchCase], key: Path | None = None) -> dict[str, ReferenceAnswer]:
    """References by case: those in the open, with the `key` of the organiser the sealed ones too.

    Raises `InputError` for a key that is none, that is of another seal, or whose answers are not
    those that were sealed.
    """
    salt, texts = ("", {}) if key is None else key_of(key)
    known = {}
    for case in cases:
        if case.reference is not None:
            known[case.name] = case.reference
        elif key is not None:
            text = texts.get(case.name, "")
            if commitment(salt, case.name, text) != case.seal:
                reason = f"does not open {case.name}: another seal, or the answer was changed"
                advice = "take the key of this state of the cases"
                raise InputError("--key", str(key), reason, advice)
            known[case.name] = reference_of(json.loads(text))
    return known


def key_of(file: Path) -> tuple[str, dict[str, str]]:
    """The salt in a key, and the texts of sealed answers by case. Raises `InputError`."""
    with open_input(file, "--key", LARGEST_KEY) as stream:
        content = stream.read()
    try:
        given = json.loads(content)
        return str(given["salt"]), {str(n): str(text) for n, text in given["sealed"].items()}
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        reason = "is no key of the bench: JSON with salt and sealed"
        raise InputError("--key", str(file), reason) from error
