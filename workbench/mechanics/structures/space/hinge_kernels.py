"""The superelement in space: an elastic bar between two hinges that yield under N, M_y and M_z.

Deformations e = (elongation, rotations about the strong and the weak axis at both ends) less those
of the hinges are elastic, Q = K e; the hinges are condensed by the projection of
`steel.hinges.biaxial_kernels` in forces over the plastic ones. Torsion is elastic. Hinges yield at
the weighted instant of a step; what they flow goes on to its end.
"""

import numpy as np

from workbench.base.compiled import njit
from workbench.mechanics.impact.contact import inner
from workbench.mechanics.impact.integrator import begin
from workbench.mechanics.structures.kernels import copy
from workbench.mechanics.structures.march import BarFunctions, march_of_bars
from workbench.mechanics.structures.space.frame_kernels import (
    add_moved_element,
    empty_frame,
    move_element,
)
from workbench.steel.hinges.biaxial_kernels import FAILED, project

OF = (0, 3, 2, 6, 5)  # of the deformations: N, strong and weak axis at the start and at the end


@njit(cache=True, error_model="numpy")
def element_forces(e, bars, weight, d, old, new, Q, C):
    """Forces `Q` (7,) and tangent `C` (7, 7) of element `e` at deformations `d` (7,) within a step.

    Arguments: tables of the `bars`; `weight` of the instant; states. Writes the plastic
    deformations at the end of the step. False where the projection fails.
    """
    room, strength, trial = bars.rooms[e], bars.strength[e], np.empty(5)
    for i in range(5):
        trial[i] = strength[i] * (d[OF[i]] - old.plastic[e, i])
    state = project(bars.surfaces[bars.of[e]], bars.stiffness[e], trial, room)
    Q[:] = 0.0
    C[:] = 0.0
    flow = room.flow
    for i in range(5):
        force = room.force[i] * strength[i]
        spent = flow[0] + flow[3] if i == 0 else flow[i if i < 3 else i + 1]
        new.plastic[e, i] = old.plastic[e, i] + spent / (strength[i] * weight)
        held = bars.held * bars.stiffness[e, i, i] * strength[i] ** 2
        Q[OF[i]] = force + held * d[OF[i]]
        for j in range(5):
            C[OF[i], OF[j]] = strength[i] * room.tangent[i, j] * strength[j]
        C[OF[i], OF[i]] += held
    twist = bars.torsion[e]
    Q[1] = twist * (d[1] - d[4])
    Q[4] = -Q[1]
    C[1, 1] = C[4, 4] = twist
    C[1, 4] = C[4, 1] = -twist
    return state != FAILED


@njit(cache=True, error_model="numpy")
def assemble(step, places, bars, old, new):
    """Add forces and tangent of all elements of a group for a `step`; write the state `new`.

    Where a projection fails forces are not numbers, so that the step does not count as solved.
    """
    end, middle = empty_frame(), empty_frame()
    moved, within, Q, C = np.empty(12), np.empty(7), np.empty(7), np.empty((7, 7))
    share = step.weight if step.dynamic else 1.0
    for e in range(places.dofs.shape[0]):
        move_element(step, places, e, bars.axes[e], old, new, moved, end)
        for i in range(7):
            within[i] = (1.0 - share) * old.deformation[e, i] + share * end.d[i]
        if not element_forces(e, bars, share, within, old, new, Q, C):
            Q[0] = np.nan
        copy(Q, new.forces[e])
        add_moved_element(step, places, e, bars.axes[e], old, moved, end, middle, Q, C)


@njit(cache=True, error_model="numpy")
def finish(weight, places, bars, old, new):
    """Energies of a step as of `account`, and the work of changes of forces on the flow, in J.

    It shows where hinges begin to flow, ring, or follow the surface around a bend.
    """
    stored = plastic = algorithmic = late = 0.0
    lag, start, end = weight - 0.5, np.empty(5), np.empty(5)
    for e in range(places.lengths.shape[0]):
        strength, d0, d1 = bars.strength[e], old.deformation[e], new.deformation[e]
        before, after = d0[1] - d0[4], d1[1] - d1[4]
        stored += 0.5 * bars.torsion[e] * after**2
        algorithmic += lag * bars.torsion[e] * (after - before) ** 2
        for i in range(5):
            start[i] = strength[i] * (d0[OF[i]] - old.plastic[e, i])
            end[i] = strength[i] * (d1[OF[i]] - new.plastic[e, i])
            held = bars.held * bars.stiffness[e, i, i] * strength[i] ** 2
            stored += 0.5 * held * d1[OF[i]] ** 2
            algorithmic += lag * held * (d1[OF[i]] - d0[OF[i]]) ** 2
        for i in range(5):
            flow, change = strength[i] * (new.plastic[e, i] - old.plastic[e, i]), 0.0
            for j in range(5):
                k = bars.stiffness[e, i, j]
                stored += 0.5 * end[i] * k * end[j]
                algorithmic += lag * (end[i] - start[i]) * k * (end[j] - start[j])
                plastic += flow * k * ((1.0 - weight) * start[j] + weight * end[j])
                change += k * (end[j] - start[j])
            # half the trapezoid of both: a fifth fewer evaluations, peaks within 0.1 % of it
            late += 0.25 * abs(flow * change)
    return stored, plastic, algorithmic, plastic, late


@njit(cache=True, error_model="numpy")
def account(weight, places, bars, old, new):
    """Energies of a step from the committed to the trial state of a group, see `StepEnergies`."""
    return finish(weight, places, bars, old, new)[:4]


@inner
def start(_old, _new):
    """Begin a step: projections begin where the last ones ended."""


@inner
def keep(new, old):
    """Commit the state of a step."""
    copy(new.triads, old.triads)
    copy(new.chord, old.chord)
    copy(new.deformation, old.deformation)
    copy(new.forces, old.forces)
    copy(new.plastic, old.plastic)


@inner
def write(old, states, n):
    """Committed state as row n of `states`."""
    copy(old.triads, states.triads[n])
    copy(old.chord, states.chord[n])
    copy(old.deformation, states.deformation[n])
    copy(old.forces, states.forces[n])
    copy(old.plastic, states.plastic[n])


@inner
def kinetic(_bars, _old):
    """Kinetic energy beside the mass matrix: none."""
    return 0.0


advance = march_of_bars(BarFunctions(assemble, start, finish, keep, write, kinetic), 3, 6)


@njit(cache=True, error_model="numpy", nogil=True)
def impact(system, drive, progress, records):
    """Follow an impact, see `workbench.mechanics.impact.integrator`: (status, records written)."""
    return advance(system, begin(drive, progress[0]), progress[0], records)
