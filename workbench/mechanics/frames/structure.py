"""A scenario's frame as an assembly: supports, masses, springs, dead loads and locks.

Models differ in the elements of the members only. They hand these over with a reader of the
members' states; everything else happens here.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any, Self, TypeVar

import numpy as np

from workbench.base.arrays import Array, Indices
from workbench.mechanics.structures.assembly import COMPONENTS, PlanarAssembly
from workbench.mechanics.structures.elements import ElementGroup
from workbench.mechanics.structures.paths import apply_loads
from workbench.mechanics.structures.time_steps import rigid_displacement
from workbench.scenarios import Frame, Load
from workbench.scenarios.parts import COMPONENT

Whole = TypeVar("Whole")
UPRIGHT = 1e-3  # run over rise of a member that counts as upright
POINTS = np.linspace(0.0, 1.0, 9)  # along a member, where its deformed shape is drawn


class MemberReader(ABC):
    """Reads the committed state of all members off their elements, in SI units.

    Two hinges per member, start and end. Axial forces are positive in tension, moments where they
    stretch the fibers on the right of somebody who looks from start to end.
    Arguments: the `elements`, one member after the other; `first` (members + 1,), where those of
    each member start.
    """

    def __init__(self, elements: ElementGroup, first: Indices) -> None:
        self.elements, self.first = elements, first
        self._ends: Indices = np.stack([first[:-1], first[1:] - 1], axis=1).ravel()
        self._signs: Array = np.resize([-1.0, 1.0], len(self._ends))
        self._side: Indices = np.resize([0, 1], len(self._ends))

    def axial_forces(self) -> Array:
        """Axial forces (hinges,)."""
        return np.asarray(self.elements.local_forces[..., self._ends, 0])

    def moments(self) -> Array:
        """Bending moments (hinges,)."""
        return self._signs * self.elements.local_forces[..., self._ends, 1 + self._side]

    def of_member(self, number: int) -> slice:
        """Elements of a member."""
        return slice(int(self.first[number]), int(self.first[number + 1]))

    def reading(self, elements: ElementGroup) -> Self:
        """Reader of a copy of the elements."""
        other = copy(self)
        other.elements = elements
        return other

    @abstractmethod
    def plastic_rotations(self) -> Array:
        """Plastic rotations (hinges,), those of the joints included."""

    def plastic_shear(self) -> Array | None:
        """Plastic shear displacement of each member (members,) in m; None where no web yields."""
        return None

    @abstractmethod
    def utilisation(self) -> Array:
        """Utilisation of the sections (hinges,) under N and M: 1 on the yield surface."""

    @abstractmethod
    def shear_forces(self) -> Array:
        """Largest shear force of each member (members,), without sign."""

    def unyielding_shear(self) -> Array:
        """Shear force of each member (members,), mean along it; zero where shear yields.

        Its end moments over its length: waves that run along it leave the mean.
        """
        return self.shear_forces()

    def shear_strains(self) -> Array | None:
        """Mean shear strain of each member (members,), without sign; None unless shear yields."""
        return None

    def contractions(self) -> Array:
        """Loss of length along the axis of each member (members,)."""
        return -np.add.reduceat(self.elements.elongations, self.first[:-1], axis=-1)

    def lengths_left(self) -> Array:
        """Least length of an element of each member over its initial one (members,).

        Where no element must vanish the length is 1.
        """
        elements = self.elements
        if not elements.crumples:
            return np.ones(len(self.first) - 1)
        left = 1.0 + elements.elongations / elements.lengths
        return np.asarray(np.minimum.reduceat(left, self.first[:-1], axis=-1))

    @abstractmethod
    def shapes(self, assembly: PlanarAssembly) -> Array:
        """Displaced positions (members, points, 2) in m at the `POINTS` of each member."""


@dataclass(frozen=True)
class FrameStructure:
    """A frame under its dead loads, ready to be hit, pushed or shaken.

    `assembly`, whose first nodes are those of the `frame`; `members` read their states;
    `start`, the displacements (dofs,) from which those of the response count; `watched`, further
    histories of the response by name: dof and sign of a displacement since the unloaded state;
    names of its `hinges`, where they are not those of the members' ends; results
    `kept` of it, shared by its copies.
    """

    frame: Frame
    assembly: PlanarAssembly
    members: MemberReader
    start: Array
    watched: Mapping[str, tuple[int, float]] = field(default_factory=dict)
    hinges: Sequence[str] = ()
    kept: dict[str, Any] = field(default_factory=dict, compare=False, repr=False)

    @property
    def is_column(self) -> bool:
        """Whether it stands for a column, whose head cannot drift."""
        return bool(self.hinges)

    @property
    def sense(self) -> float:
        """Sign of the reported moments: those of a column are positive at the base.

        The strike on it flies along +x and it goes up, which is the other way round in a frame.
        """
        return -1.0 if self.is_column else 1.0

    def fresh(self) -> Self:
        """Copy of the structure in a state of its own, which a run may change."""
        assembly = self.assembly.copy()
        members = self.members.reading(assembly.groups[0])
        return replace(self, assembly=assembly, members=members)

    def seen(self) -> Self:
        """Copy of the structure, of which other states can be shown."""
        assembly = _again(self.assembly)
        assembly.groups = tuple(map(_again, assembly.groups))
        structure, members = _again(self), _again(self.members)
        members.elements = assembly.groups[0]
        vars(structure).update(assembly=assembly, members=members)
        return structure

    def dof(self, node: str, direction: str) -> tuple[int, float]:
        """Dof and sign of a node's motion along `direction` (x, y or rotation, with a sign)."""
        sign = -1.0 if direction.startswith("-") else 1.0
        component = COMPONENT[direction.lstrip("+-")]
        return self.assembly.dof(self.frame.number[node], component), sign

    def pattern(self, loads: Sequence[Load]) -> Array:
        """Nodal forces (dofs,) of `loads`."""
        return nodal_forces(self.frame, self.assembly, loads)

    def line_load(self, members: Sequence[str], direction: str) -> Array:
        """Nodal forces (dofs,) of 1 N/m on `members` along x or y, with a sign.

        Half of what stands on an element acts at each of its ends, which does the work of the line
        load in any mechanism of the elements.
        """
        sign, sizes = (
            -1.0 if direction.startswith("-") else 1.0,
            np.zeros((len(self.frame.members), 2)),
        )
        rows = [member_names(self.frame).index(name) for name in members]
        sizes[rows, "xy".index(direction.lstrip("+-"))] = sign
        return line_forces(self.assembly, self.members, sizes)


