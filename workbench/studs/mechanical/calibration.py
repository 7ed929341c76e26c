"""Calibration of the mechanical model on push-out tests, and its check on other campaigns."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from workbench.errors import InputError, SolverError
from workbench.fields import Choice
from workbench.studs.mechanical.driving import push_out
from workbench.studs.mechanical.parameters import Stud, Surroundings
from workbench.studs.quantities import Array, specimens, undamaged_headed_studs
from workbench.studs.tables import RowIdentity, identity_of

FREE = ("bearing_factor", "foundation_factor", "slide_capacity")
OBSERVED = ("strength", "stiffness", "slip")
STIFFNESS_LEVEL = 0.4
LEAST_SCATTER = 0.05  # of logarithms: tests never repeat better, whatever few replicates say
STEPS = 120
DIFFERENCE = 0.05  # of the logarithm of a parameter: wide against the steps of the curves


def stud_of(row: pd.Series) -> Stud:
    """The stud of a row of a table of tests. Raises `InputError` for missing values."""
    test = specimens(pd.DataFrame([row]))
    needed = ("diameter", "height", "concrete_strength", "concrete_modulus", "ultimate_strength")
    values = {name: float(getattr(test, name)[0]) for name in needed}
    for name, value in values.items():
        if not np.isfinite(value):
            where = f"{row['campaign']} {row['specimen']}"
            raise InputError(f"{where}: {name}", None, "must be known for the mechanical model")
    sizes = ("head_diameter", "collar_diameter", "collar_height")
    optional = {"yield_stress": 1e6 * row["fy_MPa"]}
    optional |= {name: 1e-3 * row[f"{name}_mm"] for name in sizes}
    return Stud(**values, **{n: float(v) for n, v in optional.items() if np.isfinite(v)})


def complete_rows(table: pd.DataFrame) -> pd.DataFrame:
    """Undamaged headed studs with all values that the model needs. Raises `InputError`."""
    rows = undamaged_headed_studs(table)
    test = specimens(rows)
    known = np.isfinite(
        [test.diameter, test.height, test.concrete_strength, test.ultimate_strength]
    ).all(axis=0)
    if not known.any():
        raise InputError("table", len(table), "holds no test that the mechanical model can answer")
    return rows.iloc[np.flatnonzero(known)].reset_index(drop=True)


def _studs(rows: pd.DataFrame) -> list[Stud]:
    return [stud_of(row) for _, row in rows.iterrows()]


def _predictions(studs: Sequence[Stud], around: Surroundings) -> Array:
    """Strength, stiffness and slip at rupture (studs, 3); equal studs are solved once."""
    solved: dict[Stud, tuple[float, float, float]] = {}
    for stud in dict.fromkeys(studs):
        curve = push_out(stud, around, steps=STEPS)
        solved[stud] = (curve.strength, curve.secant(STIFFNESS_LEVEL), float(curve.slip[-1]))
    return np.array([solved[stud] for stud in studs])


def _observations(rows: pd.DataFrame) -> Array:
    test = specimens(rows)
    stiffness = rows["secant_40_kN_per_mm"].to_numpy(float) * 1e6
    return np.column_stack([test.shear, stiffness, test.slip_at_max])


def _compare(rows: pd.DataFrame, predicted: Array) -> pd.DataFrame:
    """Names, and test, prediction and ratio of each quantity; NaN where a test does not report it.

    Strength in N, stiffness (secant at 40 %) in N/m, slip (at the largest load in the test, at
    rupture in the model) in m.
    """
    observed = _observations(rows)
    columns: dict[str, Any] = {"campaign": rows["campaign"], "specimen": rows["specimen"]}
    for k, name in enumerate(OBSERVED):
        columns[f"{name}_test"] = observed[:, k]
        columns[f"{name}_model"] = predicted[:, k]
        columns[f"{name}_ratio"] = observed[:, k] / predicted[:, k]
    return pd.DataFrame(columns)


@dataclass(frozen=True)
class MechanicalFit:
    """A calibrated mechanical model.

    `around`, its parameters; `free`, those calibrated, with `standard_errors` of their logarithms
    (within the campaigns used; a new campaign may differ by more); `rows`, test and prediction of
    the calibration tests; `scatter`, standard deviation of the log ratio by quantity.
    """

    around: Surroundings
    free: tuple[str, ...]
    standard_errors: dict[str, float]
    rows: pd.DataFrame
    scatter: dict[str, float]
    identity: RowIdentity

    @property
    def basis(self) -> str:
        """What the model was calibrated on, in one sentence."""
        campaigns = ", ".join(sorted(self.identity.campaigns))
        return f"mechanical model calibrated on {len(self.rows)} undamaged push-outs of {campaigns}"

    def validate(self, table: pd.DataFrame) -> pd.DataFrame:
        """Test and prediction of tests that the calibration has not seen (see `_compare`).

        Raises `InputError` when a row was used for the calibration, also under another name.
        """
        rows = complete_rows(table)
        self.identity.refuse_overlap(rows)
        return _compare(rows, _predictions(_studs(rows), self.around))

    def to_dict(self) -> dict[str, Any]:
        """Everything but the rows, ready for JSON (SI)."""
        return {
            "parameters": asdict(self.around),
            "free": list(self.free),
            "standard_errors": self.standard_errors,
            "scatter": self.scatter,
            "tests": len(self.rows),
            "campaigns": sorted(self.identity.campaigns),
        }


def calibrate(
    table: pd.DataFrame,
    *,
    start: Surroundings | None = None,
    free: Sequence[str] = FREE,
) -> MechanicalFit:
    """Calibrate parameters of the model on the undamaged push-outs of a table.

    Least squares of the logarithms of strength, secant stiffness and slip at the largest load,
    each over its own scatter between equal specimens. Arguments: `start`, parameters to start
    from and to hold; `free`, names to calibrate. Raises `InputError`, `SolverError`.
    """
    from scipy.optimize import least_squares

    begin = start or Surroundings()
    for name in free:
        Choice(tuple(asdict(begin))).check("free", name)
    rows = complete_rows(table)
    studs = _studs(rows)
    observed = np.log(_observations(rows))
    scatter = _replicate_scatter(rows, observed)
    known = np.isfinite(observed)
    if known.sum() <= len(free):
        raise InputError("table", len(rows), f"must give more than {len(free)} observations")

    def around(theta: Array) -> Surroundings:
        return replace(begin, **dict(zip(free, np.exp(theta).tolist(), strict=True)))

    def residual(theta: Array) -> Array:
        error = (np.log(_predictions(studs, around(theta))) - observed) / scatter
        return np.asarray(error[known])

    theta = np.log([float(getattr(begin, name)) for name in free])
    found = least_squares(
        residual, theta, diff_step=DIFFERENCE, x_scale=1.0, xtol=2e-3, ftol=1e-4, max_nfev=20
    )
    if not found.success:
        raise SolverError("calibration of the stud", float(found.cost), "20 evaluations")
    best = around(found.x)
    compared = _compare(rows, _predictions(studs, best))
    covariance = np.linalg.pinv(found.jac.T @ found.jac)
    covariance *= 2.0 * found.cost / max(int(known.sum()) - len(free), 1)
    ratios = np.log(compared[[f"{name}_ratio" for name in OBSERVED]].to_numpy(float))
    return MechanicalFit(
        best, tuple(free),
        dict(zip(free, np.sqrt(np.diag(covariance)).tolist(), strict=True)),
        compared,
        {name: _spread(ratios[:, k]) for k, name in enumerate(OBSERVED)},
        identity_of(rows),
    )  # fmt: skip


def _spread(values: Array) -> float:
    kept = values[np.isfinite(values)]
    return float(np.std(kept, ddof=1)) if len(kept) > 1 else float("nan")


def _replicate_scatter(rows: pd.DataFrame, observed: Array) -> Array:
    """Standard deviation (3,) of the logarithms between equal studs, pooled."""
    keys = ["diameter_mm", "height_mm", "fcm_MPa", "fu_MPa"]
    result = np.full(3, LEAST_SCATTER)
    for k in range(3):
        values = pd.Series(observed[:, k])
        groups = values.groupby([rows[key].to_numpy() for key in keys])
        deviation = values - groups.transform("mean")
        freedom = int(values.notna().sum() - groups.mean().notna().sum())
        if freedom > 0:
            pooled = float(np.sqrt((deviation**2).sum() / freedom))
            result[k] = max(pooled, LEAST_SCATTER)
    return result
