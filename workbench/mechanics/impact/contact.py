"""The contact law of striker and structure: Newton's restitution on velocities.

Moreau 1988; Heng 2017, 3.1 and 3.2, eqs 3.17-3.30. Gap g >= 0, gap velocity gamma = g'; the
impulse P of a step obeys 0 <= P perp xi = gamma_1 + e gamma_0 >= 0 while the contact is closed.
Explicit steps and collisions call `explicit_percussion`; implicit steps write xi = 0 into their
equations with the `rebound` given here (`contact_step_of`, which decides who touches). A striker
that crushes has no restitution: its impulse is that of its law, see `crushing`.
"""

from typing import Any

from workbench.base.compiled import njit
from workbench.mechanics.impact.crushing import TRIES, approach_at, crush_line, obeys
from workbench.mechanics.impact.pace import APART, RELEASED

# Small functions that end in one entry: inlined, without the wrappers that Python would call.
_WRAPPERS: Any = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, "_nrt": True}
inner = njit(error_model="numpy", forceinline=True, **_WRAPPERS)
called = njit(error_model="numpy", **_WRAPPERS)  # the same, large and called in several places
# Inlined, without counting arrays at every call: that costs more than a step of one mass, and the
# entry holds them anyway. Such functions make no arrays and return none; nor may the kernels that
# they call, which are compiled in the same way.
uncounted = njit(error_model="numpy", forceinline=True, **(_WRAPPERS | {"_nrt": False}))


@njit(cache=True, error_model="numpy")
def rebound(gamma_start: float, restitution: float) -> float:
    """Restitution that the step uses: e while approaching, 1 while separating.

    Contact is enforced on velocities, so a drifted gap can be closed while the bodies separate.
    Newton's law with e < 1 would then do positive work on the mean gap velocity and create
    energy; with 1 the mean gap velocity, and so that work, is zero.
    """
    return 1.0 if gamma_start > 0.0 else restitution


@njit(cache=True, error_model="numpy")
def may_touch(gap: float, gamma: float, dt: float, slack: float) -> bool:
    """Whether a step of `dt` can be one of contact: the gap at its end, if it only closes."""
    return gap + dt * min(gamma, 0.0) <= slack


@njit(cache=True, error_model="numpy")
def touch_velocity(striker: float, gamma: float, restitution: float) -> float:
    """Velocity of the hit point at the end of a closed step, for the striker's as it is without P.

    An open step is admissible if the hit point is at least as fast at its end.
    """
    return striker - rebound(gamma, restitution) * gamma


@njit(cache=True, error_model="numpy")
def accepts(fits: bool, may: bool, closed: bool, refused: bool) -> bool:
    """Whether a solved state of contact is taken: it fits, or nothing else is left.

    Arguments: `fits`, P >= 0 or open and not slower than `touch_velocity`; `may`, whether contact
    was possible; whether it was `closed`; whether the other state was solved and `refused`. A
    closed contact that pulls must open, whatever the open solution says of velocities.
    """
    return fits or not may or (refused and not closed)


@njit(cache=True, error_model="numpy")
def explicit_percussion(
    gamma_free: float, gamma_start: float, restitution: float, mass: float, striker_mass: float
) -> float:
    """Impulse (N s) from the gap velocity without contact; one contact needs no iteration.

    The factor r of Heng 2017, eq. 3.28, must be (w' M^-1 w)^-1, in kg, as here; eq. 3.29 prints
    its inverse.
    """
    xi = gamma_free + rebound(gamma_start, restitution) * gamma_start
    return max(-xi, 0.0) / (1.0 / mass + 1.0 / striker_mass)


@njit(cache=True, error_model="numpy")
def contact_loss(percussion: float, gamma_start: float, gamma_end: float) -> float:
    """Energy lost in the contact during the step: minus the work of P on the mean gap velocity."""
    return -0.5 * percussion * (gamma_start + gamma_end)


def contact_step_of(hit: Any, solve: Any, released: bool = True) -> Any:
    """The step of a model that writes contact into its equations; see `integrator.Model`.

    `step(s, progress, dt, may) -> done, impulse (N s), end velocity of the hit point (m/s), energy
    lost in contact (J)`; `may`: whether contact is possible. The step is solved closed if bodies do
    not separate, else open, and the other way if the law refuses that. `released`: a step in which
    the contact opens is not done; its length up to there, by a straight line through the mean
    forces of two steps, is written as `progress.release`. Not for forces that ring. Of a striker
    that crushes the step is solved with lines through its law until the impulse obeys that.
    """

    @uncounted
    def step(s, progress, dt, may):
        (place, speed), mass, law = hit(s), progress.mass, progress.crush
        gamma, free = speed - progress.velocity, progress.velocity + dt * progress.gravity
        touch = touch_velocity(free, gamma, progress.restitution)
        closed, refused, striker = may and gamma <= APART * progress.approach, False, mass
        tries, crushes = 2 if may else 1, law.points > 0
        start, speeds = progress.place - place, progress.velocity + free - speed
        if crushes:
            law.crushed = max(law.crushed, start)
            wanted, striker, touch = crush_line(law, start, start - dt * gamma, dt, mass, speeds)
            closed, tries = wanted > 0.0, TRIES
        for _ in range(tries):
            done, end, residual, count = solve(s, dt, closed, touch, striker)
            progress.residual = residual
            progress.evaluations += count
            impulse = striker * (touch - end) if closed else 0.0
            if crushes:
                if not done:
                    break
                reached = approach_at(start, dt, mass, speeds, impulse, end)
                wanted, striker, touch = crush_line(law, start, reached, dt, mass, speeds)
                if obeys(law, impulse, wanted, mass, progress.approach):
                    lost = contact_loss(impulse, gamma, end - free + impulse / mass)
                    return True, impulse, end, lost
                closed = wanted > 0.0
                continue
            if released and done and impulse < 0.0 and progress.pushed > 0.0:  # no force there
                bend = 2.0 * (progress.pushed - impulse / dt) / (dt + progress.before)
                release = progress.pushed / bend - 0.5 * progress.before
                if progress.least < release < RELEASED * dt:
                    progress.release = release
                    return False, 0.0, 0.0, 0.0
            fits = impulse >= 0.0 if closed else end >= touch
            if done and accepts(fits, may, closed, refused):
                left = 0.0
                if closed:
                    left = contact_loss(impulse, gamma, end - free + impulse / mass)
                return True, impulse, end, left
            refused, closed = refused or done, not closed
        return False, 0.0, 0.0, 0.0

    return step
