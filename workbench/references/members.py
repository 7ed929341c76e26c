"""A frame of fiber beams: members cut into elements, joints as springs, what is read off."""

from math import inf

import numpy as np

from workbench.arrays import Array, Indices
from workbench.frames.structure import POINTS, MemberReader
from workbench.references.fiber_mesh import FrameMesh
from workbench.scenarios import Frame
from workbench.structures.assembly import PlanarAssembly
from workbench.structures.fibers import FiberElements
from workbench.structures.joints import JointSpring, JointSprings

ENVELOPE = 181  # points of the exact interaction curve
STIFF = 1e3  # stiffness of a rigid joint of limited strength over that of its member


class FiberMembers(MemberReader):
    """Reads the members of a frame off their fiber elements.

    Arguments: the `frame`, its `mesh`, its elements `beams`, its `springs` (None without joints);
    `sampled`, where an element samples plasticity, from its end next to a hinge and over its
    length; `shear_yields`, whether yielding limits the shear force.
    """

    def __init__(
        self,
        frame: Frame,
        mesh: FrameMesh,
        beams: FiberElements,
        springs: JointSprings | None,
        sampled: float,
        shear_yields: bool,
    ) -> None:
        super().__init__(beams, mesh.first)
        self._mesh, self._beams, self._springs = mesh, beams, springs
        self._sampled, self._shear_yields = sampled, shear_yields
        sections = [frame.strength_section(member) for member in frame.members]
        steel = frame.steel
        self._squash = np.repeat([s.squash_load(steel) for s in sections], 2)
        self._plastic = np.repeat([s.plastic_moment(steel) for s in sections], 2)
        radii = {s: np.hypot(*s.interaction_envelope(ENVELOPE)) for s in set(sections)}
        self._radii = np.repeat(np.stack([radii[s] for s in sections]), 2, axis=0)
        self._half = 2 * mesh.member + mesh.upper
        self._hinge = np.array([2 * m + (not start) for m, start, _, _ in mesh.joints], dtype=int)
        self._dofs: tuple[Indices, Indices] | None = None

    def plastic_rotations(self) -> Array:
        """Plastic curvature integrated over the half member next to each end, and its joint."""
        rotation = np.bincount(
            self._half, weights=self._beams.plastic_rotations(), minlength=len(self._ends)
        ).astype(float)
        if self._springs is not None:
            rotation[self._hinge] += self._springs.plastic
        return rotation

    def utilisation(self) -> Array:
        """Radius of (N/Np, M/Mp) over that of the exact envelope, where the end is sampled.

        Of the joint there, if more of its strength is used.
        """
        local = self._beams.local_forces[self._ends]
        rows = np.arange(len(local))
        near = self._signs * local[rows, 1 + self._side]
        far = -self._signs * local[rows, 2 - self._side]
        moment = (1.0 - self._sampled) * near + self._sampled * far
        n, m = np.abs(local[:, 0]) / self._squash, np.abs(moment) / self._plastic
        at = np.arctan2(n, m) / (0.5 * np.pi) * (ENVELOPE - 1)
        low = np.minimum(at.astype(int), ENVELOPE - 2)
        rows = np.arange(len(at))
        share = at - low
        bound = (1.0 - share) * self._radii[rows, low] + share * self._radii[rows, low + 1]
        used = np.asarray(np.hypot(n, m) / bound)
        if self._springs is not None:
            np.maximum.at(used, self._hinge, self._springs.utilisation())
        return used

    def shear_forces(self) -> Array:
        """Shear force of each member (members,), mean along it."""
        return self._mean(self._beams.shear_forces)

    def shear_strains(self) -> Array | None:
        """Shear strain of each member (members,), mean along it; None unless shear yields."""
        return self._mean(self._beams.shear_strains) if self._shear_yields else None

    def _mean(self, values: Array) -> Array:
        """Magnitude of the mean along each member (members,) of values (elements,)."""
        mesh = self._mesh
        weighted = np.add.reduceat(values * mesh.lengths, mesh.first[:-1])
        return np.abs(weighted / np.add.reduceat(mesh.lengths, mesh.first[:-1]))

    def shapes(self, assembly: PlanarAssembly) -> Array:
        """Displaced positions (members, points, 2), straight between the nodes."""
        mesh = self._mesh
        if self._dofs is None:
            count = range(len(mesh.coordinates))
            self._dofs = assembly.dofs(count, "u"), assembly.dofs(count, "v")
        moved = [assembly.displacement[dofs] for dofs in self._dofs]
        position = mesh.coordinates + np.stack(moved, axis=1)
        shapes = np.empty((len(mesh.first) - 1, len(POINTS), 2))
        for shape, first, last in zip(shapes, mesh.first[:-1], mesh.first[1:], strict=True):
            line = np.append(mesh.nodes[first:last, 0], mesh.nodes[last - 1, 1])
            at = np.concatenate([[0.0], np.cumsum(mesh.lengths[first:last])])
            for axis in range(2):
                shape[:, axis] = np.interp(POINTS * at[-1], at, position[line, axis])
        return shapes


def joint_springs(frame: Frame, mesh: FrameMesh) -> JointSprings | None:
    """Rotational springs between members and their nodes; None where no joint turns.

    A rigid joint of limited strength gets `STIFF` times 4 EI/L of its member. Bounds that a joint
    does not give are those of the member, whose fibers yield by themselves.
    """
    if not mesh.joints:
        return None
    pairs, springs = [], []
    for index, at_start, master, slave in mesh.joints:
        member = frame.members[index]
        joint = frame.joint(member.joint_start if at_start else member.joint_end)
        stiffness = joint.rotational_stiffness
        if stiffness is None:
            bending = frame.steel.elastic_modulus * frame.properties(member).second_moment
            stiffness = STIFF * 4.0 * bending / frame.length(member)
        positive, negative = joint.plastic_moment, joint.plastic_moment_negative
        springs.append(JointSpring(stiffness, positive or inf, negative or inf))
        pairs.append((master, slave) if at_start else (slave, master))
    return JointSprings(pairs, springs)
