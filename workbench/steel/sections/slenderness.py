"""Slender plates, slender members: classes, effective widths, lateral-torsional buckling, wear.

Sources: EN 1993-1-1, table 5.2, 6.3.2.2 and 6.3.2.3; EN 1993-1-5, 4.4; Lignos and Krawinkler 2011.
Partial factors are 1.
"""

from math import pi, sqrt
from typing import NamedTuple

from workbench.base.errors import OutOfDomainError
from workbench.steel.materials import Steel
from workbench.steel.sections.section import (
    CircularTube,
    ISection,
    Rectangle,
    RectangularTube,
    Section,
    TurnedISection,
)

BENT, PRESSED, OUTSTAND = (72.0, 83.0, 124.0), (33.0, 38.0, 42.0), (9.0, 10.0, 14.0)  # by epsilon
TIP = (9.0, 10.0, 21.0 * sqrt(0.57))  # outstand flange bent in its plane, its tip compressed
ROUND = (50.0, 70.0, 90.0)  # by epsilon squared


class Classes(NamedTuple):
    """Class 1 to 4 of a section under an axial force (`pressed`) and under a moment (`bent`)."""

    pressed: int
    bent: int


class Plates(NamedTuple):
    """Flat widths in m and thicknesses: of the `webs` in number, of the `flanges` at one end.

    `outstand`: flanges end free, two at a web; otherwise they end in webs.
    """

    web: float
    web_thickness: float
    webs: int
    flange: float
    flange_thickness: float
    flanges: int
    outstand: bool


class LateralBuckling(NamedTuple):
    """Elastic `critical` moment and buckling `resistance` in N m, reduction `factor` chi_LT."""

    critical: float
    factor: float
    resistance: float


def plates_of(section: Section) -> Plates:
    """Flat plates of an I section, between its fillets, or of a rectangular tube.

    Those of an I section about its weak axis are named as about its strong one.
    """
    shape = section.shape.turned if isinstance(section.shape, TurnedISection) else section.shape
    upright, across = shape.plates
    clear = shape.height - 2.0 * across
    if not isinstance(shape, ISection):
        wall = 0.5 * upright
        return Plates(clear, wall, 2, shape.width - upright, wall, 1, False)
    outstand = 0.5 * (shape.width - upright) - shape.fillet
    return Plates(clear - 2.0 * shape.fillet, upright, 1, outstand, across, 2, True)


def plate_classes(section: Section, steel: Steel) -> Classes:
    """Classes of EN 1993-1-1, table 5.2, those of the worst plate; of a full section class 1.

    Axial force and moment are taken one by one: the class of a web under both lies between.
    """
    e = _epsilon(steel)
    if isinstance(section.shape, Rectangle):
        return Classes(1, 1)
    if isinstance(section.shape, CircularTube):
        alone = _class(section.shape.diameter / section.shape.wall / e**2, ROUND)
        return Classes(alone, alone)
    p = plates_of(section)
    flange = _class(p.flange / p.flange_thickness / e, OUTSTAND if p.outstand else PRESSED)
    web = p.web / p.web_thickness / e
    pressed = max(flange, _class(web, PRESSED))
    if isinstance(section.shape, TurnedISection):  # the moment leaves the web alone
        return Classes(pressed, _class(p.flange / p.flange_thickness / e, TIP))
    return Classes(pressed, max(flange, _class(web, BENT)))


def reduction(ratio: float, psi: float = 1.0, outstand: bool = False) -> float:
    """The rho of EN 1993-1-5, 4.4 (2): effective over whole width of a plate in compression.

    Arguments: width over thickness and epsilon; `psi`, the stress of its other edge over the
    largest compression, from -3 to 1; an `outstand` flange is under even compression.
    """
    if outstand:
        slenderness = ratio / (28.4 * sqrt(0.43))
        return 1.0 if slenderness <= 0.748 else (slenderness - 0.188) / slenderness**2
    if psi > 0.0:
        k = 8.2 / (1.05 + psi)
    else:
        k = 7.81 - 6.29 * psi + 9.78 * psi**2 if psi > -1.0 else 5.98 * (1.0 - psi) ** 2
    slenderness = ratio / (28.4 * sqrt(k))
    if slenderness <= 0.5 + sqrt(max(0.085 - 0.055 * psi, 0.0)):
        return 1.0
    return (slenderness - 0.055 * (3.0 + psi)) / slenderness**2


