"""Rules of practice for axial force and both moments beside the exact domain, and their figure.

``biaxial-surfaces``: a panel per section, cuts of its yield surface at a few axial forces over the
plastic moments about the strong and the weak axis.
"""

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from workbench.base.arrays import Array, Flags
from workbench.report.drawing.frame import frame_scenario_of
from workbench.report.drawing.sheet import Drawing, Request, Sheet
from workbench.report.drawing.style import INK, MUTED, Style
from workbench.steel.hinges import BiaxialSurface
from workbench.steel.hinges.interaction import moment_capacity
from workbench.steel.sections import CircularTube, ISection, RectangularTube, Section
from workbench.steel.sections.section import where_it_ends

EXACT = "exact"
CUTS = (0.0, 0.3, 0.6)  # axial forces over the plastic one
_RAYS = 15  # each way in the octant, of a fit
_UPRIGHT: Style = {
    **{"rotation": 90.0, "ha": "right", "va": "bottom", "fontsize": "small"},
    "textcoords": "offset points",
}
_LOOKS: dict[str, Style] = {
    EXACT: {"color": INK, "linewidth": 1.8},
    "orbison": {"color": "C1", "linewidth": 1.1},
    "eurocode": {"color": "C0", "linewidth": 1.1, "linestyle": "--"},
    "super-ellipsoid": {"color": MUTED, "linewidth": 1.1, "linestyle": "-."},
}


def contains(rule: str, section: Section, forces: Array) -> Flags:
    """Whether the domain of a rule has N, My and Mz (..., 3) over the plastic ones, all positive.

    ``exact``; ``orbison``, the polynomial of Orbison, McGuire and Abel 1982; ``eurocode``, EN
    1993-1-1, 6.2.9.1(6), whose powers solid sections lack; ``super-ellipsoid``, separable powers
    that fit the exact radii best. Orbison's and the code's are not convex. Raises KeyError.
    """
    n, y, z = np.moveaxis(forces, -1, 0)
    if rule == EXACT:
        return np.asarray(BiaxialSurface(section).gauge(forces) < 1.0)
    if rule == "orbison":
        axial = 1.15 * n**2 - 0.15 * n**6 + 3.67 * n**2 * y**2 + 3.0 * n**6 * z**2
        return np.asarray(axial + y**2 + z**4 + 4.65 * y**4 * z**2 < 1.0)
    if rule == "super-ellipsoid":
        return _sum(forces, separable(section)) < 1.0
    strong, weak = _alone(section, n), _alone(section.about("weak"), n)
    powers = _POWERS[type(section.shape)](n)
    return np.asarray((n < 1.0) & ((y / strong) ** powers[0] + (z / weak) ** powers[1] < 1.0))


def _alone(section: Section, n: Array) -> Array:
    """Moment over the plastic one beside an axial force by the code, not zero."""
    if isinstance(section.shape, CircularTube):
        return np.maximum(1.0 - n**1.7, 1e-12)
    return np.maximum(moment_capacity("eurocode", section, n), 1e-12)


def _of_tube(n: Array) -> tuple[Array, Array]:
    power = np.minimum(6.0, 1.66 / np.maximum(1.0 - 1.13 * n**2, 0.1))
    return power, power


_POWERS: dict[type, Callable[[Array], tuple[Array, Array]]] = {
    ISection: lambda n: (np.full_like(n, 2.0), np.maximum(1.0, 5.0 * n)),
    RectangularTube: _of_tube,
    CircularTube: lambda n: (np.full_like(n, 2.0), np.full_like(n, 2.0)),
}


def rules_of(section: Section) -> tuple[str, ...]:
    """Rules that a section has."""
    coded = type(section.shape) in _POWERS
    return tuple(rule for rule in _LOOKS if coded or rule != "eurocode")


def radii(rule: str, section: Section, rays: Array) -> Array:
    """Distances from the origin (n,) at which `rays` (n, 3) in the octant leave the domain."""
    if rule == EXACT:
        return np.asarray(1.0 / BiaxialSurface(section).gauge(rays))
    ends = np.full(len(rays), np.sqrt(3.0) + 0.1)
    return where_it_ends(lambda r: contains(rule, section, r[:, None] * rays), ends)


def octant(count: int = _RAYS) -> Array:
    """Directions (count squared, 3) at equal angles between all three axes."""
    up, round_ = np.meshgrid(*[np.linspace(0.0, 0.5 * np.pi, count)] * 2)
    cosine = np.cos(up)
    rays = np.stack([np.sin(up), cosine * np.cos(round_), cosine * np.sin(round_)], axis=-1)
    return np.asarray(np.maximum(rays.reshape(-1, 3), 0.0))


def _sum(forces: Array, powers: ArrayLike) -> Array:
    total: Array = np.sum(forces ** np.asarray(powers, float), axis=-1)
    return total


@cache
def separable(section: Section) -> tuple[float, float, float]:
    """Powers of N, My and Mz, at least 1, whose sum fits the exact radii with least squares."""
    from scipy.optimize import least_squares

    rays = octant()
    exact, ends = radii(EXACT, section, rays), np.full(len(rays), np.sqrt(3.0) + 0.1)

    def error(powers: Array) -> Array:
        return where_it_ends(lambda r: _sum(r[:, None] * rays, powers) < 1.0, ends) / exact - 1.0

    fit = least_squares(error, (1.4, 1.2, 2.0), bounds=(1.0, 20.0))
    n, y, z = (float(power) for power in fit.x)
    return n, y, z


def cut(rule: str, section: Section, axial: float, count: int = 46) -> Array:
    """Moments My and Mz (2, count) over the plastic ones of a surface at an axial force N/N_p."""
    angle = np.linspace(0.0, 0.5 * np.pi, count)
    cosine, sine = np.maximum(np.cos(angle), 0.0), np.sin(angle)

    def inside(r: Array) -> Flags:
        forces = np.stack([np.full_like(r, axial), r * cosine, r * sine], axis=-1)
        return contains(rule, section, forces)

    r = where_it_ends(inside, np.full(count, 1.5))
    return np.stack([r * cosine, r * sine])


def draw_cuts(request: Request) -> Drawing:
    """A panel per section of the frames and columns of the cases, in their order."""
    known = (frame_scenario_of(case.scenario) for case in request.cases)
    frames = [scenario.frame for scenario in known if scenario]
    used = [f.strength_section(member).about("strong") for f in frames for member in f.members]
    sections = list(dict.fromkeys(used))
    sheet = Sheet.grid(len(sections), height=3.2)
    for section, panel in zip(sections, sheet.panels, strict=False):
        notes = []
        for rule in rules_of(section):
            for axial in CUTS:
                strong, weak = cut(rule, section, axial)
                line = panel.plot(strong, weak, label=rule, **_LOOKS[rule])
                sheet.record(section=section.name, rule=rule, axial=axial, strong=strong, weak=weak)
                if rule == EXACT:
                    panel.annotate(f"N/Npl = {axial:g}", (strong[0], 0.02), (-9, 0), **_UPRIGHT)
            sheet.legend(*line)
            off = 100.0 * (radii(rule, section, octant()) / radii(EXACT, section, octant()) - 1.0)
            if rule != EXACT:
                notes.append(f"{rule} {off.min():.1f} to {off.max():+.1f}")
        panel.set(aspect="equal", xlim=(0.0, 1.05), ylim=(0.0, 1.05))
        sheet.name(panel, section.name, "My/Mpl,y", "Mz/Mpl,z")
        sheet.notes.append(f"{section.name}, radial error in percent: {', '.join(notes)}.")
    return sheet.finish("cuts of yield surfaces over both moments, at three axial forces")
