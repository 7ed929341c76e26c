"""Small displacements of a frame of elastic Bernoulli beams: unit loads, mass, buckling.

Displacements of the nodes and forces at member ends are exact for loads at the nodes. Mass and
geometric stiffness are consistent with the cubic deflection (Przemieniecki 1968).
"""

from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import block_diag, eigh

from workbench.arrays import Array
from workbench.frames.structure import hinge_names, nodal_loads
from workbench.scenarios import Frame, Load, Member
from workbench.scenarios.frame_parts import COMPONENT
from workbench.structures.assembly import COMPONENTS

NO_STIFFNESS = 1e-11  # eigenvalue of the scaled stiffness that counts as none
UNBALANCED = 1e-6  # share of a load that meets no stiffness
LEAST_SOFTENING = 1e-9  # share of the stiffness; what is less is rounding


class ElasticFrame:
    """The elastic frame for small displacements from its state under dead loads.

    Arguments: `frame`; names of the `members` that count (None: all); `springs`, whether springs
    to the ground and locks act, as they do once the dead loads are on; beams (`parts`) per member.
    """

    def __init__(
        self,
        frame: Frame,
        members: Collection[str] | None = None,
        *,
        springs: bool = True,
        parts: int = 1,
    ) -> None:
        self._frame = frame
        self._first = {node.name: 3 * i for i, node in enumerate(frame.nodes)}
        self._counted = [members is None or m.name in members for m in frame.members]
        # of each member: dofs of its parts, stiffness of a part, to local axes
        self._beams: list[tuple[Array, Array, Array]] = []
        self._parts = parts
        own = 2 + 3 * (parts - 1)  # dofs of a member: rotations at joints, nodes between parts
        size = 3 * len(frame.nodes) + own * len(frame.members)
        self.stiffness: Array = np.zeros((size, size))
        self.mass: Array = np.zeros((size, size))
        for number, member in enumerate(frame.members):
            self._place(member, 3 * len(frame.nodes) + own * number, self._counted[number])
        held = []
        for node in frame.nodes:
            at = self._first[node.name]
            self.mass[range(at, at + 3), range(at, at + 3)] += node.mass, node.mass, 0.0
            self.mass[at + 2, at + 2] += node.rotary_inertia
            held += [at + COMPONENTS[component] for component in node.held]
            if springs:
                given = (node.spring_x, node.spring_y, node.spring_rotation)
                self.stiffness[range(at, at + 3), range(at, at + 3)] += given
                if node.locked != "none":
                    held.append(at + COMPONENTS[COMPONENT[node.locked]])
        resisting = np.flatnonzero(np.diag(self.stiffness) > 0.0)
        self._free = np.setdiff1d(resisting, held)
        self._held = np.array(sorted(held), dtype=np.int64)
        scale = 1.0 / np.sqrt(np.diag(self.stiffness)[self._free])
        values, modes = np.linalg.eigh(
            self.stiffness[np.ix_(self._free, self._free)] * np.outer(scale, scale)
        )
        self._stiff = values > NO_STIFFNESS * max(values.max(initial=0.0), 1e-300)
        self._values, self._modes = values, scale[:, None] * modes

    def _place(self, member: Member, spare: int, counted: bool) -> None:
        """Add stiffness and mass of a member; its own dofs begin with `spare`."""
        frame = self._frame
        start, end = frame.node(member.start), frame.node(member.end)
        chord = np.array([end.x - start.x, end.y - start.y])
        length = float(np.hypot(*chord))
        dofs = np.concatenate([self._first[n] + np.arange(3) for n in (member.start, member.end)])
        joints = [frame.joint(name) for name in (member.joint_start, member.joint_end)]
        properties, modulus = frame.properties(member), frame.steel.elastic_modulus
        softness = length / (modulus * properties.area)
        for side, joint in enumerate(joints):
            softness += 0.0 if joint.axial_stiffness is None else 1.0 / joint.axial_stiffness
            if joint.rotational_stiffness is not None:
                node, dofs[3 * side + 2] = dofs[3 * side + 2], spare + side
                if counted:
                    grid = np.ix_([node, spare + side], [node, spare + side])
                    coupling = joint.rotational_stiffness * np.array([[1.0, -1.0], [-1.0, 1.0]])
                    self.stiffness[grid] += coupling
        local = _axes(chord / length)
        part = length / self._parts
        stiffness = _stiffness(self._parts / softness, modulus * properties.second_moment, part)
        mass = _mass(properties.mass_per_length * part, part)
        between = spare + 2 + np.arange(3 * (self._parts - 1)).reshape(-1, 3)
        line = np.vstack([dofs[:3], between, dofs[3:]])
        beams = np.hstack([line[:-1], line[1:]])
        self._beams.append((beams, stiffness, local))
        for own in beams if counted else ():
            self.stiffness[np.ix_(own, own)] += local.T @ stiffness @ local
            self.mass[np.ix_(own, own)] += local.T @ mass @ local

    def load(self, loads: Sequence[Load]) -> Array:
        """Nodal forces and moments (dofs,)."""
        total = np.zeros(len(self.stiffness))
        forces = nodal_loads(self._frame, loads)
        total[: forces.size] = forces.ravel()
        return total

    def displacement(self, load: Array) -> Array | None:
        """Displacements (dofs,) under a load; None where something moves without resistance."""
        moved = np.zeros(len(load))
        carried = np.concatenate([self._free, self._held])
        loose = np.delete(load, carried)
        shares = self._modes.T @ load[self._free]
        lost = np.linalg.norm(shares[~self._stiff])
        if np.any(loose) or lost > UNBALANCED * np.linalg.norm(shares):
            return None
        stiff = self._stiff
        moved[self._free] = self._modes[:, stiff] @ (shares[stiff] / self._values[stiff])
        return moved

    @property
    def is_mechanism(self) -> bool:
        """Whether something can move without resistance."""
        return not bool(np.all(self._stiff))

    def buckling_factor(self, axial: Array) -> float:
        """Factor on `axial` forces (hinges,) at which the frame, no mechanism, buckles.

        Forces in N, tension positive, as `end_forces` gives them. Infinite without compression.
        """
        softening = np.zeros_like(self.stiffness)
        for i, (beams, _, local) in enumerate(self._beams):
            bow = _geometric(self._frame.length(self._frame.members[i]) / self._parts)
            for dofs in beams:
                softening[np.ix_(dofs, dofs)] += axial[2 * i] * local.T @ bow @ local
        grid = np.ix_(self._free, self._free)
        lowest = eigh(
            softening[grid], self.stiffness[grid], eigvals_only=True, subset_by_index=[0, 0]
        )[0]
        return np.inf if lowest > -LEAST_SOFTENING else -1.0 / float(lowest)

    def vibrations(self, load: Array) -> tuple[Array, Array]:
        """Periods (s) of the modes, and how far each swings after an impulse along a `load`.

        Both (modes,), without those that have no mass or move without resistance.
        """
        shapes = self._modes[:, self._stiff] / np.sqrt(self._values[self._stiff])
        squares, modes = eigh(shapes.T @ self.mass[np.ix_(self._free, self._free)] @ shapes)
        moved = (modes.T @ (shapes.T @ load[self._free])) ** 2
        heavy = squares > NO_STIFFNESS * squares.max(initial=0.0)
        slowness = np.sqrt(squares[heavy])  # 1 / omega
        return 2.0 * np.pi * slowness, moved[heavy] / slowness

    def end_forces(self, displacement: Array) -> tuple[Array, Array]:
        """Axial forces and moments (hinges,) at the ends of all members, see `hinge_names`.

        Axial forces are positive in tension, moments where they stretch the fibers on the right
        of somebody who looks from start to end; zero in members that do not count.
        """
        axial, moment = np.zeros((2, len(hinge_names(self._frame))))
        for i, (beams, stiffness, local) in enumerate(self._beams):
            if self._counted[i]:
                first, last = (stiffness @ local @ displacement[beams[j]] for j in (0, -1))
                axial[2 * i : 2 * i + 2] = last[3]
                moment[2 * i : 2 * i + 2] = -first[2], last[5]
        return axial, moment


