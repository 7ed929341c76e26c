"""A usual stud by the formula of a code, as a designer asks for it: both terms, what governs."""

from dataclasses import dataclass

from workbench.studs.quantities import concrete_modulus
from workbench.studs.shear import STRENGTH_MARGIN, ShearModel

DIAMETER, HEIGHT, CONCRETE, STEEL = 0.019, 0.1, 30e6, 450e6  # m; characteristic, specified, in Pa
_MEAN, _CODES = "roik-mean", ("roik-mean", "en1994", "aisc360")
_PARTIAL = {"en1994": 1.25}  # gamma_V of EN 1994-1-1, 6.6.3.1


@dataclass(frozen=True, slots=True)
class UsualStud:
    """The usual stud by a formula.

    `diameter`, `height` in m; `concrete_strength`, as the formula means it, `concrete_modulus`,
    `ultimate_strength` in Pa; `steel_term`, `concrete_term`, the smaller one, `resistance`, and
    `other_concrete_term`, with the modulus that fits take, in N; `partial_factor` of the code
    (None: it has none for the stud alone).
    """

    diameter: float
    height: float
    concrete_strength: float
    concrete_modulus: float
    ultimate_strength: float
    steel_term: float
    concrete_term: float
    resistance: float
    other_concrete_term: float
    partial_factor: float | None


def usual_stud(model: ShearModel) -> UsualStud | None:
    """The usual stud by a formula that a code has; None for others.

    The modulus is that of the code: of EN 1992-1-1, table 3.1, or 4733 sqrt(f_c) of ACI 318.
    """
    if model.name not in _CODES:
        return None
    mean = CONCRETE + STRENGTH_MARGIN
    strength = mean if model.name == _MEAN else CONCRETE
    european = 22e9 * (mean / 10e6) ** 0.3
    modulus = float(concrete_modulus(CONCRETE)) if model.name == "aisc360" else european
    steel = float(model.steel(DIAMETER, STEEL))
    concrete, other = (
        float(model.concrete(DIAMETER, HEIGHT, strength, each))
        for each in (modulus, concrete_modulus(mean))
    )
    terms = steel, concrete, min(steel, concrete), other
    sizes = DIAMETER, HEIGHT, strength, modulus, STEEL
    return UsualStud(*sizes, *terms, _PARTIAL.get(model.name))
