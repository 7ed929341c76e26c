"""What the integrators share: the state, who is in contact, and velocities with impulses."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from workbench.arrays import Array
from workbench.compiled import register_jitable
from workbench.fields import Number
from workbench.impact.laws import percussions
from workbench.impact.pace import SLACK
from workbench.impact.system import forces, mean_forces, surface

REACH = Number(0.0, 1.0)  # share of a step that gaps are forecast for
_ITERATIONS = 40
_TOLERANCE = 1e-14


class State(NamedTuple):
    """Unknowns, velocities, accelerations (n,), contact forces (m,) in N, time in s."""

    q: Array
    v: Array
    a: Array
    force: Array
    t: float


class Law(NamedTuple):
    """Restitution as the steps take it: coefficients (m,) and whether it is Poisson's."""

    e: Array
    poisson: bool


class Step(NamedTuple):
    """A step taken: `state` at its end, `impulses` (m,) in N s, residual evaluations, residual.

    `loss` is the energy (J) lost in its contacts, NaN for minus the work of the impulses on the
    mean gap velocities.
    """

    state: State
    impulses: Array
    evaluations: int
    residual: float
    loss: float


Stepper = Callable[[Any, Law, State, float], Step]


@register_jitable(inline="always")
def gaps_of(system, q, t):
    """Gaps (m,) in m."""
    return system.normals.T @ q + surface(system, t)[0]


@register_jitable(inline="always")
def rates_of(system, v, t):
    """Gap velocities (m,) in m/s."""
    return system.normals.T @ v + surface(system, t)[1]


@register_jitable(inline="always")
def forecast(system, state, reach):
    """Contacts whose gap, forecast for the share `reach` of a step in s ahead, is closed."""
    place, speed, _ = surface(system, state.t)
    across = system.normals.T
    return across @ state.q + place + reach * np.minimum(across @ state.v + speed, 0.0) <= SLACK


@register_jitable
def impulses_on(system, law, closed, matrix, free, state, t):
    """Velocities after the impulses of the closed contacts, and those; `free` is without them.

    `matrix` stands for the mass; an impulse P changes the velocities by matrix^-1 W P.
    """
    P, residual = np.zeros(closed.size), 0.0
    on = np.flatnonzero(closed)
    if on.size == 0:
        return free, P, residual
    W = np.ascontiguousarray(system.normals[:, on])
    back = np.linalg.solve(matrix, W)
    start = rates_of(system, state.v, state.t)[on]
    gamma = W.T @ free + surface(system, t)[1][on]
    found, residual = percussions(W.T @ back, gamma, start, law.e[on], law.poisson)
    P[on] = found
    return free + back @ found, P, residual


@register_jitable
def implicit(system, law, state, h, theta, shift, closed):
    """Velocities of M (v1 - v0) + h f = W P by Newton's method with the contact law inside.

    With 0 < theta <= 1 the force is theta f1 + (1 - theta) f0 at q1 = q0 + h (theta v1 +
    (1 - theta) v0) + shift; with theta = 0 it is the energy-consistent mean force over
    q1 = q0 + h (v0 + v1) / 2 + shift. Returns q1, v1, impulses, evaluations, residual.
    """
    M, q0, v0 = system.mass, state.q, state.v
    mean = theta == 0.0
    share = 0.5 if mean else theta
    f0 = q0 if mean else forces(system, q0)[0]  # of the theta-rule alone
    v1, P, known = v0.copy(), np.zeros(closed.size), 0.0
    before, push, touching = np.abs(M @ v0), np.zeros(q0.size), closed.any()
    residual, count = np.inf, 1
    for turn in range(_ITERATIONS):
        q1 = q0 + h * (share * v1 + (1.0 - share) * v0) + shift
        if mean:
            f, K = mean_forces(system, q0, q1)
            A = M + 0.5 * h * h * K
        else:
            f1, K = forces(system, q1)
            f = theta * f1 + (1.0 - theta) * f0
            A = M + (h * theta) ** 2 * K
        count += 1
        r = h * f
        if turn > 0:
            size = before + np.abs(M @ v1) + np.abs(r) + np.abs(push)
            r += M @ (v1 - v0)
            last, residual = residual, np.abs(r - push).max() / max(size.max(), 1e-300)
            if residual <= _TOLERANCE or (residual <= 1e-11 and residual >= last):
                break
        v1 = v1 - np.linalg.solve(A, r)
        if touching:
            v1, P, known = impulses_on(system, law, closed, A, v1, state, state.t + h)
            push = system.normals @ P
    q1 = q0 + h * (share * v1 + (1.0 - share) * v0) + shift
    return q1, v1, P, count - (1 if mean else 0), max(residual, known)
