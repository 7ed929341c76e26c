"""Drive a stud: push-out, pull-out, and one after the other.

**Second part.** Calibration of the mechanical model on push-out tests, and what it then predicts.

What is left of a stud after a pull-out has a band: it runs over the parameters that no test at hand
tells, all of them at once: what a cone takes from the bearing strength, where it ends, the friction
of the flange, the strain at rupture. Ratios are those of the mechanism itself, without the limits
of `Stud.largest_shear`: under a limit a loss would not show.
"""

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import lru_cache, partial
from itertools import product
from typing import Any

import numpy as np
import pandas as pd

from workbench.base.errors import InputError, OutOfDomainError, SolverError
from workbench.base.fields import Choice
from workbench.mechanics.structures.paths import apply_loads, push
from workbench.studs.fit_protocol import Tables, counted
from workbench.studs.mechanical.structure import (
    LEAST_SLENDERNESS,
    NEEDED,
    Stud,
    StudStructure,
    Surroundings,
    stud_of,
)
from workbench.studs.relations import MEASURES, MechanicalCurve
from workbench.studs.schema import QUANTITIES
from workbench.studs.tables import (
    Array,
    RowIdentity,
    identity_of,
    specimens,
    undamaged_headed_studs,
)

DRIVEN = 240


@dataclass(frozen=True)
class ShearCurve:
    """A push-out: `slip` (n,) m, `load` (n,) N per stud; of it `friction` and `collar` (n,) N.

    `tension` in the shank at its base (n,) N, `uplift` of the flange (n,) m; `failed`, the shank
    tore (or a dead load pulled the stud out) at the last point.
    """

    slip: Array
    load: Array
    friction: Array
    collar: Array
    tension: Array
    uplift: Array
    failed: bool = field(kw_only=True)

    @property
    def strength(self) -> float:
        """Largest load, in N."""
        return float(np.max(self.load))

    def rubbing(self, coefficient: float) -> "ShearCurve":
        """The curve, driven with a friction of 1, with another coefficient.

        Friction adds to the load and is no part of the equilibrium: no other run is needed.
        """
        friction = coefficient * self.friction
        return replace(self, load=self.load - self.friction + friction, friction=friction)

    def limited(self, load: float) -> "ShearCurve":
        """The curve with a plateau at a load (N) that it would exceed."""
        return replace(self, load=np.minimum(self.load, load))

    def strength_within(self, slip: float) -> float:
        """Largest load up to a slip (m), in N."""
        return float(np.max(self.load[self.slip <= slip * (1.0 + 1e-9)]))

    def chord(self, low: float = 0.1, high: float = 0.4) -> float:
        """Chord stiffness between two shares of the strength, in N/m."""
        rising = np.maximum.accumulate(self.load)
        start, end = np.interp(np.array([low, high]) * self.strength, rising, self.slip)
        return float((high - low) * self.strength / (end - start))


@dataclass(frozen=True)
class PullCurve:
    """A pull-out: `uplift` (n,) m and `load` (n,) N, and what it leaves behind.

    `failure`: ``cone``, ``steel``, ``head`` or ``none``; `residual_uplift` (m) when unloaded;
    `damage` of the cone, 0 to 1.
    """

    uplift: Array
    load: Array
    failure: str
    residual_uplift: float
    damage: float

    @property
    def strength(self) -> float:
        """Largest load, in N."""
        return float(np.max(self.load))


def _steps(end: float, first: float, count: int) -> Array:
    """Rising path to `end`, `first` m to begin with: fine at the start, where stiffness is read."""
    share = np.linspace(0.0, 1.0, count + 1)[1:]
    power = max(np.log(first / end) / np.log(share[0]), 1.0)
    return np.asarray(end * share**power)