def _axes(direction: Array) -> Array:
    """Rotation of element dofs from global to local axes (6, 6)."""
    c, s = direction
    turn = [[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]
    return np.asarray(block_diag(turn, turn))


def _local(lengthwise: ArrayLike, across: ArrayLike) -> Array:
    """Matrix (6, 6) in local axes, of axial displacements (2, 2) and of deflections (4, 4)."""
    matrix = np.zeros((6, 6))
    matrix[np.ix_([0, 3], [0, 3])] = lengthwise
    matrix[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] = across
    return matrix


def _stiffness(axial: float, bending: float, length: float) -> Array:
    """Stiffness of a beam in local axes (6, 6): `axial` in N/m, `bending` EI in N m2."""
    a, b, c = 12.0 / length**2, 6.0 / length, 4.0
    rows = [[a, b, -a, b], [b, c, -b, 0.5 * c], [-a, -b, a, -b], [b, 0.5 * c, -b, c]]
    return _local([[axial, -axial], [-axial, axial]], bending / length * np.array(rows))


def _geometric(length: float) -> Array:
    """Geometric stiffness of a beam under unit tension in local axes (6, 6)."""
    a, b, c, d = 36.0, 3.0 * length, 4.0 * length**2, -(length**2)
    rows = [[a, b, -a, b], [b, c, -b, d], [-a, -b, a, -b], [b, d, -b, c]]
    return _local(np.zeros((2, 2)), np.array(rows) / (30.0 * length))


def _mass(mass: float, length: float) -> Array:
    """Consistent mass of a beam in local axes (6, 6)."""
    a, b, c = 22.0 * length, 13.0 * length, length**2
    rows = [
        [156.0, a, 54.0, -b],
        [a, 4 * c, b, -3 * c],
        [54.0, b, 156.0, -a],
        [-b, -3 * c, -a, 4 * c],
    ]
    lengthwise = mass / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]])
    return _local(lengthwise, mass / 420.0 * np.array(rows))
