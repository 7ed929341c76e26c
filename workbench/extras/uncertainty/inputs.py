"""A scenario whose numbers may be distributions, and the scenarios of its samples.

Samples are points of a scrambled Sobol sequence (Owen scrambling, scipy), taken by index, so that
any part of a sample is the same whoever draws it. A Gaussian copula correlates the inputs.
"""

import tomllib
import warnings
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w
from scipy.special import ndtri
from scipy.stats import qmc

from workbench.base.arrays import Array
from workbench.base.datafiles import open_input
from workbench.base.errors import InputError
from workbench.base.fields import DISTRIBUTION
from workbench.extras.uncertainty.distributions import (
    Distribution,
    distribution_of,
    is_distribution,
)
from workbench.scenarios import Scenario, scenario_from
from workbench.scenarios.files import LARGEST_FILE, apply_override
from workbench.scenarios.varied import Path_, Varied, put

CORRELATION = "correlation"


@dataclass(frozen=True)
class UncertainScenario:
    """Tables of a scenario file with their uncertain inputs.

    `tables`, with the median in place of each distribution; `inputs`, keys of the uncertain numbers
    with their distributions; `factor` (inputs, inputs), of the correlation of their normal scores;
    `text`, all that as TOML.
    """

    tables: Mapping[str, Any]
    inputs: Mapping[Path_, Distribution]
    factor: Array
    text: str

    @property
    def names(self) -> list[str]:
        """Keys of the uncertain inputs, as ``--set`` writes them."""
        return [".".join(map(str, path)) for path in self.inputs]

    @property
    def base(self) -> Scenario:
        """The scenario at the medians of all inputs."""
        return scenario_from(self.tables)

    @property
    def independent(self) -> bool:
        """Whether no two inputs are correlated."""
        return bool(np.array_equal(self.factor, np.eye(len(self.inputs))))

    def normal_scores(self, count: int, seed: tuple[int, ...], first: int = 0) -> Array:
        """Independent standard normal scores (count, inputs) of points `first`, first + 1, ..."""
        return sobol_scores(len(self.inputs), count, seed, first)

    def values(self, scores: Array) -> dict[Path_, Array]:
        """Values of each input at independent normal scores (samples, inputs)."""
        correlated = scores @ self.factor.T
        columns = zip(self.inputs.items(), correlated.T, strict=True)
        return {path: distribution.values(column) for (path, distribution), column in columns}

    def scenarios(self, scores: Array) -> Iterator[Scenario | InputError]:
        """The scenario of every sample, or why its values are none."""
        varied = self.varied(scores)
        for row in range(len(varied)):
            try:
                yield varied[row]
            except InputError as error:
                yield error

    def varied(self, scores: Array) -> Varied:
        """The scenarios of all samples, each built when it is asked for."""
        return Varied(self.tables, self.values(scores))


def sobol_scores(dimension: int, count: int, seed: tuple[int, ...], first: int = 0) -> Array:
    """Standard normal scores (count, dimension) of points of a scrambled Sobol sequence."""
    sobol = qmc.Sobol(dimension, rng=np.random.default_rng(seed))
    if first:
        sobol.fast_forward(first)
    with warnings.catch_warnings():  # of counts that are no power of two: parts of a sequence
        warnings.simplefilter("ignore", UserWarning)
        points = sobol.random(count)
    return np.asarray(ndtri(np.clip(points, 1e-12, 1.0 - 1e-12)))


def load_uncertain(path: Path | str, overrides: Iterable[str] = ()) -> UncertainScenario:
    """Read a scenario file in which numbers may be distributions.

    Raises `InputError` naming the key, its value and what is allowed.
    """
    with open_input(Path(path), "scenario file", LARGEST_FILE) as stream:
        content = stream.read()
    try:
        text = content.decode()
    except ValueError as error:
        raise InputError("scenario file", str(path), "is not a UTF-8 text file") from error
    return uncertain_from_text(text, overrides, str(path))


def uncertain_from_text(
    text: str, overrides: Iterable[str] = (), name: str = "scenario"
) -> UncertainScenario:
    """An uncertain scenario from TOML text, with ``key.path=value`` overrides."""
    try:
        tables = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError("scenario file", name, f"is not valid TOML: {error}") from error
    for override in overrides:
        apply_override(tables, override)
    return uncertain_from(tables)


def uncertain_from(tables: dict[str, Any]) -> UncertainScenario:
    """An uncertain scenario from nested tables as TOML gives them. Raises `InputError`."""
    text = tomli_w.dumps(tables)
    pairs = tables.pop(CORRELATION, {})
    inputs = {
        path: distribution_of(".".join(map(str, path)), table)
        for path, table in _distributions(tables, ())
    }
    plain: Any = tables
    for path, distribution in inputs.items():
        plain = put(plain, path, distribution.middle)
    try:
        scenario_from(plain)  # refuses what is wrong before any work
    except InputError as error:
        if error.advice == DISTRIBUTION and isinstance(error.value, Mapping):
            distribution_of(error.field, error.value)  # says which laws are known
        raise
    names = [".".join(map(str, path)) for path in inputs]
    return UncertainScenario(plain, inputs, _factor(names, pairs), text)


def _distributions(value: Any, path: Path_) -> Iterator[tuple[Path_, Mapping[str, Any]]]:
    if is_distribution(value):
        yield path, value
    elif isinstance(value, Mapping):
        for key, each in value.items():
            yield from _distributions(each, (*path, key))
    elif isinstance(value, list):
        for number, each in enumerate(value):
            yield from _distributions(each, (*path, number))


def _factor(names: list[str], pairs: Any) -> Array:
    """Cholesky factor of the correlation of the normal scores."""
    correlation = np.eye(len(names))
    listed = pairs.get("pairs", []) if isinstance(pairs, Mapping) else None
    if not isinstance(listed, list) or (pairs and set(pairs) != {"pairs"}):
        text = 'must hold pairs = [["KEY", "KEY", 0.5], ...]'
        raise InputError(CORRELATION, pairs, text)
    for entry in listed:
        three = isinstance(entry, list) and len(entry) == 3
        if not three or entry[0] not in names or entry[1] not in names or entry[0] == entry[1]:
            text = f"must be two of the uncertain keys ({', '.join(names)}) and a number"
            raise InputError(f"{CORRELATION}.pairs", entry, text)
        value = entry[2]
        if isinstance(value, bool) or not isinstance(value, int | float) or not -1 < value < 1:
            raise InputError(f"{CORRELATION}.pairs", entry, "must be a number between -1 and 1")
        i, j = names.index(entry[0]), names.index(entry[1])
        correlation[i, j] = correlation[j, i] = value
    try:
        return np.asarray(np.linalg.cholesky(correlation))
    except np.linalg.LinAlgError as error:
        text = "contradict each other: no such correlations exist together"
        raise InputError(f"{CORRELATION}.pairs", listed, text) from error
