"""Biggs' factors against the printed tables, resistances against beam theory, impacts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from workbench.extras.practice.biggs import Biggs
from workbench.extras.practice.hand_estimate import mechanism_load
from workbench.models.energy_estimate import energy_to_absorb
from workbench.models.resistance.shapes import DeflectedBeam, beam_of, plastic_moment
from workbench.responses import energy_error, warnings_of

MID, THIRDS = (0.0, 0.5, 1.0), (0.0, 1 / 3, 0.5, 2 / 3, 1.0)
UNIFORM, POINT = (0.0,), (1.0,)
SIMPLE, FIXED, PROPPED = (False, False), (True, True), (True, False)
LOWEST = (0.0, 0.5785, 1.0)  # of a propped beam under uniform load, from its clamped end
# Biggs 1964, tables 5.1 to 5.3; UFC 3-340-02: K_L, K_M, K_LM and stiffness over EI/L^3 per stage,
# load of the mechanism over M_p/L. Deflections are those of midspan, or of the largest one.
TABLES = {
    "simple, uniform": (
        *(MID, SIMPLE, UNIFORM, 1, 8.0),
        [(0.64, 0.50, 0.78, 384 / 5), (0.50, 0.33, 0.66, 0.0)],
    ),
    "simple, point": (
        *(MID, SIMPLE, POINT, 1, 4.0),
        [(1.0, 0.49, 0.49, 48.0), (1.0, 0.33, 0.33, 0.0)],
    ),
    "simple, thirds": (
        *(THIRDS, SIMPLE, (0.5, 0.0, 0.5), 2, 6.0),
        # printed 0.52 and 0.60: the integral of that shape is 0.502, by hand as well
        [(0.87, 0.50, 0.58, 56.4), (1.0, 0.56, 0.56, 0.0)],
    ),
    "fixed, uniform": (
        *(MID, FIXED, UNIFORM, 1, 16.0),
        [(0.53, 0.41, 0.77, 384.0), (0.64, 0.50, 0.78, 384 / 5), (0.50, 0.33, 0.66, 0.0)],
    ),
    "fixed, point": (
        *(MID, FIXED, POINT, 1, 8.0),
        [(1.0, 0.37, 0.37, 192.0), (1.0, 0.33, 0.33, 0.0)],
    ),
    "propped, uniform": (*(LOWEST, PROPPED, UNIFORM, 1, None), [(0.58, 0.45, 0.78, 185.0)]),
}


@pytest.mark.claim("model:biggs", "load-mass factor off tables 5.1 to 5.3", "biggs1964", 0, 0.01)
@pytest.mark.parametrize("case", TABLES)
def test_factors_are_those_of_the_tables(case, claim) -> None:
    nodes, clamped, forces, reference, strength, rows = TABLES[case]
    stages = DeflectedBeam(nodes, clamped, forces, 1.0, reference).stages(np.ones(len(nodes)))
    if strength is not None:
        assert len(stages) == len(rows)
        assert stages[-1].load == pytest.approx(strength)
    for stage, (load, mass, both, stiffness) in zip(stages, rows, strict=False):
        assert round(stage.load_factor, 2) == load
        assert round(stage.mass_factor, 2) == mass
        # the tables divide factors that are rounded already
        claim(stage.load_mass_factor - both)
        assert stage.stiffness == pytest.approx(stiffness, rel=3e-3)


def test_one_public_table_mixes_its_rows() -> None:
    stage = DeflectedBeam(MID, FIXED, UNIFORM, 1.0).stages(np.ones(3))[0]
    assert stage.load_mass_factor == pytest.approx(0.762, abs=1e-3)  # not 0.64


@pytest.mark.claim("model:biggs", "stiffness, {base} to {head}, ratio", "closed form", 1, 1e-9)
@pytest.mark.parametrize("base", ["clamped", "pinned"])
@pytest.mark.parametrize("head", ["guided", "pinned"])
def test_stages_of_an_eccentric_column(thesis_impact, base, head, claim) -> None:
    column = replace(thesis_impact.column, base=base, head=head)
    a, b, length = column.length_below, column.length_above, column.length
    EI = column.steel.elastic_modulus * column.properties.second_moment
    if base == head == "pinned":
        stiffness = 3.0 * EI * length / (a * b) ** 2
    elif base == "clamped" and head == "guided":
        stiffness = 3.0 * EI * length**3 / (a * b) ** 3
    else:  # a propped beam, c from its clamped end
        c, d = (a, b) if base == "clamped" else (b, a)
        stiffness = 12.0 * EI * length**3 / (c**3 * d**2 * (4.0 * length - c))
    stages = Biggs().stages(column)
    claim(stages[0].stiffness / stiffness)
    assert stages[-1].load == pytest.approx(mechanism_load(column, "section"), rel=1e-9)
    assert stages[-1].mass_factor == pytest.approx(1.0 / 3.0)
    moments = plastic_moment(column, "section")
    ends = [moments if end != "pinned" else 0.0 for end in (base, head)]
    np.testing.assert_allclose(stages[-1].moments, [-ends[0], moments, -ends[1]], atol=1e-6)


def test_a_blow_meets_the_mass_of_the_stage_it_leads_to(thesis_impact) -> None:
    model, column = Biggs(), thesis_impact.column
    stages = model.stages(column)
    total = column.properties.mass_per_length * column.length
    for velocity, stage in ((0.3, stages[0]), (15.0, stages[-1])):
        impact = model.with_mass(thesis_impact.at_velocity(velocity))
        assert impact.column.impact_mass == pytest.approx(stage.mass_factor * total)
        response = model.simulate(thesis_impact.at_velocity(velocity))
        expected = model.curve(column).displacement_at(energy_to_absorb(impact))
        assert float(response["peak_displacement"]) == pytest.approx(expected, rel=1e-3)
        assert energy_error(response) < 1e-12
    given = replace(thesis_impact, column=replace(column, impact_mass=80.0))
    assert model.with_mass(given) is given


def test_what_flexure_alone_leaves_out_is_said(thesis_impact) -> None:
    heavy = replace(thesis_impact.column, axial_load=1.5e6, restraint_stiffness=0.0)
    findings = warnings_of(Biggs().simulate(replace(thesis_impact, column=heavy)))
    assert "simplification" in {finding.subject for finding in findings}
    assert "simplification" not in {
        finding.subject for finding in warnings_of(Biggs().simulate(thesis_impact))
    }
    weaker = beam_of(heavy).stages(np.full(3, plastic_moment(heavy, "section")))[-1].load
    assert weaker < 0.7 * mechanism_load(heavy, "none")
