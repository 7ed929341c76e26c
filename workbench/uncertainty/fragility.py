"""Probability that an impact exceeds a limit, over velocity, with a band that holds all errors.

Samples of the inputs get a critical velocity by a reduced model; a few of them, spread over its
distribution, get one by the reference; the ratio corrects all. The numerical error of the reference
is an interval that all its runs share: it is added to the band and not averaged.
See docs/theory/fragility.md.
"""

import json
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from math import ceil, exp, isfinite, log
from multiprocessing import get_context
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from scipy.stats import t as student
from threadpoolctl import threadpool_limits

from workbench.arrays import Array
from workbench.errors import InputError, WorkbenchError
from workbench.evidence.error_model import PEAK
from workbench.models.base import on_one_mesh
from workbench.responses import Outcome, outcome_of
from workbench.responses.uncertainty import WIDTHS
from workbench.uncertainty.critical_velocity import (
    ALREADY,
    BEYOND,
    BY_COLLAPSE,
    COARSE,
    NO_ANSWER,
    Asked,
    Limit,
    Ratio,
    Root,
    critical_velocity,
    ratio_to_reference,
)
from workbench.uncertainty.fragility_curve import (
    LEVEL,
    Curve,
    Population,
    fragility_curve,
    place_references,
)
from workbench.uncertainty.inputs import UncertainScenario

SCRAMBLES = 16
LOOKS = (12, 18, 27, 40, 60)  # references; the last look ends it
MESH_SAMPLES, MESH_LEVELS = 4, 5  # at one refinement more than the other references
LARGEST_SHARE = 0.2  # of references that fail, or of samples without an answer


class Target(NamedTuple):
    """Half-width that is good enough: in probability, or relative in velocity."""

    probability: float = 0.02
    velocity: float = 0.01


@dataclass(frozen=True)
class Setup:
    """What is asked: uncertain scenario, models, limit, ends of the range of velocities (m/s).

    `samples` in all; `seed`; `references` (None: looks at the band decide, up to `seconds`).
    """

    uncertain: UncertainScenario
    reduced: Any
    reference: Any
    limit: Limit
    ends: tuple[float, float]
    samples: int = 8192
    seed: int = 1
    references: int | None = None
    seconds: float = 600.0
    target: Target = Target()
    jobs: int = 1

    @property
    def search(self) -> tuple[float, float]:
        """Ln velocities between which critical velocities are searched."""
        return log(self.ends[0] / BEYOND), log(self.ends[1] * BEYOND)


@dataclass(frozen=True)
class Fragility:
    """The curve, what it rests on, and what each part of its band costs.

    `curve` with the numerical part, `curve_without` it, `reduced_curve` (points,) of the reduced
    model at the same velocities; `numerical`, half-width in ln velocity that all references share,
    None where it is not known; `shift`, ln velocity, from their mesh to a finer one; `places`
    (samples), `velocities` (ln, of the reduced model) and `ratios` of the references; `kinds`, how many samples of each kind; `seconds` by part.
    """

    setup: Setup
    curve: Curve
    curve_without: Curve
    reduced_curve: Array
    numerical: float | None
    shift: float
    places: Sequence[int]
    velocities: Sequence[float]
    ratios: Sequence[Ratio]
    kinds: dict[str, int]
    runs: dict[str, int]
    seconds: dict[str, float]
    looked: bool

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
    if not setup.uncertain.inputs:
        text = "has no uncertain input"
        advice = 'write a distribution, such as yield_stress = { jcss = "S355" }'
        raise InputError("scenario", setup.uncertain.base.name, text, advice)
    started = perf_counter()
    with _pool(setup.jobs) as run:
        scores, scrambles = _scores(setup)
        roots = _survey(setup, scores, run)
        population, kinds = _population(roots, scores, scrambles)
        seconds = {"samples": perf_counter() - started}
        say(f"{len(roots)} samples in {seconds['samples']:.1f} s")
        random = np.random.default_rng((setup.seed, SCRAMBLES))
        offset = float(random.random())
        counts = LOOKS if setup.references is None else (setup.references,)
        places = place_references(population, counts[-1], offset)
        ratios: list[Ratio] = []
        numerical: float | None = None
        shift, mesh_runs = 0.0, 0
        spent = 0.0
        for count in counts:
            begun = perf_counter()
            new = places[len(ratios) : count]
            ratios += run(partial(_ratio, setup), _tasks(new, scores, population))
            spent += perf_counter() - begun
            if count == counts[0]:
                begun = perf_counter()
                numerical, shift, mesh_runs = _mesh(setup, places, ratios, scores, population, run)
                seconds["meshes"] = perf_counter() - begun
            looked = len(counts) > 1
            without = _curve(setup, population, places, ratios, shift, looked)
            curve = without if numerical is None else without.widened(numerical)
            say(f"{count} references: half-width {curve.half_width:.3f} in probability")
            enough = _is_narrow(curve, setup.target)
            if enough or perf_counter() - started > setup.seconds:
                break
        seconds["references"] = spent
    ordered = np.sort(population.log_velocity[np.isfinite(population.log_velocity)])
    reduced = np.searchsorted(ordered, curve.log_velocity, side="right") / len(scores)
    runs = {
        "samples": sum(root.runs for root in roots),
        "references": sum(ratio.runs for ratio in ratios),
        "meshes": mesh_runs,
    }
    used = [int(place) for place in places[: len(ratios)]]
    reached = [float(population.log_velocity[place]) for place in used]
    return Fragility(
        *(setup, curve, without, reduced, numerical, shift, used, reached, ratios, kinds, runs),
        {**seconds, "all": perf_counter() - started},
        looked,
    )


