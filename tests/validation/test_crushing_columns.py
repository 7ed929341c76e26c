"""Columns hit by a heavy striker that crushes, where bending governs: models of four kinds agree.

The rule stood before any answer: ten columns of a seed, clamped and guided, of the static yield
stress; L/h 16 to 30, hit at 0.3 to 0.5 L; the mechanism needs less than half of V_pl; the striker
weighs 10 to 50 lumped masses at 5 to 25 m/s, of 2 to 20 MN/m, with the energy that the mechanism
takes up to a displacement of 0.03 to 0.2 of the segment below; the record holds the peak.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from workbench.models.base import make_model
from workbench.models.domain import euler_load, shear_demand
from workbench.scenarios import Column, ColumnImpact, Striker
from workbench.steel.sections import find

SEED, COLUMNS = 1931, 10
SECTIONS = (
    *("HEA 180", "HEA 240", "HEB 160", "HEB 220", "HEB 280", "HEM 200"),
    *("IPE 240", "IPE 300", "IPE 360", "IPE 450"),
)
MODELS = (
    *(("soft-impact", {}), ("four-dof", {}), ("flexible-superelement", {})),
    ("fiber-reissner", {"levels": 1}),
)


def drawn() -> Iterator[ColumnImpact]:
    """Columns by the rule, without end."""
    draws = np.random.default_rng(SEED)
    while True:
        u = draws.random(8).tolist()
        section = find(SECTIONS[int(u[0] * len(SECTIONS))])
        length, place = (16.0 + 14.0 * u[1]) * section.height, 0.3 + 0.2 * u[2]
        column = Column(section, place * length, (1.0 - place) * length)
        impact = ColumnImpact("drawn", column, Striker(1.0, 1.0))
        spring = 0.0 if u[4] < 0.25 else 0.005 * 60.0 ** ((u[4] - 0.25) / 0.75)
        column = replace(
            column,
            axial_load=0.15 * u[3] * min(column.properties.squash_load, 0.5 * euler_load(impact)),
            restraint_stiffness=spring * 210e9 * section.area / length,
        )
        demand = shear_demand(replace(impact, column=column)).values()
        force, stiffness = sum(demand) * column.properties.shear_resistance, 2e6 * 10.0 ** u[5]
        velocity, reach = 5.0 + 20.0 * u[6], (0.03 + 0.17 * u[7]) * column.length_below
        mass = 2.0 * force * (reach + 0.5 * force / stiffness) / velocity**2
        lumped = column.properties.impact_mass
        if max(demand) < 0.5 and 10.0 * lumped <= mass <= 50.0 * lumped:
            striker = Striker(mass, velocity, stiffness=stiffness)
            duration = 6.0 * (force / stiffness + reach) / velocity + 0.05
            yield ColumnImpact("drawn", column, striker, duration)


@pytest.mark.slow
def test_models_of_four_kinds_agree_within_five_percent() -> None:
    columns = drawn()
    for _ in range(COLUMNS):
        impact = next(columns)
        peaks = [float(make_model(*each).simulate(impact)["peak_displacement"]) for each in MODELS]
        assert max(peaks) / min(peaks) < 1.05, impact  # measured 0.9 to 4.9 %
