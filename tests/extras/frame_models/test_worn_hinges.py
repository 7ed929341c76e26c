"""Bars whose hinges wear by the energy they dissipate: energy, strength, the end of both."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from superelement_cases import EA, EI, MP, NP, PLATES

from workbench.extras.frame_models.bars import Bar, BarElements, PlasticEnd, hinged_bars
from workbench.mechanics.structures.elements import Bars, StepRequest
from workbench.steel.hinges.interaction import polyline

LENGTH = 4.0


def bar(rotation: float, curve: str = "exact", spread: np.ndarray | None = None) -> BarElements:
    """One bar along x whose hinges wear."""
    first = 1.0 if spread is None else 0.88
    end = PlasticEnd((NP, NP), (MP, MP), polyline(curve, PLATES), np.inf, 0.0, first, spread)
    end = replace(end, rotation=rotation, softness=LENGTH / 6.0 / EI)
    made = hinged_bars([[0, 1]], [Bar(end, end, EA, EI, 71.0)], regularisation=0.0)
    places = np.arange(36)[None] % 18
    chord = np.array([[LENGTH, 0.0]])
    made.place(Bars(np.arange(6)[None], places, chord, np.array([LENGTH])))
    return made


SPREAD = np.array([[0.0, 0.001, 0.004, 0.02], [0.0, 0.5, 0.8, 1.0]])


@pytest.mark.thorough
@given(
    st.lists(st.tuples(*(st.floats(-1.0, 1.0) for _ in range(3))), min_size=2, max_size=12),
    st.sampled_from((0.02, 0.2, 2.0)),
    st.sampled_from((None, SPREAD)),
)
def test_energy_is_never_negative(
    moves: list[tuple[float, float, float]], rotation: float, spread: np.ndarray | None
) -> None:
    """Whatever way the ends of a bar go: dissipation grows, energy is conserved, strength falls."""
    element, start = bar(rotation, spread=spread), np.zeros(6)
    left, work, spent, stored = np.ones((1, 2)), 0.0, 0.0, 0.0
    size = NP * LENGTH / EA + MP * LENGTH / EI * 0.1
    for along, first, last in moves:
        end = np.array([0.0, 0.0, 0.1 * first, 4e-3 * along, 0.0, 0.1 * last])
        for k in range(1, 41):
            at = start + (end - start) * k / 40
            force, band = np.zeros(6), np.zeros(18)
            before = start + (end - start) * (k - 1) / 40
            element.assemble(StepRequest(force, band, before, at, 1.0, False, 1.0, True))
            energies = element.account(1.0)
            assert energies.ideal >= -1e-9 * MP * size
            assert energies.plastic + energies.algorithmic >= -1e-9 * MP * size
            assert energies.stored >= 0.0
            work += float(force @ (at - before))
            spent += energies.plastic + energies.algorithmic
            stored = energies.stored
            element.commit()
            assert np.all(element.strength_left <= left)
            assert np.all(element.utilisation() <= 1.0 + 1e-9)
            left = element.strength_left
        start = end
    assert work == pytest.approx(spent + stored, rel=2e-2, abs=1e-6 * MP)
    assert np.all(left > 0.0)


def test_worn_hinges_are_pins_in_the_end() -> None:
    element, start = bar(0.01), np.zeros(6)
    for k in range(400):
        end = np.array([0.0, 0.0, 0.1 if k % 2 else -0.1, 0.0, 0.0, 0.0])
        element.assemble(StepRequest(np.zeros(6), np.zeros(18), start, end, 1.0, False, 1.0, True))
        element.commit()
        start = end
    assert element.strength_left[0, 0] == pytest.approx(1e-6)
    assert abs(element.local_forces[0, 1]) <= 1e-6 * MP
