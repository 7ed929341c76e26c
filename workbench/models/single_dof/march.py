"""One mass on its spring as the integrator of `workbench.impact` takes it.

Three entries: `impact` with energy-conserving midpoint steps, as long as the error allows or equal;
`explicit_impact` with Moreau's steps; `pulse`, without a striker under a force over time,

    M(v) v'' + c v' + R(v) = F(t),

whose mass belongs to a shape of deflection that changes once the spring has come to the next stage
(Biggs), and the velocity by a factor that the stage brings; the kinetic energy that this leaves is
dissipated. Once the striker cannot come back and the column swings on a straight line, the rest of
the record is exact: a rotation in the plane of displacement and velocity over frequency.
"""

from typing import Any, NamedTuple

import numpy as np

from workbench.compiled import njit
from workbench.impact.contact import inner, moreau_step_of, uncounted
from workbench.impact.integrator import COMMON, DRIVE, Model, begin, march_of, no_flow
from workbench.models.single_dof.spring import (
    Spring,
    solve_midpoint,
    spring_at_rest,
    spring_energy,
    spring_moved,
)

RECORD = np.dtype(
    [
        (name, float)
        for name in (*COMMON, "force", "elastic", "dissipated", "external_work", "plastic")
    ]
)
STATE = np.dtype(
    [
        *((name, bool if name == "yielded" else float) for name in Spring._fields),
        *(("w", float), ("mass", float)),  # velocity and mass that move
        *(("time", float), ("push", float), ("work", float)),  # of pulses: mean force, its work
        ("stage", int),
        *(("x", float), ("contact", float), ("crushed", float)),  # of a striker that crushes
    ],
    align=True,
)
_POINTS, _MOST_POINTS = 20, 2000  # records of a period of the vibration, and of a whole record
_NO_MORE = 1.0 + 1e-4  # of the peak


class OneMass(NamedTuple):
    """System: committed and trial state, resistance curve, displacement of collapse (m)."""

    states: Any
    pieces: Any
    limit: float


class PushedMass(NamedTuple):
    """As `OneMass`; mean forces (N) of the steps, their length (s).

    And stages (n, 3) of displacement (m), mass (kg) and factor on the velocity, `damping` in N s/m.
    """

    states: Any
    pieces: Any
    limit: float
    means: Any
    length: float
    stages: Any
    damping: float


@uncounted
def spring_of(state):
    """The spring of a state."""
    return Spring(
        *(state.v, state.force, state.top, state.top_force, state.stiffness),
        *(state.yielded, state.dissipated),
    )


@uncounted
def put(state, spring):
    """Write the spring into a state."""
    state.v, state.force, state.top = spring.v, spring.force, spring.top
    state.top_force, state.stiffness = spring.top_force, spring.stiffness
    state.yielded, state.dissipated = spring.yielded, spring.dissipated


@uncounted
def hit(s):
    """Displacement and velocity."""
    return s.states[0].v, s.states[0].w


@uncounted
def solve(s, dt, closed, touch, striker):
    """The step of the mass, with that of a striker in contact."""
    now = s.states[0]
    mass, jump = now.mass, 0.0
    if closed:
        mass, jump = mass + striker, striker * (now.w - touch)
    w1, residual = solve_midpoint(dt, now.w, mass, jump, spring_of(now), s.pieces)
    s.states[1].w = w1
    return residual <= 1e-9, w1, residual, 1


@uncounted
def accept(s, dt):
    """Move the spring."""
    now = s.states[0]
    w1 = s.states[1].w
    put(now, spring_moved(spring_of(now), now.v + 0.5 * dt * (now.w + w1), s.pieces))
    now.w = w1


@uncounted
def write(s, records, n):
    """Force, energies, plastic displacement."""
    row, now = records[n], s.states[0]
    row.plastic = now.v - now.force / now.stiffness if now.yielded else 0.0
    row.kinetic, row.force, row.dissipated = 0.5 * now.mass * now.w**2, now.force, now.dissipated
    row.elastic, row.external_work = spring_energy(spring_of(now), s.pieces), now.work


@uncounted
def lost(s):
    """Whether the displacement of collapse is passed."""
    return s.states[0].v > s.limit


@uncounted
def mass_of(s):
    """The impact mass."""
    return s.states[0].mass


@uncounted
def kick(s, dv):
    """Change the velocity."""
    s.states[0].w += dv


@uncounted
def slope_of(now, pieces):
    """Slope of the line on which the spring unloads, or on which it has not yielded yet."""
    return now.stiffness if now.yielded else pieces[0].c[1]


@uncounted
def calm(s, progress):
    """Whether a free column swings on a straight line for good, out of reach of its striker.

    And no farther than to the peak that it has had.
    """
    now, first = s.states[0], s.pieces[0]
    k = slope_of(now, s.pieces)
    turn = (now.w * now.w * now.mass / k + (now.force / k) ** 2) ** 0.5
    if now.yielded:
        straight = now.v <= now.top and k * turn <= now.top_force
    else:
        straight = first.c[2] == 0.0 and first.c[3] == 0.0 and turn <= now.top
        straight = straight and (s.pieces.size == 1 or now.top <= s.pieces[1].start)
    centre = now.v - now.force / k
    away = progress.velocity <= 0.0 and progress.place < centre - turn
    return straight and away and centre + turn <= _NO_MORE * progress.peak


