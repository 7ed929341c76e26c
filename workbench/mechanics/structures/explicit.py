"""Explicit impact driver: central differences, lumped mass, contact by impulses.

With accelerations a_n = M^-1 (p - f_n) and velocities at half steps,
  v_n+1/2 = v_n-1/2 + dt a_n + M^-1 w P,   x_n+1 = x_n + dt v_n+1/2,
and the contact impulse P obeys Newton's law between the half-step velocities, so that bodies in
contact stay together without drift. The ledger is that of the scheme itself: with the kinetic
energy T_n = v_n-1/2 . M v_n+1/2 / 2 (P left out) every step balances the trapezoidal work of the
nodal forces exactly. What remains is the difference of that work from the trapezoidal work of the
section forces, of third order in a turn; it grows when the step is unstable.
Sources: Belytschko, Liu and Moran 2000, section 6.2; Moreau 1988.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import ceil, sqrt
from typing import NamedTuple

import numpy as np
from scipy.sparse.linalg import LinearOperator, eigsh

from workbench.base.arrays import Array, Indices
from workbench.base.errors import SolverError
from workbench.mechanics.impact import contact
from workbench.mechanics.impact.contact import force_at
from workbench.mechanics.impact.integrator import law_of
from workbench.mechanics.structures.elements import StepEnergies
from workbench.mechanics.structures.equilibrium import ExplicitStructure
from workbench.mechanics.structures.impact import PointMass, TimeStep, check_count

SAFETY = 0.9  # of the stability limit: yielding softens, but tension and contact stiffen
LARGEST_ERROR = 0.02  # of the energy brought in; beyond it the step is taken to be unstable
LEDGER_WEIGHT = 0.5  # the trapezoidal rule


def lumped_mass(assembly: ExplicitStructure) -> Array:
    """Mass of every dof (dofs,) of an assembly with lumped mass; held dofs get infinite mass.

    Raises ValueError if the mass matrix is not diagonal or a free dof has no mass.
    """
    ones = np.ones(assembly.size)
    alternating = np.resize([1.0, -1.0, 2.0, 3.0], assembly.size)
    mass = assembly.mass_times(ones)
    if not np.allclose(assembly.mass_times(alternating), mass * alternating, rtol=1e-12):
        raise ValueError("explicit steps need an assembly with lumped mass")
    mass[assembly.held] = np.inf
    if np.any(mass <= 0.0):
        raise ValueError("explicit steps need mass at every free dof")
    return mass


def stable_step(assembly: ExplicitStructure) -> float:
    """Largest stable time step 2 / omega_max of the committed state, in s."""
    assembly.assemble(assembly.displacement, None)
    root = 1.0 / np.sqrt(lumped_mass(assembly))  # 0 at held dofs

    def product(x: Array) -> Array:
        return root * assembly.tangent_times(root * x.ravel())

    operator = LinearOperator((assembly.size, assembly.size), matvec=product, dtype=float)
    start = np.resize([1.0, -1.0, 0.5], assembly.size)  # fixed, so that runs repeat exactly
    largest = eigsh(operator, k=1, which="LA", v0=start, tol=1e-6, return_eigenvectors=False)
    return float(2.0 / np.sqrt(largest[0]))


class Face(NamedTuple):
    """A striker's face: the dofs that it meets and their `shares` of its force, with their sense.

    Its place is the mean of theirs, by the same shares.
    """

    dofs: Indices
    shares: Array


def explicit_impact(
    assembly: ExplicitStructure,
    dof: int | Face,
    striker: PointMass,
    spans: Sequence[tuple[float, float]],
    step: float = np.inf,
    *,
    sign: float = 1.0,
) -> Iterator[TimeStep]:
    """Follow an impact at a dof, or of a face, along growing displacement or against it.

    Arguments: `assembly` with lumped mass, at rest under its dead loads; `striker`; `spans`, end
    times and intervals between records of successive parts of the record, both in s; longest
    time `step` in s, which is reduced to `SAFETY` times the stability limit; `sign`, -1 for a
    strike along the negative direction.
    Yields a `TimeStep` for every record: its sums run over all steps since the last one, its
    `kinetic` energy is that of the scheme. Raises `SolverError` when the energy balance is lost.
    """
    duration, law = spans[-1][0], law_of(striker.crushing)
    mass = lumped_mass(assembly)
    free = np.isfinite(mass)
    inverse = 1.0 / mass
    at, shares = dof if isinstance(dof, Face) else Face(np.array([dof]), np.ones(1))
    shares = sign * shares
    node_mass = 1.0 / float(shares**2 @ inverse[at])
    stable = stable_step(assembly)
    if law["points"]:  # its spring adds at most so much to the square of the highest frequency
        square = law["unloading"] * (1.0 / node_mass + 1.0 / striker.mass)
        stable = 1.0 / sqrt(1.0 / stable**2 + 0.25 * square)
    shortest = min(step, SAFETY * stable)
    check_count(duration / shortest)
    count = ceil(duration / shortest)
    dt = duration / count
    assembly.begin_step(dt)

    acceleration = inverse * (assembly.load - assembly.resist(assembly.displacement))
    half = assembly.velocity - 0.5 * dt * acceleration
    velocity, position = striker.velocity - 0.5 * dt * striker.gravity, striker.position
    origin = float(shares @ assembly.displacement[at])
    brought = striker.kinetic_energy + assembly.kinetic_energy()
    reference = brought + assembly.stored
    spent = 0.0
    done = 0
    for record in _records(spans, dt):
        total = loss = plastic = ideal = 0.0
        begin, start = assembly.displacement, position
        for _ in range(record - done):
            before = float(shares @ half[at]) - velocity
            half = half + dt * acceleration
            velocity += dt * striker.gravity
            gap = float(shares @ assembly.displacement[at]) - origin - position
            impulse = 0.0
            if law["points"]:
                law["crushed"] = max(law["crushed"], -gap)
                impulse = dt * force_at(law, -gap)[0]
            elif gap + dt * min(before, 0.0) <= 0.0:
                without = float(shares @ half[at]) - velocity
                masses = node_mass, striker.mass
                impulse = contact.explicit_percussion(without, before, striker.restitution, *masses)
            if impulse > 0.0:
                half[at] += impulse * shares * inverse[at]
                velocity -= impulse / striker.mass
                after = float(shares @ half[at]) - velocity
                loss += contact.contact_loss(impulse, before, after)
                total += impulse
            position += dt * velocity
            end = assembly.displacement + dt * half
            acceleration = inverse * (assembly.load - assembly.resist(end))
            energies = assembly.account(end, LEDGER_WEIGHT)
            plastic += energies.plastic
            ideal += energies.ideal
            assembly.commit(end)
        assembly.velocity = half + 0.5 * dt * acceleration
        assembly.stored = energies.stored
        speed = velocity + 0.5 * dt * striker.gravity
        moving = replace(striker, velocity=speed, position=position)
        external = float(assembly.load @ (assembly.displacement - begin))
        external += striker.mass * striker.gravity * (position - start)
        next_half = half + dt * acceleration
        kinetic = 0.5 * float(np.sum(mass[free] * half[free] * next_half[free]))
        spent += plastic + loss - external
        error = kinetic + moving.kinetic_energy + energies.stored + spent - reference
        if not abs(error) <= LARGEST_ERROR * brought:
            raise SolverError(
                f"time {record * dt:.6g} s",
                abs(error) / brought,
                f"explicit steps of {dt:.3g} s: the energy balance is lost, reduce the step",
            )
        yield TimeStep(
            time=record * dt,
            length=(record - done) * dt,
            striker=moving,
            impulse=total,
            contact_loss=loss,
            energies=StepEnergies(energies.stored, plastic, 0.0, ideal),
            external_work=external,
            kinetic=kinetic,
            evaluations=record - done,
        )
        done = record


def _records(spans: Sequence[tuple[float, float]], dt: float) -> Iterator[int]:
    """Numbers of the steps after which to record."""
    begin = 0
    for time, interval in spans:
        end = round(time / dt)
        if end > begin:
            count = max(1, ceil((end - begin) * dt / interval - 1e-9))
            marks = np.linspace(begin, end, count + 1).round().astype(int)
            yield from np.unique(marks[marks > begin]).tolist()
            begin = end
