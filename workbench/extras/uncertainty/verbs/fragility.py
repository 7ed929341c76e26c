"""`workbench fragility`: probability of exceedance over velocity; `workbench verify`: its check."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from math import exp, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from workbench.base.errors import InputError
from workbench.cli.output import (
    PICTURES,
    Answer,
    Jobs,
    ScenarioFile,
    Settings,
    option,
    processes,
    verb,
    writable,
)
from workbench.report.page.markdown import Block, Cell, Table, paragraph

if TYPE_CHECKING:
    from workbench.extras.uncertainty.fragility import Fragility

VELOCITY = "striker.velocity"
_LARGEST = 5_000_000  # bytes of a certificate
CURVES, MOST_VALUES = "fragility-curves", 8  # kind of several certificates; curves told apart
_SHOWN = 7  # velocities in the table of the curve


@verb
def fragility(
    scenario: ScenarioFile,
    over: str = option("Range of impact velocities, in m/s.", ..., "striker.velocity=LOW:HIGH"),
    limit: str = option("What must not be exceeded.", ..., "displacement=METRES|collapse"),
    model: str | None = option(
        "Reduced model of the samples.  [default: four-dof, with panels where webs yield, "
        "seven-dof of oblique hits]",
        None,
    ),
    reference: str | None = option(
        "Reference that corrects it.  [default: fiber-reissner, fiber-shear where webs yield, "
        "fiber-space of oblique hits]",
        None,
    ),
    samples: int = option("Samples of the inputs: 16 times a power of 2, at least 2048.", 8192),
    references: int | None = option(
        "Number of references, 8 or more.  [default: as many as the band needs, 12 to 60]", None
    ),
    half_width: float = option("Half-width in probability that is good enough.", 0.02),
    seconds: float = option("Budget; no further look at the band after it.", 600.0),
    seed: int = option("Seed of the samples.", 1),
    jobs: Jobs = None,
    settings: Settings = None,
    given: str | None = option(
        "Values of a second number: a curve for each.", None, "striker.mass=1000,1500", "--and"
    ),
    plot: str | None = option("Draw the curve.", None, "OUT.png|svg|pdf"),
    out: str | None = option("Write the certificate.", None, "CERTIFICATE.json"),
) -> Answer:
    """Probability that an impact exceeds a limit.

    Numbers of the scenario may be distributions, such as yield_stress = { jcss = "S355" }. The
    band of 90 % over velocity holds the errors of samples, model and reference. Exit status
    0 if it is as narrow as was asked (or within 1 % in velocity), 1 if it is not, 2 for bad input.
    """
    from workbench.base.fields import Number
    from workbench.extras.uncertainty.certificate import certificate
    from workbench.extras.uncertainty.critical_ratio import FEWEST_REFERENCES
    from workbench.extras.uncertainty.critical_velocity import limit_of
    from workbench.extras.uncertainty.fragility import MOST_REFERENCES, SCRAMBLES
    from workbench.extras.uncertainty.fragility import fragility as run
    from workbench.extras.uncertainty.inputs import load_uncertain
    from workbench.extras.uncertainty.sample_runs import Setup, Target
    from workbench.models.base import make_model
    from workbench.study.store import write_atomically

    target = writable("--out", out, "json", inputs=[scenario])
    picture = writable("--plot", plot, *PICTURES, inputs=[scenario])
    ends = _range(over)
    each = samples // SCRAMBLES
    if not 128 <= each <= 1 << 16 or samples % SCRAMBLES or each & (each - 1):
        text = f"must be {SCRAMBLES} times a power of 2, from 2048 to {SCRAMBLES << 16}"
        raise InputError("--samples", samples, text, "such as 8192")
    if references is not None:
        rule = Number(FEWEST_REFERENCES, MOST_REFERENCES, integer=True)
        rule.check("--references", references)
    Number(1e-3, 0.5).check("--half-width", half_width)
    Number(1.0, 1e6).check("--seconds", seconds)
    Number(0, 2**32 - 1, integer=True).check("--seed", seed)
    count = processes(jobs)
    exceeded = limit_of(limit)
    key, values = _second(given)
    setups = {}
    for value in values:
        uncertain = load_uncertain(scenario, [*(settings or []), *([value] if key else [])])
        if VELOCITY in uncertain.names:
            text = "is what the probability is given over: it cannot be uncertain itself"
            raise InputError(VELOCITY, "a distribution", text, "write a number")
        pair = pair_of(struck(uncertain.base).at_velocity(ends[1]), model, reference)
        reduced, governing = (make_model(name) for name in pair)
        setups[value] = Setup(
            *(uncertain, reduced, governing, exceeded, ends, samples, seed, references, seconds),
            Target(half_width),
            count,
        )
    results = {}
    for value, asked in setups.items():  # none begins before all are known to be right
        say = partial(_say, f"{value}: " if key else "")
        results[value] = run(asked, say)
    contents = {value: certificate(result) for value, result in results.items()}
    whole = [{"given": value, **content} for value, content in contents.items()]
    content = {"kind": CURVES, "curves": whole} if key else contents[""]
    if target is not None:
        write_atomically(target, json.dumps(content, indent=1, allow_nan=False).encode())
    if picture is not None:
        from workbench.extras.uncertainty.figures import fragility_chart
        from workbench.report.gallery import save

        save(fragility_chart(results), picture)
    files = {"certificate": target, "picture": picture}
    narrow = all(result.reaches_target for result in results.values())
    blocks = _by_value(key, results) if key else _blocks(results[""])
    return Answer(content, blocks, int(not narrow), files)


@verb
def verify(
    certificate: Annotated[str, typer.Argument(metavar="CERTIFICATE.json", help="Certificate.")],
    seed: int = option("Seed of the choice of references.", 1),
    jobs: Jobs = None,
) -> Answer:
    """Compute a certificate again, and compare all of it.

    From its inputs and seeds: samples, curve and band; a random tenth of the references, and one on
    a finer mesh, are run again. Exit status 0 if all agrees, 1 if something does not, 2 for bad
    input.
    """
    from workbench.base.datafiles import open_input
    from workbench.base.fields import Number
    from workbench.extras.uncertainty import certificate as certificates

    Number(0, 2**32 - 1, integer=True).check("--seed", seed)
    count = processes(jobs)
    with open_input(Path(certificate), "certificate", _LARGEST) as stream:
        try:
            content = json.loads(stream.read())
        except (ValueError, RecursionError) as error:
            raise InputError("certificate", certificate, "is not JSON") from error
    if not isinstance(content, Mapping):
        raise InputError("certificate", certificate, "is no JSON object")
    several = content.get("curves") if content.get("kind") == CURVES else [content]
    if not isinstance(several, list) or not all(isinstance(each, Mapping) for each in several):
        raise InputError("certificate.curves", None, "must be a list of certificates")
    verified = [certificates.verify(one, seed, count) for one in several]
    checked = [each for one in verified for each in one.runs]
    differs = list(dict.fromkeys(place for one in verified for place in one.differs))
    columns = {
        "sample": "sample",
        "mesh": "mesh",
        "ln ratio stated": lambda row: _ratio(row.stated),
        "run again": lambda row: _ratio(row.again),
        "agrees": lambda row: "yes" if row.agrees else "no",
    }
    holds = all(one.holds for one in verified)
    agree = sum(each.agrees for each in checked)
    rest = f"{', '.join(differs)} do not follow" if differs else "all else follows"
    text = f"{agree} of {len(checked)} runs agree within 0.05 %; {rest} from the inputs and seeds: "
    text += "the certificate holds." if holds else "the certificate does not hold."
    rows = [each._asdict() for each in checked]
    blocks = (paragraph(text), Table.of("verified", "", columns, checked))
    content = {"holds": holds, "references": rows, "differs": differs}
    return Answer(content, blocks, int(not holds))


def _ratio(value: float | None) -> Cell | str:
    return "no answer" if value is None else Cell(f"{value:+.5f}", value)


def _say(head: str, text: str) -> None:
    print(f"workbench: {head}{text}", file=sys.stderr, flush=True)


def _second(text: str | None) -> tuple[str, list[str]]:
    """Key of the second number and its settings, ``KEY=VALUE`` each; one empty one without it."""
    if text is None:
        return "", [""]
    key, equals, listed = text.partition("=")
    values = list(dict.fromkeys(each.strip() for each in listed.split(",")))
    if not key.strip() or not equals or not all(values) or len(values) > MOST_VALUES:
        text_ = f"must be KEY=A,B,... with at most {MOST_VALUES} values"
        raise InputError("--and", text, text_, "such as striker.mass=750,1500,3000")
    if key.strip() == VELOCITY:
        raise InputError("--and", text, f"is what --over varies; name another key than {VELOCITY}")
    return key.strip(), [f"{key.strip()}={value}" for value in values]


def _range(text: str) -> tuple[float, float]:
    """Ends of ``striker.velocity=LOW:HIGH`` in m/s."""
    from workbench.base.units import in_si
    from workbench.extras.uncertainty.critical_velocity import VELOCITIES

    key, _, values = text.partition("=")
    low, colon, high = values.partition(":")
    ends = []
    for value in (low, high):
        try:
            number: float | None = float(value)
        except ValueError:
            number = in_si(value, "m/s")
        ends.append(number)
    first, last = ends
    if key.strip() != VELOCITY or not colon or first is None or last is None:
        text_ = f"must look like {VELOCITY}=5:30"
        raise InputError("--over", text, text_, "ends in m/s, or such as 20 km/h:100 km/h")
    for end in (first, last):
        VELOCITIES.check("--over", end)
    if not first < last:
        raise InputError("--over", text, "must rise from the first to the last velocity")
    return first, last


def struck(scenario: Any) -> Any:
    """Return the scenario unchanged if it has an impact velocity, else raise `InputError`."""
    if not hasattr(scenario, "at_velocity"):
        text = "has no impact velocity"
        raise InputError("kind", scenario.KIND, text, "take column-impact or frame-impact")
    return scenario


def pair_of(scenario: Any, model: str | None, reference: str | None) -> tuple[str, str]:
    """Reduced model and reference: of bending, of webs that yield in shear, of oblique hits."""
    from workbench.models.base import make_model

    usual = ("flexible-superelement", "fiber-reissner")
    if scenario.KIND == "column-impact" and scenario.striker.angle:
        usual = ("seven-dof", "fiber-space")
    elif scenario.KIND == "column-impact":
        findings = make_model("four-dof").domain(scenario)
        yields = any(finding.subject == "shear" for finding in findings)
        usual = ("four-dof-shear", "fiber-shear") if yields else ("four-dof", "fiber-reissner")
    return model or usual[0], reference or usual[1]


def _blocks(result: Fragility) -> Iterator[Block]:
    from workbench.extras.uncertainty.fragility import CHECKED
    from workbench.extras.uncertainty.fragility_curve import PROBABILITIES

    setup, curve = result.setup, result.curve
    low, middle, high = (exp(u) for u in curve.velocity(0.5))
    limit = setup.limit
    exceeded = f"exceeds {limit}" if isfinite(limit.displacement) else "collapses"
    band = f"{low:.4g} to {high:.4g} m/s" if isfinite(low) and isfinite(high) else "open"
    yield paragraph(
        f"{setup.uncertain.base.name}: {exceeded} with probability 0.5 at "
        f"{middle:.4g} m/s (90 %: {band}); {setup.reduced.name} in {setup.samples} samples, "
        f"corrected by {len(result.ratios)} runs of {setup.reference.name}, "
        "which is taken as the truth but for its mesh."
    )
    ends = [curve.velocity(p)[1] for p in (0.02, 0.98)]
    first, last = map(exp, ends) if all(map(isfinite, ends)) else setup.ends
    velocities = [first + k * (last - first) / (_SHOWN - 1) for k in range(_SHOWN)]
    ends_of = {"low": "low", "high": "high"}
    rows = [{"velocity": v, **_banded(result.at(v), "probability")} for v in velocities]
    columns = {"velocity m/s": "velocity", "probability": "probability", **ends_of}
    yield Table.of("curve", "Probability of exceedance, band of 90 %.", columns, rows)
    quantiles = {p: _banded(map(exp, curve.velocity(p)), "velocity") for p in PROBABILITIES}
    rows = [{"probability": p, **cells} for p, cells in quantiles.items()]
    columns = {"probability": "probability", "velocity m/s": "velocity", **ends_of}
    yield Table.of("velocities", "Velocity at a probability.", columns, rows)
    yield _costs(result)
    if result.numerical is None:
        text = "The numerical error of the reference is not known: the band does not contain it."
        yield paragraph(text)
    if result.turning:
        share = f"In {result.turning} of {CHECKED} samples"
        text = "the peak falls below the limit again above the critical velocity"
        yield paragraph(f"{share} {text}: the curve counts the first passage.")
    if result.failed:
        yield paragraph(f"{result.failed} references have no answer: the band is widened for them.")
    if not result.reaches_target:
        text = "The band is wider than was asked; the largest part above says what to refine."
        yield paragraph(text)


def _by_value(key: str, results: Mapping[str, Fragility]) -> Iterator[Block]:
    """One row for each value of the second number."""
    from workbench.extras.uncertainty.fragility_curve import PROBABILITIES

    rows = []
    for value, result in results.items():
        row: dict[str, Any] = {key: value.partition("=")[2]}
        for p in PROBABILITIES:
            low, middle, high = map(exp, result.curve.velocity(p))
            row[f"v at {p:g} m/s"] = Cell(f"{middle:.3g} ({low:.3g} to {high:.3g})", middle)
        unknown = "" if result.numerical is not None else ", meshes unknown"
        width = result.curve.half_width
        row["half-width"] = Cell(f"{width:.3f}{unknown}", width)
        row["references"] = len(result.ratios)
        rows.append(row)
    setup = next(iter(results.values())).setup
    head = f"{setup.uncertain.base.name}: limit {setup.limit}, {setup.samples} samples, by {key}."
    yield paragraph(f"{head} All values have the same samples of the other inputs.")
    yield Table.of(
        "given", "Velocity at a probability, 90 %.", {name: name for name in rows[0]}, rows
    )


def _banded(band: Iterable[float], middle: str) -> dict[str, Cell]:
    """Low end, `middle` and high end of a band."""
    names = ("low", middle, "high")
    return {name: Cell(f"{value:.3f}", value) for name, value in zip(names, band, strict=True)}


def _costs(result: Fragility) -> Table:
    """Table of the parts of the band: width, runs and seconds of each."""
    curve, seconds, runs = result.curve, result.seconds, result.runs
    widened = curve.half_width - result.curve_without.half_width
    widths = {
        "samples": curve.sampling.max(),
        "references": curve.correction.max(),
        "meshes": None if result.numerical is None else widened,
        "all": curve.half_width,
    }
    columns = {
        "part of the band": lambda n: "numerical, of the reference" if n == "meshes" else n,
        "half-width": lambda n: "unknown" if widths[n] is None else f"{widths[n]:.4f}",
        "runs": lambda n: sum(runs.values()) if n == "all" else runs[n],
        "seconds": lambda n: f"{seconds[n]:.1f}",
    }
    in_velocity = 100.0 * curve.velocity_half_width
    measured = f"{in_velocity:.2f} % in velocity" if isfinite(in_velocity) else "open in velocity"
    caption = f"Largest half-width in probability, and its price; {measured}."
    return Table.of("costs", caption, columns, widths)
