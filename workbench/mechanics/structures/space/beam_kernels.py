"""The fiber beam in space: section forces N, M_y, M_z, its local law, group assembly, energies.

Symbols: eps = e/L + z kappa_y - y kappa_z with kappa = b1 theta_1 + b2 theta_2 about both axes,
b1 = (6 xi - 4)/L and b2 = (6 xi - 2)/L; N = sum(sigma A), M_y = sum(sigma z A), M_z =
-sum(sigma y A); torsion G I_t (theta_1x - theta_2x) / L, elastic. y runs along the height of the
section, z along its width. Source: Heng 2017, 2.1, in both planes.
"""

from typing import NamedTuple

import numpy as np

from workbench.base.arrays import Array
from workbench.base.compiled import njit
from workbench.mechanics.structures.fibers.kernels import LINEAR, linear, linear_rate
from workbench.mechanics.structures.kernels import copy
from workbench.mechanics.structures.space.frame_kernels import (
    add_moved_element,
    empty_frame,
    move_element,
)

ROWS = ((0, 0), (2, 5), (3, 6))  # of d: elongation, rotations of both ends about y and about z


@njit(cache=True, error_model="numpy")
def section_forces(beam, sections, strains, old, new, forces, k):
    """Forces (3,) N, M_y, M_z of a section of a `beam` within a step, and their tangent `k` (3, 3).

    Arguments: `sections` tables; `strains` (3,) eps, kappa_y, kappa_z at the weighted instant at
    which fibers yield; committed fiber states `old` (states, f). Writes the trial states `new` at
    the end of the step, see `fibers.kernels.section_response`.
    """
    plane, s = sections.plane, beam.section
    duration, on = beam.duration * beam.weight, 1.0 / beam.weight
    p, resting = plane.parameters[s], plane.code[s] == LINEAR
    axial, about_y, about_z = strains[0], strains[1], strains[2]
    N = My = Mz = 0.0
    k00 = k01 = k02 = k11 = k12 = k22 = 0.0
    for f in range(plane.y.shape[1]):
        y, z, area = plane.y[s, f], sections.z[s, f], plane.area[s, f]
        eps = axial + z * about_y - y * about_z
        if resting:
            stress, modulus, plastic, other = linear(
                p[0], p[1], p[2], p[3], eps, old[0, f], old[1, f]
            )
        else:
            stress, modulus, plastic, other = linear_rate(p, duration, eps, old[0, f], old[1, f])
        new[0, f] = old[0, f] + on * (plastic - old[0, f])
        new[1, f] = old[1, f] + on * (other - old[1, f])
        stress *= area
        modulus *= area
        N += stress
        My += stress * z
        Mz -= stress * y
        k00 += modulus
        k01 += modulus * z
        k02 -= modulus * y
        k11 += modulus * z * z
        k12 -= modulus * z * y
        k22 += modulus * y * y
    forces[0], forces[1], forces[2] = N, My, Mz
    k[0, 0], k[1, 1], k[2, 2] = k00, k11, k22
    k[0, 1] = k[1, 0] = k01
    k[0, 2] = k[2, 0] = k02
    k[1, 2] = k[2, 1] = k12


class SpaceBeam(NamedTuple):
    """One element as its law sees it.

    `length` in m; number of its `section`; `xi` along it with `weights` (points,); fiber states
    `old` and `new` (points, states, f); `weight` and `duration` (s) of the step.
    """

    length: float
    section: int
    xi: Array
    weights: Array
    old: Array
    new: Array
    weight: float
    duration: float


@njit(cache=True, error_model="numpy")
def point_factors(length, xi, factor):
    """Factors (3, 2) of the deformations `ROWS` in eps, kappa_y and kappa_z at a point."""
    factor[0, 0], factor[0, 1] = 1.0 / length, 0.0
    for i in range(1, 3):
        factor[i, 0], factor[i, 1] = (6.0 * xi - 4.0) / length, (6.0 * xi - 2.0) / length


