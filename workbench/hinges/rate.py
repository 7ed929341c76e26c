"""A plastic hinge that feels the strain rate, in closed form and without a length of its own.

Along a straight moment diagram from mu M_p to zero over a distance L, only the sections with more
than M_p flow, each at the rate of its overstress (Cowper and Symonds). The integral of their
curvature rates is the rotation rate of the hinge: a faster hinge is longer. Derivation and checks:
docs/theory/strain-rate.md.
"""

from functools import lru_cache
from math import exp, log, log1p, sqrt

import numpy as np

from workbench.materials import CowperSymonds
from workbench.sections import Section

_ITERATIONS, _LAYERS = 60, 400


@lru_cache(maxsize=256)
def overstress_shape(section: Section, exponent: float) -> float:
    """Overstress moment over that of a section whose fibers all have the rate of its edge.

    c = (2 / h)^(1/q) / W_pl integral |y|^(1 + 1/q) dA; 10/11 of a rectangle with q = 5.
    """
    heights, areas = section.fibers(_LAYERS)
    relative = np.abs(heights) / (0.5 * section.height)
    return float(np.sum(areas * relative ** (1.0 + 1.0 / exponent)) / np.sum(areas * relative))


def rotation_rate(
    overstress: float, length: float, height: float, shape: float, law: CowperSymonds
) -> float:
    """Rotation rate (rad/s) of a hinge whose moment is (1 + `overstress`) M_p.

    Arguments: `length` (m) from the hinge to the zero of moment, `height` of the section (m),
    `shape` of its overstress.
    """
    q, D = law.exponent, law.reference_rate
    share = overstress ** (q + 1.0) / ((q + 1.0) * (1.0 + overstress))
    return float(2.0 * D * length / (height * shape**q) * share)


def hinge_overstress(
    rate: float, length: float, height: float, shape: float, law: CowperSymonds
) -> float:
    """Inverse of `rotation_rate`: mu - 1 at a rotation rate (rad/s)."""
    if rate <= 0.0:
        return 0.0
    q, D = law.exponent, law.reference_rate
    wanted = log((q + 1.0) * shape**q * height * rate / (2.0 * D * length))
    logarithm = wanted / (q + 1.0)
    for _ in range(_ITERATIONS):  # Newton in ln x: rising and concave, slope between q and q + 1
        x = exp(logarithm)
        change = ((q + 1.0) * logarithm - log1p(x) - wanted) / (q + 1.0 - x / (1.0 + x))
        logarithm -= change
        if abs(change) <= 1e-14 * max(1.0, abs(logarithm)):
            break
    return exp(logarithm)


def panel_overstress(rate: float, law: CowperSymonds) -> float:
    """V / V_pl - 1 of a web at the plastic shear strain rate (1/s), uniform along its bar."""
    return law.factor(rate / sqrt(3.0)) - 1.0
