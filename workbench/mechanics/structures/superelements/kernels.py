"""Assembly and energies of superelements.

Symbols: local deformations (u, theta_1, theta_4) against the chord, local forces (N, M_1, M_4);
Q, what hinges and bar carry; eta, the share of the elastic stiffness that always acts beside
them and keeps the tangent regular; alpha, rotation of the chord, the only rotation of a rigid
bar that has inertia. Source: Heng 2017, papers III and IV; midpoint form of Hamilton's
principle for the rotary inertia after Simo and Tarnow 1992.
"""

import math

from numba.core.types import NoneType
from numba.extending import overload

from workbench.base.compiled import njit
from workbench.mechanics.impact.contact import inner
from workbench.mechanics.impact.integrator import begin
from workbench.mechanics.structures.kernels import (
    Chord,
    add_moved_element,
    chord_at,
    chord_before,
    copy,
)
from workbench.mechanics.structures.march import BarFunctions, march_of_bars
from workbench.steel.hinges.kernels import flow_of_bar
from workbench.steel.hinges.panel_elements import project_condensed
from workbench.steel.hinges.panel_kernels import HingePair, Panel, project_pair, utilisation


@njit(cache=True, error_model="numpy", forceinline=True)
def _quadratic(matrix, x):
    """Quadratic form of x (3,) with [a, 0, 0; 0, b, c; 0, c, d], stored as (a, b, c, d)."""
    axial = matrix[0] * x[0] * x[0]
    bending = matrix[1] * x[1] * x[1] + matrix[3] * x[2] * x[2]
    coupling = 2.0 * matrix[2] * x[1] * x[2]
    return axial + bending + coupling


@njit(cache=True, error_model="numpy", forceinline=True)
def _on_surfaces(e, hinges, trial, forces, k, flow):
    """Forces of element `e` nearest to the elastic ones of `trial`, their tangent, and the flow.

    Begins with the `forces` (3,); all tables are read as numbers, as views cost more than the rest.
    The last of the `flow` (5,) is how far the web slides: its angle, which is in the rotations
    before it, times the length; where none can slide it stays as it is.
    """
    f, pins = hinges.bending, hinges.pinned
    flexibility, pinned = (f[e, 0], f[e, 1], f[e, 2], f[e, 3]), (pins[e, 0], pins[e, 1])
    if hinges.webs[e].stiffness > 0.0:
        panel = Panel(flexibility, pinned, hinges.lengths[e], hinges.webs[e])
        project_condensed(panel, trial, forces, k, flow)
    else:
        b, x = hinges.bounds, hinges.exponents
        bounds = (
            (b[e, 0, 0], b[e, 0, 1], b[e, 0, 2], b[e, 0, 3]),
            (b[e, 1, 0], b[e, 1, 1], b[e, 1, 2], b[e, 1, 3]),
        )
        exponents = (x[e, 0, 0], x[e, 0, 1]), (x[e, 1, 0], x[e, 1, 1])
        project_pair(HingePair(flexibility, bounds, exponents, pinned), trial, forces, k, flow)


@njit(cache=True, error_model="numpy")
def _at_rate(e, time, hinges, plastic, trial, forces, k, flow):
    """Solve as `_on_surfaces` does, a bar that flows point by point for a `time` (s).

    Its moment M_1 is the internal one with its sign turned, so is V. Hinges share the elongation.
    """
    f, pins = hinges.flexibility, hinges.pinned
    f_n, f11, f14, f44 = f[e, 0], f[e, 1], f[e, 2], f[e, 3]
    forces[1] = -forces[1]
    _, (nn, n1, n4, k11, k14, k44), slid = flow_of_bar(
        hinges.laws[e],
        hinges.lengths[e],
        (f_n, f11, -f14, f44),
        (pins[e, 0], pins[e, 1]),
        (trial[0], -trial[1], trial[2]),
        time,
        plastic[e, 5:],
        forces,
        flow[5:],
    )
    forces[1] = -forces[1]
    k[0, 0], k[1, 1], k[2, 2] = nn, k11, k44
    k[0, 1], k[0, 2], k[1, 2] = -n1, n4, -k14
    k[1, 0], k[2, 0], k[2, 1] = -n1, n4, -k14
    flow[0] = flow[2] = 0.5 * (trial[0] - f_n * forces[0])
    flow[1] = trial[1] - f11 * forces[1] - f14 * forces[2]
    flow[3] = trial[2] - f14 * forces[1] - f44 * forces[2]
    flow[4] = -slid


