"""Direct shear beside flexure: the ends of a member slide over their supports.

Krauthammer and others (told by Heng 2017, chapter 4; the paper was not at hand): a second single
degree of freedom at each support, which nothing couples to that of flexure but the dynamic reaction
V of the latter,

    m_s s'' + R_s(s) = V(t),   m_s = m L / 2,

m_s what either end has of the member that slides as a whole under a line load. R_s of a rolled
section is that of its web, elastic over the height h and then plastic: V_pl at s = h tau_y / G.
"""

import numpy as np

from workbench.arrays import Array
from workbench.errors import Collapse, CollapseError
from workbench.errors import Mechanism as Fall
from workbench.impact.pace import Pace
from workbench.impact.records import follow
from workbench.models.resistance import Resistance, ResistanceCurve, mechanism_of
from workbench.models.resistance.curve import straight_pieces
from workbench.models.resistance.given import given_curve, is_given
from workbench.models.single_dof import march
from workbench.scenarios import Column

NONE, WEB = "none", "web"
DIRECT_SHEAR = Resistance((NONE, WEB))
_PARTS = 64  # of the period of the shear mass


def slip_resistance(column: Column, law: str) -> ResistanceCurve:
    """Resistance (N) of a support over the slip (m): `law` web or the points of a CSV file."""
    mechanism = mechanism_of(column, uniform=True)
    if is_given(law):
        return given_curve(mechanism, law)
    steel, force = column.steel, column.properties.shear_resistance
    strain = steel.yield_stress / np.sqrt(3.0) / steel.shear_modulus
    elastic = float(strain * column.section.height)
    pieces = straight_pieces(elastic * np.arange(3.0), force * np.array([0.0, 1.0, 1.0]))
    return ResistanceCurve(WEB, mechanism, pieces, elastic)


def slips(column: Column, law: str, time: Array, reactions: Array) -> Array:
    """Slip (2, times) in m of both ends under `reactions` (2, times) in N at equal `time` (s).

    Raises `CollapseError` where an end has slid beyond its resistance: it is sheared off.
    """
    curve = slip_resistance(column, law)
    mass = 0.5 * column.properties.mass_per_length * column.length
    period = 2.0 * np.pi * np.sqrt(mass / curve.pieces["c"][:, 1].max())
    parts = max(1, int(np.ceil(_PARTS * time[1] / period)))
    fine = np.linspace(0.0, time[-1], (len(time) - 1) * parts + 1)
    limit, slid = min(curve.lost_at, curve.end), []
    for end, reaction in zip(("base", "head"), reactions, strict=True):
        force = np.interp(fine, time, reaction)
        stages, means = np.array([(0.0, mass, 1.0)]), 0.5 * (force[1:] + force[:-1])
        drive = march.no_striker(curve.elastic_limit, limit, mass)
        pace = Pace.equal(fine[-1], fine[1], len(means))
        run = follow(march.pulse, (curve.pieces, stages, means, 0.0), pace, drive, march.RECORD)
        if run.collapsed:
            fallen = Collapse(Fall.SHEAR, (end,), limit, float(run.records["time"][-1]))
            raise CollapseError(fallen, f"the {end} slides beyond its resistance to direct shear")
        slid.append(run.records["displacement"][::parts])
    return np.array(slid)
