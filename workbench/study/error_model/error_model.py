"""The error of any answer, through one model whose error was measured: the anchor.

ln(truth / answer) = ln(anchor / answer) + ln(truth / anchor). The first term is exact and costs a
run of the anchor; the second has nothing to do with the model that was asked. It was measured on
drawn scenarios (`workbench data measure`) and is taken by order statistics from those of the same
cell. Derivation and numbers: docs/theory/error-model.md.

**Second part.** Advice on an answer: the error to expect of it, and the model to take where that is
warned of.

One order for all scenarios: the anchor of the error model, then the references. A model is named
only where it is inside its own domain, and only above the model that warns, so that no advice goes
in a circle. Where the error was measured it stands in place of what a domain says about physics.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from math import inf, isinf, isnan, log, nan, radians
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from workbench.base.arrays import Array
from workbench.base.errors import InputError, OutOfDomainError, WorkbenchError
from workbench.mechanics.frames.members import SPREAD
from workbench.mechanics.frames.runs import LARGEST_SHEAR_STRAIN
from workbench.models.base import Model, findings_before, is_oblique, make_model, options_of
from workbench.models.domain import FACE, log_factors, undrawn
from workbench.models.resistance import column_curve
from workbench.models.seven_dof import SevenDof
from workbench.models.strain_rate import feels_rate, steel_of, with_strain_rate
from workbench.responses import (
    PEAK,
    RESIDUAL,
    ExpectedError,
    Finding,
    Outcome,
    Response,
    attribute,
    finding,
    findings_of,
    outcome_of,
    refusal_message,
    set_attributes,
    set_findings,
    survives,
)
from workbench.scenarios import (
    ColumnImpact,
    FrameImpact,
    FrameScenario,
    MemberPulse,
    frame_scenario,
)
from workbench.steel.sections import ISection
from workbench.study.error_model.error_table import (
    ANCHOR,
    DEMAND,
    FAR,
    FINEST,
    MARGIN,
    REFERENCE,
    ErrorTable,
    ends_of,
    features,
    table_of,
)

BEYOND = 0.10  # an error of the peak that matters
OFF, STICKING = radians(5.0), 1e3  # angle off the web; friction of a face that holds
LEAST_MORE = 1.0  # percent of the peak, about which a sentence is made
TWICE = 2.0  # times as far goes what is about to collapse, if it does not
BOUND = 1e9  # m, above all displacements
HALVINGS = 5  # of the velocities between which that begins
HANGS = "hangs-on"  # subject
OPEN_END = "the upper end is not measured so close to collapse"


class TruthRatio(NamedTuple):
    """Sorted `values` of ln(truth / anchor) in the `cell` of a scenario with such `features`.

    Infinite ones are collapses. Empty where nothing is known, for the `reason`. Of all such
    structures `fallen` is the share that collapses.
    """

    values: Array
    cell: str = ""
    reason: str = ""
    features: Mapping[str, float] = MappingProxyType({})
    fallen: float | None = None


def expected_error(scenario: Any, response: Response) -> ExpectedError:
    """The error to expect of an answer to a scenario, of any model, by one run of the anchor.

    The anchor itself is not run again. Raises `InputError` if it is not installed.
    """
    name, peak = response.attrs["model"], reached(response).peak
    table = table_of(scenario)
    by_anchor = table is not None and _is_anchor(response, table.anchor)
    error = _error(scenario, name, peak, peak if by_anchor else None)
    return (
        error if error.near_collapse else replace(error, residual=residual_ends(scenario, response))
    )


def anchor_error(scenario: Any) -> ExpectedError:
    """The error to expect of the anchor itself, as `expected_error`."""
    table = table_of(scenario)
    peak = nan if table is None or truth_ratio(scenario).reason else anchor_peak(scenario)
    error = _error(scenario, table.anchor if table else ANCHOR, peak, peak)
    return error if error.near_collapse else replace(error, residual=residual_ends(scenario))


def _error(scenario: Any, name: str, answer: float, anchor: float | None) -> ExpectedError:
    """Error of the size of the peak `answer` (m); the `anchor` has this peak (None: run it)."""
    table = table_of(scenario)
    if table is None:
        return ExpectedError(ANCHOR, reason=f"errors of {scenario.KIND} were not measured")
    ratio = truth_ratio(scenario)
    known = ExpectedError(table.anchor, reason=ratio.reason)
    if ratio.reason:
        return known
    anchor, answer = abs(anchor_peak(scenario) if anchor is None else anchor), abs(answer)
    if isnan(answer) or isnan(anchor):
        whose = "the answer" if isnan(answer) else "the anchor"
        return replace(known, reason=f"{whose} has no peak displacement")
    known = replace(known, cell=ratio.cell, count=len(ratio.values), collapse=ratio.fallen)
    known = replace(known, near_collapse=bool(ratio.features[MARGIN]))
    if isinf(answer) or isinf(anchor):
        reason = "the anchor collapses" if isinf(anchor) else "the anchor survives"
        if ratio.fallen is None:
            return replace(known, reason=f"{reason}, close to collapse, which was not measured")
        chance = 1.0 - ratio.fallen if isinf(answer) else ratio.fallen
        unsafe = 0.0 if isinf(answer) else chance
        return replace(known, chance=chance, unsafe=unsafe, reason=reason)
    values = ratio.values + log(anchor / answer)
    if name in (table.reference, FINEST) and not _is_beside(scenario):
        values = table.doubts(ratio.features) if name == table.reference else values[:0]
        known = replace(known, collapse=None)  # that is what it answers itself
    if not len(values):
        return replace(known, reason="nothing finer has measured it")
    errors = np.exp(-values[::-1]) - 1.0
    low, high = ends_of(len(errors))
    middle, least, most = float(np.median(errors)), float(errors[low]), float(errors[high])
    chance, unsafe = map(float, chances_beyond(errors))
    known = replace(known, high=most, chance=chance, unsafe=unsafe)
    if ratio.fallen is None:
        return replace(known, reason=OPEN_END)
    return replace(known, expected=middle, low=least)


def chances_beyond(errors: Array) -> tuple[Any, Any]:
    """Chances of an error beyond 10 %, either way and below, from `errors` (..., n): (...)."""
    off = np.abs(errors) > BEYOND, errors < -BEYOND
    either, below = ((each.sum(axis=-1) + 0.5) / (errors.shape[-1] + 1.0) for each in off)
    return either, below


@lru_cache(maxsize=256)  # every model of a study asks for the same scenario
def truth_ratio(scenario: Any) -> TruthRatio:
    """Ratios ln(truth / anchor) known of a scenario before it is answered.

    Of a scenario that has a table; with what the finest reference says of the reference, and shells
    of a hit beside the shear centre.
    """
    striker = getattr(scenario, "striker", None)
    if striker is not None and striker.crushes and not isinstance(scenario, ColumnImpact):
        return TruthRatio(np.empty(0), reason="errors of frames were measured with rigid strikers")
    frame = frame_scenario(scenario).frame
    if is_oblique(scenario) and not isinstance(scenario, ColumnImpact):
        return TruthRatio(np.empty(0), reason="errors of frames were measured in their plane")
    if getattr(striker, "friction", 0.0):
        return TruthRatio(np.empty(0), reason="errors were measured without friction")
    if not isinstance(scenario, ColumnImpact) and any(
        m.axis == "weak" and m.section != m.section.about("strong") for m in frame.members
    ):
        reason = "errors were measured about the strong axis"
        return TruthRatio(np.empty(0), reason=reason)
    if getattr(scenario, "acceleration", 0.0) or any(frame.gravity) or frame.line_loads.any():
        reason = "errors were measured without gravity and line loads"
        return TruthRatio(np.empty(0), reason=reason)
    if isinstance(scenario, FrameImpact):
        attached = scenario.frame.node(scenario.striker.node).mass
    else:
        attached = scenario.column.attached_mass
    if attached > 0.0:
        reason = "errors were measured without a mass attached at the impact point"
        return TruthRatio(np.empty(0), reason=reason)
    table, steel = _table(scenario), steel_of(scenario)
    if steel is not None and steel.hardening_modulus is not None:
        return TruthRatio(np.empty(0), reason="errors were measured without hardening")
    if feels_rate(scenario) and isinstance(scenario, MemberPulse):
        reason = f"errors of {scenario.KIND} were measured without strain rate"
        return TruthRatio(np.empty(0), reason=reason)
    try:
        values = table.features(scenario)
    except OutOfDomainError as error:
        return TruthRatio(np.empty(0), reason=f"not measured here: {error}")
    reason = table.unknown(values)
    if not reason and _is_beside(scenario) and undrawn(scenario):
        reason = "errors were measured in hits through the shear centre"
    if reason:
        return TruthRatio(np.empty(0), reason=reason)
    margin = margin_of(scenario)
    values = {**values, MARGIN: margin}
    stands = not isinf(anchor_peak(scenario))
    if margin and stands and not table.knows(margin):
        far = table.log_ratios({**values, MARGIN: 0.0})
        return TruthRatio(far, table.cell(values), features=values)
    ratios = table.log_ratios(values)
    finite = widened(ratios[np.isfinite(ratios)], table.doubts(values))
    if _is_beside(scenario):
        finite = widened(finite, log_factors(scenario, FACE))
    ratios = np.concatenate([finite, ratios[np.isinf(ratios)]])
    fallen = table.collapses(not stands, values)
    return TruthRatio(ratios, table.cell(values), features=values, fallen=fallen)


def margin_of(scenario: Any) -> float:
    """Velocity, or force of a pulse, over the least one at which the anchor is about to collapse.

    There it collapses, hangs on bars that have turned far, or goes twice as far as it does here, if
    it comes to rest at all.
    0 where that is far away: above 1.25 of the velocity, or where it collapses at 0.8 of it.
    """

    def falls(factor: float) -> bool:
        there = _anchor(_scaled(scenario, factor))
        return there.hangs or not abs(there.peak) <= most  # nor does it come to rest

    here = _anchor(scenario)
    gone = here.hangs or isinf(here.peak)
    most = BOUND if gone else TWICE * abs(here.peak)
    low, high = (FAR, 1.0) if gone else (1.0, 1.0 / FAR)
    if isnan(here.peak) or (falls(low) if gone else not falls(high)):
        return 0.0
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if falls(middle) else (middle, high)
    return 1.0 / high


def _is_beside(scenario: Any) -> bool:
    """Whether a hit passes beside the shear centre, of which only shells know."""
    return bool(getattr(getattr(scenario, "striker", None), "eccentricity", 0.0))


def widened(values: Array, doubts: Array) -> Array:
    """Sorted log ratios (n,) to a reference that itself is off by some of `doubts` (m,), sorted.

    They move by its median, and both sides of their interval grow by its half-width, in quadrature.
    """
    if not len(doubts):
        return values
    (low, high), (least, most) = ends_of(len(values)), ends_of(len(doubts))
    middle, width = np.median(values), 0.5 * (doubts[most] - doubts[least])
    sides = np.where(values < middle, middle - values[low], values[high] - middle)
    grown: Array = (values - middle) * np.hypot(sides, width) / np.maximum(sides, 1e-9)
    return middle + np.median(doubts) + grown


def anchor_peak(scenario: Any) -> float:
    """Peak displacement of the anchor in m; infinite if it collapses, NaN if it has none."""
    return _anchor(scenario).peak


class Reached(NamedTuple):
    """Peak and residual displacement (m) of an answer; whether it `hangs` on turned bars."""

    peak: float
    residual: float
    hangs: bool = False


@lru_cache(maxsize=256)
def _anchor(scenario: Any) -> Reached:
    """Displacements of the anchor, NaN where it has none."""
    return reached(make_model(_table(scenario).anchor).simulate(scenario))


def _table(scenario: Any) -> ErrorTable:
    table = table_of(scenario)
    assert table is not None
    return table


def residual_ends(scenario: Any, response: Response | None = None) -> tuple[float, float] | None:
    """Ends (m) of 90 % for the true residual displacement; None where that is not known.

    The difference to that of the anchor was measured in parts of its peak. Where `response` is the
    answer of the anchor it is not run again.
    """
    table = table_of(scenario)
    if table is None or truth_ratio(scenario).reason or _is_beside(scenario):
        return None
    parts = table.residuals(truth_ratio(scenario).features)
    if not len(parts):
        return None
    if response is not None and _is_anchor(response, table.anchor):
        peak, residual, _ = reached(response)
    else:
        peak, residual, _ = _anchor(scenario)
    if isnan(residual):
        return None
    low, high = ends_of(len(parts))
    return residual + float(parts[low]) * peak, residual + float(parts[high]) * peak


def reached(response: Response) -> Reached:
    """Of a response: infinite and NaN at a collapse, NaN where not known."""
    alive = survives(response)
    if not alive:
        return Reached(nan if alive is None else inf, nan)
    peak, residual = (float(response.get(name, nan)) for name in (PEAK, RESIDUAL))
    hangs = any(each.subject == HANGS for each in findings_of(response))
    return Reached(peak if peak != 0.0 else nan, residual, hangs)


def _is_anchor(response: Response, anchor: str) -> bool:
    if response.attrs["model"] != anchor:
        return False
    return attribute(response, "options") == options_of(make_model(anchor))


def _scaled(scenario: Any, factor: float) -> Any:
    """The scenario at so many times its velocity or force."""
    if isinstance(scenario, MemberPulse):
        peak = factor * scenario.pulse.peak
        return replace(scenario, pulse=replace(scenario.pulse, peak=peak))
    return scenario.at_velocity(factor * scenario.striker.velocity)


ORDER = (ANCHOR, REFERENCE, FINEST)
IN_SPACE = ("superelement-space", "fiber-space")  # of frames that are hit off their plane
SPATIAL = (*IN_SPACE, "shell")  # of columns
RUBBED = ("seven-dof", *SPATIAL[1:])  # by a face with friction
REMAINING = ("residual_displacement", "displacement", "peak_displacement")
CLOSE, UNMEASURED = "close-to-collapse", "error-not-measured"  # subjects
NONE = "no model of more trust is inside its domain here"
_BECAUSE = {  # subjects of warnings that a measured error replaces, as its cause
    "buckling": "the axial load bends what is deflected",
    "shear": "webs yield in shear",
    "stub": "a segment is hardly longer than its section is high",
    "plates": "the strength given is not that of the plates",
    "small-rotations": "bars turn far",
    "simplification": "the resistance is simplified",
    "striker": "the striker is soft here",
    "hard-impact": "the structure is soft here",
    "catenary": "members are pulled",
    "short-pulse": "the pulse is much shorter than the period",
    "interaction": "members are pressed",
    "light-striker": "the striker is light",
    "hit-mass": "elements share much mass with the striker",
    "near-collapse": "the frame nearly falls",
    "ends": "ends of the column move",
    "sway": "ends of the column sway",
    "fall": "the frame may fall",
    "dead-moments": "dead loads bend the column",
    "restraint": "the frame gives way to the spring",
    "direct-shear": "webs yield in direct shear",
}


def is_judged(model: Model) -> bool:
    """Whether the error of a model is told by the anchor.

    A reference says ``judged: ClassVar[bool] = False``, and so does what holds numbers of tests,
    or a striker of its own: their warnings are all that is said of them.
    """
    return bool(getattr(model, "judged", True))


def advise(model: Model, scenario: Any, response: Response | None = None) -> list[Finding]:
    """Findings about a model in a scenario, each with the model to take instead.

    Those of its domain before it answers, of the anchor also of its error; with a `response` those
    of that, and of its error.
    """
    if response is None:
        findings, table = _domain_findings(model, scenario), table_of(scenario)
        if table is not None and model.name == table.anchor:
            findings = judged(model, scenario, anchor_error(scenario), findings)
        return with_remedies(model, scenario, findings)
    return _advised(model, scenario, response)[0]


def advised(model: Model, scenario: Any, response: Response) -> Response:
    """Put advice and the error to expect on a response, and return it."""
    findings, error = _advised(model, scenario, response)
    set_findings(response, findings)
    set_attributes(response, error=asdict(error))
    if any(each.refusal for each in findings):
        response.attrs["message"] = refusal_message(findings)
    return response


def _advised(
    model: Model, scenario: Any, response: Response
) -> tuple[list[Finding], ExpectedError]:
    findings = findings_of(response)
    error = ExpectedError(ANCHOR, reason=f"{model.name} is not judged by the anchor")
    if is_judged(model) or model.name == REFERENCE:
        error = expected_error(scenario, response)
    if survives(response) is not None:
        findings = judged(model, scenario, error, findings)
    findings = [*findings, *creeping(scenario, response)]
    return with_remedies(model, scenario, findings), error


def judged(
    model: Model, scenario: Any, error: ExpectedError, findings: Iterable[Finding]
) -> list[Finding]:
    """Findings about an answer, its `error` in place of those that it replaces.

    Models that are not judged keep all of theirs.
    """
    kept = list(findings)
    if not is_judged(model) or table_of(scenario) is None:
        return kept
    if error.chance is None:
        return [*kept, finding(UNMEASURED, reason=error.reason)]
    replaced = [each for each in kept if not each.refusal and each.subject in _BECAUSE]
    causes = dict.fromkeys(_BECAUSE[each.subject] for each in replaced)
    return [*(each for each in kept if each not in replaced), *_about(error, ", ".join(causes))]


def _about(error: ExpectedError, causes: str) -> Iterator[Finding]:
    """Warnings of an error, and the `causes` that the domain of the model names."""
    if error.warns:
        parts = ("at-least",) * (error.reason == OPEN_END) + ("because",) * bool(causes)
        chances: Any = {n: 100.0 * (getattr(error, n) or 0.0) for n in ("chance", "unsafe")}
        name = "error" if error.high is not None else "error-of-collapse"
        yield finding(name, error.chance, parts=parts, error=error, causes=causes, **chances)
    if error.near_collapse:
        yield finding(CLOSE, anchor=error.anchor)


def with_remedies(model: Any, scenario: Any, findings: Iterable[Finding]) -> list[Finding]:
    """The findings of a model, those that another model mends with the name of that."""
    completed, findings = [], list(findings)
    sheared = any("shear" in each.subject for each in findings)
    for each in findings:
        if each.instead is not None:
            names = better(model.name, scenario, sheared)
            each = replace(each, remedy=NONE, instead=names)
            each = each.taking(names) if names else each
            if FINEST in names:
                each = replace(each, remedy=f"{each.remedy}, which takes minutes")
        completed.append(each)
    return completed


@dataclass(frozen=True, slots=True)
class ModelChoice:
    """The model to take for a scenario, `because`, and of the anchor the `error` to expect.

    `reason` says both.
    """

    model: str
    because: str
    error: ExpectedError
    measured: bool = True

    @property
    def reason(self) -> str:
        """Why it is taken, with the error where that was measured for such scenarios."""
        of = "" if self.model == self.error.anchor else f"{self.error.anchor}: "
        return f"{self.because}: {of}{self.error}" if self.measured else self.because


def choose(scenario: Any) -> ModelChoice:
    """The anchor, where it is warned of the beam that judges; the anchor too if no model will do.

    The solid takes minutes: it is a remedy, no choice. Off the plane of bending see `order_of`.
    """
    error = anchor_error(scenario)
    order = order_of(scenario)
    model, because = ANCHOR, "which comes nearest: no quick model is inside its domain"
    if order != ORDER:
        model, because = order[0], "which answers hits from any side"
        if _is_beside(scenario):
            model, because = order[2], "the only model of hits beside the shear centre"
    elif is_inside(ANCHOR, scenario):
        because = "the anchor of the error model"
    elif is_inside(REFERENCE, scenario):
        model, because = REFERENCE, f"a reference, as {ANCHOR} is warned of here"
    return ModelChoice(model, because, error, table_of(scenario) is not None)


def quick_reference(scenario: Any) -> str:
    """The quickest reference that is inside its domain; empty without one.

    The solid takes minutes, and is none; nor is there one off the plane of bending.
    """
    plane = order_of(scenario) == ORDER
    return REFERENCE if plane and is_inside(REFERENCE, scenario) else ""


def order_of(scenario: Any) -> tuple[str, ...]:
    """The quickest model of a scenario, its quick reference and its finest one."""
    if isinstance(scenario, ColumnImpact):
        spatial = RUBBED if scenario.striker.friction else SPATIAL
        return spatial if is_oblique(scenario) or _is_beside(scenario) else ORDER
    return IN_SPACE if isinstance(scenario, FrameScenario) and is_oblique(scenario) else ORDER


def better(name: str, scenario: Any, sheared: bool = False) -> tuple[str, ...]:
    """The first model above this one in the order that is inside its domain; empty without.

    Off the plane of bending shells alone let webs yield in shear, where a warning says that they
    are `sheared`.
    """
    order = order_of(scenario)
    above = order[order.index(name) + 1 :] if name in order else order
    above = tuple(set(above) & set(order[2:])) if sheared and order != ORDER else above
    return next(((each,) for each in above if is_inside(each, scenario)), ())


def no_reference(scenario: Any) -> str:
    """Why `quick_reference` names none, in one sentence."""
    order = order_of(scenario)
    if order != ORDER:
        return f"no quick reference off the plane of bending: {order[1]} takes minutes"
    return f"no reference inside its domain: {REFERENCE} ({'; '.join(doubts(REFERENCE, scenario))})"


def is_inside(name: str, scenario: Any) -> bool:
    """Whether an installed model answers a scenario inside its domain, and is not warned of."""
    return not doubts(name, scenario)


@lru_cache(maxsize=256)
def doubts(name: str, scenario: Any) -> tuple[str, ...]:
    """Why a model is not inside its domain in a scenario; empty where it is."""
    model = _default_model(name)
    if model is None:
        return ("it is not installed",)
    if scenario.KIND not in model.answers:
        return (f"it does not answer {scenario.KIND}",)
    try:
        findings, table = _domain_findings(model, scenario), table_of(scenario)
        if table is not None and name == table.anchor:
            error = anchor_error(scenario)
            if error.chance is None:
                return (error.reason,)
            findings = judged(model, scenario, error, findings)
    except WorkbenchError as refused:  # it would refuse as it answers
        return (str(refused),)
    return tuple(each.text for each in findings if each.outside or each.refusal)


def _domain_findings(model: Model, scenario: Any) -> list[Finding]:
    """Findings known before a model answers, and whether the reference would shear too far.

    A striker that crushes takes the energy that would do it. Of a push also whether the anchor
    leaves out much yielding between hinges.
    """
    findings = findings_before(model, scenario, with_strain_rate(model, scenario)[2])
    if model.name == ANCHOR and scenario.STATIC:
        findings += _spread(scenario)
    if (
        model.name != REFERENCE
        or not isinstance(scenario, ColumnImpact)
        or scenario.striker.crushes
    ):
        return findings
    hit, largest = features(scenario), LARGEST_SHEAR_STRAIN
    if hit[DEMAND] > 1.0 and hit["turned"] > largest:
        findings.append(finding("shears-far", hit["turned"], largest=largest))
    return findings


@lru_cache(maxsize=64)
def _spread(scenario: Any) -> tuple[Finding, ...]:
    """Findings on yielding between hinges, by a run of the anchor."""
    response = make_model(ANCHOR).simulate(scenario)
    return tuple(each for each in findings_of(response) if each.subject == SPREAD)


@lru_cache(maxsize=len(ORDER))
def _default_model(name: str) -> Model | None:
    """The installed model of this name with default options; looking it up takes milliseconds."""
    try:
        return make_model(name)
    except InputError:
        return None


def off_line(scenario: object, response: Response) -> list[Finding]:
    """Return what `seven-dof` says beside an answer to a hit on an I section.

    Of a hit along the web: how much farther one goes that comes 5 degrees off it. Of an oblique one
    whose face slides: by how much a face that holds the column sideways would lower the peak. Two
    runs of `seven-dof`, for single answers: those of studies and sweeps do without.
    """
    if not isinstance(scenario, ColumnImpact) or outcome_of(response) is not Outcome.OK:
        return []
    return list(_off_line(scenario))


@lru_cache(maxsize=256)
def _off_line(scenario: ColumnImpact) -> tuple[Finding, ...]:
    striker = scenario.striker
    if not isinstance(scenario.column.section.shape, ISection) or striker.friction > 0.0:
        return ()
    oblique = striker.angle > 0.0
    others = (
        striker,
        striker.changed(friction=STICKING) if oblique else striker.changed(angle=OFF),
    )
    space = SevenDof()
    straight, other = (space.peak_of(scenario.changed(striker=each)) for each in others)
    if straight is None or other is None or not 0.0 < straight < inf:
        return ()
    if isinf(other):
        return (finding("off-web-collapse"),)
    more = 100.0 * (other / straight - 1.0)
    name, change = ("sticking-face", -more) if oblique else ("off-web", more)
    return (finding(name, change),) if change > LEAST_MORE else ()


def creeping(scenario: object, response: Response) -> list[Finding]:
    """Return the finding of a column that stays where its static strength carries no axial load.

    Overstress holds a column up only as long as it moves: behind the displacement (m) at which its
    analytic resistance with the static yield stress is lost it creeps on, slowly at first, beyond
    the end of a record. Compared is the displacement that remains, or, where that is not known, the
    last one or the peak.
    """
    if not isinstance(scenario, ColumnImpact) or outcome_of(response) is not Outcome.OK:
        return []
    column = scenario.column
    if column.steel.rate is None or column.axial_load == 0.0:
        return []
    known = (name for name in REMAINING if name in response)
    remaining = float(response[next(known)].values.reshape(-1)[-1])
    static = replace(column, steel=replace(column.steel, rate=None))
    try:
        limit = column_curve(static, None, "analytic").lost_at
    except OutOfDomainError:
        return []
    return [finding("creep", remaining, limit=limit)] if remaining > limit else []
