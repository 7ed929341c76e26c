"""The plastic mechanism of the column: its hinge groups in plain numbers."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import NDArray

from workbench.errors import OutOfDomainError
from workbench.scenarios import Column

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Mechanism:
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
    def arguments(self) -> tuple[Array, Array, Array, float, float, float, float, float]:
        """Arguments of the kernels: s, K, phi, kappa, M_p, N_p, N_0, c_ax."""
        return (
            self.rotation_rates,
            self.moments_per_displacement,
            self.flexibilities,
            self.slope_sum,
            self.plastic_moment,
            self.squash_load,
            self.axial_force,
            self.axial_flexibility,
        )


def mechanism_of(column: Column, rotational_stiffness: float = 6.0) -> Mechanism:
    """The mechanism of a column.

    Arguments: `column`; `rotational_stiffness`, the factor c of the hinge stiffness c EI / l of
    a bar of length l (Heng 2017: 6; half of it at the hit point if the bar's other end is
    pinned). A head that is fixed has no restraint flexibility; the restraint of any other head
    is its spring, and without one the head is free to shorten.
    Raises `OutOfDomainError` if the axial load exhausts the lateral stiffness of the mechanism.
    """
    properties = column.properties
    below, above = column.length_below, column.length_above
    bending = column.steel.elastic_modulus * properties.second_moment
    groups, rates, flexibilities = [], [], []
    half = rotational_stiffness * bending
    middle = 0.0
    for name, length, pinned in (
        ("base", below, column.base == "pinned"),
        ("head", above, column.head == "pinned"),
    ):
        middle += (2.0 if pinned else 1.0) * length / half
        if not pinned:
            groups.append(name)
            rates.append(1.0 / length)
            flexibilities.append(length / half)
    place = 1 if "base" in groups else 0
    groups.insert(place, "hit")
    rates.insert(place, 1.0 / below + 1.0 / above)
    flexibilities.insert(place, middle)
    bars = column.length / (column.steel.elastic_modulus * properties.area)
    if column.head == "fixed":
        axial = bars
    elif column.restraint_stiffness > 0.0:
        axial = bars + 1.0 / column.restraint_stiffness
    else:
        axial = inf
    mechanism = Mechanism(
        tuple(groups),
        np.array(rates),
        np.array(flexibilities),
        (below, above),
        properties.plastic_moment,
        properties.squash_load,
        -column.axial_load,
        axial,
    )
    elastic = float(rates @ mechanism.moments_per_displacement)
    if elastic <= mechanism.slope_sum * column.axial_load:
        raise OutOfDomainError(
            f"the axial load {column.axial_load / 1e3:.4g} kN exhausts the lateral stiffness of "
            f"the two-bar mechanism, which carries {elastic / mechanism.slope_sum / 1e3:.4g} kN: "
            "reduce the load"
        )
    return mechanism
