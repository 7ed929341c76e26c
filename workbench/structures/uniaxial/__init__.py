"""Steel laws of fibers: hardening, rate sensitivity, Menegotto-Pinto, yielding with shear."""

from workbench.structures.uniaxial.laws import MILD_STEEL as MILD_STEEL
from workbench.structures.uniaxial.laws import CowperSymonds as CowperSymonds
from workbench.structures.uniaxial.laws import LinearHardening as LinearHardening
from workbench.structures.uniaxial.laws import MenegottoPinto as MenegottoPinto
from workbench.structures.uniaxial.laws import ShearYielding as ShearYielding
from workbench.structures.uniaxial.laws import UniaxialLaw as UniaxialLaw
