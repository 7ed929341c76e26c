"""The works that models, data and metrics rest on, by key."""

from __future__ import annotations

from typing import NamedTuple

from workbench.report.stud_works import STUD_WORKS


class Reference(NamedTuple):
    """A published work: `where` names journal, publisher or institution; `doi` may be empty."""

    key: str
    authors: str
    year: str
    title: str
    where: str
    doi: str = ""


_WORKS = (
    Reference(
        "heng2017",
        "Heng, P.",
        "2017",
        "Simplified mechanical models for the nonlinear dynamic analysis of elasto-plastic steel "
        "structures impacted by a rigid body",
        "doctoral thesis, KTH Royal Institute of Technology, Stockholm",
    ),
    Reference(
        "moreau1988",
        "Moreau, J. J.",
        "1988",
        "Unilateral contact and dry friction in finite freedom dynamics",
        "in: Nonsmooth Mechanics and Applications, CISM Courses and Lectures 302, Springer, 1-82",
        "10.1007/978-3-7091-2624-0_1",
    ),
    Reference(
        "simo-tarnow1992",
        "Simo, J. C.; Tarnow, N.",
        "1992",
        "The discrete energy-momentum method: conserving algorithms for nonlinear elastodynamics",
        "Zeitschrift für angewandte Mathematik und Physik 43, 757-792",
        "10.1007/BF00913408",
    ),
    Reference(
        "reissner1972",
        "Reissner, E.",
        "1972",
        "On one-dimensional finite-strain beam theory: the plane problem",
        "Zeitschrift für angewandte Mathematik und Physik 23, 795-804",
        "10.1007/BF01602645",
    ),
    Reference(
        "simo1985",
        "Simo, J. C.",
        "1985",
        "A finite strain beam formulation. The three-dimensional dynamic problem. Part I",
        "Computer Methods in Applied Mechanics and Engineering 49, 55-70",
        "10.1016/0045-7825(85)90050-7",
    ),
    Reference(
        "simo-tarnow-doblare1995",
        "Simo, J. C.; Tarnow, N.; Doblaré, M.",
        "1995",
        "Non-linear dynamics of three-dimensional rods: exact energy and momentum conserving "
        "algorithms",
        "International Journal for Numerical Methods in Engineering 38, 1431-1473",
        "10.1002/nme.1620380903",
    ),
    Reference(
        "cowper-symonds1957",
        "Cowper, G. R.; Symonds, P. S.",
        "1957",
        "Strain hardening and strain-rate effects in the impact loading of cantilever beams",
        "Technical Report 28, Division of Applied Mathematics, Brown University",
    ),
    Reference(
        "menegotto-pinto1973",
        "Menegotto, M.; Pinto, P. E.",
        "1973",
        "Method of analysis for cyclically loaded R.C. plane frames including changes in geometry "
        "and non-elastic behaviour of elements under combined normal force and bending",
        "IABSE Symposium, Lisbon, 15-22",
    ),
    Reference(
        "eccs1984",
        "ECCS",
        "1984",
        "Ultimate limit state calculation of sway frames with rigid joints",
        "Publication 33, European Convention for Constructional Steelwork, Brussels",
    ),
    Reference(
        "simo-hughes1998",
        "Simo, J. C.; Hughes, T. J. R.",
        "1998",
        "Computational Inelasticity",
        "Springer, New York",
        "10.1007/b98904",
    ),
    Reference(
        "crisfield1991",
        "Crisfield, M. A.",
        "1991",
        "Non-linear Finite Element Analysis of Solids and Structures, volume 1",
        "Wiley, Chichester",
    ),
    Reference(
        "biggs1964",
        "Biggs, J. M.",
        "1964",
        "Introduction to Structural Dynamics",
        "McGraw-Hill, New York",
    ),
    Reference(
        "en1993-1-1",
        "CEN",
        "2005",
        "EN 1993-1-1: Eurocode 3, Design of steel structures, general rules and rules for "
        "buildings",
        "European Committee for Standardization, Brussels",
    ),
    Reference(
        "en1991-1-7",
        "CEN",
        "2006",
        "EN 1991-1-7: Eurocode 1, Actions on structures, general actions, accidental actions",
        "European Committee for Standardization, Brussels",
    ),
    Reference(
        "en10365",
        "CEN",
        "2017",
        "EN 10365: Hot rolled steel channels, I and H sections, dimensions and masses",
        "European Committee for Standardization, Brussels",
    ),
    Reference(
        "roache1994",
        "Roache, P. J.",
        "1994",
        "Perspective: a method for uniform reporting of grid refinement studies",
        "Journal of Fluids Engineering 116 (3), 405-413",
        "10.1115/1.2910291",
    ),
    Reference(
        "celik2008",
        "Celik, I. B.; Ghia, U.; Roache, P. J.; Freitas, C. J.; Coleman, H.; Raad, P. E.",
        "2008",
        "Procedure for estimation and reporting of uncertainty due to discretization in CFD "
        "applications",
        "Journal of Fluids Engineering 130 (7), 078001",
        "10.1115/1.2960953",
    ),
    Reference(
        "eca-hoekstra2014",
        "Eca, L.; Hoekstra, M.",
        "2014",
        "A procedure for the estimation of the numerical uncertainty of CFD calculations based on "
        "grid refinement studies",
        "Journal of Computational Physics 262, 104-130",
        "10.1016/j.jcp.2014.01.006",
    ),
    Reference(
        "oberkampf-roy2010",
        "Oberkampf, W. L.; Roy, C. J.",
        "2010",
        "Verification and Validation in Scientific Computing",
        "Cambridge University Press",
        "10.1017/CBO9780511760396",
    ),
    Reference(
        "asme-vv20",
        "ASME",
        "2009",
        "V&V 20: Standard for verification and validation in computational fluid dynamics and "
        "heat transfer",
        "American Society of Mechanical Engineers, New York",
    ),
    Reference(
        "sprague-geers",
        "Sprague, M. A.; Geers, T. L.",
        "2004",
        "A spectral-element method for modelling cavitation in transient fluid-structure "
        "interaction",
        "International Journal for Numerical Methods in Engineering 60, 2467-2499",
        "10.1002/nme.1054",
    ),
    Reference(
        "nchrp179",
        "Ray, M. H.; Mongiardini, M.; Plaxico, C. A.; Anghileri, M.",
        "2010",
        "Procedures for verification and validation of computer simulations used for roadside "
        "safety applications",
        "NCHRP Web-Only Document 179, Transportation Research Board, Washington",
    ),
    Reference(
        "jekel2019",
        "Jekel, C. F.; Venter, G.; Venter, M. P.; Stander, N.; Haftka, R. T.",
        "2019",
        "Similarity measures for identifying material parameters from hysteresis loops using "
        "inverse analysis",
        "International Journal of Material Forming 12, 355-378",
        "10.1007/s12289-018-1421-8",
    ),
    Reference(
        "witowski2012",
        "Witowski, K.; Stander, N.",
        "2012",
        "Parameter identification of hysteretic models using partial curve mapping",
        "12th AIAA Aviation Technology, Integration, and Operations Conference, Indianapolis",
        "10.2514/6.2012-5580",
    ),
    Reference(
        "fds-validation",
        "McGrattan, K.; Toman, B.",
        "2011",
        "Quantifying the predictive uncertainty of complex numerical models (the statistics of "
        "the Fire Dynamics Simulator validation guide, NIST SP 1018-3)",
        "Metrologia 48, 173-180",
        "10.1088/0026-1394/48/3/011",
    ),
    Reference(
        "efron-tibshirani1993",
        "Efron, B.; Tibshirani, R. J.",
        "1993",
        "An Introduction to the Bootstrap",
        "Chapman & Hall, New York",
    ),
)

BIBLIOGRAPHY: dict[str, Reference] = {
    work.key: work for work in (*_WORKS, *(Reference(*entry) for entry in STUD_WORKS))
}


def reference_of(key: str) -> Reference:
    """The work of a key; a key that the list lacks stands for itself, as written."""
    return BIBLIOGRAPHY.get(key) or Reference(key, "", "", key, "")
