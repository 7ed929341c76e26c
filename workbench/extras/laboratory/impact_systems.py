"""The column of four unknowns and structures, as the integrators of the laboratory ask for them.

The striker is one more unknown, the last: q = (structure, x_c), gap = w . q_structure - x_c. What
has no mass (the rotation of the impact point) follows inside the forces.
"""

import numpy as np

from workbench.base.arrays import Array
from workbench.extras.laboratory.complementarity import Restitution
from workbench.extras.laboratory.problems import BenchProblem
from workbench.mechanics.structures.assembly import PlanarAssembly
from workbench.mechanics.structures.fibers import BeamSection
from workbench.mechanics.structures.fibers.section import LinearHardening, ReissnerBeams
from workbench.models.four_dof import FourDof, march, statics
from workbench.models.four_dof.kinematics import BETA, U1, U2, V
from workbench.scenarios import Column
from workbench.steel.sections import find

_MOVING = np.array([V, U1, U2])


def _with_striker(matrix: Array, entry: float) -> Array:
    """A matrix with one more row and column, of which the diagonal alone is not zero."""
    n = len(matrix)
    out = np.zeros((n + 1, n + 1))
    out[:n, :n], out[n, n] = matrix, entry
    return out


class _Struck:
    """Common base of struck systems: a striker, and contact surfaces that stand still."""

    mass: Array
    normals: Array

    def surface(self, _t: float) -> tuple[Array, Array, Array]:
        """Gaps begin at zero."""
        return np.zeros(1), np.zeros(1), np.zeros(1)


class ColumnSystem(_Struck):
    """The column of `four-dof` with a head mass: unknowns v1, u1, u2 (m) and the striker."""

    def __init__(self, column: Column, striker_mass: float, model: FourDof | None = None) -> None:
        self.column, q = (model or FourDof()).bars(column)
        self.mass = _with_striker(np.diag(self.column["mass"][_MOVING]), striker_mass)
        self.normals = np.array([[1.0], [0.0], [0.0], [-1.0]])
        self.start = np.array([*q[_MOVING], 0.0])
        self._work = np.zeros(1, statics.WORK)[0]
        self._committed = np.zeros(1, statics.STATE)
        self._committed["q"][0] = q
        statics.internal_forces(self.column, self._committed[0], self._work)

    def _at(self, q: Array) -> np.void:
        trial: np.void = self._committed.copy()[0]
        trial["q"][_MOVING] = q[:3]
        statics.balance_rotation(self.column, trial, self._work)
        return trial

    def _tangent(self) -> Array:
        K = np.array(self._work["K"])
        if not statics.rotation_is_free(self.column, self._work["K"]):
            K -= np.outer(K[:, BETA], K[BETA]) / K[BETA, BETA]
        return _with_striker(K[np.ix_(_MOVING, _MOVING)], 0.0)

    def forces(self, q: Array) -> tuple[Array, Array]:
        """Forces and tangent, see `laboratory.system.System`, as of the other methods."""
        self._at(q)
        return np.append(self._work["F"][_MOVING], 0.0), self._tangent()

    def mean_forces(self, q0: Array, q1: Array) -> tuple[Array, Array]:
        """Averaged stresses on discrete gradients; `q0` is the committed place."""
        self._work["q0"][:] = self._committed["q"][0]
        self._work["stress0"][:] = self._committed["stress"][0]
        trial = self._at(q1)
        march.mean_forces(self.column, trial, self._work)
        return np.append(self._work["mean"][_MOVING], 0.0), 0.5 * self._tangent()

    def commit(self, q: Array) -> None:
        """Plastic flow."""
        start = self._committed["stress"][0].copy()
        trial = self._at(q)
        statics.update_plastic_deformations(self.column, start, trial, self._work)
        self._committed[0] = trial

    def energy(self) -> tuple[float, float]:
        """Stored and dissipated."""
        state, flexibility = self._committed[0], self.column["flexibility"][:, [0, 1, 3]]
        head = float(state["q"][U2])
        stored = 0.5 * float(np.sum(flexibility * state["stress"][:, :3] ** 2))
        spring = head - float(self.column["unstressed"])
        stored += 0.5 * float(self.column["spring"]) * spring**2 + float(self.column["load"]) * head
        return stored, float(state["dissipated"])


