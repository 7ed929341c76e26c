"""The fiber section of a member."""

from workbench.scenarios import Frame, Member
from workbench.structures.fibers import BeamSection
from workbench.structures.uniaxial import LinearHardening


def fiber_section(frame: Frame, member: Member, layers: int, hardening_ratio: float) -> BeamSection:
    """Fibers of a member's strength section, rigid in shear, with its material and mass.

    Arguments: `layers` over the depth; kinematic hardening over the elastic modulus.
    """
    steel = frame.steel
    y, area = frame.strength_section(member).fibers(layers)
    modulus = steel.elastic_modulus
    law = LinearHardening(modulus, steel.yield_stress, hardening_ratio * modulus)
    return BeamSection(y, area, law, frame.properties(member).mass_per_length)
