"""Catenary action as three simple models have it: single degrees of freedom on other curves.

kappa = 1/L_a + 1/L_b, N_p and M_p the strengths, S = sum(s) the turning of all hinges of the
mechanism per displacement, c the axial flexibility, N_0 the axial force before. All three end in
the rope F = kappa N_p v. Derived from the assumptions that Heng 2017, chapter 4, tells of the
papers, which were not at hand: docs/theory/practice.md.

* Tri-linear: elastic line to F_0 = S M_p (1 - |N_0|/N_p), plateau, straight line to the rope.
* Yin and Wang (2005): F = min(k_e v, S M_p (1 - |N|/N_p)) + kappa N v, N = N_0 + Lambda v^2 / c.
* Izzuddin (2005): c dN = (kappa v - sign(N) r S) dv once the mechanism stands.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

import numpy as np

from workbench.base.errors import OutOfDomainError
from workbench.models.resistance import PlasticMechanism, ResistanceCurve, mechanism_of
from workbench.models.resistance import curve as events
from workbench.models.resistance.curve import LINEAR
from workbench.models.resistance.kernels import PIECE, falling_root
from workbench.models.resistance.shapes import analytic, beam_of, put, simplified_points
from workbench.models.single_dof import SingleDof
from workbench.scenarios import Column

TRILINEAR, PROFILE, RIGID_PLASTIC = "trilinear", "profile", "rigid-plastic"
_COMMON = (
    "Single degree of freedom: a third of the column's mass at the impact point, elastic unloading "
    "with the initial stiffness.",
    "The original formulas were not at hand: derived here from the assumptions that are stated of "
    "them, and extended to any supports, place of the hit and axial load by the same equations.",
    "No shear yielding, no local buckling, no strain-rate effect.",
)


def trilinear(mechanism: PlasticMechanism) -> ResistanceCurve:
    """Elastic line, plateau, straight line to the rope."""
    F0, ke, vy, _, v_nd, v_c = simplified_points(mechanism.kernel)
    arm = mechanism.plastic_moment / mechanism.squash_load
    hinges = arm * float(mechanism.rotation_rates.sum()) / mechanism.slope_sum
    starts = max(vy, v_nd, hinges)
    pieces = np.zeros(4, PIECE)
    put(pieces, 0, events.START, 0.0, (0.0, ke, 0.0))
    put(pieces, 1, events.LOAD, vy, (F0, 0.0, 0.0))
    if not starts < v_c < np.inf:
        return ResistanceCurve(TRILINEAR, mechanism, pieces[:2], vy)
    rope = mechanism.slope_sum * mechanism.squash_load
    put(pieces, 2, events.TENSION, starts, (F0, (rope * v_c - F0) / (v_c - starts), 0.0))
    put(pieces, 3, events.CATENARY, v_c, (rope * v_c, rope, 0.0))
    return ResistanceCurve(TRILINEAR, mechanism, pieces, vy)


def profile(mechanism: PlasticMechanism, stretching: float) -> ResistanceCurve:
    """Axial force of an assumed profile, moment by the interaction; `stretching` Lambda in 1/m."""
    S, kappa = float(mechanism.rotation_rates.sum()), mechanism.slope_sum
    Mp, Np, N0 = mechanism.plastic_moment, mechanism.squash_load, mechanism.axial_force
    ke = float(mechanism.rotation_rates @ mechanism.moments_per_displacement)
    growth = stretching / mechanism.axial_flexibility
    v_0 = np.sqrt(-N0 / growth) if N0 < 0.0 < growth else (np.inf if N0 < 0.0 else 0.0)
    v_c = np.sqrt((Np - N0) / growth) if growth > 0.0 else np.inf

    def plastic(sign: float) -> tuple[float, float, float]:
        """Coefficients of S M_p (1 - |N|/N_p) in v."""
        return S * Mp * (1.0 - sign * N0 / Np), 0.0, -S * Mp * sign * growth / Np

    def yields(sign: float) -> float:
        constant, _, square = plastic(sign)
        return float(falling_root(constant, -ke, square, 0.0))

    v_y = yields(-1.0) if N0 < 0.0 else np.inf
    if v_y > v_0 or N0 >= 0.0:
        v_y = yields(1.0)
    axial = np.polynomial.Polynomial([N0, 0.0, growth])
    along = np.polynomial.Polynomial([0.0, kappa])
    begins = [(0.0, events.START), (v_y, events.LOAD)]
    begins += [(v_0, events.NO_AXIAL_FORCE)] if 0.0 < v_0 < np.inf else []
    begins += [(v_c, events.CATENARY)] if v_c < np.inf else []
    pieces = np.zeros(len(begins), PIECE)
    for n, (start, event) in enumerate(sorted(begins)):
        sign = -1.0 if start < v_0 else 1.0
        bending = np.polynomial.Polynomial(plastic(sign) if start >= v_y else (0.0, ke))
        force = bending + along * axial
        if start >= v_c:
            force = along * Np
        shifted = force(np.polynomial.Polynomial([start, 1.0]))
        pieces[n]["start"], pieces[n]["event"] = start, event
        pieces[n]["c"][: len(shifted.coef)] = shifted.coef
    return ResistanceCurve(PROFILE, mechanism, pieces, v_y)


def rigid_plastic(mechanism: PlasticMechanism) -> ResistanceCurve:
    """Event-driven curve whose plastic hinges turn with the whole mechanism."""
    s, K, phi, kappa, Mp, Np, N0, c, corner = mechanism.kernel
    pieces, unloads = analytic((s, K, np.zeros_like(phi), kappa, Mp, Np, N0, c, corner))
    if unloads:
        raise OutOfDomainError("a yielded hinge would unload while the push goes on")
    limit = pieces["start"][pieces["plastic"].any(axis=1)][0]
    return ResistanceCurve(RIGID_PLASTIC, mechanism, pieces, float(limit))


@lru_cache(maxsize=256)
def catenary_curve(column: Column, shape: str, uniform: bool = False) -> ResistanceCurve:
    """Resistance of a column at its impact point by one of the three models; kept for the next."""
    mechanism = mechanism_of(column, interaction=LINEAR, uniform=uniform)
    if shape == TRILINEAR:
        return trilinear(mechanism)
    if shape == RIGID_PLASTIC:
        return rigid_plastic(mechanism)
    plastic = np.full(3, column.properties.plastic_moment)
    return profile(mechanism, beam_of(column, uniform).stages(plastic)[0].shape.stretching)


@dataclass(frozen=True)
class _Catenary(SingleDof):
    """Common base of catenary models: their curve stands for the resistance of the column."""

    rotational_stiffness: ClassVar[None] = None  # type: ignore[misc]
    rate_factor: ClassVar[None] = None  # type: ignore[misc]
    interaction: ClassVar[str] = LINEAR  # type: ignore[misc]

    def curve(self, column: Column, uniform: bool = False) -> ResistanceCurve:
        """Resistance curve with catenary action, as in `single-dof`. Raises `OutOfDomainError`."""
        return catenary_curve(column, self.resistance, uniform)


@dataclass(frozen=True)
class TrilinearCatenary(_Catenary):
    """Elastic line, plastic plateau, straight line to the rope; options as in `single-dof`."""

    resistance: ClassVar[str] = TRILINEAR  # type: ignore[misc]

    name: ClassVar[str] = "trilinear-catenary"
    version: ClassVar[int] = 4
    assumptions: ClassVar[tuple[str, ...]] = (
        "Resistance of three straight lines: elastic, plastic mechanism at the axial force before "
        "the hit, catenary from where chords stretch more than hinges to the rope at N_p.",
        *_COMMON,
    )
    sources: ClassVar[tuple[str, ...]] = ("heng2017", "lee2009")


@dataclass(frozen=True)
class YinWang(_Catenary):
    """Axial force of the assumed profile, moment beside it; options as in `single-dof`."""

    resistance: ClassVar[str] = PROFILE  # type: ignore[misc]

    name: ClassVar[str] = "yin-wang"
    version: ClassVar[int] = 3
    assumptions: ClassVar[tuple[str, ...]] = (
        "The deflection keeps the profile of the elastic beam; its elongation alone makes the "
        "axial force, up to N_p, and the moment is what a linear interaction leaves beside it.",
        "Published for symmetric beams without initial compression.",
        *_COMMON,
    )
    sources: ClassVar[tuple[str, ...]] = ("heng2017", "yin-wang2005")


@dataclass(frozen=True)
class Izzuddin(_Catenary):
    """Elastic, plastic bending, transient and final catenary; options as in `single-dof`."""

    resistance: ClassVar[str] = RIGID_PLASTIC  # type: ignore[misc]

    name: ClassVar[str] = "izzuddin"
    version: ClassVar[int] = 3
    assumptions: ClassVar[tuple[str, ...]] = (
        "Plastic hinges turn as those of a rigid-plastic mechanism and stretch by the flow rule of "
        "the linear N-M interaction. Heng 2017 says that this makes the axial force too small; as "
        "derived here it comes out larger than with elastic rotation, by 0.6 % in his column.",
        "Published for a simply supported symmetric beam without initial compression.",
        *_COMMON,
    )
    sources: ClassVar[tuple[str, ...]] = ("heng2017", "izzuddin2005")