def shares_by_class(section: Section, strength: Section, steel: Steel) -> tuple[float, float]:
    """Shares that its classes leave of the squash load in compression and of the plastic moment.

    All up to class 2, the elastic moment in class 3, effective widths in class 4 (EN 1993-1-5, 4.3
    (3) and (4), each force by itself). Arguments: the `section`, whose flat widths count; the one
    that the `strength` is that of; steel. Raises `OutOfDomainError` for circular tubes of class 4.
    """
    classes = plate_classes(section, steel)
    if max(classes) == 4 and isinstance(section.shape, CircularTube):
        raise OutOfDomainError(f"{section.name} is of class 4, round, without effective widths")
    if classes.bent == 4 and isinstance(section.shape, TurnedISection):
        raise OutOfDomainError(f"{section.name} is of class 4, without effective widths")
    area, modulus = strength.area, strength.plastic_section_modulus
    if classes.bent == 3:
        modulus = strength.elastic_section_modulus
    elif classes.bent == 4:
        modulus = _effective_modulus(section, strength, steel)
    if classes.pressed == 4:
        p, e = plates_of(section), _epsilon(steel)
        web = 1.0 - reduction(p.web / p.web_thickness / e)
        flange = 1.0 - reduction(p.flange / p.flange_thickness / e, outstand=p.outstand)
        area -= p.webs * web * p.web * p.web_thickness
        area -= 2 * p.flanges * flange * p.flange * p.flange_thickness
    return area / strength.area, modulus / strength.plastic_section_modulus


def torsion_of(shape: ISection) -> tuple[float, float, float]:
    """I_z and I_t (m4) and I_w (m6) of an I section, as tables of profiles have them."""
    h, b, web, t, r = shape.height, shape.width, shape.web, shape.flange, shape.fillet
    clear = h - 2.0 * t
    corners = 0.03 * r**4 + 0.2146 * r**2 * (web + 0.4468 * r) ** 2
    weak = (2.0 * t * b**3 + clear * web**3) / 12.0 + corners
    twist = (2.0 * b * t**3 + clear * web**3) / 3.0
    if r:
        inscribed = ((r + 0.5 * web) ** 2 + (r + t) ** 2 - r**2) / (2.0 * r + t)
        twist += 2.0 * (web / t) * (0.145 + 0.1 * r / t) * inscribed**4 - 0.42 * t**4
    return weak, twist, t * b**3 / 24.0 * (h - t) ** 2


def torsion_constants(section: Section) -> tuple[float, float]:
    """St Venant's torsion constant I_t (m4) and warping constant I_w (m6) of a section.

    Thin plates of an I section without its fillets, Bredt's formula of a hollow one.
    """
    shape = section.shape
    if isinstance(shape, ISection):
        between = shape.height - shape.flange
        plates = 2.0 * shape.width * shape.flange**3 + between * shape.web**3
        return plates / 3.0, torsion_of(shape)[2]
    if isinstance(shape, RectangularTube):
        h, b = shape.height - shape.wall, shape.width - shape.wall
        return 2.0 * (h * b) ** 2 * shape.wall / (h + b), 0.0
    if isinstance(shape, CircularTube):
        return 2.0 * section.second_moment, 0.0
    assert isinstance(shape, Rectangle)
    long, short = max(shape.height, shape.width), min(shape.height, shape.width)
    ratio = short / long  # Timoshenko and Goodier, within 0.5 %
    return long * short**3 * (1.0 - 0.63 * ratio * (1.0 - ratio**4 / 12.0)) / 3.0, 0.0


