"""Compiled loops over shell elements: strain, stress, hourglass control and forces of a step.

Quadrilaterals of Belytschko, Lin and Tsay with one point in their plane and four through their
thickness. A frame turns with each element: its third axis is normal to both diagonals, its first
one lies between the directions of the sides. Increments of strain are those of Almansi over a step
(of the gradients G of its displacements: sym G - G'G / 2), so that a body that turns feels
nothing. Layers return to the yield surface of plane stress as the points of the solid do.
Vectors are tuples of three numbers, in the axes of the structure or of the element.
Sources: Belytschko, Lin and Tsay 1984; Belytschko, Liu and Moran 2000, sections 8.7 and 9.6.
"""

from typing import NamedTuple

import numpy as np

from workbench.base.arrays import Array, Flags, Indices
from workbench.base.compiled import njit
from workbench.models.references.solid.kernels import SolidSteel, Tensor, return_mapping

SHEAR_FACTOR = 5.0 / 6.0  # of the transverse shear stiffness
DRILLING = 0.1  # stiffness that ties rotations in the plane to its turn, over the shear modulus
HOURGLASS = 0.05  # stiffness against hourglass modes, over that of the elements
# Points through the thickness, from -1 to 1: two of Gauss in either half, exact for the elastic and
# for the fully plastic moment, of which five over the whole would lose 5.5 %.
POINTS = np.array([-0.5 - 0.5 / np.sqrt(3.0), -0.5 + 0.5 / np.sqrt(3.0), 0.0, 0.0])
POINTS[2:] = -POINTS[1::-1]
WEIGHTS = np.full(len(POINTS), 0.5)


class Shells(NamedTuple):
    """Quadrilaterals: their four `nodes` (elements, 4), in turn, and `thickness` (elements,), m."""

    nodes: Indices
    thickness: Array


class ShellState(NamedTuple):
    """State of the elements in their own axes.

    `yielded` (elements,): elements that have flowed keep the elastic strain and the equivalent
    plastic strain of their `layers` (elements, 4, 4), and as `linear` (elements, 6) their forces
    (N/m) and moments (N); the others the strain of their middle surface and its curvatures there.
    Transverse `shear` forces (elements, 3) in N/m, the third against rotations in the plane,
    `hourglass` moments and forces (elements, 5): two of rotations, then along the three axes.
    """

    yielded: Flags
    linear: Array
    layers: Array
    shear: Array
    hourglass: Array

    @classmethod
    def of(cls, count: int) -> "ShellState":
        """So many elements that nothing has happened to."""
        sizes = (count, 6), (count, len(POINTS), 4), (count, 3), (count, 5)
        return cls(np.zeros(count, dtype=bool), *map(np.zeros, sizes))


class StepWork(NamedTuple):
    """Work of a step in J: stored in strain, plastic, and against hourglass modes."""

    elastic: float
    plastic: float
    hourglass: float


@njit(cache=True, error_model="numpy")
def row(table, i, first):
    """Vector that stands in a table from a column on."""
    return table[i, first], table[i, first + 1], table[i, first + 2]


