"""Drawing members of superelements in many states at once."""

from workbench.compiled import njit


@njit(cache=True, error_model="numpy")
def draw(drawn, along, origin, bends, bars, x, carried, shapes):
    """Write the `shapes` (2, members, points, pictures) in m, as `MemberElements.bent` has them.

    Arguments: of each point of each member the element it is `drawn` on, where `along` that (0..1),
    and the `origin` of the element; flexibility `bends` of all elements; displacements `x` (dofs,
    pictures) and forces `carried` (elements, 3, pictures), axial force and end moments.
    """
    for m in range(drawn.shape[0]):
        for p in range(drawn.shape[1]):
            e, at = drawn[m, p], along[m, p]
            u0, v0, u1, v1 = bars.dofs[e, 0], bars.dofs[e, 1], bars.dofs[e, 3], bars.dofs[e, 4]
            soft = (bars.lengths[e] / 6.0 * bends[e]) * at * (1.0 - at)
            Dx, Dy, x0, y0 = bars.chords[e, 0], bars.chords[e, 1], origin[m, p, 0], origin[m, p, 1]
            for k in range(x.shape[1]):
                dx = Dx + x[u1, k] - x[u0, k]
                dy = Dy + x[v1, k] - x[v0, k]
                m1, m4 = carried[e, 1, k], carried[e, 2, k]
                across = soft * ((1.0 - at) * (2.0 * m1 - m4) - at * (2.0 * m4 - m1))
                shapes[0, m, p, k] = x0 + (x[u0, k] + at * dx - across * dy)
                shapes[1, m, p, k] = y0 + (x[v0, k] + at * dy + across * dx)