def _flows(hinges):
    """Whether tables of this type have bars that flow point by point."""
    return not isinstance(hinges.types[hinges.fields.index("laws")], NoneType)


def project(e, time, hinges, plastic, trial, forces, k, flow):
    """Forces of element `e`, as the type of the tables says when kernels are compiled.

    After a `time` (s) since the `plastic` deformations; else as `_on_surfaces`.
    """
    raise NotImplementedError


@overload(project, jit_options={"error_model": "numpy", "forceinline": True})
def _by_type(e, time, hinges, plastic, trial, forces, k, flow):
    if _flows(hinges):
        return lambda e, time, hinges, plastic, trial, forces, k, flow: _at_rate(
            e, time, hinges, plastic, trial, forces, k, flow
        )
    return lambda e, time, hinges, plastic, trial, forces, k, flow: _on_surfaces(
        e, hinges, trial, forces, k, flow
    )


def returned(hinges, weight):
    """Part of a step at which plastic flow is found: the middle, of a rate the end."""
    raise NotImplementedError


@overload(returned, jit_options={"error_model": "numpy", "forceinline": True})
def _returned(hinges, weight):
    if _flows(hinges):
        return lambda hinges, weight: 1.0
    return lambda hinges, weight: weight


@njit(cache=True, error_model="numpy")
def obey(weight, hinges, old, new, tangents, time=0.0):
    """Local forces of all elements for their deformations in the `new` state, and `tangents`.

    Hinges return to the yield surface at the `weight` of the way from the `old` state, see
    `settle`; bars that flow at a rate have done so for a `time` (s) at its end. Writes the new
    plastic deformations, the forces carried by the hinges, local forces and their tangents
    (e, 3, 3). Arrays are taken out of their tables once: each time costs as
    much as a division.
    """
    weight = returned(hinges, weight)
    eta, before = hinges.eta, 1.0 - weight
    rest, ratio = 1.0 - eta, before / weight
    _, _, trial, forces, flow, _ = hinges.scratch
    x0, x, plastic0, plastic = old.deformation, new.deformation, old.plastic, new.plastic
    carried0, carried, local, stiffness = old.carried, new.carried, new.local, hinges.stiffness
    for e in range(hinges.rotary.size):
        k = tangents[e]
        trial[0] = x[e, 0] - plastic0[e, 0] - plastic0[e, 2]
        trial[1] = x[e, 1] - plastic0[e, 1]
        trial[2] = x[e, 2] - plastic0[e, 3]
        for i in range(3):
            trial[i] += before * (x0[e, i] - x[e, i])
            forces[i] = carried[e, i] + before * (carried0[e, i] - carried[e, i])
        project(e, time, hinges, plastic0, trial, forces, k, flow)
        for i in range(4):
            plastic[e, i] = plastic0[e, i] + flow[i] / weight
        if hinges.webs[e].stiffness > 0.0:  # by itself: four numbers at a time are faster
            plastic[e, 4] = plastic0[e, 4] + flow[4] / weight
        for i in range(5, plastic.shape[1]):
            plastic[e, i] = plastic0[e, i] + flow[i]
        for i in range(3):
            carried[e, i] = forces[i] + ratio * (forces[i] - carried0[e, i])
            for j in range(3):
                k[i, j] *= rest
        kn, k11, k14, k44 = stiffness[e, 0], stiffness[e, 1], stiffness[e, 2], stiffness[e, 3]
        local[e, 0] = rest * carried[e, 0] + eta * kn * x[e, 0]
        local[e, 1] = rest * carried[e, 1] + eta * (k11 * x[e, 1] + k14 * x[e, 2])
        local[e, 2] = rest * carried[e, 2] + eta * (k14 * x[e, 1] + k44 * x[e, 2])
        k[0, 0] += eta * kn
        k[1, 1] += eta * k11
        k[1, 2] += eta * k14
        k[2, 1] += eta * k14
        k[2, 2] += eta * k44