@njit(cache=True, error_model="numpy")
def dot(a, b):
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True, error_model="numpy")
def cross(a, b):
    """Vector product."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


@njit(cache=True, error_model="numpy")
def blend(s, a, t, b):
    """Vector s a + t b."""
    return s * a[0] + t * b[0], s * a[1] + t * b[1], s * a[2] + t * b[2]


@njit(cache=True, error_model="numpy")
def mixed(a, b, c, d, signs):
    """Sum of four vectors with their signs."""
    s = signs
    return (
        s[0] * a[0] + s[1] * b[0] + s[2] * c[0] + s[3] * d[0],
        s[0] * a[1] + s[1] * b[1] + s[2] * c[1] + s[3] * d[1],
        s[0] * a[2] + s[1] * b[2] + s[2] * c[2] + s[3] * d[2],
    )


@njit(cache=True, error_model="numpy")
def inside(frame, a):
    """Vector in the axes of a frame, which are its rows."""
    return dot(frame[0], a), dot(frame[1], a), dot(frame[2], a)


@njit(cache=True, error_model="numpy")
def outside(frame, a):
    """Vector of a frame in the axes of the structure."""
    e1, e2, e3 = frame
    return (
        e1[0] * a[0] + e2[0] * a[1] + e3[0] * a[2],
        e1[1] * a[0] + e2[1] * a[1] + e3[1] * a[2],
        e1[2] * a[0] + e2[2] * a[1] + e3[2] * a[2],
    )


@njit(cache=True, error_model="numpy")
def frame_of_element(p, q):
    """Axes of an element with these diagonals, first to third and second to fourth node; area."""
    a, b = blend(0.5, p, -0.5, q), blend(0.5, p, 0.5, q)  # between the middles of its sides
    normal = cross(a, b)
    area = np.sqrt(dot(normal, normal))
    e3 = blend(1.0 / area, normal, 0.0, normal)
    first = blend(1.0 / np.sqrt(dot(a, a)), a, 1.0 / np.sqrt(dot(b, b)), cross(b, e3))
    e1 = blend(1.0 / np.sqrt(dot(first, first)), first, 0.0, first)
    return (e1, cross(e3, e1), e3), area


@njit(cache=True, error_model="numpy")
def elastic_stress(strain, steel):
    """Stress of plane stress of an elastic strain with engineering shear."""
    plane = steel.modulus / (1.0 - steel.poisson**2)
    s1 = plane * (strain[0] + steel.poisson * strain[1])
    s2 = plane * (strain[1] + steel.poisson * strain[0])
    return s1, s2, 0.5 * steel.modulus / (1.0 + steel.poisson) * strain[2]


@njit(cache=True, error_model="numpy")
def misfit(s):
    """Square of the equivalent stress."""
    return s[0] * s[0] - s[0] * s[1] + s[1] * s[1] + 3.0 * s[2] * s[2]


@njit(cache=True, error_model="numpy")
def stays_elastic(linear, thickness, steel):
    """Whether no layer of an element that has never flowed is beyond its strength."""
    z = 0.5 * thickness * POINTS[-1]
    middle, curvature = (linear[0], linear[1], linear[2]), (linear[3], linear[4], linear[5])
    upper = misfit(elastic_stress(blend(1.0, middle, z, curvature), steel))
    lower = misfit(elastic_stress(blend(1.0, middle, -z, curvature), steel))
    return max(upper, lower) <= steel.yield_stress**2


@njit(cache=True, error_model="numpy")
def flow_through(layers, thickness, strain, bent, steel):
    """Step of the layers of an element: forces and moments (N/m, N), plastic work (J/m2).

    Arguments: its `layers` (4, 4), which change; increments of the strain of the middle surface,
    `strain`, and of the curvatures, `bent`. The plastic work is that of the mean stress.
    """
    forces, moments, plastic = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0
    for k in range(len(POINTS)):
        z, weight = 0.5 * thickness * POINTS[k], 0.5 * thickness * WEIGHTS[k]
        before = (layers[k, 0], layers[k, 1], layers[k, 2])
        trial = blend(1.0, before, 1.0, blend(1.0, strain, z, bent))
        stress = elastic_stress(trial, steel)
        if misfit(stress) > (steel.yield_stress + steel.hardening * layers[k, 3]) ** 2:
            back = return_mapping(Tensor(trial[0], trial[1], trial[2]), layers[k, 3], steel)
            stress = (back.stress.t11, back.stress.t22, back.stress.t12)
            flow = (back.flow.t11, back.flow.t22, back.flow.t12)
            mean = blend(0.5, elastic_stress(before, steel), 0.5, stress)
            plastic += weight * dot(mean, flow)
            trial = blend(1.0, trial, -1.0, flow)
            layers[k, 3] = back.hardened
        for i in range(3):
            layers[k, i] = trial[i]
        forces = blend(1.0, forces, weight, stress)
        moments = blend(1.0, moments, weight * z, stress)
    return forces, moments, plastic


@njit(cache=True, error_model="numpy")
def add(table, i, force, moment):
    """Add a force and a moment to those of a node."""
    for k in range(3):
        table[i, k] += force[k]
        table[i, 3 + k] += moment[k]


@njit(cache=True, error_model="numpy")
def respond(
    shells: Shells, place: Array, step: Array, state: ShellState, steel: SolidSteel, force: Array
) -> StepWork:
    """Add the internal forces and moments of all nodes to `force` (nodes, 6) at the end of a step.

    Arguments: `place` (nodes, 3) of the nodes at its end, m; `step` (nodes, 6), displacements and
    rotations in it; `state`, which becomes that at its end.
    """
    elastic = plastic = against = 0.0
    E, shear_modulus = steel.modulus, 0.5 * steel.modulus / (1.0 + steel.poisson)
    ones, turns = (1.0, 1.0, 1.0, 1.0), (1.0, -1.0, 1.0, -1.0)
    for e in range(len(shells.thickness)):
        i, j, k, l = shells.nodes[e]  # noqa: E741
        t, linear, hourglass = shells.thickness[e], state.linear[e], state.hourglass[e]
        at = row(place, i, 0), row(place, j, 0), row(place, k, 0), row(place, l, 0)
        p, q = blend(1.0, at[2], -1.0, at[0]), blend(1.0, at[3], -1.0, at[1])
        frame, area = frame_of_element(p, q)
        p, q = inside(frame, p), inside(frame, q)
        h = inside(frame, mixed(at[0], at[1], at[2], at[3], turns))
        half = 0.5 / area
        # gradients of the shape functions of the first two nodes; those of the others are opposite
        b1, b2 = (-half * q[1], half * p[1]), (half * q[0], -half * p[0])

        ui, uj, uk, ul = row(step, i, 0), row(step, j, 0), row(step, k, 0), row(step, l, 0)
        d13, d24 = blend(1.0, ui, -1.0, uk), blend(1.0, uj, -1.0, ul)
        d13, d24 = inside(frame, d13), inside(frame, d24)
        g1, g2 = blend(b1[0], d13, b1[1], d24), blend(b2[0], d13, b2[1], d24)
        wave = inside(frame, mixed(ui, uj, uk, ul, turns))
        ui, uj, uk, ul = row(step, i, 3), row(step, j, 3), row(step, k, 3), row(step, l, 3)
        d13, d24 = blend(1.0, ui, -1.0, uk), blend(1.0, uj, -1.0, ul)
        d13, d24 = inside(frame, d13), inside(frame, d24)
        w1, w2 = blend(b1[0], d13, b1[1], d24), blend(b2[0], d13, b2[1], d24)
        ripple = inside(frame, mixed(ui, uj, uk, ul, turns))
        turn = inside(frame, mixed(ui, uj, uk, ul, ones))
        x, y, spin = 0.25 * turn[0], 0.25 * turn[1], 0.5 * (g1[1] - g2[0])

        strain = (
            g1[0] - 0.5 * dot(g1, g1),
            g2[1] - 0.5 * dot(g2, g2),
            g1[1] + g2[0] - dot(g1, g2),
        )
        bent = (w1[1], -w2[0], w2[1] - w1[0])
        slide = (g1[2] + y + 0.5 * x * spin, g2[2] - x + 0.5 * y * spin, 0.25 * turn[2] - spin)
        # five hourglass modes, blind to rigid motion and even strain of warped elements too
        modes = (
            ripple[0] - h[0] * w1[0] - h[1] * w2[0],
            ripple[1] - h[0] * w1[1] - h[1] * w2[1],
            wave[0] - h[0] * g1[0] - h[1] * g2[0] + h[2] * g1[2],
            wave[1] - h[0] * g1[1] - h[1] * g2[1] + h[2] * g2[2],
            wave[2] - h[0] * g1[2] - h[1] * g2[2],
        )

        bend, lost = t**3 / 12.0, 0.0
        middle, curved = (linear[0], linear[1], linear[2]), (linear[3], linear[4], linear[5])
        if not state.yielded[e]:
            old = middle, curved
            middle, curved = blend(t, middle, 0.0, middle), blend(bend, curved, 0.0, curved)
            middle, curved = elastic_stress(middle, steel), elastic_stress(curved, steel)
            for n in range(3):
                linear[n], linear[3 + n] = old[0][n] + strain[n], old[1][n] + bent[n]
            if not stays_elastic(linear, t, steel):
                state.yielded[e] = True
                for n in range(len(POINTS)):
                    for m in range(3):
                        layer = old[0][m] + 0.5 * t * POINTS[n] * old[1][m]
                        state.layers[e, n, m] = layer
        if state.yielded[e]:
            N, M, lost = flow_through(state.layers[e], t, strain, bent, steel)
            for n in range(3):
                linear[n], linear[3 + n] = N[n], M[n]
        else:
            N = elastic_stress((t * linear[0], t * linear[1], t * linear[2]), steel)
            M = elastic_stress((bend * linear[3], bend * linear[4], bend * linear[5]), steel)
        work = dot(blend(0.5, middle, 0.5, N), strain) + dot(blend(0.5, curved, 0.5, M), bent)
        elastic, plastic = elastic + area * (work - lost), plastic + area * lost

        shear, V = SHEAR_FACTOR * shear_modulus * t, state.shear[e]
        stiffness = (shear, shear, DRILLING * shear_modulus * t)
        for n in range(3):
            V[n] += stiffness[n] * slide[n]
            elastic += area * (V[n] - 0.5 * stiffness[n] * slide[n]) * slide[n]
        steep = 2.0 * area * (b1[0] ** 2 + b1[1] ** 2 + b2[0] ** 2 + b2[1] ** 2)
        plate = HOURGLASS * E * t**3 * steep / 192.0
        sheet = HOURGLASS * E * t * steep / 8.0
        against_modes = (plate, plate, sheet, sheet, HOURGLASS * shear * t**2 * steep / 12.0)
        for n in range(5):
            hourglass[n] += against_modes[n] * modes[n]
            against += (hourglass[n] - 0.5 * against_modes[n] * modes[n]) * modes[n]

        H = (hourglass[2], hourglass[3], hourglass[4])
        to1 = (N[0], N[2] - 0.5 * V[2], V[0] + h[2] * H[0] / area)
        to2 = (N[2] + 0.5 * V[2], N[1], V[1] + h[2] * H[1] / area)
        to1, to2 = blend(area, to1, -h[0], H), blend(area, to2, -h[1], H)
        f13, f24 = blend(b1[0], to1, b2[0], to2), blend(b1[1], to1, b2[1], to2)
        f13, f24, H = outside(frame, f13), outside(frame, f24), outside(frame, H)
        R = (hourglass[0], hourglass[1], 0.0)
        to1 = blend(area, (-M[2], M[0], 0.0), -h[0], R)
        to2 = blend(area, (-M[1], M[2], 0.0), -h[1], R)
        m13, m24 = blend(b1[0], to1, b2[0], to2), blend(b1[1], to1, b2[1], to2)
        m13, m24, R = outside(frame, m13), outside(frame, m24), outside(frame, R)
        even = outside(frame, (-V[1], V[0], V[2]))
        even = blend(0.25 * area, even, 0.0, even)
        odd, same = blend(1.0, even, 1.0, R), blend(1.0, even, -1.0, R)
        add(force, i, blend(1.0, H, 1.0, f13), blend(1.0, odd, 1.0, m13))
        add(force, k, blend(1.0, H, -1.0, f13), blend(1.0, odd, -1.0, m13))
        add(force, j, blend(-1.0, H, 1.0, f24), blend(1.0, same, 1.0, m24))
        add(force, l, blend(-1.0, H, -1.0, f24), blend(1.0, same, -1.0, m24))
    return StepWork(elastic, plastic, against)
