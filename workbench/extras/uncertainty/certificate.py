"""The certificate of a fragility curve: all that it rests on, and the check that it holds.

A JSON object with the scenario as TOML, models with versions, seed, samples, looks, every
reference, and the curve. `verify` computes it again and compares all of it.
"""

from collections.abc import Iterator, Mapping
from functools import partial
from math import ceil, exp, inf, isclose, isfinite, isnan, nan
from typing import Any, NamedTuple

import numpy as np

from workbench.base.errors import InputError
from workbench.base.fields import Many, Number, Text
from workbench.extras.uncertainty.critical_ratio import FEWEST_REFERENCES
from workbench.extras.uncertainty.critical_velocity import (
    LEAST_LIMIT,
    MOST_LIMIT,
    VELOCITIES,
    DisplacementLimit,
    Ratio,
)
from workbench.extras.uncertainty.fragility import (
    CHECKED,
    FINEST_MESH,
    LOOKS,
    MOST_REFERENCES,
    SCRAMBLES,
    Fragility,
    Samples,
    refined_ones,
)
from workbench.extras.uncertainty.inputs import uncertain_from_text
from workbench.extras.uncertainty.sample_runs import Finer, Setup, on_finer_mesh, ratio_at
from workbench.models.base import make_model, on_one_mesh
from workbench.responses import COVERAGE
from workbench.responses.build import provenance
from workbench.study.batches import Processes

KIND, FORMAT = "fragility", 2
SAME, ROUND_OFF = 5e-4, 1e-6  # ln velocity of a run that is made again, and relative; absolute
LEAST = 2  # references that are run again
_FINER = ("shift", "half_width")  # in ln velocity, of a reference on a finer mesh
_CURVE = ("median", "low", "high", "low_all", "high_all")