def shear(structure: StudStructure, slip: float | None = None, steps: int = DRIVEN) -> ShearCurve:
    """Push the flange of a structure in its present state by `slip` (m), to failure at most.

    Under a dead load on the flange the curve also ends where the anchorage cannot carry it any
    more. Raises `SolverError` when no equilibrium is found otherwise.
    """
    if slip is None:  # beyond any rupture
        slip = (1.2 * structure.around.slide_capacity + 0.3) * structure.stud.diameter
    assembly, dof = structure.assembly, structure.slip_dof
    assembly.release([dof])
    origin = float(assembly.displacement[dof])
    rows = [(0.0, 0.0, 0.0, 0.0, structure.base_tension, structure.uplift)]
    failed, done = False, 0.0
    for target in _steps(slip, 2e-6, steps):
        try:
            (step,) = push(assembly, dof, np.array([target - done]))
            structure.update()
        except (OutOfDomainError, SolverError) as error:
            loaded = assembly.load[structure.uplift_dof] != 0.0
            if loaded and (isinstance(error, OutOfDomainError) or structure.anchorage_exhausted):
                failed = True  # no equilibrium beyond: the dead load has pulled the stud out
                break
            raise
        done = float(assembly.displacement[dof]) - origin
        friction = structure.friction()
        collar = float(structure.links.state.force[structure.collar])
        force = step.factor + friction
        rows.append((done, force, friction, collar, structure.base_tension, structure.uplift))
        if failed := structure.ruptured:
            break
    return ShearCurve(*np.array(rows).T, failed=failed)


def pull(
    structure: StudStructure, uplift: float, steps: int = DRIVEN, *, unload: bool = True
) -> PullCurve:
    """Lift the flange by `uplift` (m) without slip, then let it go.

    Ends where the shank tears. Raises `SolverError` when no equilibrium is found.
    """
    dof = structure.uplift_dof
    rows, failure, done = [(0.0, 0.0)], "none", 0.0
    for target in _steps(uplift, 2e-6, steps):
        try:
            (step,) = push(structure.assembly, dof, np.array([-(target - done)]))
            structure.update()
        except OutOfDomainError:
            failure = "steel"
            break
        done = structure.uplift
        rows.append((done, -step.factor))
        if structure.ruptured:
            failure = "steel"
            break
    lifted, loads = np.array(rows).T
    if failure == "none":
        crushed = "head" if structure.head_crushed else "none"
        failure = "cone" if structure.cone_damage > 0.0 else crushed
    if unload and failure != "steel" and loads[-1] > 0.0:
        _let_go(structure, float(loads[-1]))
    return PullCurve(lifted, loads, failure, structure.uplift, structure.cone_damage)


def _let_go(structure: StudStructure, load: float) -> None:
    """Lower the flange until it is free of load."""
    dof, rest, step_size = structure.uplift_dof, load, 1e-6
    for _ in range(400):
        (step,) = push(structure.assembly, dof, np.array([step_size]))
        structure.update()
        before, rest = rest, -step.factor
        if abs(rest) <= 1e-4 * load:
            return
        slope = (before - rest) / step_size
        # towards zero along the secant, with growing steps while that is far
        wanted = rest / slope if slope > 0.0 else step_size
        step_size = float(np.clip(wanted, -4.0 * abs(step_size), 4.0 * abs(step_size)))
    raise SolverError("unloading of the pull-out", abs(rest) / load, "400 secant steps")


def push_out(
    stud: Stud,
    around: Surroundings,
    slip: float | None = None,
    *,
    tension: float = 0.0,
    steps: int = DRIVEN,
    refinement: int = 0,
) -> ShearCurve:
    """Push-out of an undamaged stud to `slip` in m (None: to rupture), or to rupture.

    Arguments: constant `tension` on the flange in N, `steps`, `refinement` of the elements. Raises
    `SolverError`, also when the stud cannot bear the tension alone.
    """
    structure = StudStructure(stud, around, refinement)
    if tension > 0.0:
        structure.assembly.load[structure.uplift_dof] = -tension
        apply_loads(structure.assembly, steps=20)
        structure.update()
    return shear(structure, slip, steps)


def pull_out(stud: Stud, around: Surroundings, *, steps: int = DRIVEN) -> PullCurve:
    """Pull-out of an undamaged stud to the end of the cone or to rupture."""
    far = (1.05 * around.cone_end + 1.3 * around.rupture_strain) * stud.embedment
    return pull(StudStructure(stud, around), far, steps, unload=False)


