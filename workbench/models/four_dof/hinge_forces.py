"""Strength of a bar: two hinges on a yield surface, a panel, or a bar that flows point by point."""

from numba.extending import overload

from workbench.base.compiled import njit
from workbench.models.four_dof import kinematics as geometry
from workbench.steel.hinges.kernels import ELASTIC, project
from workbench.steel.hinges.viscoplastic_kernels import flow_of_bar

_FLOWING = ELASTIC + 1


@njit(cache=True, error_model="numpy", forceinline=True)
def projected(column, bar, elastic, stress, work):
    """Forces of two hinges, or of a panel, that do not know time."""
    if column.sliding:
        trial, D = work.trial[:], work.D[bar]
        trial[0], trial[1], trial[2] = elastic
        geometry.chord_forces(column, bar, stress[bar], work)
        return D[0, 0], D[0, 1], D[0, 2], D[1, 1], D[1, 2], D[2, 2]
    k, N, M = column.stiffness, column.squash_loads, column.plastic_moments
    stiffness = k[bar, 0], k[bar, 1], k[bar, 2]
    trial = stiffness[0] * elastic[0], stiffness[1] * elastic[1], stiffness[2] * elastic[2]
    bounds, exponents = (N[0], N[1], M[0], M[1]), (column.alpha, column.beta)
    projected = project(stiffness, bounds, exponents, trial, work.z[bar])
    work.branch[bar], work.z[bar] = projected[0], projected[3]
    stress[bar, 0], stress[bar, 1], stress[bar, 2] = projected[1]
    return projected[2]


@njit(cache=True, error_model="numpy")
def viscoplastic(column, bar, elastic, state, work):
    """Forces of a bar after a step of `work.dt`, from those that the last tangent expects."""
    f, pinned, length = column.flexibility[bar], column.pinned[bar], column.lengths[bar]
    slides = column.sliding
    soft = 1.0 / (length * column.web.stiffness) if slides else 0.0
    last, stress = work.last[bar], state.stress[bar]
    e, a, b = elastic[0] - last[0], elastic[1] - last[1], elastic[2] - last[2]
    stress[0] += last[3] * e + last[4] * a + last[5] * b
    stress[1] += last[4] * e + last[6] * a + last[7] * b
    stress[2] += last[5] * e + last[7] * a + last[8] * b
    flows, tangent, work.flow[bar, 3] = flow_of_bar(
        column.law,
        length,
        (f[0], f[1] + soft, f[2] - soft, f[3] + soft),
        (pinned[0] > 0, pinned[1] > 0),
        elastic,
        work.dt,
        state.plastic[bar, 4:],
        stress,
        work.flow[bar, 4:],
    )
    for i in range(3):
        last[i] = elastic[i]
    for i in range(6):
        last[3 + i] = tangent[i]
    work.branch[bar] = _FLOWING if flows else ELASTIC
    if slides:
        stress[3] = (stress[1] - stress[2]) / length
    return tangent


def hinge_forces(column, bar, elastic, state, work):
    """Forces of a bar from its `elastic` deformations, into `state.stress`, and their tangent.

    The tangent as numbers, NN, N1, N2, 11, 12, 22. Which strength it is, the type of the column
    says when kernels are compiled: what is not used is not compiled.
    """
    raise NotImplementedError


@overload(hinge_forces, jit_options={"error_model": "numpy", "forceinline": True})
def _by_type(column, bar, elastic, state, work):
    if "law" in column.fields:
        return lambda column, bar, elastic, state, work: viscoplastic(
            column, bar, elastic, state, work
        )
    return lambda column, bar, elastic, state, work: projected(
        column, bar, elastic, state.stress, work
    )
