"""Two masses and two springs, stepped through by the leapfrog rule (Heng 2017, figure 3.1).

    m_A x''  + R_1(x - v) = 0            striker, with the spring R_1 of what crushes
    m_B v''  - R_1(x - v) + R_2(v) = 0   impact mass of the column on its resistance R_2

R_1 is linear up to the crush force, flows there, unloads with its stiffness and cannot pull. The
velocities are those between two steps, so that steps are explicit, of second order and bounded in
energy below the stability limit.
"""

from typing import NamedTuple

from workbench.compiled import njit
from workbench.models.single_dof.kernels import (
    COLLAPSE,
    OK,
    spring_at_rest,
    spring_energy,
    spring_moved,
)


class Meeting(NamedTuple):
    """Masses (kg) of column and striker, its velocity (m/s); crush stiffness (N/m) and force (N).

    The force is infinite where the striker stays elastic.
    """

    mass: float
    striker: float
    velocity: float
    stiffness: float
    crush_force: float


@njit(cache=True, error_model="numpy")
def crush(approach, crushed, meeting):
    """Contact force and crushed length of an `approach` x - v (m), `crushed` before."""
    force = max(meeting.stiffness * (approach - crushed), 0.0)
    if force > meeting.crush_force:
        crushed = approach - meeting.crush_force / meeting.stiffness
        force = meeting.crush_force
    return force, crushed


@njit(cache=True, error_model="numpy")
def impact(dt, meeting, elastic_limit, limit, pieces, records):
    """Follow the impact in steps of `dt`; returns (status, last step, final spring, crushed).

    `records` (steps + 1,) of the RECORD of `single_dof` are zero at first. COLLAPSE when v passes
    `limit`.
    """
    spring = spring_at_rest(elastic_limit, pieces)
    m_column, m_striker = meeting.mass, meeting.striker
    w, x, wx, crushed, lost, contact = 0.0, 0.0, meeting.velocity, 0.0, 0.0, 0.0
    records[0].striker_velocity = wx
    records[0].kinetic = 0.5 * m_striker * wx**2
    for n in range(1, records.size):
        half, half_x = (
            w + 0.5 * dt * (contact - spring.force) / m_column,
            wx - 0.5 * dt * contact / m_striker,
        )
        before, spent = contact, crushed
        spring = spring_moved(spring, spring.v + dt * half, pieces)
        x += dt * half_x
        contact, crushed = crush(x - spring.v, crushed, meeting)
        lost += meeting.crush_force * (crushed - spent) if crushed > spent else 0.0
        w = half + 0.5 * dt * (contact - spring.force) / m_column
        wx = half_x - 0.5 * dt * contact / m_striker
        row = records[n]
        row.displacement, row.velocity, row.striker_velocity = spring.v, w, wx
        row.percussion, row.force = 0.5 * dt * (before + contact), spring.force
        row.kinetic = 0.5 * (m_column * w**2 + m_striker * wx**2)
        row.elastic = spring_energy(spring, pieces) + 0.5 * contact**2 / meeting.stiffness
        row.dissipated, row.contact_loss = spring.dissipated, lost
        if spring.v > limit:
            return COLLAPSE, n, spring, crushed
    return OK, records.size - 1, spring, crushed