def twist_stiffness(section: Section, steel: Steel) -> float:
    """St Venant's torsional stiffness of a section, G I_t, in N m2."""
    return steel.shear_modulus * torsion_constants(section)[0]


def lateral_torsional(
    shape: ISection, steel: Steel, length: float, moment: float
) -> LateralBuckling:
    """Buckling of an I section with forks `length` (m) apart under an even moment.

    EN 1993-1-1: 6.3.2.3 for sections with fillets, taken as rolled, 6.3.2.2 for welded ones.
    Argument: the `moment` (N m) that the section resists.
    """
    weak, twist, warping = torsion_of(shape)
    euler = pi**2 * steel.elastic_modulus * weak / length**2
    critical = euler * sqrt(warping / weak + steel.shear_modulus * twist / euler)
    slenderness, slim = sqrt(moment / critical), shape.height <= 2.0 * shape.width
    if shape.fillet:
        imperfection, plateau, beta = (0.34 if slim else 0.49), 0.4, 0.75
    else:
        imperfection, plateau, beta = (0.49 if slim else 0.76), 0.2, 1.0
    phi = 0.5 * (1.0 + imperfection * (slenderness - plateau) + beta * slenderness**2)
    factor = 1.0 / (phi + sqrt(phi**2 - beta * slenderness**2))
    factor = min(factor, 1.0, 1.0 / slenderness**2)
    return LateralBuckling(critical, factor, factor * moment)


TESTED = {"h/t_w": (20.0, 55.0), "b/2t_f": (4.0, 8.0), "f_y/MPa": (240.0, 450.0)}


def tested_ratios(section: Section, steel: Steel) -> dict[str, float]:
    """Ratios behind the capacity of an I section in cyclic tests, by the names of `TESTED`."""
    p = plates_of(section)
    ratios = p.web / p.web_thickness, 0.5 * section.width / p.flange_thickness
    return dict(zip(TESTED, (*ratios, steel.yield_stress / 1e6), strict=True))


def rotation_capacity(section: Section, steel: Steel) -> float:
    """Plastic rotation (rad) over which an I section's hinge would spend all its energy.

    The Lambda of Lignos and Krawinkler 2011, beams without reduced flanges, a fit to cyclic tests.
    """
    web, flange, stress = tested_ratios(section, steel).values()
    return float(495.0 * web**-1.34 * flange**-0.595 * (stress / 355.0) ** -0.36)


def _epsilon(steel: Steel) -> float:
    return sqrt(235e6 / steel.yield_stress)


def _class(ratio: float, limits: tuple[float, ...]) -> int:
    return 1 + sum(ratio > limit for limit in limits)


def _effective_modulus(section: Section, strength: Section, steel: Steel) -> float:
    """Section modulus W_eff (m3) of what is left: first of the flange, then of the web."""
    p, e, half = plates_of(section), _epsilon(steel), 0.5 * section.height
    t, at = p.flange_thickness, half - 0.5 * p.flange_thickness
    lost = p.flanges * p.flange * (1.0 - reduction(p.flange / t / e, outstand=p.outstand))
    area, first = strength.area - lost * t, -lost * t * at
    second = strength.second_moment - lost * t * (at**2 + t**2 / 12.0)
    axis = first / area  # below mid-height
    deep = 0.5 * p.web - axis  # of the web in compression
    share = reduction(p.web / p.web_thickness / e, (deep - p.web) / deep)
    gap = (1.0 - share) * deep  # between 0.4 of the effective part at the flange, 0.6 at the axis
    middle = axis + 0.6 * share * deep + 0.5 * gap
    strip = p.webs * p.web_thickness * gap
    area, first = area - strip, first - strip * middle
    second -= strip * (middle**2 + gap**2 / 12.0)
    axis = first / area
    return (second - area * axis**2) / (half - axis)