@njit(cache=True, error_model="numpy")
def element_forces(beam, sections, d, Q, C, work):
    """Forces `Q` (7,) of a `beam` at deformations `d` (7,), and their tangent `C` (7, 7).

    Arguments: `sections` tables; scratch `work` (6, 3). Writes the fiber states.
    """
    strains, forces, k = work[0], work[1], work[2:5]
    Q[:] = 0.0
    C[:] = 0.0
    factor = np.empty((3, 2))
    for g in range(beam.xi.shape[0]):
        along = beam.weights[g] * beam.length
        point_factors(beam.length, beam.xi[g], factor)
        for i in range(3):
            strains[i] = factor[i, 0] * d[ROWS[i][0]] + factor[i, 1] * d[ROWS[i][1]]
        section_forces(beam, sections, strains, beam.old[g], beam.new[g], forces, k)
        for i in range(3):
            for a in range(2):
                row, share = ROWS[i][a], along * factor[i, a]
                Q[row] += share * forces[i]
                for j in range(3):
                    for b in range(2):
                        C[row, ROWS[j][b]] += share * factor[j, b] * k[i, j]
    twist = sections.torsion[beam.section] / beam.length
    Q[1] = twist * (d[1] - d[4])
    Q[4] = -Q[1]
    C[1, 1] = C[4, 4] = twist
    C[1, 4] = C[4, 1] = -twist


@njit(cache=True, error_model="numpy")
def assemble(step, bars, points, sections, axes, old, new):
    """Add forces and tangent of all elements of a group for a `step`; write the state `new`.

    `axes` (e, 2, 3, 3): those of the dofs of both nodes, as rows.
    """
    end, middle = empty_frame(), empty_frame()
    moved, within, Q, C = np.empty(12), np.empty(7), np.empty(7), np.empty((7, 7))
    work = np.empty((5, 3))
    share = step.weight if step.dynamic else 1.0
    for e in range(bars.dofs.shape[0]):
        move_element(step, bars, e, axes[e], old, new, moved, end)
        for i in range(7):
            within[i] = (1.0 - share) * old.deformation[e, i] + share * end.d[i]
        beam = SpaceBeam(
            bars.lengths[e],
            sections.plane.of[e],
            points.xi[e],
            points.weights[e],
            old.fibers[e],
            new.fibers[e],
            share,
            step.duration,
        )
        element_forces(beam, sections, within, Q, C, work)
        copy(Q, new.forces[e])
        add_moved_element(step, bars, e, axes[e], old, moved, end, middle, Q, C)


@njit(cache=True, error_model="numpy")
def account(weight, bars, points, sections, _axes, old, new):
    """Energies of a step from the committed to the trial state of a group, see `StepEnergies`."""
    plane = sections.plane
    stored = plastic = algorithmic = 0.0
    factor, before, after = np.empty((3, 2)), np.empty(3), np.empty(3)
    lag = weight - 0.5
    for e in range(bars.lengths.shape[0]):
        L, s, d0, d1 = bars.lengths[e], plane.of[e], old.deformation[e], new.deformation[e]
        E, H, twist = plane.parameters[s, 0], plane.parameters[s, 1], sections.torsion[s] / L
        start, end = d0[1] - d0[4], d1[1] - d1[4]
        stored += 0.5 * twist * end * end
        algorithmic += lag * twist * (end - start) ** 2
        for g in range(points.xi.shape[1]):
            along = points.weights[e, g] * L
            point_factors(L, points.xi[e, g], factor)
            for i in range(3):
                first, second = ROWS[i]
                before[i] = factor[i, 0] * d0[first] + factor[i, 1] * d0[second]
                after[i] = factor[i, 0] * d1[first] + factor[i, 1] * d1[second]
            for f in range(plane.y.shape[1]):
                y, z, volume = plane.y[s, f], sections.z[s, f], along * plane.area[s, f]
                p0, p1 = old.fibers[e, g, 0, f], new.fibers[e, g, 0, f]
                elastic0 = before[0] + z * before[1] - y * before[2] - p0
                elastic1 = after[0] + z * after[1] - y * after[2] - p1
                change, flow = elastic1 - elastic0, p1 - p0
                stored += 0.5 * volume * (E * elastic1 * elastic1 + H * p1 * p1)
                algorithmic += lag * volume * (E * change * change + H * flow * flow)
                stress = (1.0 - weight) * (E * elastic0 - H * p0)
                stress += weight * (E * elastic1 - H * p1)
                plastic += volume * stress * flow
    return stored, plastic, algorithmic, plastic