@uncounted
def coast(s, pace, progress, records, n):
    """Records after the n-th of a column that swings on a straight line; which is the last one."""
    now = s.states[0]
    k = slope_of(now, s.pieces)
    omega, left = (k / now.mass) ** 0.5, pace.duration - progress.time
    step = max(2.0 * np.pi / (_POINTS * omega), 0.5 * pace.spacing, pace.duration / _MOST_POINTS)
    count = max(int(np.ceil(left / step)), 1)
    step = left / count
    c, sine = np.cos(omega * step), np.sin(omega * step)
    centre, x, y = now.v - now.force / k, now.force / k, now.w / omega
    striking = 0.5 * progress.mass * progress.velocity**2
    for i in range(1, count + 1):
        x, y = c * x + sine * y, c * y - sine * x
        row = records[n + i]
        row.time = pace.duration if i == count else progress.time + i * step
        row.displacement, row.velocity = centre + x, omega * y
        row.striker_velocity, row.contact_loss = progress.velocity, progress.contact_loss
        row.percussion, row.force, row.external_work = 0.0, k * x, 0.0
        row.kinetic, row.elastic = 0.5 * k * y * y + striking, 0.5 * k * x * x
        row.dissipated, row.plastic = now.dissipated, records[n].plastic
    return n + count


@uncounted
def drift(s, dt):
    """Half a step of Moreau's with the velocity."""
    now, trial = s.states[0], s.states[1]
    put(trial, spring_moved(spring_of(now), now.v + 0.5 * dt * now.w, s.pieces))
    return True, trial.v


@uncounted
def push(s, dt):
    """The velocity that the force in the middle leaves."""
    s.states[1].w = s.states[0].w - dt * s.states[1].force / s.states[0].mass
    return s.states[1].w, s.states[0].mass


@uncounted
def jump(s, dv, dt):
    """Impulse, and the other half of the step."""
    trial = s.states[1]
    trial.w += dv
    put(trial, spring_moved(spring_of(trial), trial.v + 0.5 * dt * trial.w, s.pieces))


@uncounted
def accept_trial(s, dt):
    """What Moreau's step has moved."""
    put(s.states[0], spring_of(s.states[1]))
    s.states[0].w = s.states[1].w


@uncounted
def solve_pushed(s, dt, closed, touch, striker):
    """The step of the mass under the pulse."""
    now = s.states[0]
    now.push = s.means[min(int(now.time / s.length + 1e-6), s.means.size - 1)]
    spring, impulse = spring_of(now), dt * (s.damping * now.w - now.push)
    damped = now.mass + 0.5 * dt * s.damping  # the dashpot feels the mean velocity
    w1, residual = solve_midpoint(dt, now.w, damped, impulse, spring, s.pieces)
    s.states[1].w = w1
    return residual <= 1e-9, w1, residual, 1


@uncounted
def accept_pushed(s, dt):
    """Move the spring; the work of pulse and dashpot; what the next stage changes."""
    now, before = s.states[0], s.states[0].v
    accept(s, dt)
    now.time += dt
    now.dissipated += s.damping * (now.v - before) ** 2 / dt
    now.work += now.push * (now.v - before)
    while now.stage + 1 < s.stages.shape[0] and abs(now.v) >= s.stages[now.stage + 1, 0]:
        now.stage += 1
        kinetic = 0.5 * now.mass * now.w**2
        now.mass, now.w = s.stages[now.stage, 1], s.stages[now.stage, 2] * now.w
        now.dissipated += kinetic - 0.5 * now.mass * now.w**2


_FULL = Model(
    *(hit, solve, no_flow, accept, write, lost), mass=mass_of, kick=kick, calm=calm, coast=coast
)
_march = march_of(_FULL)
_explicit = march_of(
    _FULL._replace(accept=accept_trial, step=moreau_step_of(hit, drift, push, jump))
)
_pushed = march_of(Model(hit, solve_pushed, no_flow, accept_pushed, write, lost))


@inner
def at_rest(drive, pieces):
    """States before anything happens; the drive ends with elastic limit, collapse and mass."""
    states = np.zeros(2, STATE)
    put(states[0], spring_at_rest(drive[DRIVE], pieces))
    states[0].mass = drive[DRIVE + 2]
    return states


@njit(cache=True, error_model="numpy")
def impact(pieces, drive, progress, records):
    """Follow an impact: (status, rows).

    Arguments: `pieces` of the resistance; `drive`, `progress` and `records` of `workbench.impact`,
    the drive with elastic limit (m), displacement of collapse (m) and impact mass (kg).
    """
    s = OneMass(at_rest(drive, pieces), pieces, drive[DRIVE + 1])
    return _march(s, begin(drive, progress[0]), progress[0], records)


@njit(cache=True, error_model="numpy")
def explicit_impact(pieces, drive, progress, records):
    """As `impact`, with Moreau's explicit steps."""
    s = OneMass(at_rest(drive, pieces), pieces, drive[DRIVE + 1])
    return _explicit(s, begin(drive, progress[0]), progress[0], records)


def no_striker(elastic_limit: float, limit: float, mass: float) -> tuple[float, ...]:
    """The drive of a pulse after its pace; displacements (m) and the mass at first (kg)."""
    return 0.0, 0.0, 0.0, 0.0, elastic_limit, limit, mass


@njit(cache=True, error_model="numpy")
def pulse(pieces, stages, means, damping, drive, progress, records):
    """Follow a pulse in equal steps: (status, rows), as `impact`.

    Arguments: `stages` (n, 3), displacement (m) from which on a mass (kg) moves and the factor on
    the velocity there, the first from 0 on; `means` (steps,) of the force; `damping` in N s/m.
    """
    pace = begin(drive, progress[0])
    states, limit = at_rest(drive, pieces), drive[DRIVE + 1]
    s = PushedMass(states, pieces, limit, means, pace.longest, stages, damping)
    return _pushed(s, pace, progress[0], records)
