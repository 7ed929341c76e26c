"""The superelement in space: an elastic bar between two hinges that yield under N, M_y and M_z.

Deformations e = (elongation, rotations about the strong and the weak axis at both ends) less those
of the hinges are elastic, Q = K e; the hinges are condensed by the projection of
`steel.hinges.biaxial_kernels` in forces over the plastic ones. Torsion is elastic. Hinges yield at
the weighted instant of a step; what they flow goes on to its end.
"""

import numpy as np

from workbench.base.compiled import njit
from workbench.mechanics.structures.kernels import copy
from workbench.mechanics.structures.space.frame_kernels import (
    add_moved_element,
    columns_by,
    element_step,
    empty_frame,
    spin_map,
    take_frame,
    turn,
)
from workbench.steel.hinges.biaxial_kernels import FAILED, project

OF = (0, 3, 2, 6, 5)  # of the deformations: N, strong and weak axis at the start and at the end


@njit(cache=True, error_model="numpy")
def element_forces(e, bars, weight, d, old, new, Q, C):
    """Forces `Q` (7,) and tangent `C` (7, 7) of element `e` at deformations `d` (7,) within a step.

    Arguments: tables of the `bars`; `weight` of the instant; states. Writes the plastic
    deformations at the end of the step. False where the projection fails.
    """
    room, strength, trial = new.rooms[e], bars.strength[e], np.empty(5)
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
def assemble(step, places, bars, axes, old, new):
    """Add forces and tangent of all elements of a group for a `step`; write the state `new`.

    Where a projection fails forces are not numbers, so that the step does not count as solved.
    """
    end, middle = empty_frame(), empty_frame()
    moved, within, Q, C = np.empty(12), np.empty(7), np.empty(7), np.empty((7, 7))
    maps = np.empty((2, 3, 3))
    share = step.weight if step.dynamic else 1.0
    for e in range(places.dofs.shape[0]):
        element_step(step, places.dofs[e], axes[e], moved)
        for node in range(2):
            psi = moved[6 * node + 3 : 6 * node + 6]
            turn(psi, 1.0, old.triads[e, node], new.triads[e, node])
            spin_map(psi, 1.0, maps[node])
        for k in range(3):
            new.chord[e, k] = old.chord[e, k] + (moved[6 + k] - moved[k])
        triads, L = new.triads[e], places.lengths[e]
        take_frame(new.chord[e], places.chords[e], L, triads[0], triads[1], end)
        columns_by(end.B, maps[0], maps[1])
        copy(end.d, new.deformation[e])
        for i in range(7):
            within[i] = (1.0 - share) * old.deformation[e, i] + share * end.d[i]
        if not element_forces(e, bars, share, within, old, new, Q, C):
            Q[0] = np.nan
        copy(Q, new.forces[e])
        add_moved_element(step, places, e, axes[e], old, moved, end, middle, Q, C)


@njit(cache=True, error_model="numpy")
def account(weight, places, bars, _axes, old, new):
    """Energies of a step from the committed to the trial state of a group, see `StepEnergies`."""
    stored = plastic = algorithmic = 0.0
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
            flow = strength[i] * (new.plastic[e, i] - old.plastic[e, i])
            for j in range(5):
                k = bars.stiffness[e, i, j]
                stored += 0.5 * end[i] * k * end[j]
                algorithmic += lag * (end[i] - start[i]) * k * (end[j] - start[j])
                plastic += flow * k * ((1.0 - weight) * start[j] + weight * end[j])
    return stored, plastic, algorithmic, plastic