def pull_then_push(
    stud: Stud, around: Surroundings, uplift: float, *, steps: int = DRIVEN
) -> tuple[PullCurve, ShearCurve | None]:
    """Pull the stud to `uplift` (m), unload, then push it out (None if it tore in the pull-out)."""
    structure = StudStructure(stud, around)
    pulled = pull(structure, uplift, steps)
    return pulled, None if pulled.failure == "steel" else shear(structure, steps=steps)


FREE = ("bearing_factor", "foundation_factor", "slide_capacity")
OBSERVED = ("strength", "stiffness", "slip")
STIFFNESS_LEVEL = 0.4
LEAST_SCATTER = 0.05  # of logarithms: tests never repeat better, whatever few replicates say
STEPS = 120
DRAWN = 60  # steps of the curves that are kept
_DIFFERENT = ["campaign", "diameter_mm", "height_mm", "fcm_MPa", "fu_MPa"]
DIFFERENCE = 0.05  # of the logarithm of a parameter: wide against the steps of the curves


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


def _studs(rows: pd.DataFrame) -> list[Stud]:
    return [stud_of(row) for _, row in rows.iterrows()]


def _predictions(
    studs: list[Stud],
    around: Surroundings,
    curve_of: Callable[[Stud, Surroundings], ShearCurve] = predicted,
) -> Array:
    """Strength, stiffness and slip at rupture (studs, 3); equal studs are solved once."""
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
        """Basis of the calibration of the model, in one sentence."""
        campaigns = ", ".join(sorted(self.identity.campaigns))
        tests = f"{len(self.rows)} undamaged push-outs of {campaigns}"
        return f"mechanical model calibrated on {tests}, which are {self.studs} different studs"

    def validate(self, table: pd.DataFrame) -> pd.DataFrame:
        """Test and prediction of tests that the calibration has not seen (see `_compare`).

        Raises `InputError` when a row was used for the calibration, also under another name.
        """
        rows = complete_rows(table)
        self.identity.refuse_overlap(rows)
        return _compare(rows, _predictions(_studs(rows), self.around))

    def summary(self) -> dict[str, Any]:
        """Summary of the calibration, and the scatter there: one row of a table."""
        scatter = {f"scatter_of_{name}": value for name, value in self.scatter.items()}
        return {**counted(self.rows), "studs": self.studs, "basis": self.basis, **scatter}

    def tables(self) -> Tables:
        """Parameters (SI), calibrated or assumed, and the tests of the calibration."""
        values = asdict(self.around)
        errors = pd.Series(self.standard_errors, dtype=float).reindex(list(values))
        parameters = {"parameter": list(values), "value": list(values.values())}
        table = pd.DataFrame({**parameters, "standard_error": errors.to_numpy()})
        table["calibrated"] = table["standard_error"].notna()
        return {"parameters": table, "tests": self.rows}


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
    studs, observed = _studs(rows), np.log(_observations(rows))
    scatter = _replicate_scatter(rows, observed)
    known = np.isfinite(observed)
    if known.sum() <= len(FREE):
        raise InputError("table", len(rows), f"must give more than {len(FREE)} observations")

    mechanism = partial(push_out, steps=STEPS)

    def around(theta: Array) -> Surroundings:
        return replace(begin, **dict(zip(FREE, np.exp(theta).tolist(), strict=True)))

    def residual(theta: Array) -> Array:
        error = (np.log(_predictions(studs, around(theta), mechanism)) - observed) / scatter
        return np.asarray(error[known])

    theta = np.log([float(getattr(begin, name)) for name in FREE])
    solved = least_squares(
        residual, theta, diff_step=DIFFERENCE, x_scale=1.0, xtol=2e-3, ftol=1e-4, max_nfev=20
    )
    if not solved.success:
        raise SolverError("calibration of the stud", float(solved.cost), "20 evaluations")
    best = around(solved.x)
    strength = _predictions(studs, best, mechanism)[:, 0]
    compared = _compare(rows, _predictions(studs, best))
    compared["mechanism_ratio"] = compared["strength_test"] / strength
    covariance = np.linalg.pinv(solved.jac.T @ solved.jac)
    covariance *= 2.0 * solved.cost / max(int(known.sum()) - len(FREE), 1)
    errors = dict(zip(FREE, np.sqrt(np.diag(covariance)).tolist(), strict=True))
    ratios = {name: np.log(compared[f"{name}_ratio"].dropna().to_numpy()) for name in OBSERVED}
    spread = {n: float(np.std(r, ddof=1)) if len(r) > 1 else np.nan for n, r in ratios.items()}
    return MechanicalFit(best, errors, compared, spread, len({*studs}), identity_of(rows))


