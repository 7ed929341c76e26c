"""A frame whose column is gone (study `column_removal`): own frame, its modes, energy, factor 2."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigh

from workbench.extras.frame_models.hinged_frames import PlasticHinge
from workbench.models.superelements import FlexibleSuperelement, RigidSuperelement

STUDY = runpy.run_path(str(Path(__file__).parents[3] / "studies" / "column_removal.py"))
removal, pseudo_static = STUDY["removal"], STUDY["pseudo_static"]


def elastic_step(frame, node: str, load: float) -> tuple[float, float]:
    """Static displacement (m) of a node under a load down, and the peak if it comes at once.

    Bernoulli members without mass, one each; masses at the nodes: modes, summed up.
    """
    freedoms = [(n.name, c) for n in frame.nodes if n.support == "free" for c in "xyr"]
    at = {freedom: i for i, freedom in enumerate(freedoms)}
    place = {n.name: np.array([n.x, n.y]) for n in frame.nodes}
    mass = np.array([1e-3 if c == "r" else frame.node(n, "").mass for n, c in freedoms])
    stiffness = np.zeros((len(at), len(at)))
    for member in frame.members:
        chord = place[member.end] - place[member.start]
        length = float(np.hypot(*chord))
        c, s = chord / length
        turn = np.kron(np.eye(2), [[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        a, b = (
            210e9 * member.section.area / length,
            210e9 * member.section.second_moment / length**3,
        )
        k = np.zeros((6, 6))
        k[np.ix_([0, 3], [0, 3])] = a * np.array([[1.0, -1.0], [-1.0, 1.0]])
        bent = np.array([1.0, length / 2.0, -1.0, length / 2.0])
        k[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] = 12.0 * b * np.outer(bent, bent)
        k[np.ix_([2, 5], [2, 5])] += b * length**2 * np.array([[1.0, -1.0], [-1.0, 1.0]])
        ends = [at.get((n, f), -1) for n in (member.start, member.end) for f in "xyr"]
        free = [i for i, dof in enumerate(ends) if dof >= 0]
        dofs = [ends[i] for i in free]
        stiffness[np.ix_(dofs, dofs)] += (turn.T @ k @ turn)[np.ix_(free, free)]
    force = np.zeros(len(at))
    force[at[node, "y"]] = -load
    squares, modes = eigh(stiffness, np.diag(mass))
    shares = -modes[at[node, "y"]] * (modes.T @ force) / squares
    time = np.linspace(0.0, 1.2, 24_001)
    swings = shares @ (1.0 - np.cos(np.sqrt(squares)[:, None] * time))
    return float(shares.sum()), float(swings.max())


@pytest.mark.thorough
def test_taken_away_at_once_an_elastic_frame_goes_twice_as_far() -> None:
    slow, sudden = removal(3e3, 0.01)
    held = slow.magnitude
    static, peak = elastic_step(slow.frame, "B1", held)
    assert peak == pytest.approx(2.0 * static, rel=1e-3)  # one mode has 0.998 of it
    model = PlasticHinge(elements=4, shear_flexible=False)
    pushed = model.simulate(slow)
    value = float(np.interp(1.0, pushed["load_factor"], pushed["displacement"]))
    assert value == pytest.approx(static, rel=0.01)
    swung = float(model.simulate(sudden)["peak_displacement"])
    assert swung == pytest.approx(2.0 * value, rel=2e-3)
    assert swung == pytest.approx(peak, rel=0.01)


@pytest.mark.thorough
@pytest.mark.parametrize("kind", [FlexibleSuperelement, RigidSuperelement])
def test_where_it_yields_the_peak_is_that_of_the_static_work(kind) -> None:
    """And the factor 2 says collapse: no 2 R is carried within 0.6 m."""
    slow, sudden = removal(1.2e4)
    pushed = kind(elements=4).simulate(slow)
    way, factor = pushed["displacement"].values, pushed["load_factor"].values
    swung = kind(elements=4).simulate(sudden)
    assert float(swung["peak_displacement"]) == pytest.approx(pseudo_static(way, factor), rel=5e-3)
    assert factor.max() < 1.3
    assert np.interp(float(swung["peak_displacement"]), way, factor) == pytest.approx(
        1.25, abs=0.01
    )
    assert float(swung["dissipated"][-1]) > 0.5 * float(swung["input_energy"])


def test_static_work_of_a_straight_line_meets_at_twice_the_static_way() -> None:
    way = np.linspace(0.0, 3.0, 301)
    assert pseudo_static(way, way) == pytest.approx(2.0, rel=1e-6)
    assert np.isnan(pseudo_static(way, 0.9 * np.minimum(way, 1.0)))
