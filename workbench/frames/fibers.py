"""The fiber section of a member."""

import numpy as np

from workbench.arrays import Array
from workbench.scenarios import Frame, Member
from workbench.structures.fibers import BeamSection
from workbench.structures.uniaxial import LinearHardening

SHARES = 49  # points of the curve of spreading yield, denser towards the full section


def fiber_section(frame: Frame, member: Member, layers: int, hardening_ratio: float) -> BeamSection:
    """Fibers of a member's strength section, rigid in shear, with its material and mass.

    Arguments: `layers` over the depth; kinematic hardening over the elastic modulus.
    """
    steel = frame.steel
    y, area = frame.strength_section(member).fibers(layers)
    modulus = steel.elastic_modulus
    law = LinearHardening(modulus, steel.yield_stress, hardening_ratio * modulus)
    return BeamSection(y, area, law, frame.properties(member).mass_per_length)


def spread_of_yield(section: BeamSection) -> tuple[float, Array, Array]:
    """How a cantilever yields on from its end, by its fibers and without axial force.

    Result: moment at first yield over the plastic one; plastic rotations of the end, over its
    length times the curvature at first yield, and the share of the way from first yield to the
    plastic moment that the end moment has gone there (points,). By virtual work, the moment being
    linear: plastic curvature times moment, integrated over the moment, over the end moment squared.
    """
    y, area = section.y / np.max(section.y), section.area
    bent = np.concatenate([np.linspace(1.0, 3.0, 41), np.geomspace(3.2, 200.0, 40)])
    moment = np.sum(np.clip(bent[:, None] * y, -1.0, 1.0) * y * area, axis=1)
    moment /= np.sum(np.abs(y) * area)
    plastic = bent - moment / moment[0]
    along = plastic * moment
    gained = 0.5 * (along[1:] + along[:-1]) * np.diff(moment)
    rotation = np.concatenate([[0.0], np.cumsum(gained)]) / moment**2
    share = 1.0 - np.linspace(1.0, 0.0, SHARES) ** 2
    known = (moment - moment[0]) / (moment[-1] - moment[0])
    return float(moment[0]), np.interp(share, known, rotation), share
