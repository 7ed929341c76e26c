"""A planar structure: meshes of members, dof numbering, band storage, supports, masses, state."""

from collections.abc import Iterable, Sequence
from copy import copy
from functools import lru_cache
from math import ceil, isfinite, log
from typing import Any, ClassVar, Self

import numpy as np
import scipy
from numpy.typing import ArrayLike

from workbench.base.arrays import Array, Indices
from workbench.mechanics.structures import kernels
from workbench.mechanics.structures.elements import Bars, ElementGroup, StepEnergies, StepRequest

COMPONENTS = {"u": 0, "v": 1, "rotation": 2}
SPATIAL = {"u": 0, "v": 1, "w": 2, "turn_x": 3, "turn_y": 4, "rotation": 5}


class PlanarAssembly:
    """Nodes with (u, v, rotation), element groups, and everything attached to single dofs.

    Arguments: `coordinates` (nodes, 2) in m; `groups`; `lumped`, mass at the nodes instead of
    consistent with linear interpolation; `ties`, pairs (master, slave) of nodes at one place: the
    slave shares u and v of the master but turns by itself. Nodes are renumbered inside to keep
    the band narrow, so dofs come from `dof(node, component)`. `displacement` and `velocity` are
    the committed state; a trial state lives in the groups until `commit`. Of the `components` of a
    node the first `axes` are translations.
    """

    components: ClassVar[dict[str, int]] = COMPONENTS
    axes: ClassVar[int] = 2

    def __init__(
        self,
        coordinates: ArrayLike,
        groups: Sequence[ElementGroup],
        *,
        lumped: bool = False,
        ties: Iterable[tuple[int, int]] = (),
    ) -> None:
        self.coordinates: Array = np.asarray(coordinates, dtype=float).reshape(-1, self.axes)
        self.groups = tuple(groups)
        each = len(self.components)
        self.size = each * len(self.coordinates)
        self._master: Indices = np.arange(len(self.coordinates), dtype=np.int64)
        for leader, slave in ties:
            self._master[slave] = leader  # whose translations the node has
        self._dof_of_node = self._numbering()
        placed = [self._dof_of_node[group.nodes].reshape(-1, 2 * each) for group in self.groups]
        self.width = max(2 * each - 1, *(int(np.max(np.ptp(dofs, axis=1))) for dofs in placed))
        self._rows = 3 * self.width + 1
        self.shortest = np.inf
        for group, dofs in zip(self.groups, placed, strict=True):
            self._place(group, dofs)
        self.band: Array = np.zeros(self._rows * self.size)
        self.mass: Array = np.zeros_like(self.band)
        self._add_masses(lumped)
        self.displacement: Array = np.zeros(self.size)
        self.velocity: Array = np.zeros(self.size)
        self.load: Array = np.zeros(self.size)
        self._held: Indices = self._unused.copy()
        self.springs: dict[int, tuple[float, float]] = {}
        self.stored = 0.0
        self._force: Array = np.zeros(self.size)
        self._duration = np.inf
        self.largest_force = 1e-6

    def copy(self) -> Self:
        """Copy of the structure in the same state, with arrays of its own."""
        other = copy(self)
        for name, value in vars(self).items():
            if isinstance(value, np.ndarray | dict):
                setattr(other, name, value.copy())
        other.groups = tuple(group.copy() for group in self.groups)
        return other

    # -- numbering ---------------------------------------------------------------------------

    def _numbering(self) -> Indices:
        """Dofs (nodes, components); those that a tied node does not use are kept in `_unused`."""
        count = len(self.coordinates)
        tied = self._master != np.arange(count)
        pairs = np.concatenate([group.nodes for group in self.groups])
        if np.any(tied):  # rotations of nodes meet translations of masters
            master = self._master[pairs]
            across = np.stack([pairs, master[:, ::-1]], axis=2).reshape(-1, 2)
            same = np.stack([pairs, master], axis=2).reshape(-1, 2)
            pairs = np.concatenate([pairs, master, across, same])
        each, shared = len(self.components), slice(self.axes)
        dofs = each * _places(pairs.tobytes(), count)[:, None] + np.arange(each)
        self._unused: Indices = np.sort(dofs[tied, shared].ravel())
        dofs[:, shared] = dofs[self._master, shared]
        return dofs

    def dof(self, node: int, component: str) -> int:
        """Number of a dof, `component` one of `components`; a slave's u and v are its master's."""
        return int(self._dof_of_node[node, self.components[component]])

    def dofs(self, nodes: Iterable[int], component: str) -> Indices:
        """Numbers of the same dof of several nodes."""
        return np.array([self.dof(node, component) for node in nodes], dtype=np.int64)

    def _place(self, group: ElementGroup, dofs: Indices) -> None:
        chords = np.diff(self.coordinates[group.nodes], axis=1)[:, 0]
        lengths = np.hypot.reduce(chords.T)
        shortest = np.min(lengths, where=lengths > 0.0, initial=np.inf)
        self.shortest = min(self.shortest, float(shortest))
        rows, columns = dofs[:, :, None], dofs[:, None, :]
        positions = columns * self._rows + 2 * self.width + rows - columns
        group.place(Bars(dofs, positions.reshape(len(dofs), -1), chords, lengths))

    # -- what is attached to dofs ------------------------------------------------------------

    def _diagonal(self, dof: Any) -> Any:
        return dof * self._rows + 2 * self.width

    def _add_masses(self, lumped: bool) -> None:
        pattern = np.array([[0.5, 0.0], [0.0, 0.5]] if lumped else [[2.0, 1.0], [1.0, 2.0]])
        if not lumped:
            pattern /= 6.0
        for group in self.groups:
            positions = group.bars.positions
            each, inertia = len(self.components), [np.asarray(m) for m in group.masses()]
            for component in range(each):
                for i in range(2):
                    for j in range(2):
                        at = 2 * each * (each * i + component) + each * j + component
                        mass = inertia[component >= self.axes]
                        np.add.at(self.mass, positions[:, at], pattern[i, j] * mass)
            matrices = group.mass_matrices()
            if matrices is not None:
                np.add.at(self.mass, positions, matrices.reshape(-1, 36))

    def add_mass(self, node: int, mass: float, rotary: float = 0.0) -> None:
        """Add a point mass (kg), and a rotary inertia (kg m2), to a node."""
        for component, number in self.components.items():
            value = mass if number < self.axes else rotary
            self.mass[self._diagonal(self.dof(node, component))] += value

    def add_rotary_inertia(self, inertia: Array) -> None:
        """Add rotary inertias (nodes,) in kg m2 to all nodes."""
        self.mass[self._diagonal(self._dof_of_node[:, self.axes :])] += inertia[:, None]

    def add_spring(self, dof: int, stiffness: float) -> None:
        """Put a spring (N/m or N m/rad) to the ground on a dof, unstressed as it is now."""
        self.springs[dof] = (stiffness, float(self.displacement[dof]))

    def hold(self, dofs: Iterable[int]) -> None:
        """Hold dofs at their present displacement, in addition to those already held."""
        self._held = np.union1d(self._held, np.fromiter(dofs, dtype=np.int64))
        self.velocity[self._held] = 0.0

    def release(self, dofs: Iterable[int]) -> None:
        """Let held dofs go."""
        free = np.setdiff1d(self._held, np.fromiter(dofs, dtype=np.int64))
        self._held = np.union1d(free, self._unused)

    @property
    def held(self) -> Indices:
        """The dofs that are held, and those that tied nodes do not use."""
        return self._held

    # -- forces, solution, commit ------------------------------------------------------------

    def assemble(self, end: Array, weight: float | None, mass_factor: float = 0.0) -> Array:
        """Internal forces (dofs,) of elements and springs; the tangent goes into `band`.

        Arguments: displacements `end` at the end of the step; `weight` of the end state in the
        energy-exact forces of a time step (springs take the mid-step), None for equilibrium at
        the end; `mass_factor` times the mass matrix is added to the tangent.
        """
        np.multiply(self.mass, mass_factor, out=self.band)
        force = self._forces(end, weight, True)
        for dof, (stiffness, _) in self.springs.items():
            self.band[self._diagonal(dof)] += stiffness if weight is None else 0.5 * stiffness
        return force

    def resist(self, end: Array) -> Array:
        """Internal forces (dofs,) at the displacements `end`; groups keep the trial state."""
        return self._forces(end, None, False)

    def _forces(self, end: Array, weight: float | None, tangent: bool) -> Array:
        force = self._force = np.zeros(self.size)
        share, dynamic = (1.0, False) if weight is None else (weight, True)
        step = StepRequest(
            force, self.band, self.displacement, end, share, dynamic, self._duration, tangent
        )
        for group in self.groups:
            group.assemble(step)
        for dof, (stiffness, reference) in self.springs.items():
            at = 0.5 * (end[dof] + self.displacement[dof]) if dynamic else end[dof]
            force[dof] += stiffness * (at - reference)
        return force

    def begin_step(self, duration: float) -> None:
        """Tell groups to which the rate matters how long the next step is, in s."""
        self._duration = duration

    def add_to_diagonal(self, dof: int, value: float) -> None:
        """Add to the diagonal of the tangent."""
        self.band[self._diagonal(dof)] += value

    def mass_times(self, x: Array) -> Array:
        """Product of the mass matrix with x (dofs,)."""
        result = np.empty(self.size)
        kernels.band_product(self.mass, self.width, x, result)
        return result

    def residual(self, moved: Array, factor: float, start: Array, force: Array) -> Array:
        """Residual (dofs,) of a time step: M moved factor - start + force, zero at held dofs."""
        result = np.empty(self.size)
        kernels.add_inertia(self.mass, self.width, moved, factor, start, force, self._held, result)
        return result

    def allowed_residual(self, tolerance: float, start: Array, residual: Array) -> float:
        """Largest residual entry (N) with which a step counts as solved.

        Arguments: `tolerance` relative to the largest nodal force so far or load; the first
        `residual` of the step, a thousandth of which counts as well (a structure at rest has no
        forces yet); displacements `start`, whose rounding leaves a residual by itself, as does
        that of the chords.
        """
        largest = kernels.largest
        scale = max(self.largest_force, largest(self.load), 1e-3 * largest(residual))
        size = max(largest(start), self.shortest)
        return kernels.allowed_residual(tolerance * scale, self.band, self.width, size)

    def tangent_times(self, x: Array) -> Array:
        """Product of the tangent in `band` with x (dofs,)."""
        result = np.empty(self.size)
        kernels.band_product(self.band, self.width, x, result)
        return result

    def tangent_row(self, dof: int) -> tuple[Array, Indices]:
        """Row of a dof in the tangent in `band`, and its columns."""
        columns = np.arange(max(0, dof - self.width), min(self.size, dof + self.width + 1))
        band = self.band.reshape(self.size, -1)
        return band[columns, 2 * self.width + dof - columns], columns

    def solve(self, right: Array, held: Indices | None = None) -> Array | None:
        """Solve the tangent against `right` (dofs,) with `held` dofs at zero; None if singular.

        The tangent in `band` is used up.
        """
        held = self._held if held is None else held
        kernels.hold(self.band, self.width, held, self.size)
        x = right.copy()
        x[held] = 0.0
        matrix = self.band.reshape((self._rows, self.size), order="F")
        _, _, x, info = scipy.linalg.lapack.dgbsv(
            self.width, self.width, matrix, x, overwrite_ab=1, overwrite_b=1
        )
        return x if info == 0 and isfinite(kernels.largest(x.ravel(order="K"))) else None

    def account(self, end: Array, weight: float) -> StepEnergies:
        """Energies of the step to the trial state at displacements `end`; springs are stored."""
        total = StepEnergies(0.0, 0.0, 0.0, 0.0)
        for group in self.groups:
            total = total + group.account(weight)
        springs = sum(0.5 * k * (end[dof] - at) ** 2 for dof, (k, at) in self.springs.items())
        return total._replace(stored=total.stored + springs)

    def commit(self, end: Array, velocity: Array | None = None) -> None:
        """Make the trial state at displacements `end` (and `velocity`) the committed one."""
        for group in self.groups:
            group.commit()
        self.displacement = end.copy()
        self.largest_force = max(self.largest_force, float(kernels.largest(self._force)))
        if velocity is not None:
            self.velocity = velocity

    def show(self, displacement: Array, velocity: Array, stored: Any) -> None:
        """Take a state that was reached elsewhere, or several (..., dofs), to be looked at."""
        self.displacement, self.velocity, self.stored = displacement, velocity, stored

    def kinetic_energy(self, velocity: Array | None = None) -> float:
        """Kinetic energy of the structure, in J; `velocity` (dofs,), None for the committed one."""
        v = self.velocity if velocity is None else velocity
        groups = sum(group.kinetic_energy() for group in self.groups)
        return 0.5 * float(v @ self.mass_times(v)) + groups


