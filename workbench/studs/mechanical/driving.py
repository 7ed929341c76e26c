"""Drive a stud: push-out, pull-out, and one after the other."""

from dataclasses import dataclass, field, replace

import numpy as np

from workbench.base.errors import OutOfDomainError, SolverError
from workbench.mechanics.structures.paths import apply_loads, push
from workbench.studs.mechanical.parameters import Stud, Surroundings
from workbench.studs.mechanical.structure import StudStructure
from workbench.studs.quantities import Array

STEPS = 240


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


def shear(structure: StudStructure, slip: float | None = None, steps: int = STEPS) -> ShearCurve:
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
    structure: StudStructure, uplift: float, steps: int = STEPS, *, unload: bool = True
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
    steps: int = STEPS,
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


def pull_out(stud: Stud, around: Surroundings, *, steps: int = STEPS) -> PullCurve:
    """Pull-out of an undamaged stud to the end of the cone or to rupture."""
    far = (1.05 * around.cone_end + 1.3 * around.rupture_strain) * stud.embedment
    return pull(StudStructure(stud, around), far, steps, unload=False)


def pull_then_push(
    stud: Stud, around: Surroundings, uplift: float, *, steps: int = STEPS
) -> tuple[PullCurve, ShearCurve | None]:
    """Pull the stud to `uplift` (m), unload, then push it out (None if it tore in the pull-out)."""
    structure = StudStructure(stud, around)
    pulled = pull(structure, uplift, steps)
    return pulled, None if pulled.failure == "steel" else shear(structure, steps=steps)
