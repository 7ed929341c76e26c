"""What a superelement consists of: two hinges, the bar between them, its mass."""

from dataclasses import dataclass
from math import inf

import numpy as np

from workbench.arrays import Array
from workbench.errors import InputError
from workbench.fields import Choice, Declared, Flag, Number, checked
from workbench.hinges import ShearSurface, YieldSurface

INERTIAS = ("nonlinear", "linear", "none")
_MASS = Number(0.0, 1e9, "kg/m")


@dataclass(frozen=True)
class HingeEnd:
    """Generalized hinge at one end of a superelement.

    Arguments: `surface`, bounds of the axial force and of the internal moment, positive where it
    stretches the fibers on the right of somebody who looks from start to end; `axial_stiffness`
    in N/m (inf: the hinge itself is rigid); `rotational_stiffness` in N m/rad (inf: rigid, 0: a
    pin, which carries no moment). Raises `InputError`.
    """

    surface: YieldSurface
    axial_stiffness: float = inf
    rotational_stiffness: float = inf

    def __post_init__(self) -> None:
        if not self.axial_stiffness > 0.0:
            raise InputError("hinge.axial_stiffness", self.axial_stiffness, "must be positive")
        if not self.rotational_stiffness >= 0.0:
            raise InputError(
                "hinge.rotational_stiffness", self.rotational_stiffness, "must not be negative"
            )

    @property
    def pinned(self) -> bool:
        """Whether the hinge carries no moment."""
        return self.rotational_stiffness == 0.0


@dataclass(frozen=True)
class Superelement(Declared, table="superelement"):
    """A bar with a generalized hinge at each end (Heng 2017, papers III and IV).

    Arguments: hinges `start` and `end`; `axial_stiffness` EA (N) and `bending_stiffness` EI
    (N m2) of the bar if it is flexible, not used if it is rigid; `flexible`; `mass_per_length` in
    kg/m; `rotary_inertia` per length, rho I, in kg m, which acts on the rotation of the chord;
    `rotation_inertia`: that of the deformed chord (nonlinear), of the initial chord (linear),
    none; `web` that yields in shear, whose surface is then that of both hinges (None: rigid in
    shear). Raises `InputError`.
    """

    start: HingeEnd
    end: HingeEnd
    axial_stiffness: float = inf
    bending_stiffness: float = inf
    flexible: bool = checked(Flag(), False)
    mass_per_length: float = checked(_MASS, 0.0)
    rotary_inertia: float = checked(_MASS, 0.0)
    rotation_inertia: str = checked(Choice(INERTIAS), "none")
    web: ShearSurface | None = None

    def check(self) -> None:
        """Refuse stiffnesses that leave the bar or its hinges undetermined."""
        ends = self.start, self.end
        if self.flexible:
            for name in ("axial_stiffness", "bending_stiffness"):
                if not 0.0 < getattr(self, name) < inf:
                    raise self.refusal(name, "must be positive and finite in a flexible bar")
        elif min(end.axial_stiffness for end in ends) == inf:
            raise InputError(
                "hinge.axial_stiffness", inf, "must be finite at one end of a rigid bar"
            )
        elif max(end.rotational_stiffness for end in ends) == inf:
            raise InputError("hinge.rotational_stiffness", inf, "must be finite in a rigid bar")

    def flexibility(self, length: float) -> Array:
        """Elastic flexibility f_N, f_11, f_14, f_44 (4,) of hinges and bar, `length` in m.

        Entries of a pinned end are those of the bar alone.
        """
        ends = self.start, self.end
        axial = sum(1.0 / end.axial_stiffness for end in ends)
        own = [0.0 if end.pinned else 1.0 / end.rotational_stiffness for end in ends]
        bend = 0.0
        if self.flexible:
            axial += length / self.axial_stiffness
            bend = length / (6.0 * self.bending_stiffness)
        return np.array([axial, own[0] + 2.0 * bend, -bend, own[1] + 2.0 * bend])

    def shear_flexibility(self, length: float) -> float:
        """Rotation of both ends by the elastic web per end moment (1/N m), `length` in m."""
        return 0.0 if self.web is None else 1.0 / (length * float(self.web.record["stiffness"]))

    def bounds(self) -> Array:
        """Bounds (2, 4) of N in tension and compression and of M_1, M_4 positive and negative.

        The moment on the bar at its start is the internal one with its sign turned.
        """
        first, last = self.start.surface, self.end.surface
        return np.array(
            [
                [*first.axial_bounds, *first.moment_bounds[::-1]],
                [*last.axial_bounds, *last.moment_bounds],
            ]
        )

    def exponents(self) -> Array:
        """Exponents alpha and beta of both hinges (2, 2)."""
        return np.array([[end.surface.alpha, end.surface.beta] for end in (self.start, self.end)])


def sway_stiffness(
    length: float, bending_stiffness: float, joints: tuple[float, float] = (inf, inf)
) -> tuple[float, float]:
    """Hinge stiffnesses (N m/rad) with which a rigid bar is exact when both its ends keep upright.

    Arguments: `length` (m) and EI (N m2) of the member; rotational stiffness of its `joints` in
    N m/rad (inf: rigid, 0: pinned). Rigid joints give 6 EI / L at both ends, hence 12 EI / L^3
    against sway; with a pin the other end gets 3 EI / L. A rigid bar between two springs cannot
    be exact in other modes as well: uniform bending would need 2 EI / L.
    """
    bend = length / (6.0 * bending_stiffness)
    # moments of the flexible member for a unit chord rotation, free of division by a pin's zero
    softness = [0.0 if joint == inf else 1.0 for joint in joints]
    stiff = [1.0 if joint == inf else joint for joint in joints]
    diagonal = [2.0 * bend * k + s for k, s in zip(stiff, softness, strict=True)]
    determinant = diagonal[0] * diagonal[1] - bend * bend * stiff[0] * stiff[1]
    first = stiff[0] * (diagonal[1] + bend * stiff[1]) / determinant
    last = stiff[1] * (diagonal[0] + bend * stiff[0]) / determinant
    return first, last
