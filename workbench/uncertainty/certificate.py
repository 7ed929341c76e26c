"""The certificate of a fragility curve: all that it rests on.

A JSON object with the scenario as TOML, models with versions, seed, samples, looks, every
reference, and the curve. `verification.verify` computes it again.
"""

from math import exp, isfinite
from typing import Any

import numpy as np

from workbench.responses.provenance import provenance
from workbench.uncertainty.fragility import (
    CHECKED,
    LOOKS,
    SCRAMBLES,
    Fragility,
)
from workbench.uncertainty.fragility_curve import LEVEL

KIND, FORMAT = "fragility", 2
FINER = ("shift", "half_width")  # in ln velocity, of a reference on a finer mesh
_CURVE = ("median", "low", "high", "low_all", "high_all")


def certificate(result: Fragility) -> dict[str, Any]:
    """What a fragility curve rests on, as JSON holds it; probabilities over velocity in m/s."""
    setup, curve, finer = result.setup, result.curve, result.finer
    numerical, shift = finer.error
    references = [
        {
            "sample": int(place),
            "velocity": exp(u),
            "log_ratio": number(ratio.value),
            "slope": number(ratio.slope),
            "runs": ratio.runs,
            "reason": ratio.reason,
        }
        for place, u, ratio in zip(result.places, result.velocities, result.ratios, strict=True)
    ]
    return {
        "kind": KIND,
        "format": FORMAT,
        "scenario": setup.uncertain.text,
        "limit": number(setup.limit.displacement) or "collapse",
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
            "runs": [dict(zip(FINER, map(number, each), strict=True)) for each in finer.runs],
        },
        "numerical_half_width": numerical,
        "mesh_shift": shift,
        "level": LEVEL,
        "half_width": {
            "probability": curve.half_width,
            "velocity": number(curve.velocity_half_width),
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


def number(value: float) -> float | None:
    """The number, None where it is not finite."""
    return value if isfinite(value) else None
