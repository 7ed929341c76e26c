"""Oracle: superelements by condensation of their internal degrees of freedom (papers III, IV).

Every hinge is a return mapping of its own deformations; what is inside the element, the ends
2 and 3 of the bar, is brought into equilibrium by Newton's method and condensed out of the
tangent. Source: Heng 2017, papers III (flexible bar) and IV (rigid bar).
"""

from __future__ import annotations

import numpy as np
from generalized_hinge import GeneralizedHinge
from scipy.optimize import brentq

SIGN = np.array([1.0, -1.0])  # the moment on the bar at end 1 is the internal one, turned


def flexible(hinges: tuple[GeneralizedHinge, GeneralizedHinge], bar, deformation, plastic):
    """Forces (N, M1, M4), condensed tangent, residual that is left.

    `bar` is L, EA, EI; `plastic` (2, 2). The tangent is None where both hinges sit on a corner
    and the internal degrees of freedom are loose.
    """
    length, axial, bending = bar
    k_n = axial / length
    k_b = bending / length * np.array([[4.0, 2.0], [2.0, 4.0]])
    total = np.asarray(deformation, float)

    def residual(x):
        u2, t2, u3, t3 = x
        one = hinges[0].return_mapping([u2, total[1] - t2], plastic[0])
        two = hinges[1].return_mapping([total[0] - u3, total[2] - t3], plastic[1])
        normal = k_n * (u3 - u2)
        m2, m3 = k_b @ [t2, t3]
        r = np.array([
            one.forces[0] - normal, m2 - one.forces[1],
            normal - two.forces[0], m3 - two.forces[1],
        ])  # fmt: skip
        d1, d4 = one.tangent, two.tangent
        inner = np.array([
            [d1[0, 0] + k_n, -d1[0, 1], -k_n, 0.0],
            [-d1[1, 0], k_b[0, 0] + d1[1, 1], 0.0, k_b[0, 1]],
            [-k_n, 0.0, k_n + d4[0, 0], d4[0, 1]],
            [0.0, k_b[1, 0], d4[1, 0], k_b[1, 1] + d4[1, 1]],
        ])  # fmt: skip
        return r, inner, one, two

    # the residual is the gradient of a convex potential: a line search on its slope is safe
    scale = np.tile([hinges[0].axial_stiffness, hinges[0].rotational_stiffness[0]], 2)
    x = np.array([0.5 * total[0], total[1], 0.5 * total[0], total[2]])
    r, inner, one, two = residual(x)
    for _ in range(500):
        left = np.linalg.norm(r / scale) / np.abs(total).max()
        if left <= 1e-14:
            break
        step = np.linalg.solve(inner + min(1e-2, left) * np.diag(scale), -r)
        slope = step @ r
        low, high, s = 0.0, np.inf, 1.0
        for _ in range(30):
            r, inner, one, two = residual(x + s * step)
            if abs(step @ r) <= 0.1 * abs(slope):
                break
            low, high = (low, s) if step @ r > 0.0 else (s, high)
            s = 2.0 * s if high == np.inf else 0.5 * (low + high)
        x = x + s * step
    d1, d4 = one.tangent, two.tangent
    outer = np.array([[d4[0, 0], 0.0, d4[0, 1]], [0.0, d1[1, 1], 0.0], [d4[1, 0], 0.0, d4[1, 1]]])
    by_inner = np.array([
        [0.0, 0.0, -d4[0, 0], -d4[0, 1]],
        [d1[1, 0], -d1[1, 1], 0.0, 0.0],
        [0.0, 0.0, -d4[1, 0], -d4[1, 1]],
    ])  # fmt: skip
    by_outer = np.array([
        [0.0, d1[0, 1], 0.0],
        [0.0, -d1[1, 1], 0.0],
        [-d4[0, 0], 0.0, -d4[0, 1]],
        [-d4[1, 0], 0.0, -d4[1, 1]],
    ])  # fmt: skip
    forces = np.array([two.forces[0], one.forces[1], two.forces[1]])
    unit = np.sqrt(np.outer(scale, scale))
    if np.linalg.matrix_rank(inner / unit, tol=1e-9) < 4:
        return forces, None, left
    return forces, outer - by_inner @ np.linalg.solve(inner, by_outer), left


def rigid(hinges: tuple[GeneralizedHinge, GeneralizedHinge], deformation, plastic):
    """Forces (N, M1, M4) with the axial displacement of the bar as the only unknown."""
    total = np.asarray(deformation, float)

    def ends(u):
        one = hinges[0].return_mapping([u, total[1]], plastic[0])
        two = hinges[1].return_mapping([total[0] - u, total[2]], plastic[1])
        return one.forces, two.forces

    def residual(u):
        one, two = ends(u)
        return one[0] - two[0]

    reach = 10.0 * (np.abs(total).sum() + np.abs(plastic).sum() + 1e-3)
    u = brentq(residual, -reach, reach, xtol=1e-18, rtol=1e-15, maxiter=500)
    one, two = ends(u)
    return np.array([0.5 * (one[0] + two[0]), one[1], two[1]])