def _replicate_scatter(rows: pd.DataFrame, observed: Array) -> Array:
    """Standard deviation (3,) of the logarithms between equal studs, pooled."""
    keys = ["diameter_mm", "height_mm", "fcm_MPa", "fu_MPa"]
    values = pd.DataFrame(observed)
    groups = values.groupby([rows[key].to_numpy() for key in keys])
    squares = ((values - groups.transform("mean")) ** 2).sum()
    freedom = values.notna().sum() - groups.mean().notna().sum()
    pooled = np.sqrt(squares / freedom.where(freedom > 0))
    return np.asarray(pooled.fillna(0.0).clip(lower=LEAST_SCATTER))


def predicted_curves(rows: pd.DataFrame, around: Surroundings) -> pd.DataFrame:
    """Predicted push-outs of the different studs of rows: campaign, specimen, and points in SI."""
    names, parts = ["campaign", "specimen"], ("slip", "load", "collar", "friction")
    curves = []
    for _, row in rows.drop_duplicates(_DIFFERENT).iterrows():
        curve = predicted(stud_of(row), around, DRAWN)
        points = pd.DataFrame({part: getattr(curve, part) for part in parts})
        curves.append(points.assign(**row[names]))
    return pd.concat(curves, ignore_index=True)[[*names, *parts]]


# -- what is left after a pull-out, and shear under tension ----------------------------------------

LEVELS = (0.0, 0.1, 0.25, 0.5, 0.75, 1.0)
LOST = 0.2  # of the peak: a pull-out that has fallen to it has failed
TRIED = (40, STEPS, 2 * STEPS)  # steps at the corners of the band: 40 are within 0.01 of 120
# ends of the unknown parameters, whose corners span the band
UNKNOWN = {
    "cone_loss": (0.0, 1.0),
    "cone_end": (0.03, 0.12),
    "friction": (0.0, 0.6),
    "rupture_strain": (0.06, 0.20),
}


def uplift_at(pulled: PullCurve, level: float, measure: str) -> float:
    """Uplift (m) of a level of damage, 0 to 1, of a pull-out.

    ``displacement ratio``: share of the uplift where the load has fallen to 20 % of its peak, or
    the shank tears; ``load ratio``: share of the peak before it. Raises `InputError` for others.
    """
    if not 0.0 <= level <= 1.0:
        raise InputError("level", level, "damage lies from 0 to 1")
    Choice(MEASURES).check("measure", measure)
    peak = int(np.argmax(pulled.load))
    if measure == "load ratio":
        rising = np.maximum.accumulate(pulled.load[: peak + 1])
        return float(np.interp(level * pulled.strength, rising, pulled.uplift[: peak + 1]))
    fallen = np.flatnonzero(pulled.load[peak:] <= LOST * pulled.strength)
    if len(fallen) == 0:
        return level * float(pulled.uplift[-1])
    i = peak + int(fallen[0])
    ends = slice(i, i - 2, -1)  # falling load: rising order for the interpolation
    return level * float(np.interp(LOST * pulled.strength, pulled.load[ends], pulled.uplift[ends]))


