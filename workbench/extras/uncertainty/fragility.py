"""Probability that an impact exceeds a limit, over velocity, with a band that holds all errors.

Samples of the inputs get a critical velocity by a reduced model; a few of them, spread over its
distribution, get one by the reference; the ratio corrects all. The numerical error of the reference
is an interval that all its runs share: it is added to the band and not averaged.
See docs/theory/fragility.md.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from math import isfinite, log, nan
from time import perf_counter
from typing import Self

import numpy as np

from workbench.base.arrays import Array, Indices
from workbench.base.errors import InputError, WorkbenchError
from workbench.extras.uncertainty.critical_velocity import (
    ALREADY,
    BEYOND,
    BY_COLLAPSE,
    CLOSE,
    NO_ANSWER,
    STRIDE,
    DisplacementLimit,
    Ratio,
    Root,
    grows,
    slopes_at,
)
from workbench.extras.uncertainty.fragility_curve import (
    Curve,
    Population,
    fragility_curve,
    place_references,
)
from workbench.extras.uncertainty.sample_runs import (
    Finer,
    Sampled,
    Setup,
    Target,
    on_finer_mesh,
    ratio_at,
)
from workbench.study.batches import Processes, Run

SCRAMBLES, PILOT = 16, 64  # independent sequences of samples; samples before all others
LOOKS = (12, 18, 27, 40, 60)  # references; the last look ends it
MESH_SAMPLES = 4  # run on finer meshes than the other references
CHECKED = 100  # samples whose peak must grow with the velocity
FINEST_MESH = 2  # refinements more than those
MOST_REFERENCES = 2000
LARGEST_SHARE = 0.2  # of references that fail, or of samples without an answer


@dataclass(frozen=True)
class Samples:
    """All samples by the reduced model, and where references stand among them.

    `roots` and `population`; `kinds`, how many of each kind; `sampled`, to ask them again; `places`
    of as many references as there may be; `turning`, see `Fragility`.
    """

    roots: Sequence[Root]
    population: Population
    kinds: dict[str, int]
    sampled: Sampled
    places: Indices
    turning: int

    @classmethod
    def of(cls, setup: Setup, run: Run) -> "Samples":
        """Samples of a setup. Raises as `survey`."""
        roots, population, kinds = survey(setup, run)
        sampled = Sampled.of(setup, population.inputs, run)
        offset = float(np.random.default_rng((setup.seed, SCRAMBLES)).random())
        most = setup.references or LOOKS[-1]
        places = place_references(population, most, offset)
        checked = place_references(population, CHECKED, offset)
        y = population.log_velocity[checked]
        turning = int((~grows(sampled.peaks_at, checked, y, setup.limit)).sum())
        return cls(roots, population, kinds, sampled, places, turning)

    def task_of(self, number: int, ratio: Ratio) -> tuple[Array, float, Ratio]:
        """Scores, ln critical velocity and ratio of a reference, as `on_finer_mesh` takes them."""
        place = self.places[number]
        scores = self.population.inputs[place : place + 1]
        return scores, float(self.population.log_velocity[place]), ratio

    def tasks(
        self, limit: DisplacementLimit, numbers: Sequence[int]
    ) -> list[tuple[Array, float, float]]:
        """Scores, ln critical velocity and slope at some of the references, as `ratio_at` takes."""
        places = self.places[list(numbers)]
        y = self.population.log_velocity[places]
        slopes = slopes_at(self.sampled.peaks_at, places, y, limit)
        scores = self.population.inputs[places][:, None]
        return list(zip(scores, y.tolist(), slopes.tolist(), strict=True))


@dataclass(frozen=True)
class Fragility:
    """The curve, what it rests on, and what each part of its band costs.

    `curve` with the numerical part, `curve_without` it, `reduced_curve` (points,) of the reduced
    model at the same velocities; `population`, the samples; `places` (samples) and `ratios` of the
    references, and some of them on a `finer` mesh; `kinds`, how many samples of each kind; `runs`
    and `seconds` by part; `looked`, whether the band decided how many references; `turning`, of
    `CHECKED` samples those whose peak falls below the limit again 5 % above the critical velocity.
    """

    setup: Setup
    curve: Curve
    curve_without: Curve
    reduced_curve: Array
    finer: Finer
    population: Population
    places: Sequence[int]
    ratios: Sequence[Ratio]
    kinds: dict[str, int]
    runs: dict[str, int]
    turning: int
    seconds: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def of(cls, setup: Setup, samples: Samples, ratios: Sequence[Ratio], finer: Finer) -> Self:
        """Fragility from samples and references. Raises `WorkbenchError` if too many failed."""
        population = samples.population
        numerical, shift = finer.error
        without = _curve(setup, population, samples.places, ratios, shift)
        curve = without if numerical is None else without.widened(numerical)
        ordered = np.sort(population.log_velocity[np.isfinite(population.log_velocity)])
        counts = np.searchsorted(ordered, curve.log_velocity, side="right")
        runs = {
            "samples": sum(root.runs for root in samples.roots),
            "references": sum(ratio.runs for ratio in ratios),
            "meshes": finer.refined * len(finer.runs),
        }
        used = [int(place) for place in samples.places[: len(ratios)]]
        reduced = counts / len(population.log_velocity)
        return cls(
            *(setup, curve, without, reduced, finer, population, used, ratios),
            *(samples.kinds, runs, samples.turning),
        )

    @property
    def looked(self) -> bool:
        """Whether looks at the band decided how many references there are."""
        return self.setup.references is None

    @property
    def numerical(self) -> float | None:
        """Half-width in ln velocity that all references share; None where it is not known."""
        return self.finer.error[0]

    @property
    def velocities(self) -> list[float]:
        """Ln critical velocities of the reduced model at the places of the references."""
        return [float(self.population.log_velocity[place]) for place in self.places]

    @property
    def failed(self) -> int:
        """References without an answer."""
        return sum(not isfinite(ratio.value) for ratio in self.ratios)

    @property
    def reaches_target(self) -> bool:
        """Whether the band is as narrow as was asked, by either measure."""
        return _is_narrow(self.curve, self.setup.target) and self.numerical is not None

    def at(self, velocity: float) -> tuple[float, float, float]:
        """Low, median and high probability at a velocity (m/s)."""
        u, curve = log(velocity), self.curve
        edges = (curve.low, curve.median, curve.high)
        low, middle, high = (float(np.interp(u, curve.log_velocity, edge)) for edge in edges)
        return low, middle, high


def _is_narrow(curve: Curve, target: Target) -> bool:
    in_velocity = curve.velocity_half_width
    return curve.half_width <= target.probability or in_velocity <= target.velocity


def fragility(setup: Setup, say: Callable[[str], None] = lambda text: None) -> Fragility:
    """Run the samples and as many references as the band needs.

    `say` gets a line as work goes on. Raises `InputError` for a setup that cannot be answered,
    `WorkbenchError` where too many samples or references have no answer.
    """
    started = perf_counter()
    seconds = {"samples": 0.0, "references": 0.0, "meshes": 0.0}
    with Processes(setup.jobs) as run:
        samples = Samples.of(setup, run)
        seconds["samples"] = perf_counter() - started
        say(f"{len(samples.roots)} samples in {seconds['samples']:.1f} s")
        tasks = samples.tasks(setup.limit, range(len(samples.places)))
        ratios: list[Ratio] = []
        finer, dominates, look = Finer(), False, 0
        counts = LOOKS if setup.references is None else (setup.references,)
        while True:
            begun = perf_counter()
            ratios += run(partial(ratio_at, setup), tasks[len(ratios) : counts[look]])
            seconds["references"] += perf_counter() - begun
            if setup.has_meshes and (not finer.refined or dominates):
                begun = perf_counter()
                finer = _on_finer_meshes(setup, finer.refined + 1, samples, ratios, run)
                seconds["meshes"] += perf_counter() - begun
            result = Fragility.of(setup, samples, ratios, finer)
            curve, without = result.curve, result.curve_without
            say(
                f"{len(ratios)} references, meshes {2**finer.refined} times finer: half-width "
                f"{curve.half_width:.3f} in probability, {without.half_width:.3f} without meshes"
            )
            # what is the larger part is worth the next runs
            large = curve.half_width > 2.0 * without.half_width
            dominates = result.numerical is not None and large and finer.refined < FINEST_MESH
            last = look == len(counts) - 1
            if _is_narrow(curve, setup.target) or perf_counter() - started > setup.seconds:
                break
            if not dominates and (last or (large and finer.refined == FINEST_MESH)):
                break
            look += not dominates
    return replace(result, seconds={**seconds, "all": perf_counter() - started})


def _scores(setup: Setup) -> tuple[Array, Array]:
    """Normal scores (samples, inputs) of independent scrambles, and the number of its scramble."""
    each = setup.samples // SCRAMBLES
    parts = [setup.uncertain.normal_scores(each, (setup.seed, k)) for k in range(SCRAMBLES)]
    return np.vstack(parts), np.repeat(np.arange(SCRAMBLES), each)


def _refuse_far_limits(setup: Setup, roots: list[Root]) -> None:
    """Refuse a limit that hardly any sample reaches, before all are run."""
    if not any(isfinite(root.log_velocity) for root in roots):
        kinds = ", ".join(sorted({root.kind for root in roots}))
        text = (
            f"is answered by none of {len(roots)} samples up to {BEYOND:g} times its end: {kinds}"
        )
        raise InputError("--limit", str(setup.limit), text, "take another limit, range or model")


def survey(setup: Setup, run: Run) -> tuple[list[Root], Population, dict[str, int]]:
    """Critical velocities of all samples by the reduced model, and how many of each kind.

    The first of them say where all others start. Raises `InputError` and `WorkbenchError` as
    `fragility`.
    """
    if not setup.uncertain.inputs:
        text = "has no uncertain input"
        advice = 'write a distribution, such as yield_stress = { jcss = "S355" }'
        raise InputError("scenario", setup.uncertain.base.name, text, advice)
    scores, scrambles = _scores(setup)
    middle = np.full(PILOT, log(setup.ends[0] * setup.ends[1]) / 2.0)
    pilot = Sampled.of(setup, scores[:PILOT], run).roots(setup, middle)
    _refuse_far_limits(setup, pilot)
    roots = Sampled.of(setup, scores, run).roots(setup, *_starts(pilot, scores))
    return roots, *_population(roots, scores, scrambles)


def _starts(pilot: list[Root], scores: Array) -> tuple[Array, float]:
    """Ln velocities (samples,) near the critical ones, linear in the scores, and how near.

    By the first samples; their mean where too few of those have a critical velocity.
    """
    known = np.array([root.log_velocity for root in pilot])
    finite = np.isfinite(known)
    columns = np.column_stack([np.ones(len(scores)), scores])
    given = columns[: len(pilot)][finite]
    freedom = len(given) - given.shape[1]
    if freedom < given.shape[1]:
        return np.full(len(scores), known[finite].mean()), STRIDE
    fit = np.linalg.lstsq(given, known[finite])[0]
    scatter = np.sqrt(((known[finite] - given @ fit) ** 2).sum() / freedom)
    return columns @ fit, max(2.0 * float(scatter), CLOSE)


def _population(
    roots: list[Root], scores: Array, scrambles: Array
) -> tuple[Population, dict[str, int]]:
    """Samples with their classes: what collapses before it reaches a displacement has its own."""
    kinds = {kind: sum(root.kind == kind for root in roots) for kind in {r.kind for r in roots}}
    silent = kinds.get(NO_ANSWER, 0)
    if silent > LARGEST_SHARE * len(roots):
        text = f"{silent} of {len(roots)} samples have no answer by the reduced model"
        raise WorkbenchError(f"{text}; take another model, or a narrower range of velocities")
    by_collapse = np.array([root.kind == BY_COLLAPSE for root in roots])
    apart = 0 < by_collapse.sum() < len(roots)
    u = np.array([root.log_velocity for root in roots])
    classes = by_collapse.astype(int) if apart else np.zeros(len(roots), dtype=int)
    if apart and by_collapse.mean() > 0.5:
        classes = 1 - classes
    if apart and min(classes.mean(), 1.0 - classes.mean()) < 0.01:
        classes = np.zeros(len(roots), dtype=int)
    finite = np.isfinite(u)
    if finite.sum() < 1000:
        text = f"{int(finite.sum())} of {len(u)} samples reach the limit: no curve to correct"
        raise WorkbenchError(f"{text}; take another limit or range of velocities")
    if (u[finite] == u[finite].min()).sum() > 1 and kinds.get(ALREADY, 0) > 0.01 * len(u):
        text = "is exceeded below a third of the lowest velocity already"
        raise InputError("--over", kinds[ALREADY], text, "start the range lower")
    return Population(u, scores, classes, scrambles), kinds


def refined_ones(ratios: Sequence[Ratio]) -> list[int]:
    """Numbers of the references that are run on a finer mesh."""
    answered = [k for k, ratio in enumerate(ratios) if isfinite(ratio.value)]
    return answered[:: max(1, len(answered) // MESH_SAMPLES)][:MESH_SAMPLES]


def _on_finer_meshes(
    setup: Setup, refined: int, samples: Samples, ratios: list[Ratio], run: Run
) -> Finer:
    """A few of the references so far on a mesh that is refined further."""
    tasks = [samples.task_of(k, ratios[k]) for k in refined_ones(ratios)]
    parts = run(partial(on_finer_mesh, setup, refined), tasks)
    return Finer(refined, len(ratios), tuple(part or (nan, nan) for part in parts))


def _curve(
    setup: Setup,
    population: Population,
    places: Indices,
    ratios: Sequence[Ratio],
    shift: float,
) -> Curve:
    """The corrected curve by the references so far."""
    answered = [k for k, ratio in enumerate(ratios) if isfinite(ratio.value)]
    failed = len(ratios) - len(answered)
    if failed > LARGEST_SHARE * len(ratios):
        reasons = {ratio.reason for ratio in ratios if not isfinite(ratio.value)}
        text = f"{failed} of {len(ratios)} references have no answer ({', '.join(sorted(reasons))})"
        raise WorkbenchError(f"{text}; take another reference, see `workbench advise`")
    values = np.array([ratios[k].value for k in answered]) + shift
    random = np.random.default_rng((setup.seed, SCRAMBLES, len(ratios)))
    looked = setup.references is None
    return fragility_curve(
        population, places[answered], values, random, looked=looked, failed=failed
    )