def line_forces(assembly: PlanarAssembly, members: MemberReader, loads: Array) -> Array:
    """Nodal forces (dofs,) of line `loads` on members, along x and y in N/m (members, 2)."""
    forces, elements = np.zeros(assembly.size), members.elements
    for number in np.flatnonzero(loads.any(axis=1)):
        part = members.of_member(int(number))
        for load, component in zip(loads[number], "uv", strict=True):
            for end in elements.nodes[part].T:
                np.add.at(
                    forces, assembly.dofs(end, component), 0.5 * load * elements.lengths[part]
                )
    return forces


def hinge_names(frame: Frame) -> tuple[str, ...]:
    """Names of the two hinges of every member, in the order of the members."""
    return tuple(f"{member.name}:{end}" for member in frame.members for end in ("start", "end"))


def member_names(frame: Frame) -> tuple[str, ...]:
    """Names of the members in their order."""
    return tuple(member.name for member in frame.members)


@lru_cache(maxsize=64)
def upright_names(frame: Frame) -> tuple[str, ...]:
    """Names of the members that stand upright, in their order."""
    run, rise = np.abs(frame.chords.T)
    return tuple(frame.members[i].name for i in np.flatnonzero(run < UPRIGHT * rise))


def _again(whole: Whole) -> Whole:
    """A shallow copy, as of `copy.copy`, which takes five times as long."""
    other = object.__new__(type(whole))
    vars(other).update(vars(whole))
    return other


def nodal_loads(frame: Frame, loads: Sequence[Load]) -> Array:
    """Forces along x and y and moments of `loads` at the nodes of a frame (nodes, 3)."""
    total = np.zeros((len(frame.nodes), 3))
    for load in loads:
        total[frame.number[load.node]] += load.x, load.y, load.moment
    return total


