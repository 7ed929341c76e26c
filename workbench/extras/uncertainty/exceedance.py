"""A fragility curve as the answer of a model to a scenario, so that studies can hold several.

The reduced model answers alone, or corrected by runs of a reference. What the response carries is
named by `curve.` (over velocity), `velocity.` (at a probability), `band.` (its parts), `runs.` and
`governs.` (shares of the inputs).
"""

from dataclasses import dataclass
from math import exp, inf, isfinite
from typing import Any, ClassVar

import numpy as np

from workbench.base.arrays import Array
from workbench.base.errors import InputError, OutOfDomainError, WorkbenchError
from workbench.base.fields import Flag, Number, Text, checked
from workbench.extras.uncertainty.critical_velocity import DisplacementLimit
from workbench.extras.uncertainty.fragility import fragility, survey
from workbench.extras.uncertainty.fragility_curve import PROBABILITIES, Curve, reduced_curve
from workbench.extras.uncertainty.inputs import uncertain_from_text
from workbench.extras.uncertainty.sample_runs import Setup
from workbench.extras.uncertainty.scenario import UncertainImpact
from workbench.models.base import Answering, make_model
from workbench.responses import Finding, Response, build_response, set_attributes
from workbench.study.batches import Processes

MEDIAN = "velocity.at_50"


@dataclass(frozen=True)
class Exceedance(Answering):
    """Probability over velocity that an impact exceeds a limit, with a band of 90 %."""

    reduced: str = checked(Text(), "four-dof", help="model of the samples")
    reference: str = checked(Text(shortest=0), "", help="that corrects it; empty: none")
    samples: int = checked(Number(1024, 1 << 20, integer=True), 8192)
    references: int = checked(
        Number(0, 2000, integer=True), 0, help="0: as many as the band needs, 12 to 60"
    )
    meshes: bool = checked(Flag(), True, help="whether some references are refined")
    seed: int = checked(Number(0, 2**32 - 1, integer=True), 1)

    name: ClassVar[str] = "exceedance"
    version: ClassVar[int] = 1
    answers: ClassVar[tuple[str, ...]] = (UncertainImpact.KIND,)
    assumptions: ClassVar[tuple[str, ...]] = (
        "The peak grows with the velocity: every sample has one critical velocity.",
        "A reference is the truth but for the error of its mesh; a reduced model alone, as it is.",
    )
    sources: ClassVar[tuple[str, ...]] = ()

    def domain(self, scenario: UncertainImpact) -> list[Finding]:
        """Findings in advance: none; samples outside a domain are found one by one."""
        return []

    def _solve(self, scenario: UncertainImpact) -> Response:
        uncertain = uncertain_from_text(scenario.text)
        limit = DisplacementLimit(inf if scenario.displacement is None else scenario.displacement)
        setup = Setup(
            uncertain,
            make_model(self.reduced),
            make_model(self.reference) if self.reference else None,
            limit,
            (scenario.low, scenario.high),
            self.samples,
            self.seed,
            references=self.references or None,
            meshes=self.meshes,
        )
        try:
            if self.reference:
                result = fragility(setup)
                parts: dict[str, Any] = {"references": result.curve.correction.max()}
                if result.numerical is not None:
                    unwidened = result.curve_without.half_width
                    parts["meshes"] = result.curve.half_width - unwidened
                values, scores = result.population.log_velocity, result.population.inputs
                return _response(result.curve, uncertain.names, values, scores, parts, result.runs)
            with Processes(1) as run:
                roots, population, _ = survey(setup, run)
        except InputError:
            raise
        except WorkbenchError as error:
            raise OutOfDomainError(str(error)) from error
        curve = reduced_curve(population, np.random.default_rng((self.seed, 0)))
        values, runs = population.log_velocity, {"samples": sum(root.runs for root in roots)}
        return _response(curve, uncertain.names, values, population.inputs, {}, runs)


def shares(log_velocity: Array, scores: Array) -> Array:
    """Share of each input (inputs,) in the variance of the critical velocity.

    Squared correlation of its ln with the independent normal score of the input: its first Sobol
    index where the relation is linear. `scores` (samples, inputs).
    """
    finite = np.isfinite(log_velocity)
    together = np.column_stack([log_velocity[finite], scores[finite]])
    correlation = np.asarray(np.corrcoef(together, rowvar=False))
    return np.asarray(correlation[0, 1:] ** 2)


def _response(
    curve: Curve,
    names: list[str],
    log_velocity: Array,
    scores: Array,
    parts: dict[str, Any],
    runs: dict[str, int],
) -> Response:
    """Response of a curve, the inputs that govern it and its costs, as in a store."""
    response = build_response({})
    widths = {}

    def put(name: str, dims: tuple[str, ...], value: Any, units: str, meaning: str) -> None:
        response[name] = (dims, value, {"units": units, "long_name": meaning})

    put("curve.velocity", ("curve",), np.exp(curve.log_velocity), "m/s", "impact velocity")
    for edge in ("median", "low", "high", "low_all", "high_all"):
        put(f"curve.{edge}", ("curve",), getattr(curve, edge), "1", "probability of exceedance")
    for probability in PROBABILITIES:
        low, middle, high = map(exp, curve.velocity(probability))
        if all(map(isfinite, (low, middle, high))):
            name = f"velocity.at_{100.0 * probability:.0f}"
            put(name, (), middle, "m/s", f"velocity at a probability of {probability:g}")
            widths[name] = (high - low) / 2.0
    parts = {"all": curve.half_width, "samples": curve.sampling.max(), **parts}
    for name, width in parts.items():
        put(f"band.{name}", (), float(width), "1", "largest half-width in probability")
    for name, count in runs.items():
        put(f"runs.{name}", (), count, "1", "runs of a model")
    put("governs.input", ("input",), names, "1", "uncertain input")
    given = shares(log_velocity, scores)
    put("governs.share", ("input",), given, "1", "share in the variance of ln critical velocity")
    set_attributes(response, sampling_uncertainty=widths)
    return response
