"""The plastic mechanism of the column: its hinge groups in plain numbers."""

from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.errors import OutOfDomainError
from workbench.scenarios import Column

Array = NDArray[np.float64]


Groups = tuple[Array, Array, Array, float, float, float, float, float]


class Mechanism(NamedTuple):
    """Two rigid bars with hinge groups that yield in bending and axial force (linear surface).

    Arguments: `groups`, names out of base, hit, head (a pinned end has no group; the two hinges
    at the hit point, which carry the same moment, are one group); per group `rotation_rates`
    s = d(rotation)/dv (1/m), `flexibilities` phi (rad/(N m)); `lengths` of the two bars (m);
    `plastic_moment` (N m), `squash_load` (N); `axial_force` before the push (N, tension
    positive); `axial_flexibility` of bars and restraint (m/N), infinite if free to shorten.
    """

    groups: tuple[str, ...]
    rotation_rates: Array
    flexibilities: Array
    lengths: tuple[float, float]
    plastic_moment: float
    squash_load: float
    axial_force: float
    axial_flexibility: float

    @property
    def slope_sum(self) -> float:
        """Sum kappa of the inverse lengths, in 1/m."""
        return 1.0 / self.lengths[0] + 1.0 / self.lengths[1]

    @property
    def moments_per_displacement(self) -> Array:
        """Elastic moment K = s / phi of each group per displacement, in N (N m/m)."""
        return np.asarray(self.rotation_rates / self.flexibilities)

    @property
    def kernel(self) -> Groups:
        """What the kernels take: s, K, phi, kappa, M_p, N_p, N_0, c_ax."""
        moments, kappa = self.moments_per_displacement, self.slope_sum
        return self.rotation_rates, moments, self.flexibilities, kappa, *self[4:]


def mechanism_of(column: Column, rotational_stiffness: float = 6.0) -> Mechanism:
    """The mechanism of a column.

    Arguments: `column`; `rotational_stiffness`, the factor c of the hinge stiffness c EI / l of
    a bar of length l (Heng 2017: 6; half of it at the hit point if the bar's other end is
    pinned). A head that is fixed has no restraint flexibility; the restraint of any other head
    is its spring, and without one the head is free to shorten.
    Raises `OutOfDomainError` if the axial load exhausts the lateral stiffness of the mechanism.
    """
    properties = column.properties
    bending = column.steel.elastic_modulus * properties.second_moment
    half = rotational_stiffness * bending
    ends = (
        ("base", column.length_below, column.base == "pinned"),
        ("head", column.length_above, column.head == "pinned"),
    )
    middle = 0.0
    for _, length, pinned in ends:
        middle += (2.0 if pinned else 1.0) * length / half
    hit = ("hit", 1.0 / column.length_below + 1.0 / column.length_above, middle)
    base, head = (
        [] if pinned else [(name, 1.0 / length, length / half)] for name, length, pinned in ends
    )
    groups, rates, flexibilities = zip(*base, hit, *head, strict=True)
    mechanism = Mechanism(
        groups,
        np.array(rates),
        np.array(flexibilities),
        (column.length_below, column.length_above),
        properties.plastic_moment,
        properties.squash_load,
        -column.axial_load,
        axial_flexibility(column),
    )
    elastic = float(rates @ mechanism.moments_per_displacement)
    if elastic <= mechanism.slope_sum * column.axial_load:
        raise OutOfDomainError(
            f"the axial load {column.axial_load / 1e3:.4g} kN exhausts the lateral stiffness of "
            f"the two-bar mechanism, which carries {elastic / mechanism.slope_sum / 1e3:.4g} kN: "
            "reduce the load"
        )
    return mechanism


def axial_flexibility(column: Column) -> float:
    """Shortening (m/N) of the column and its restraint per axial force, infinite if it is free."""
    own = column.length / (column.steel.elastic_modulus * column.properties.area)
    if column.head == "fixed":
        return own
    spring = column.restraint_stiffness
    return own + 1.0 / spring if spring > 0.0 else inf
