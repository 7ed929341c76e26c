"""The plastic mechanism of the column: its hinge groups in plain numbers."""

from math import inf
from typing import NamedTuple

import numpy as np

from workbench.arrays import Array
from workbench.errors import OutOfDomainError
from workbench.frames.shear import shear_stiffness
from workbench.models.elastic_springs import beam_springs, thesis_springs
from workbench.scenarios import Column

INTERACTIONS = LINEAR, SECTION = ("linear", "section")  # yield surfaces of N and M

Groups = tuple[Array, Array, Array, float, float, float, float, float, float]


class Mechanism(NamedTuple):
    """Two rigid bars with hinge groups that yield in bending and axial force.

    Arguments: `groups`, names out of base, hit, head (a pinned end has no group; the two hinges
    at the hit point, which carry the same moment, are one group); per group `rotation_rates`
    s = d(rotation)/dv (1/m), `flexibilities` phi (rad/(N m)); `lengths` of the two bars (m);
    `plastic_moment` (N m), `squash_load` (N); `axial_force` before the push (N, tension
    positive); `axial_flexibility` of bars and restraint (m/N), infinite if free to shorten;
    `corner`, axial force (N) up to which the plastic moment is not reduced; beyond it falls in a
    straight line.
    """

    groups: tuple[str, ...]
    rotation_rates: Array
    flexibilities: Array
    lengths: tuple[float, float]
    plastic_moment: float
    squash_load: float
    axial_force: float
    axial_flexibility: float
    corner: float = 0.0

    def capacity(self, axial_force: Array) -> Array:
        """Moment (N m) that hinges carry beside axial forces (N)."""
        share = (self.squash_load - np.abs(axial_force)) / (self.squash_load - self.corner)
        return np.asarray(self.plastic_moment * np.minimum(1.0, share))

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
        """What the kernels take: s, K, phi, kappa, M_p, N_p, N_0, c_ax, N_c."""
        moments, kappa = self.moments_per_displacement, self.slope_sum
        return self.rotation_rates, moments, self.flexibilities, kappa, *self[4:]


def mechanism_of(
    column: Column,
    rotational_stiffness: float | None = None,
    interaction: str = SECTION,
    uniform: bool = False,
) -> Mechanism:
    """The mechanism of a column.

    Arguments: `column`; `rotational_stiffness`, the factor c of the hinge stiffness c EI / l of
    a bar of length l (Heng 2017: 6; None: springs that make the bars the elastic column under a
    force at the hit point, or a `uniform` load); `interaction`, yield surface of straight lines
    with the area of the exact envelope (section) or from M_p to N_p (linear, Heng 2017). A head
    that is fixed has no restraint flexibility; the restraint of any other head is its spring, and
    without one the head is free to shorten.
    Raises `OutOfDomainError` if the axial load exhausts the lateral stiffness of the mechanism.
    """
    properties = column.properties
    if rotational_stiffness is None:
        stiffness = shear_stiffness(column.strength_section, column.steel)
        springs = beam_springs(column, stiffness, uniform=uniform)
    else:
        springs = thesis_springs(column, rotational_stiffness)
    corner = column.strength_section.interaction_corner() if interaction == SECTION else 0.0
    below, above = 1.0 / column.length_below, 1.0 / column.length_above
    all_groups = (
        ("base", below, springs.base),
        ("hit", below + above, springs.below + springs.above),
        ("head", above, springs.head),
    )
    groups, rates, flexibilities = zip(*(g for g in all_groups if g[2] < inf), strict=True)
    mechanism = Mechanism(
        groups,
        np.array(rates),
        np.array(flexibilities),
        (column.length_below, column.length_above),
        properties.plastic_moment,
        properties.squash_load,
        -column.axial_load,
        axial_flexibility(column),
        corner * properties.squash_load,
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
    flexibility = column.length / (column.steel.elastic_modulus * column.properties.area)
    if column.head == "fixed":
        return flexibility
    spring = column.restraint_stiffness
    return flexibility + 1.0 / spring if spring > 0.0 else inf