@njit(cache=True, error_model="numpy")
def settle(weight, hinges, old, new):
    """Let hinges flow on until they are admissible at the end of a step; energies of it, in J.

    Forces that are at yield at the `weight` of a step end beyond the surface: by the curvature of
    their path, or where the flow begins. What it takes to bring them back with nothing moving is
    plastic work, and tells how well the step has followed the hinges. Result: as of `account`, and
    that work; of bars that flow at a rate, which end where they may be, what their forces at the
    end would do more than those in the mean. Elements are settled in the `new` state.
    """
    stored = plastic = algorithmic = excess = late = 0.0
    eta, rest = hinges.eta, 1.0 - hinges.eta
    tangents, _, trial, forces, flow, _ = hinges.scratch
    k = tangents[0]
    for e in range(hinges.rotary.size):
        flexibility, stiffness = hinges.flexibility[e], hinges.stiffness[e]
        carried, gone = new.carried[e], new.plastic[e]
        for i in range(3):
            trial[i] = carried[i] - old.carried[e, i]
        algorithmic += (weight - 0.5) * rest * _quadratic(flexibility, trial)
        for i in range(3):
            trial[i] = new.deformation[e, i] - old.deformation[e, i]
        algorithmic += (weight - 0.5) * eta * _quadratic(stiffness, trial)
        stored += 0.5 * eta * _quadratic(stiffness, new.deformation[e])
        for i in range(3):
            forces[i] = carried[i]
        trial[0] = new.deformation[e, 0] - gone[0] - gone[2]
        trial[1] = new.deformation[e, 1] - gone[1]
        trial[2] = new.deformation[e, 2] - gone[3]
        project(e, 0.0, hinges, new.plastic, trial, forces, k, flow)
        mean = 0.0
        for h in range(4):
            i = 0 if h % 2 == 0 else 1 + h // 2
            flown = rest * (gone[h] - old.plastic[e, h])
            mean += (weight * carried[i] + (1.0 - weight) * old.carried[e, i]) * flown
            late += 0.5 * abs((carried[i] - old.carried[e, i]) * flown)
            excess += 0.5 * rest * (carried[i] + forces[i]) * flow[h]
            gone[h] += flow[h]
        if hinges.webs[e].stiffness > 0.0:
            gone[4] += flow[4]
        for i in range(3):
            new.local[e, i] += rest * (forces[i] - carried[i])
            carried[i] = forces[i]
        stored += 0.5 * rest * _quadratic(flexibility, carried)
        plastic += mean
    spent = late if new.plastic.shape[1] > 5 else excess
    # the forces that a flow goes with are at yield and do most work: all of it is ideal
    return stored, plastic + excess, algorithmic, plastic + excess, spent


@njit(cache=True, error_model="numpy", forceinline=True)
def assemble(step, bars, hinges, old, new):
    """Add forces and tangents of all superelements for a `step`; write the state `new`.

    The rotary inertia of the chords acts in time steps of finite duration only.
    """
    tangents, work, _, _, _, chords = hinges.scratch
    weight = step.weight if step.dynamic else 1.0
    moving = step.dynamic and math.isfinite(step.duration)
    end, dofs, deformation, rotary = step.end, bars.dofs, new.deformation, hinges.rotary
    for e in range(dofs.shape[0]):
        chord = chord_at(bars, e, end)
        deformation[e, 0] = chord.elongation
        deformation[e, 1] = end[dofs[e, 2]] - chord.rotation
        deformation[e, 2] = end[dofs[e, 5]] - chord.rotation
        chords[e, 0], chords[e, 1], chords[e, 2] = chord.x, chord.y, chord.length
        chords[e, 3], chords[e, 4] = chord.rotation, chord.elongation
    obey(weight, hinges, old, new, tangents, step.duration if moving else 0.0)
    for e in range(dofs.shape[0]):
        chord = Chord(chords[e, 0], chords[e, 1], chords[e, 2], chords[e, 3], chords[e, 4])
        before = chord
        if step.dynamic:
            before = chord_before(bars, e, step.start, old.deformation)
        gradients, turn = add_moved_element(
            step, bars, e, before, chord, old.local[e], new.local[e], tangents[e], work
        )
        new.rate[e] = 0.0
        if moving and rotary[e] > 0.0:
            new.rate[e] = 2.0 * turn / step.duration - old.rate[e]
            turn_chord(step, bars, e, chord, gradients, rotary[e], new.rate[e] - old.rate[e])


