"""Steel laws of fibers: hardening, rate sensitivity, Menegotto-Pinto, yielding with shear."""

from workbench.structures.uniaxial.laws import (
    MILD_STEEL,
    CowperSymonds,
    LinearHardening,
    MenegottoPinto,
    ShearYielding,
    UniaxialLaw,
)

__all__ = [
    "MILD_STEEL",
    "CowperSymonds",
    "LinearHardening",
    "MenegottoPinto",
    "ShearYielding",
    "UniaxialLaw",
]