@lru_cache(maxsize=128)  # strength and stiffness, and all frictions, come from the same runs
def _runs(
    stud: Stud, around: Surroundings, levels: tuple[float, ...], measure: str, steps: int
) -> tuple[ShearCurve, tuple[ShearCurve | None, ...]]:
    """The push-out of the undamaged stud and those after each level (None: torn)."""
    whole, pulled = push_out(stud, around, steps=steps), pull_out(stud, around, steps=steps)
    after = [
        pull_then_push(stud, around, uplift_at(pulled, float(level), measure), steps=steps)[1]
        if level > 0.0
        else whole
        for level in levels
    ]
    return whole, tuple(after)


def residual_ratios(
    stud: Stud, around: Surroundings, levels: tuple[float, ...], measure: str, steps: int = STEPS
) -> tuple[Array, Array]:
    """Strength and stiffness (10 to 40 %) over those of the undamaged stud (levels,) each.

    Strength counts up to the slip at which the undamaged stud tears. A stud torn in the pull-out
    has nothing left.
    """
    whole, after = _runs(stud, replace(around, friction=1.0), levels, measure, steps)
    whole = whole.rubbing(around.friction)
    curves = [None if each is None else each.rubbing(around.friction) for each in after]
    end, strength, chord = float(whole.slip[-1]), whole.strength, whole.chord()
    left = [
        (0.0, 0.0) if c is None else (c.strength_within(end) / strength, c.chord() / chord)
        for c in curves
    ]
    return np.array(left).T[0], np.array(left).T[1]


def _at_corner(
    stud: Stud, around: Surroundings, levels: tuple[float, ...], measure: str
) -> tuple[Array, Array]:
    """Ratios as in `residual_ratios`, with as few steps as find an equilibrium."""
    for steps in TRIED[:-1]:
        try:
            return residual_ratios(stud, around, levels, measure, steps)
        except SolverError:
            continue
    return residual_ratios(stud, around, levels, measure, TRIED[-1])


def residual_curve(
    stud: Stud,
    around: Surroundings,
    quantity: str = "strength",
    *,
    measure: str = "displacement ratio",
    levels: tuple[float, ...] = LEVELS,
    spread: Mapping[str, tuple[float, ...]] = UNKNOWN,
    basis: str = "mechanical model, not calibrated",
) -> MechanicalCurve:
    """Predict what is left after a pull-out to several levels, with a band.

    Arguments: `quantity` ``strength`` or ``stiffness``; `measure` of the level (see `uplift_at`);
    rising `levels` from 0; `spread`, ends of the unknown parameters; `basis`, what the parameters
    rest on (`MechanicalFit.basis`). Raises `InputError`, `SolverError`.
    """
    Choice(tuple(QUANTITIES)).check("quantity", quantity)
    which, at = list(QUANTITIES).index(quantity), np.array(levels, float)
    middle = residual_ratios(stud, around, levels, measure)[which]
    corners = (dict(zip(spread, ends, strict=True)) for ends in product(*spread.values()))
    every = [middle] + [
        _at_corner(stud, replace(around, **corner), levels, measure)[which] for corner in corners
    ]
    bounds, kind = (np.min(every, axis=0), np.max(every, axis=0)), ("pull-out", measure, quantity)
    return MechanicalCurve(at, middle, *bounds, *kind, basis, stud.title)


def interaction_points(
    stud: Stud, around: Surroundings, shares: tuple[float, ...] = (0.0, 0.25, 0.5, 0.75, 0.9)
) -> tuple[Array, Array]:
    """Tension over the pull-out strength, and the shear that is left over the shear strength.

    The tension is held while the stud is pushed out, up to the slip at which it tears without
    tension. Result: both ratios (n + 1,), the last point being the pull-out itself.
    """
    whole = push_out(stud, around, steps=STEPS)
    end, strength = float(whole.slip[-1]), pull_out(stud, around, steps=STEPS).strength
    held = (push_out(stud, around, tension=share * strength, steps=STEPS) for share in shares)
    shear = [each.strength_within(end) / whole.strength for each in held]
    return np.array([*shares, 1.0]), np.array([*shear, 0.0])