def certificate(result: Fragility) -> dict[str, Any]:
    """Certificate of a fragility curve, as JSON holds it; probabilities over velocity in m/s."""
    setup, curve, finer = result.setup, result.curve, result.finer
    numerical, shift = finer.error
    references = [
        {
            "sample": int(place),
            "velocity": exp(u),
            "log_ratio": _number(ratio.value),
            "slope": _number(ratio.slope),
            "runs": ratio.runs,
            "reason": ratio.reason,
        }
        for place, u, ratio in zip(result.places, result.velocities, result.ratios, strict=True)
    ]
    return {
        "kind": KIND,
        "format": FORMAT,
        "scenario": setup.uncertain.text,
        "limit": _number(setup.limit.displacement) or "collapse",
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
        "meshes": {
            "refined": finer.refined,
            "of": finer.among,
            "runs": [dict(zip(_FINER, map(_number, each), strict=True)) for each in finer.runs],
        },
        "numerical_half_width": numerical,
        "mesh_shift": shift,
        "level": COVERAGE,
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


class Checked(NamedTuple):
    """A run that was made again: its `sample`, on which mesh, both log numbers, do they agree."""

    sample: int
    mesh: str
    stated: float | None
    again: float | None
    agrees: bool


class Verified(NamedTuple):
    """Result of a verification: runs made again, and places that do not follow from it."""

    runs: tuple[Checked, ...]
    differs: tuple[str, ...]

    @property
    def holds(self) -> bool:
        """Whether all is as it is stated."""
        return not self.differs and all(each.agrees for each in self.runs)


def verify(content: Mapping[str, Any], seed: int, jobs: int = 1) -> Verified:
    """Compute a certificate again from its inputs and seeds, and a random tenth of its references.

    All samples are asked again; the curve follows from them and from the references as stated, of
    which a tenth, and one of those on a finer mesh, are run again. Raises `InputError` for a
    certificate of another form, or of other versions of its models.
    """
    try:
        ratios = [_ratio(each, k) for k, each in enumerate(content.get("references", ()))]
        setup, finer = _setup(content, len(ratios), jobs), _finer(content["meshes"])
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError("certificate", str(error), "lacks or garbles a part") from error
    random = np.random.default_rng(seed)
    count = max(LEAST, ceil(len(ratios) / 10))
    chosen = np.sort(random.choice(len(ratios), count, replace=False)).tolist()
    with Processes(jobs) as run:
        samples = Samples.of(setup, run)
        computed = certificate(Fragility.of(setup, samples, ratios, finer))
        del computed["provenance"]
        again = run(partial(ratio_at, setup), samples.tasks(setup.limit, chosen))
        pairs = [(k, "", ratios[k], ratio) for k, ratio in zip(chosen, again, strict=True)]
        refined = refined_ones(ratios[: finer.among])
        if setup.has_meshes != bool(finer.runs) or len(refined) != len(finer.runs):
            raise InputError(
                "certificate.meshes", len(finer.runs), "are not those of its references"
            )
        for i in random.choice(len(refined), 1).tolist() if refined else ():
            task = samples.task_of(refined[i], ratios[refined[i]])
            moved = on_finer_mesh(setup, finer.refined, task) or (nan, nan)
            pairs.append((refined[i], f"{2**finer.refined} times finer", finer.runs[i], moved))
    runs = tuple(
        Checked(
            int(samples.places[k]),
            mesh,
            _number(stated[0]),
            _number(found[0]),
            _same(found, stated, SAME),
        )
        for k, mesh, stated, found in pairs
    )
    return Verified(runs, tuple(_differences(computed, content)))


def _same(computed: Any, stated: Any, near: float = ROUND_OFF) -> bool:
    """Whether a value is what is stated: floats nearly, NaN as NaN."""
    if isinstance(computed, tuple | list) and isinstance(stated, tuple | list):
        pairs = zip(computed, stated, strict=False)
        return len(computed) == len(stated) and all(_same(*pair, near) for pair in pairs)
    if not isinstance(computed, float) or type(stated) not in (int, float):
        return bool(computed == stated)
    both = computed, stated
    return isclose(*both, rel_tol=SAME, abs_tol=near) or (isnan(computed) and isnan(stated))


def _differences(computed: Mapping[str, Any], stated: Any, path: str = "") -> Iterator[str]:
    """Places at which a certificate states another value than what is computed."""
    for key, value in computed.items():
        place, other = f"{path}{key}", stated.get(key) if isinstance(stated, Mapping) else None
        if isinstance(value, Mapping):
            yield from _differences(value, other, f"{place}.")
        elif value and isinstance(value, list) and isinstance(value[0], Mapping):
            listed = other if isinstance(other, list) and len(other) == len(value) else {}
            pairs = zip(value, listed, strict=False)
            if not listed or any(True for pair in pairs for _ in _differences(*pair)):
                yield place
        elif not _same(value, other):
            yield place


def _ratio(entry: Mapping[str, Any], k: int) -> Ratio:
    """A reference as it is stated."""
    path = f"certificate.references.{k}"
    value, slope = (_logarithm(f"{path}.{name}", entry[name]) for name in ("log_ratio", "slope"))
    runs = Number(0, 1e4, integer=True).check(f"{path}.runs", entry["runs"])
    return Ratio(value, slope, int(runs), Text(shortest=0).check(f"{path}.reason", entry["reason"]))


def _finer(given: Mapping[str, Any]) -> Finer:
    """Runs on finer meshes as they are stated."""
    path = "certificate.meshes"
    refined = Number(0, FINEST_MESH, integer=True).check(f"{path}.refined", given["refined"])
    count = Number(0, MOST_REFERENCES, integer=True).check(f"{path}.of", given["of"])
    runs = []
    for k, each in enumerate(given["runs"]):
        shift, width = (_logarithm(f"{path}.runs.{k}.{name}", each[name]) for name in _FINER)
        runs.append((shift, width))
    return Finer(int(refined), int(count), tuple(runs))


def _logarithm(path: str, value: Any) -> float:
    """A number of ln velocity, or a slope; NaN for null."""
    return nan if value is None else Number(-100.0, 100.0).check(path, value)


def _setup(content: Mapping[str, Any], references: int, jobs: int) -> Setup:
    """Setup of the question, from a certificate."""
    if content.get("kind") != KIND or content.get("format") != FORMAT:
        text = f"must be a certificate of kind {KIND}, format {FORMAT}"
        raise InputError("certificate", content.get("kind"), text, "make the certificate again")
    looked = content["looks"] is not None
    path = "certificate.references"
    Number(FEWEST_REFERENCES, MOST_REFERENCES, integer=True).check(path, references)
    if looked and references not in LOOKS:
        raise InputError(path, references, f"must be one of {', '.join(map(str, LOOKS))}")
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
    rule = Number(LEAST_LIMIT, MOST_LIMIT, "m")
    limit = DisplacementLimit(inf if d == "collapse" else rule.check("certificate.limit", d))
    ends = Many(VELOCITIES, 2, 2).check("certificate.velocities", content["velocities"])
    if not ends[0] < ends[1]:
        raise InputError("certificate.velocities", list(ends), "must rise")
    uncertain = uncertain_from_text(str(content["scenario"]))
    rule = Number(64 * SCRAMBLES, SCRAMBLES << 16, integer=True)
    count = int(rule.check("certificate.samples", content["samples"]))
    seed = int(Number(0, 2**32 - 1, integer=True).check("certificate.seed", content["seed"]))
    return Setup(
        *(uncertain, models[0], on_one_mesh(models[1]), limit, ends, count, seed),
        references=None if looked else references,
        jobs=jobs,
        meshes=bool(content["meshes"]["runs"]),
    )
