"""Calibration of the mechanical model on push-out tests, and its check on other campaigns."""

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from workbench.errors import InputError, SolverError
from workbench.studs.mechanical.driving import ShearCurve, push_out
from workbench.studs.mechanical.parameters import LEAST_SLENDERNESS, Stud, Surroundings
from workbench.studs.quantities import Array, specimens, undamaged_headed_studs
from workbench.studs.schema import HEADED
from workbench.studs.tables import RowIdentity, identity_of

FREE = ("bearing_factor", "foundation_factor", "slide_capacity")
NEEDED = ("diameter", "height", "concrete_strength", "concrete_modulus", "ultimate_strength")
OBSERVED = ("strength", "stiffness", "slip")
STIFFNESS_LEVEL = 0.4
LEAST_SCATTER = 0.05  # of logarithms: tests never repeat better, whatever few replicates say
STEPS = 120
DIFFERENCE = 0.05  # of the logarithm of a parameter: wide against the steps of the curves


def stud_of(row: pd.Series) -> Stud:
    """The stud of a row of a table of tests. Raises `InputError` for missing values."""
    test = specimens(pd.DataFrame([row]))
    values = {name: float(getattr(test, name)[0]) for name in NEEDED}
    for name, value in values.items():
        if not np.isfinite(value):
            where = f"{row['campaign']} {row['specimen']}"
            raise InputError(f"{where}: {name}", None, "must be known for the mechanical model")
    sizes = ("head_diameter", "collar_diameter", "collar_height")
    optional = {"yield_stress": 1e6 * row["fy_MPa"], **{n: 1e-3 * row[f"{n}_mm"] for n in sizes}}
    return Stud(**values, **{n: float(v) for n, v in optional.items() if np.isfinite(v)})


# a usual stud, for what neither a table nor the question tells, and by how much (a share) the studs
# of a table may differ and still are one
USUAL = {"diameter_mm": 19.0, "height_mm": 100.0, "fcm_MPa": 30.0, "fu_MPa": 450.0}
ALIKE = np.array([0.02, 0.02, 0.1, 0.1])


class TableStud(NamedTuple):
    """A `stud` of a table, in how many `tests`, and what is `assumed` of it (words)."""

    stud: Stud
    tests: int
    assumed: str


def studs_of(
    table: pd.DataFrame, given: Mapping[str, float | None]
) -> tuple[list[TableStud], list[str]]:
    """The different headed studs of a table with their mean values, that of most tests first.

    And why the model refuses others. Raises `InputError` where it refuses all.
    Arguments: `given`, values by column (those of `USUAL`, None: not given) that count instead of
    those of the table. What neither tells is taken from `USUAL`, and said to be assumed.
    """
    own = {name: value for name, value in given.items() if value is not None}
    rows = table[table["connector"] == HEADED].reindex(columns=list(USUAL)).astype(float)
    rows = (rows if len(rows) else pd.DataFrame([dict.fromkeys(USUAL, np.nan)])).assign(**own)
    known = rows.dropna(subset=[name for name in USUAL if rows[name].notna().any()])
    known = rows if known.empty else known
    assumed = [f"{name} {USUAL[name]:g}" for name in USUAL if known[name].isna().any()]
    groups: list[list[Array]] = []
    for values in known.fillna(USUAL).to_numpy(float):
        same = (g for g in groups if np.all(np.abs(values / g[0] - 1.0) <= ALIKE))
        if (group := next(same, None)) is None:
            groups.append(group := [])
        group.append(values)
    groups.sort(key=len, reverse=True)
    means = [np.mean(group, axis=0) * (1e-3, 1e-3, 1e6, 1e6) for group in groups]
    studs, refused = [], []
    for mean, group in zip(means, groups, strict=True):
        try:
            stud = Stud.of_concrete(*mean.tolist())
        except InputError as error:
            refused.append(error)
        else:
            studs.append(TableStud(stud, len(group) if len(table) else 0, ", ".join(assumed)))
    if not studs:
        raise refused[0]
    return studs, [str(error) for error in refused]


def complete_rows(table: pd.DataFrame) -> pd.DataFrame:
    """Undamaged headed studs in the range of the model, with all values. Raises `InputError`."""
    rows = undamaged_headed_studs(table)
    test = specimens(rows)
    known = np.isfinite([getattr(test, name) for name in NEEDED]).all(axis=0)
    known &= test.slenderness >= LEAST_SLENDERNESS
    if not known.any():
        raise InputError("table", len(table), "holds no test that the mechanical model can answer")
    return rows.iloc[np.flatnonzero(known)].reset_index(drop=True)


def predicted(stud: Stud, around: Surroundings, steps: int = STEPS) -> ShearCurve:
    """The push-out of a stud, at most at its `largest_shear`."""
    return push_out(stud, around, steps=steps).limited(stud.largest_shear)