def column_problem() -> BenchProblem:
    """The column of the thesis hit at 15 m/s, with a head mass.

    Plastic flow is committed step by step, so that event-driven steps are of first order here too.
    """
    column = Column(
        *(find("HEB 220"), 0.8, 3.2),
        fillets=False,
        axial_load=0.5e6,
        restraint_stiffness=1e7,
        head_mass=95.25,
    )
    striker = 1500.0
    start = tuple(ColumnSystem(column, striker).start), (0.0, 0.0, 0.0, 15.0)
    return BenchProblem(
        "column of four unknowns",
        "certified",
        *(lambda: ColumnSystem(column, striker), Restitution(0.0), start, 0.03),
        steps=100,
        impacts=1,
        certified=1e-4,
    )


class StructureSystem(_Struck):
    """A planar structure struck at a dof: unknowns are its free dofs, then the striker."""

    def __init__(self, assembly: PlanarAssembly, dof: int, striker_mass: float) -> None:
        self.assembly = assembly
        self.free = np.setdiff1d(np.arange(assembly.size), assembly.held)
        self.mass = _with_striker(self._matrix(assembly.mass_times), striker_mass)
        unit = np.zeros((assembly.size, 1))
        unit[dof] = 1.0
        self.normals = np.vstack([unit[self.free], [[-1.0]]])
        self.start = np.append(assembly.displacement[self.free], 0.0)
        self._dissipated = 0.0

    def _matrix(self, product) -> Array:
        units = np.eye(self.assembly.size)[self.free]
        return np.array([product(unit)[self.free] for unit in units]).T

    def _all(self, q: Array) -> Array:
        x = self.assembly.displacement.copy()
        x[self.free] = q[:-1]
        return x

    def _forces(self, q: Array, weight: float | None) -> tuple[Array, Array]:
        force = self.assembly.assemble(self._all(q), weight) - self.assembly.load
        tangent = _with_striker(self._matrix(self.assembly.tangent_times), 0.0)
        return np.append(force[self.free], 0.0), tangent

    def forces(self, q: Array) -> tuple[Array, Array]:
        """Forces and tangent, see `laboratory.system.System`, as of the other methods."""
        return self._forces(q, None)

    def mean_forces(self, _q0: Array, q1: Array) -> tuple[Array, Array]:
        """The energy-exact forces of the elements from the committed place."""
        return self._forces(q1, 0.5)

    def commit(self, q: Array) -> None:
        """Plastic flow."""
        end = self._all(q)
        self.assembly.assemble(end, 0.5)
        energies = self.assembly.account(end, 0.5)
        self._dissipated += energies.plastic
        self.assembly.stored = energies.stored
        self.assembly.commit(end)

    def energy(self) -> tuple[float, float]:
        """Stored and dissipated."""
        dead = float(self.assembly.load @ self.assembly.displacement)
        return self.assembly.stored - dead, self._dissipated


def _portal() -> StructureSystem:
    """A clamped portal of four Reissner beams, 3 m high and wide, struck at mid-height."""
    layers, area = np.array([-0.05, 0.0, 0.05]), np.full(3, 0.004 / 3.0)
    law = LinearHardening(210e9, 355e6, 2.1e9)
    section = BeamSection(layers, area, law, 31.4, shear_stiffness=2.7e8)
    places = [(0.0, 0.0), (0.0, 1.5), (0.0, 3.0), (3.0, 3.0), (3.0, 0.0)]
    nodes = np.array([[0, 1], [1, 2], [2, 3], [3, 4]])
    beams = ReissnerBeams(nodes, np.zeros(len(nodes), dtype=np.int64), [section])
    portal = PlanarAssembly(places, [beams], lumped=True)
    portal.hold([portal.dof(foot, way) for foot in (0, 4) for way in ("u", "v", "rotation")])
    return StructureSystem(portal, portal.dof(1, "u"), 200.0)


def frame_problem() -> BenchProblem:
    """An elastic-plastic portal hit by 200 kg at 10 m/s: two fifths of the energy dissipate.

    As of the column, its answer is of first order; two schemes meet to two thousandths.
    """
    start = _portal().start
    return BenchProblem(
        "struck frame",
        "certified",
        *(_portal, Restitution(0.0), (tuple(start), (*np.zeros(len(start) - 1), 10.0)), 0.03),
        steps=150,
        certified=2e-3,
    )


PROBLEMS = {"column": column_problem, "frame": frame_problem}