def _scores(setup: Setup) -> tuple[Array, Array]:
    """Normal scores (samples, inputs) of independent scrambles, and the number of its scramble."""
    each = setup.samples // SCRAMBLES
    parts = [setup.uncertain.normal_scores(each, (setup.seed, k)) for k in range(SCRAMBLES)]
    return np.vstack(parts), np.repeat(np.arange(SCRAMBLES), each)


def _survey(setup: Setup, scores: Array, run: "Run") -> list[Root]:
    """Critical velocities of all samples by the reduced model."""
    chunk = max(1, ceil(len(scores) / (4 * setup.jobs)))
    parts = [scores[k : k + chunk] for k in range(0, len(scores), chunk)]
    return [root for part in run(partial(_roots, setup), parts) for root in part]


def _roots(setup: Setup, scores: Array) -> list[Root]:
    """Critical velocities of some samples; each search starts from the one before."""
    start, roots = log(setup.ends[0] * setup.ends[1]) / 2.0, []
    for scenario in setup.uncertain.scenarios(scores):
        asked = Asked(setup.reduced, scenario)
        root = critical_velocity(asked.peak_at, setup.limit, start, setup.search)
        roots.append(root)
        if isfinite(root.log_velocity):
            start = root.log_velocity
    return roots


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


def _tasks(places: Array, scores: Array, population: Population) -> list[tuple[Array, float]]:
    return [(scores[p : p + 1], float(population.log_velocity[p])) for p in places]


def _ratio(setup: Setup, task: tuple[Array, float]) -> Ratio:
    """The ratio at one sample."""
    scenario = next(setup.uncertain.scenarios(task[0]))
    reference = Asked(on_one_mesh(setup.reference), scenario)
    reduced = Asked(setup.reduced, scenario)
    return ratio_to_reference(reference, reduced, setup.limit, task[1], setup.search)


def _mesh(
    setup: Setup,
    places: Array,
    ratios: list[Ratio],
    scores: Array,
    population: Population,
    run: "Run",
) -> tuple[float | None, float, int]:
    """Half-width and shift in ln velocity from the mesh of the references to a finer one."""
    if not hasattr(setup.reference, "refinement"):
        return None, 0.0, 0
    answered = [k for k, ratio in enumerate(ratios) if isfinite(ratio.value)]
    chosen = answered[:: max(1, len(answered) // MESH_SAMPLES)][:MESH_SAMPLES]
    tasks = [
        (scores[places[k] : places[k] + 1], float(population.log_velocity[places[k]]), ratios[k])
        for k in chosen
    ]
    parts = [part for part in run(partial(_finer, setup), tasks) if part is not None]
    if len(parts) < 2:
        return None, 0.0, len(tasks)
    shifts, widths = np.array(parts).T
    spread = student.ppf(0.5 + LEVEL / 2.0, len(parts) - 1) * shifts.std(ddof=1)
    half = float(widths.max() + spread / np.sqrt(len(parts)))
    return half, float(shifts.mean()), len(tasks)


def _finer(setup: Setup, task: tuple[Array, float, Ratio]) -> tuple[float, float] | None:
    """Shift of one critical velocity by a finer mesh, and the half-width that is left, in ln."""
    scores, log_velocity, ratio = task
    scenario = next(setup.uncertain.scenarios(scores))
    x = log_velocity + ratio.value
    model = setup.reference
    fine = replace(model, refinement=model.refinement + 1, levels=MESH_LEVELS)
    if not isfinite(setup.limit.displacement) or not isfinite(ratio.slope):
        asked = Asked(on_one_mesh(fine), scenario)
        root = critical_velocity(asked.peak_at, setup.limit, x, setup.search, COARSE)
        moved = root.log_velocity - x
        return (moved, abs(moved) + COARSE) if isfinite(moved) else None
    struck: Any = scenario
    struck = struck.at_velocity(exp(x))
    response = fine.simulate(struck)
    coarse = Asked(on_one_mesh(model), scenario).peak_at(x)
    if outcome_of(response) is not Outcome.OK or not isfinite(coarse):
        return None
    peak, width = float(response[PEAK]), json.loads(response.attrs[WIDTHS]).get(PEAK)
    if width is None:
        return None
    return -log(peak / coarse) / ratio.slope, width / peak / ratio.slope


def _curve(
    setup: Setup,
    population: Population,
    places: Array,
    ratios: list[Ratio],
    shift: float,
    looked: bool,
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
    return fragility_curve(
        population, places[answered], values, random, looked=looked, failed=failed
    )


Run = Callable[[Callable[[Any], Any], Sequence[Any]], list[Any]]


class _pool:  # noqa: N801 - used as a function
    """Run a function over tasks in processes of one thread each; in this one if `jobs` is 1."""

    def __init__(self, jobs: int) -> None:
        self.jobs = jobs
        self.pool: ProcessPoolExecutor | None = None

    def __enter__(self) -> Run:
        if self.jobs == 1:
            return lambda function, tasks: [function(task) for task in tasks]
        context = get_context("spawn")
        self.pool = ProcessPoolExecutor(self.jobs, context, initializer=_one_thread)
        pool = self.pool
        return lambda function, tasks: list(pool.map(function, tasks))

    def __exit__(self, *_: object) -> None:
        if self.pool is not None:
            self.pool.shutdown(cancel_futures=True)


def _one_thread() -> None:
    threadpool_limits(1)
