"""Beams in space for tests: elastic sections of four fibers, chains of elements, their momenta."""

import numpy as np

from workbench.mechanics.structures.equilibrium import equilibrium
from workbench.mechanics.structures.fibers.section import LinearHardening
from workbench.mechanics.structures.space import SpaceAssembly, SpaceBeams, SpaceSection

PLACES, TURNS = ("u", "v", "w"), ("turn_x", "turn_y", "rotation")


def elastic(modulus, area, strong, weak, torsion, mass=1.0, law=None):
    """Section with the second moments `strong` (of the height) and `weak`."""
    y = np.sqrt(strong / area) * np.array([1.0, 1.0, -1.0, -1.0])
    z = np.sqrt(weak / area) * np.array([1.0, -1.0, 1.0, -1.0])
    law = law or LinearHardening(modulus, 1e20)
    return SpaceSection(y=y, area=np.full(4, area / 4.0), law=law, mass_per_length=mass, z=z,
                        torsion=torsion)  # fmt: skip


def chain(points, section, heights, axes=None):
    """Elements from each point (n, 3) to the next."""
    points = np.asarray(points, dtype=float)
    ends = [(i, i + 1) for i in range(len(points) - 1)]
    beams = SpaceBeams(ends, np.zeros(len(ends), dtype=int), [section], heights, axes=axes)
    return SpaceAssembly(points, [beams])


def dofs(assembly, node, names=PLACES + TURNS):
    return [assembly.dof(node, name) for name in names]


def loaded(assembly, node, name, size, steps):
    """Equilibrium of a cantilever under a load at a node, brought on in steps."""
    assembly.hold(dofs(assembly, 0))
    total = np.zeros(assembly.size)
    for step in range(steps):
        total[assembly.dof(node, name)] = size * (step + 1) / steps
        given = assembly, total, assembly.displacement, assembly.held, 1e-9
        solution, _ = equilibrium(*given)
        assert solution.converged
        assembly.commit(solution.x)


def place(assembly, node):
    return assembly.coordinates[node] + assembly.displacement[dofs(assembly, node, PLACES)]


def momenta(assembly):
    """Momentum and angular momentum about the origin."""
    carried = assembly.mass_times(assembly.velocity)
    linear, angular = np.zeros(3), np.zeros(3)
    for node in range(len(assembly.coordinates)):
        along = carried[dofs(assembly, node, PLACES)]
        linear += along
        angular += np.cross(place(assembly, node), along) + carried[dofs(assembly, node, TURNS)]
    return linear, angular


def differences(assembly, x, weight, step=1e-6):
    """Tangent of the internal forces by central differences."""
    columns = []
    for unit in np.eye(assembly.size):
        ahead = assembly.assemble(x + step * unit, weight).copy()
        columns.append((ahead - assembly.assemble(x - step * unit, weight)) / (2.0 * step))
    return np.stack(columns, axis=1)
