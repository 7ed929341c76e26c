"""Event-driven integration: Runge-Kutta between events, impacts and releases located.

Between events a set of contacts is closed for good and pushes with forces l of the accelerations,
W' M^-1 (W l - f) + c'' = 0; the others are open. A step of the classical Runge-Kutta method ends
where a gap closes or a force l vanishes, found on the step itself to round-off: the order of the
method survives impacts. Impacts follow the law of restitution. Impacts that accumulate (Zeno) are
ended where the next flight would be shorter than a small share of the step: the contact then
counts as closed. What a step misses is a gap that closes and opens within it unseen by the cubic
through its ends.
"""

import numpy as np

from workbench.base.arrays import Array, Flags
from workbench.extras.laboratory.complementarity import complementary, percussions
from workbench.extras.laboratory.system import System
from workbench.extras.laboratory.systems import (
    RestitutionLaw,
    Stepper,
    SystemState,
    SystemStep,
    gaps_of,
    rates_of,
)

_CLOSED = 1e-10  # m; a gap that counts as closed
_FLIGHT = 1e-4  # share of a step; impacts in faster succession have accumulated
_MOST_EVENTS = 500  # in a step
_RELEASED = 1e-9  # of the forces; a contact that pushes less lets go
_ROOT = 60


class _Stretch:
    """Motion with given closed contacts from one state, over any time."""

    def __init__(self, system: System, state: SystemState, closed: Flags) -> None:
        self.system, self.state, self.on = system, state, np.flatnonzero(closed)
        self.normals = np.ascontiguousarray(system.normals[:, self.on])
        self.back = np.linalg.solve(system.mass, self.normals)
        self.evaluations = 0

    def push(self, q: Array, t: float) -> tuple[Array, Array]:
        """Accelerations (n,), and forces of the closed contacts."""
        f, _ = self.system.forces(q)
        self.evaluations += 1
        free = np.asarray(-np.linalg.solve(self.system.mass, f), dtype=float)
        if not self.on.size:
            return free, np.zeros(0)
        lack = self.normals.T @ free + self.system.surface(t)[2][self.on]
        forces = np.linalg.lstsq(self.normals.T @ self.back, -lack, rcond=None)[0]
        force = np.asarray(forces, dtype=float)
        return free + self.back @ force, force

    def after(self, h: float) -> SystemState:
        """The state after `h` (s)."""
        q, v, t = self.state.q, self.state.v, self.state.t
        a1 = self.push(q, t)[0]
        a2 = self.push(q + 0.5 * h * v, t + 0.5 * h)[0]
        a3 = self.push(q + 0.5 * h * v + 0.25 * h * h * a1, t + 0.5 * h)[0]
        a4 = self.push(q + h * v + 0.5 * h * h * a2, t + h)[0]
        place = q + h * v + h * h / 6.0 * (a1 + a2 + a3)
        return SystemState(
            place, v + h / 6.0 * (a1 + 2.0 * (a2 + a3) + a4), a4, self.state.force, t + h
        )

    def margins(self, state: SystemState) -> Array:
        """Gaps of open contacts (m,); forces (N) of closed ones."""
        out: Array = gaps_of(self.system, state.q, state.t)
        out[self.on] = self.push(state.q, state.t)[1]
        return out

    def first_event(self, h: float) -> tuple[float, SystemState]:
        """When the first gap closes or force vanishes within `h`, or `h`; and the state there."""
        end = self.after(h)
        margins, first = self.margins(end), (h, end)
        start = gaps_of(self.system, self.state.q, self.state.t)
        rates = [rates_of(self.system, s.v, s.t) for s in (self.state, end)]
        for i in range(start.size):
            upper, at_upper = h, margins[i]
            if at_upper >= 0.0 and i not in self.on:
                upper = _lowest(h, start[i], margins[i], rates[0][i], rates[1][i])
                at_upper = self.margins(self.after(upper))[i] if upper < h else at_upper
            if at_upper < (0.0 if i in self.on else -_CLOSED):
                time = self._root(i, upper, float(at_upper))
                if time < first[0]:
                    first = time, self.after(time)
        return first

    def _root(self, i: int, high: float, at_high: float) -> float:
        """Where margin `i`, negative at `high`, changes sign (Illinois' false position)."""
        low = 1e-3 * high
        if i not in self.on:  # a short flight after an impact: not before its top
            rate = float(rates_of(self.system, self.state.v, self.state.t)[i])
            pull = float(self.system.normals[:, i] @ self.push(self.state.q, self.state.t)[0])
            pull += float(self.system.surface(self.state.t)[2][i])
            low = min(low, rate / -pull) if rate > 0.0 > pull else low
        at_low = float(self.margins(self.after(low))[i])
        if at_low <= 0.0:
            return low
        side = 0
        for _ in range(_ROOT):
            time = (low * at_high - high * at_low) / (at_high - at_low)
            value = float(self.margins(self.after(time))[i])
            if abs(value) < 1e-15 or high - low < 1e-15 * high:
                return time
            if value < 0.0:
                high, at_high, at_low = time, value, 0.5 * at_low if side < 0 else at_low
                side = -1
            else:
                low, at_low, at_high = time, value, 0.5 * at_high if side > 0 else at_high
                side = 1
        return 0.5 * (low + high)