@njit(cache=True, error_model="numpy", forceinline=True)
def turn_chord(step, bars, e, chord, gradients, inertia, change):
    """Add the forces that change the angular velocity of a chord by `change`, and their tangent."""
    dofs, positions = bars.dofs, bars.positions
    couple = inertia * change / step.duration
    gx, gy = gradients.gx, gradients.gy
    step.force[dofs[e, 0]] -= couple * gx
    step.force[dofs[e, 1]] -= couple * gy
    step.force[dofs[e, 3]] += couple * gx
    step.force[dofs[e, 4]] += couple * gy
    # d alpha / d d_1 = n_1 / l_1
    turn = 2.0 * inertia / (step.duration * step.duration * chord.length)
    e1x, e1y = chord.x / chord.length, chord.y / chord.length
    xx = couple * gradients.gxx - turn * gx * e1y
    xy = couple * gradients.gxy + turn * gx * e1x
    yx = couple * gradients.gyx - turn * gy * e1y
    yy = couple * gradients.gyy + turn * gy * e1x
    for i in range(2):
        for j in range(2):
            sign = 1.0 if i == j else -1.0
            first = 18 * i + 3 * j
            step.band[positions[e, first]] += sign * xx
            step.band[positions[e, first + 1]] += sign * xy
            step.band[positions[e, first + 6]] += sign * yx
            step.band[positions[e, first + 7]] += sign * yy


@njit(cache=True, error_model="numpy")
def use_webs(hinges, carried, used):
    """Write how far ends (n, e, 2) with webs are used by the forces `carried` (n, e, 3)."""
    for e in range(hinges.webs.size):
        if hinges.webs[e].stiffness > 0.0:
            utilisation(hinges.webs[e], hinges.lengths[e], carried[:, e], used[:, e])


@njit(cache=True, error_model="numpy")
def account(weight, bars, hinges, old, new):
    """Energies of a step from the committed to the trial state of a group, which settles, in J.

    Result: stored energy at the end; plastic dissipation of the step with forces weighted as in
    the step; algorithmic dissipation; and the plastic work of forces that stay at yield.
    """
    return settle(weight, hinges, old, new)[:4]


@inner
def start(old, new):
    """Begin a step: projections start at the forces that hinges carry."""
    copy(old.carried, new.carried)


@inner
def finish(weight, _bars, hinges, old, new):
    """Energies of a step that is solved, and what it spends on flow, see `settle`."""
    return settle(weight, hinges, old, new)


@inner
def keep(new, old):
    """Commit the state of a step."""
    copy(new.plastic, old.plastic)
    copy(new.carried, old.carried)
    copy(new.local, old.local)
    copy(new.deformation, old.deformation)
    copy(new.rate, old.rate)


@inner
def write(old, states, n):
    """Committed state as row n of `states`."""
    copy(old.plastic, states.plastic[n])
    copy(old.carried, states.carried[n])
    copy(old.local, states.local[n])
    copy(old.deformation, states.deformation[n])


@inner
def kinetic(hinges, old):
    """Kinetic energy of turning chords, in J."""
    total = 0.0
    for e in range(hinges.rotary.size):
        total += 0.5 * hinges.rotary[e] * old.rate[e] ** 2
    return total


advance = march_of_bars(BarFunctions(assemble, start, finish, keep, write, kinetic), 2, 3)


@njit(cache=True, error_model="numpy", nogil=True)
def impact(system, drive, progress, records):
    """Follow an impact, see `workbench.mechanics.impact.integrator`: (status, records written)."""
    return advance(system, begin(drive, progress[0]), progress[0], records)
