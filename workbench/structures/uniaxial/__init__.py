"""Uniaxial steel laws of fibers: hardening, rate sensitivity, Menegotto-Pinto."""

from workbench.structures.uniaxial.laws import (
    MILD_STEEL,
    CowperSymonds,
    LinearHardening,
    MenegottoPinto,
    UniaxialLaw,
)

__all__ = [
    "MILD_STEEL",
    "CowperSymonds",
    "LinearHardening",
    "MenegottoPinto",
    "UniaxialLaw",
]
