"""The certificate of a fragility curve: all that it rests on, and the check that it holds.

A JSON object with the scenario as TOML, models with versions, seed, samples, looks, every
reference, and the curve. `verify` runs a random tenth of the references again.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import ceil, exp, inf, isclose, isfinite, log
from typing import Any

import numpy as np

from workbench.errors import InputError
from workbench.models.base import on_one_mesh
from workbench.registry import make_model
from workbench.responses.provenance import provenance
from workbench.uncertainty.critical_velocity import Limit, slopes_at
from workbench.uncertainty.fragility import CHECKED, LOOKS, SCRAMBLES, Fragility
from workbench.uncertainty.fragility_curve import LEVEL
from workbench.uncertainty.inputs import uncertain_from_text
from workbench.uncertainty.sample_runs import Sampled, Setup, ratio_at

KIND, FORMAT = "fragility", 1
SAME = 5e-4  # ln velocity: searches that start elsewhere end as close
LEAST = 2  # references that are run again
_CURVE = ("median", "low", "high", "low_all", "high_all")


def certificate(result: Fragility) -> dict[str, Any]:
    """What a fragility curve rests on, as JSON holds it; probabilities over velocity in m/s."""
    setup, curve = result.setup, result.curve
    d = setup.limit.displacement
    references = [
        {
            "sample": int(place),
            "velocity": exp(u),
            "log_ratio": ratio.value if isfinite(ratio.value) else None,
            "slope": ratio.slope if isfinite(ratio.slope) else None,
            "runs": ratio.runs,
            "reason": ratio.reason,
        }
        for place, u, ratio in zip(result.places, result.velocities, result.ratios, strict=True)
    ]
    return {
        "kind": KIND,
        "format": FORMAT,
        "scenario": setup.uncertain.text,
        "limit": d if isfinite(d) else "collapse",
        "velocities": list(setup.ends),
        "models": {
            role: {"name": model.name, "version": model.version}
            for role, model in (("reduced", setup.reduced), ("reference", setup.reference))
        },
        "seed": setup.seed,
        "samples": setup.samples,
        "scrambles": SCRAMBLES,
        "looks": list(LOOKS) if result.looked else None,
        "kinds": result.kinds,
        "runs": result.runs,
        "turning": {"samples": result.turning, "of": CHECKED},
        "references": references,
        "numerical_half_width": result.numerical,
        "mesh_shift": result.shift,
        "level": LEVEL,
        "half_width": {
            "probability": curve.half_width,
            "velocity": _number(curve.velocity_half_width),
            "references": float(curve.correction.max()),
            "samples": float(curve.sampling.max()),
        },
        "curve": {
            "velocity": np.exp(curve.log_velocity).tolist(),
            "reduced": result.reduced_curve.tolist(),
            **{name: getattr(curve, name).tolist() for name in _CURVE},
        },
        "provenance": provenance(),
    }


def _number(value: float) -> float | None:
    return value if isfinite(value) else None


@dataclass(frozen=True)
class Checked:
    """A reference that was run again: its `sample`, both log ratios, whether they agree."""

    sample: int
    stated: float | None
    again: float
    agrees: bool


def verify(content: Mapping[str, Any], seed: int) -> list[Checked]:
    """Run a random tenth of the references of a certificate again.

    Raises `InputError` for a certificate of another form, or of other versions of its models.
    """
    try:
        parts = _setup(content), content["references"]
        setup, references = parts[0], list(parts[1])
        samples = [int(entry["sample"]) for entry in references]
        velocities = [log(float(entry["velocity"])) for entry in references]
        stated = [entry["log_ratio"] for entry in references]
    except (KeyError, TypeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError("certificate", str(error), "lacks or garbles a part") from error
    each = setup.samples // SCRAMBLES
    if not samples or not all(0 <= sample < setup.samples for sample in samples):
        raise InputError("certificate.references", samples, "must name samples of the sequence")
    count = min(len(samples), max(LEAST, ceil(len(samples) / 10)))
    chosen = np.sort(np.random.default_rng(seed).choice(len(samples), count, replace=False))
    scores = []
    for sample in np.array(samples)[chosen].tolist():
        scramble, number = divmod(sample, each)
        scores.append(setup.uncertain.normal_scores(1, (setup.seed, scramble), number))
    reduced = Sampled.of(setup, np.vstack(scores), map)
    roots = reduced.roots(setup, np.array(velocities)[chosen])
    at = np.array([root.log_velocity for root in roots])
    slopes = slopes_at(reduced.peaks_at, np.arange(count), at, setup.limit)
    checked = []
    tasks = list(zip(scores, at.tolist(), slopes.tolist(), strict=True))
    for k, task in zip(chosen.tolist(), tasks, strict=True):
        again = task[1] + ratio_at(setup, task).value - velocities[k]
        known = stated[k]
        agrees = isclose(again, known, abs_tol=SAME) if known is not None else not isfinite(again)
        checked.append(Checked(samples[k], known, again, agrees))
    return checked


def _setup(content: Mapping[str, Any]) -> Setup:
    """What was asked, from a certificate."""
    if content.get("kind") != KIND or content.get("format") != FORMAT:
        text = f"must be a certificate of kind {KIND}, format {FORMAT}"
        raise InputError("certificate", content.get("kind"), text)
    models = []
    for role in ("reduced", "reference"):
        entry = content["models"][role]
        model = make_model(entry["name"])
        if model.version != entry["version"]:
            text = f"is not the version that is here, {model.version}"
            advice = "make the certificate again, or install the version that made it"
            raise InputError(f"certificate.models.{role}.version", entry["version"], text, advice)
        models.append(model)
    d = content["limit"]
    limit = Limit(inf if d == "collapse" else float(d))
    low, high = map(float, content["velocities"])
    uncertain = uncertain_from_text(str(content["scenario"]))
    count, seed = int(content["samples"]), int(content["seed"])
    return Setup(uncertain, models[0], on_one_mesh(models[1]), limit, (low, high), count, seed)