def nodal_forces(frame: Frame, assembly: PlanarAssembly, loads: Sequence[Load]) -> Array:
    """Forces and moments (dofs,) of `loads` at the nodes of the frame."""
    forces = np.zeros(assembly.size)
    for component, values in zip(COMPONENTS, nodal_loads(frame, loads).T, strict=True):
        forces[assembly.dofs(range(len(frame.nodes)), component)] = values
    return forces


def _counted(frame: Frame) -> list[Load]:
    """Loads that take off the weight of nodal masses as far as dead loads bring it already."""
    (x, y), stood = frame.gravity, frame.load_masses
    masses = {node.name: -min(node.mass, stood.get(node.name, 0.0)) for node in frame.nodes}
    return [Load(name, x=x * mass, y=y * mass) for name, mass in masses.items() if mass]


@lru_cache(maxsize=64)
def dead_loads(frame: Frame) -> tuple[Load, ...]:
    """Dead loads of a frame at its nodes, half of line loads and, under gravity, of own weight."""
    if not any(frame.gravity) and not frame.line_loads.any():
        return frame.loads
    lines = frame.line_loads + np.outer(frame.each("mass_per_length"), frame.gravity)
    forces = np.outer([node.mass for node in frame.nodes], frame.gravity)
    np.add.at(forces, frame.ends, (0.5 * frame.lengths[:, None] * lines)[:, None])
    pairs = zip(frame.nodes, forces.tolist(), strict=True)
    return (*frame.loads, *_counted(frame), *(Load(node.name, x=x, y=y) for node, (x, y) in pairs))


def own_weight(frame: Frame, assembly: PlanarAssembly) -> Array:
    """Forces (dofs,) of all masses under the gravity of the frame, but for which loads stand."""
    x, y = frame.gravity
    pull = x * rigid_displacement(assembly, "x") + y * rigid_displacement(assembly, "y")
    return assembly.mass_times(pull) + nodal_forces(frame, assembly, _counted(frame))


def stand_frame(
    frame: Frame,
    coordinates: Array,
    groups: Sequence[ElementGroup],
    members: MemberReader,
    *,
    ties: Iterable[tuple[int, int]] = (),
    rotary_inertia: Array | None = None,
) -> FrameStructure:
    """Support a frame, bring its dead loads on, then its springs and locks.

    Arguments: `coordinates` (nodes, 2) in m, those of the frame's nodes first and in their order;
    element `groups`, and the reader of its `members`; `ties`, pairs
    (master, slave) of nodes that share translations only; `rotary_inertia`
    (nodes,) in kg m2, beside what frame and members give. Springs are unstressed, and locked nodes
    stand still, once the dead loads are on. Raises `SolverError` when those find no equilibrium.
    """
    assembly = PlanarAssembly(coordinates, groups, ties=ties)
    held = [(number, part) for number, node in enumerate(frame.nodes) for part in node.held]
    held += [(number, "rotation") for number in free_to_spin(frame)]
    assembly.hold([assembly.dof(*each) for each in held])
    for number, node in enumerate(frame.nodes):
        if node.mass or node.rotary_inertia:
            assembly.add_mass(number, node.mass, node.rotary_inertia)
    if rotary_inertia is not None:
        assembly.add_rotary_inertia(rotary_inertia)
    assembly.load = nodal_forces(frame, assembly, frame.loads)
    if any(frame.gravity):
        assembly.load += own_weight(frame, assembly)
    if frame.line_loads.any():
        assembly.load += line_forces(assembly, members, frame.line_loads)
    if np.any(assembly.load):
        apply_loads(assembly)
    for number, node in enumerate(frame.nodes):
        for direction, component in COMPONENT.items():
            stiffness = getattr(node, f"spring_{direction}")
            if stiffness > 0.0:
                assembly.add_spring(assembly.dof(number, component), stiffness)
        if node.locked != "none":
            assembly.hold([assembly.dof(number, COMPONENT[node.locked])])
    assembly.assemble(assembly.displacement, None)
    assembly.stored = assembly.account(assembly.displacement, 0.5).stored
    return FrameStructure(frame, assembly, members, assembly.displacement.copy())


def free_to_spin(frame: Frame) -> list[int]:
    """Numbers of nodes whose rotation nothing resists: every member there ends in a pin."""
    nodes = enumerate(frame.nodes)
    return [i for i, n in nodes if n.name not in frame.turned and n.spring_rotation == 0.0]