@lru_cache(maxsize=256)
def _places(pairs: bytes, count: int) -> Indices:
    """Places of so many nodes that keep the band narrow; `pairs` (n, 2) of those that meet."""
    ends, place = np.frombuffer(pairs, np.int64).reshape(-1, 2), np.arange(count)
    spread = int(np.max(np.abs(ends[:, 0] - ends[:, 1])))
    if spread > 1:
        graph = scipy.sparse.coo_matrix((np.ones(len(ends)), ends.T), shape=(count, count)).tocsr()
        order = scipy.sparse.csgraph.reverse_cuthill_mckee(graph + graph.T, symmetric_mode=True)
        renumbered = np.empty(count, dtype=np.int64)
        renumbered[order] = np.arange(count)
        if np.max(np.abs(np.diff(renumbered[ends], axis=1))) < spread:
            return renumbered
    return place


def graded_lengths(
    length: float, smallest: float, largest: float, growth: float = 1.5, least: int = 4
) -> Array:
    """Element lengths of a segment: `smallest` at both ends, growing inwards up to `largest`.

    Arguments: `length` of the segment, `smallest` and `largest` element length in m; `growth`,
    ratio of neighbouring elements; `least` number of elements. Result: lengths (elements,) that
    sum to `length`, symmetric, slightly below the sizes asked for where they do not fit exactly.
    """
    # one element per unit of the integral of dx / h(x), h(x) = start + slope x up to the cap;
    # start is chosen so that the first element has the length `smallest`
    slope = log(growth)
    start = smallest * slope / (growth - 1.0)
    half = 0.5 * length
    graded = min(max((largest - start) / slope, 0.0), half)
    cap = max(largest, start)
    graded_count = log(1.0 + slope * graded / start) / slope
    half_count = graded_count + (half - graded) / cap
    count = max(ceil(2.0 * half_count - 1e-9), least)
    at = np.linspace(0.0, 2.0 * half_count, count + 1)
    inner = np.minimum(at, 2.0 * half_count - at)
    position = np.where(
        inner <= graded_count,
        start * np.expm1(slope * np.minimum(inner, graded_count)) / slope,
        graded + (inner - graded_count) * cap,
    )
    nodes = np.where(at <= half_count, position, length - position)
    return np.asarray(np.diff(nodes))


def halved(lengths: Array, times: int) -> Array:
    """Element lengths after halving every element `times` times."""
    return np.asarray(np.repeat(lengths, 2**times) / 2**times)
