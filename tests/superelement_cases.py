"""Superelements that several tests use, and the column of Heng 2017, section 5.2."""

from __future__ import annotations

import numpy as np

from workbench.mechanics.structures.assembly import PlanarAssembly
from workbench.mechanics.structures.march import CollapseLimits
from workbench.mechanics.structures.paths import apply_loads
from workbench.mechanics.structures.superelements import (
    HingeEnd,
    Superelement,
    Superelements,
    sway_stiffness,
)
from workbench.steel.hinges import YieldSurface
from workbench.steel.materials import Steel
from workbench.steel.sections import find

# the thesis takes strength from the plates alone and elastic stiffness with the fillets
FULL, PLATES = find("HEB 220"), find("HEB 220").without_fillets()
E_STEEL = Steel().elastic_modulus
EA, EI = E_STEEL * FULL.area, E_STEEL * FULL.second_moment
NP, MP = PLATES.squash_load(Steel()), PLATES.plastic_moment(Steel())
SCALE = np.array([3e-3, 3e-3, 1e-2])  # displacements (m) and rotations that make hinges yield
_NONE, _PAIRS, _NUMBERS = np.zeros(0), np.zeros((0, 2)), np.zeros(0, np.int64)
_CORNERS, _ACROSS = np.zeros((0, 4), np.int64), np.zeros((0, 1, 2))
NO_LIMITS = CollapseLimits(
    *(np.inf, np.inf, -np.inf, np.zeros(1, np.int64), _CORNERS, _ACROSS, _PAIRS, _NUMBERS, _NONE)
)
VARIANTS = {
    "rigid 1/1.3": {"exponents": (1.0, 1.3)},
    "rigid 1/1": {"exponents": (1.0, 1.0)},
    "rigid 2/2": {"exponents": (2.0, 2.0)},
    "flexible 1/1.3": {"exponents": (1.0, 1.3), "flexible": True},
    "flexible, weak end": {"exponents": (1.5, 2.0), "flexible": True, "weak": True},
    "rigid, pinned": {"exponents": (1.0, 1.3), "pinned": True},
    "flexible, pinned": {"exponents": (1.0, 2.0), "flexible": True, "pinned": True},
}


def bar(
    length: float,
    exponents: tuple[float, float] = (1.0, 1.3),
    *,
    flexible: bool = False,
    factor: float = 10.0,
    pinned: bool = False,
    weak: bool = False,
    mass: float = 0.0,
    inertia: str = "none",
) -> Superelement:
    """An HEB 220: `factor` of a flexible bar's hinges; a `weak` asymmetric or `pinned` start."""
    surface = YieldSurface(NP, MP, *exponents)
    start = YieldSurface(0.8 * NP, 0.5 * MP, 1.0, 1.3, NP, 0.3 * MP) if weak else surface
    share = factor if flexible else 1.0
    joints = (0.0, np.inf) if pinned and not flexible else (np.inf, np.inf)
    rotational = [share * k for k in sway_stiffness(length, EI, joints)]
    if pinned:
        rotational[0] = 0.0
    axial = share * 2.0 * EA / length
    return Superelement(
        HingeEnd(start, axial, rotational[0]),
        HingeEnd(surface, axial, rotational[1]),
        EA,
        EI,
        flexible,
        mass,
        mass * EI / EA,
        inertia,
    )


def chain(
    lengths,
    *,
    angle: float = 0.0,
    regularisation: float = 1e-6,
    first_order: bool = False,
    **options,
) -> tuple[PlanarAssembly, Superelements]:
    """Superelements in a row from the origin, at an angle to the x axis."""
    count = len(lengths)
    group = Superelements(
        np.stack([np.arange(count), np.arange(1, count + 1)], axis=1),
        [bar(length, **options) for length in lengths],
        regularisation=regularisation,
        first_order=first_order,
    )
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    where = np.stack([along * np.cos(angle), along * np.sin(angle)], axis=1)
    return PlanarAssembly(where, [group]), group


def thesis_column(**options) -> tuple[PlanarAssembly, Superelements, int]:
    """The column under its dead load of 0.5 MN, with the spring of 10 MN/m there before it.

    Clamped base, guided head; hit across at 0.8 m of 4 m. Returns the dof of the hit as well.
    """
    assembly, group = chain([0.8, 3.2], **options)
    assembly.hold([assembly.dof(0, name) for name in ("u", "v", "rotation")])
    assembly.hold([assembly.dof(2, name) for name in ("v", "rotation")])
    head = assembly.dof(2, "u")
    assembly.load[head] = -0.5e6
    assembly.add_spring(head, 1e7)
    apply_loads(assembly)
    return assembly, group, assembly.dof(1, "v")