def _predictions(
    rows: pd.DataFrame,
    around: Surroundings,
    curve_of: Callable[[Stud, Surroundings], ShearCurve] = predicted,
) -> Array:
    """Strength, stiffness and slip at rupture (rows, 3); equal studs are solved once."""
    studs = [stud_of(row) for _, row in rows.iterrows()]
    solved: dict[Stud, tuple[float, float, float]] = {}
    for stud in dict.fromkeys(studs):
        curve = curve_of(stud, around)
        solved[stud] = (curve.strength, curve.chord(0.0, STIFFNESS_LEVEL), float(curve.slip[-1]))
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
    kinds = {"test": observed, "model": predicted, "ratio": observed / predicted}
    named = [(f"{name}_{kind}", k, kind) for k, name in enumerate(OBSERVED) for kind in kinds]
    columns = {name: kinds[kind][:, k] for name, k, kind in named}
    return rows[["campaign", "specimen"]].assign(**columns)


@dataclass(frozen=True)
class MechanicalFit:
    """A calibrated mechanical model.

    `around`, its parameters; `standard_errors` of the logarithms of those calibrated (within the
    campaigns used; a new campaign may differ by more); `rows`, test and prediction of the
    calibration tests, and `mechanism_ratio`, test over the strength of the mechanism without its
    limits, which is what was calibrated; `scatter`, standard deviation of the log ratio by
    quantity; `studs`, how many different ones the tests have.
    """

    around: Surroundings
    standard_errors: dict[str, float]
    rows: pd.DataFrame
    scatter: dict[str, float]
    studs: int
    identity: RowIdentity

    @property
    def basis(self) -> str:
        """What the model was calibrated on, in one sentence."""
        campaigns = ", ".join(sorted(self.identity.campaigns))
        tests = f"{len(self.rows)} undamaged push-outs of {campaigns}"
        return f"mechanical model calibrated on {tests}, which are {self.studs} different studs"

    def validate(self, table: pd.DataFrame) -> pd.DataFrame:
        """Test and prediction of tests that the calibration has not seen (see `_compare`).

        Raises `InputError` when a row was used for the calibration, also under another name.
        """
        rows = complete_rows(table)
        self.identity.refuse_overlap(rows)
        return _compare(rows, _predictions(rows, self.around))

    def to_dict(self) -> dict[str, Any]:
        """Everything but the rows, ready for JSON (SI)."""
        return {
            "parameters": asdict(self.around),
            "free": list(self.standard_errors),
            "standard_errors": self.standard_errors,
            "scatter": self.scatter,
            "tests": len(self.rows),
            "studs": self.studs,
            "campaigns": sorted(self.identity.campaigns),
        }


def calibrate(table: pd.DataFrame) -> MechanicalFit:
    """Calibrate the parameters `FREE` of the model on the undamaged push-outs of a table.

    Least squares of the logarithms of strength, secant stiffness and slip at the largest load,
    each over its own scatter between equal specimens. It is the mechanism that is calibrated,
    without the limits of `Stud.largest_shear`: where one governs, the parameters would not show.
    Raises `InputError`, `SolverError`.
    """
    from scipy.optimize import least_squares

    begin = Surroundings()
    rows = complete_rows(table)
    observed = np.log(_observations(rows))
    scatter = _replicate_scatter(rows, observed)
    known = np.isfinite(observed)
    if known.sum() <= len(FREE):
        raise InputError("table", len(rows), f"must give more than {len(FREE)} observations")

    mechanism = partial(push_out, steps=STEPS)

    def around(theta: Array) -> Surroundings:
        return replace(begin, **dict(zip(FREE, np.exp(theta).tolist(), strict=True)))

    def residual(theta: Array) -> Array:
        error = (np.log(_predictions(rows, around(theta), mechanism)) - observed) / scatter
        return np.asarray(error[known])

    theta = np.log([float(getattr(begin, name)) for name in FREE])
    found = least_squares(
        residual, theta, diff_step=DIFFERENCE, x_scale=1.0, xtol=2e-3, ftol=1e-4, max_nfev=20
    )
    if not found.success:
        raise SolverError("calibration of the stud", float(found.cost), "20 evaluations")
    best = around(found.x)
    strength = _predictions(rows, best, mechanism)[:, 0]
    compared = _compare(rows, _predictions(rows, best))
    compared["mechanism_ratio"] = compared["strength_test"] / strength
    covariance = np.linalg.pinv(found.jac.T @ found.jac)
    covariance *= 2.0 * found.cost / max(int(known.sum()) - len(FREE), 1)
    errors = dict(zip(FREE, np.sqrt(np.diag(covariance)).tolist(), strict=True))
    ratios = {name: np.log(compared[f"{name}_ratio"].dropna().to_numpy()) for name in OBSERVED}
    spread = {n: float(np.std(r, ddof=1)) if len(r) > 1 else np.nan for n, r in ratios.items()}
    studs = len({stud_of(row) for _, row in rows.iterrows()})
    return MechanicalFit(best, errors, compared, spread, studs, identity_of(rows))


def _replicate_scatter(rows: pd.DataFrame, observed: Array) -> Array:
    """Standard deviation (3,) of the logarithms between equal studs, pooled."""
    keys = ["diameter_mm", "height_mm", "fcm_MPa", "fu_MPa"]
    values = pd.DataFrame(observed)
    groups = values.groupby([rows[key].to_numpy() for key in keys])
    squares = ((values - groups.transform("mean")) ** 2).sum()
    freedom = values.notna().sum() - groups.mean().notna().sum()
    pooled = np.sqrt(squares / freedom.where(freedom > 0))
    return np.asarray(pooled.fillna(0.0).clip(lower=LEAST_SCATTER))