def _lowest(h: float, g0: float, g1: float, r0: float, r1: float) -> float:
    """Where the cubic of a gap with these ends is least within the step."""
    if r0 >= 0.0 or r1 <= 0.0:
        return h
    c2, c3 = 3.0 * (g1 - g0) / h - 2.0 * r0 - r1, r0 + r1 - 2.0 * (g1 - g0) / h
    root = max(c2 * c2 - 3.0 * c3 * r0, 0.0) ** 0.5
    return float(min(max(-r0 * h / (c2 + root), 0.0), h)) if c2 + root > 0.0 else h


def event_driven() -> Stepper:
    """The step. Residual evaluations grow with the number of events in it."""

    def step(system: System, law: RestitutionLaw, state: SystemState, h: float) -> SystemStep:
        end, impulses, evaluations = state.t + h, np.zeros_like(state.force), 0
        residual = loss = 0.0
        for _ in range(_MOST_EVENTS):
            before = rates_of(system, state.v, state.t)
            state, P, unsolved = _meet(system, law, state, h)
            loss -= 0.5 * float(P @ (before + rates_of(system, state.v, state.t)))
            stretch = _Stretch(system, state, state.force > 0.0)
            span, after = stretch.first_event(end - state.t)
            force = np.zeros_like(state.force)
            force[stretch.on] = stretch.push(after.q, after.t)[1]
            impulses = impulses + P + 0.5 * span * (state.force + force)
            evaluations += stretch.evaluations
            residual = max(residual, unsolved)
            state = after._replace(force=force)
            system.commit(state.q)
            if state.t >= end - 1e-13 * h:
                return SystemStep(state._replace(t=end), impulses, evaluations, residual, loss)
        return SystemStep(state, impulses, evaluations, np.nan, loss)  # too many events

    return step


def _meet(
    system: System, law: RestitutionLaw, state: SystemState, h: float
) -> tuple[SystemState, Array, float]:
    """The state after impacts with the forces of the contacts that stay, impulses, residual."""
    P, residual = np.zeros_like(state.force), 0.0
    on = np.flatnonzero(gaps_of(system, state.q, state.t) <= _CLOSED)
    if not on.size:
        return state._replace(force=P), P, residual
    W = np.ascontiguousarray(system.normals[:, on])
    back = np.linalg.solve(system.mass, W)
    G, v = W.T @ back, state.v
    f, _ = system.forces(state.q)
    lack = system.surface(state.t)[2][on] - back.T @ f
    slow = 0.5 * _FLIGHT * h * np.maximum(-lack, 0.0) + 1e-12 * (1.0 + np.abs(v).max())
    rate = rates_of(system, v, state.t)[on]
    if (rate < -slow).any():
        P[on], residual = percussions(G, rate, rate, law.e[on], law.poisson)
        v = v + back @ P[on]
        rate = rates_of(system, v, state.t)[on]
    rest = np.flatnonzero(np.abs(rate) <= slow)
    force = np.zeros_like(P)
    if rest.size:  # what is left of an accumulation ends here
        part = np.ascontiguousarray(G[rest][:, rest])
        last = np.linalg.lstsq(part, -rate[rest], rcond=None)[0]
        v = v + back[:, rest] @ last
        P[on[rest]] += last
        push, unsolved = complementary(part, lack[rest])
        push[push <= _RELEASED * np.abs(f).max()] = 0.0
        force[on[rest]], residual = push, max(residual, unsolved)
    return state._replace(v=v, force=force), P, residual
