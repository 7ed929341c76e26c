"""Frame of P. Heng, doctoral thesis, KTH 2017, section 5.3, and its columns with superelements.

Figure 5.14 prints curves; the digits below are peaks (m) of an independent implementation of the
same equations, which lie on the published curves. What the figure does not say (clamped bases,
middle column, 0.8 m above the base) follows from it: the other readings give other peaks.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from builders import thesis_frame

from workbench.base.datafiles import data_directory
from workbench.models.superelements import FlexibleSuperelement, RigidSuperelement
from workbench.responses import Outcome, outcome_of
from workbench.scenarios import (
    ColumnPushover,
    FrameImpact,
    FrameStriker,
    frame_of,
    load_scenario,
)
from workbench.steel.sections import find

# one bar of the thesis per member, or so many
RIGID = partial(RigidSuperelement, elements=1, rotational_stiffness=6.0)


@pytest.fixture(scope="module")
def frame_impact() -> FrameImpact:
    scenario = load_scenario(data_directory() / "published" / "heng2017_frame.toml")
    assert isinstance(scenario, FrameImpact)
    return replace(scenario, duration=0.052)


def hit(impact: FrameImpact, axis: str, height: float, base: str = "clamped") -> FrameImpact:
    """The same impact elsewhere on the ground floor."""
    frame = thesis_frame(base)
    return replace(impact, frame=frame.split(f"{axis}0-{axis}1", height, "hit"))


def peak(response) -> float:
    assert outcome_of(response) is Outcome.OK, response.attrs["message"]
    error = np.abs(response["balance_error"]).max() / response["input_energy"]
    assert float(error) < 1e-7  # measured 2.2e-8
    return float(response["peak_displacement"])


@pytest.mark.parametrize(
    ("model", "expected", "time"),
    [
        (RIGID(), 0.4981, 0.029),
        (RIGID(inertia="linear"), 0.4981, 0.029),
        (RIGID(inertia="none"), 0.4984, 0.029),
        (FlexibleSuperelement(elements=1), 0.5020, 0.029),
        (RIGID(elements=2), 0.5024, 0.029),
        (RIGID(elements=4), 0.4981, 0.028),
        (RIGID(alpha=1.0, beta=1.0), 0.548, 0.0305),
        (RIGID(alpha=1.5, beta=1.5), 0.5045, 0.029),
        (RIGID(alpha=2.0, beta=2.0), 0.491, 0.029),
    ],
    ids=str,
)
def test_figure_5_14(frame_impact, model, expected, time) -> None:
    response = model.simulate(frame_impact)
    assert peak(response) == pytest.approx(expected, rel=2e-3)
    assert float(response["time_of_peak"]) == pytest.approx(time, abs=1e-3)


def test_shortly_after_the_peak_the_curve_is_inside_the_published_inset(frame_impact) -> None:
    response = RIGID().simulate(frame_impact)
    # it vibrates by 1 mm, whose phase steps by error leave open; steps of 1e-5 s: 0.4796
    assert float(response["displacement"].interp(time=0.05)) == pytest.approx(0.480, abs=3e-3)


@pytest.mark.parametrize(("restitution", "expected"), [(0.5, 0.496), (1.0, 0.542)])
def test_restitution(frame_impact, restitution, expected) -> None:
    striker = replace(frame_impact.striker, restitution=restitution)
    response = RIGID(accuracy=2e-4).simulate(replace(frame_impact, striker=striker))
    # repeated rebounds: at the default accuracy the peak is 0.1 to 0.3 % off, 0.5401 m at
    # restitution 1; there it scatters from 0.5420 to 0.5434 m with node
    # inertias of 0.05 to 0.2 kg m2, without a trend
    assert peak(response) == pytest.approx(expected, rel=3e-3 if restitution == 1.0 else 2e-3)


@pytest.mark.parametrize(
    ("axis", "height", "base", "expected"),
    [
        ("C", 3.2, "clamped", 0.526),
        ("B", 0.8, "clamped", 0.500),
        ("A", 0.8, "clamped", 0.556),
        ("E", 0.8, "clamped", 0.538),
        ("C", 0.8, "pinned", 0.618),
    ],
)
def test_other_readings_of_figure_5_13(frame_impact, axis, height, base, expected) -> None:
    response = RIGID().simulate(hit(frame_impact, axis, height, base))
    assert peak(response) == pytest.approx(expected, rel=2e-3)


def test_the_step_matters_little(frame_impact) -> None:
    peaks = [peak(RIGID(time_step=step).simulate(frame_impact)) for step in (4e-4, 1e-4, 2.5e-5)]
    assert max(peaks) / min(peaks) < 1.0025


def test_first_impact_loses_the_share_of_two_bars(frame_impact) -> None:
    response = RIGID().simulate(frame_impact)
    loss = float(response["contact_loss"][-1]) / frame_impact.input_energy
    assert loss == pytest.approx(0.21, abs=5e-3)
    halves = RIGID(elements=2).simulate(frame_impact)
    loss = float(halves["contact_loss"][-1]) / frame_impact.input_energy
    assert loss == pytest.approx(0.11, abs=1e-2)


def test_a_stiffer_hinge_is_a_smaller_peak(frame_impact) -> None:
    """Sensitivities of the peak to the stiffness of the hinges, in percent."""
    base = peak(RIGID().simulate(frame_impact))
    for model, change in (
        (RIGID(rotational_stiffness=3.0), 3.0),
        (RIGID(rotational_stiffness=12.0), -1.7),
        (RIGID(rotational_stiffness=24.0), -2.7),
    ):
        response = 100.0 * (peak(model.simulate(frame_impact)) / base - 1.0)
        assert response == pytest.approx(change, abs=0.15)


# -- the columns of section 5.2 as frames ----------------------------------------------------

AT = [0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]
STATIC_KN = {
    (1.0, 1.0): [735.84, 770.81, 846.44, 860.36, 866.19, 971.08, 1261.2, 1852.1, 2836.5],
    (1.0, 1.3): [783.95, 807.41, 837.16, 896.27, 959.11, 1134.0, 1485.2, 2097.0, 2848.3],
    (1.0, 2.0): [830.31, 841.37, 833.18, 887.54, 1043.8, 1325.7, 1746.4, 2313.7, 2867.4],
}
# another implementation with the elastic stiffness of the plates alone, in MN
COARSER = {
    (1.0, 1.0): [0.739, 0.775, 0.851, 0.860, 0.866, 0.970, 1.260, 1.849, 2.836],
    (1.0, 1.3): [0.786, 0.810, 0.840, 0.896, 0.959, 1.133, 1.484, 2.094, 2.848],
    (1.0, 2.0): [0.831, 0.843, 0.835, 0.889, 1.045, 1.326, 1.745, 2.311, 2.867],
}


@pytest.mark.thorough
@pytest.mark.parametrize("exponents", STATIC_KN)
def test_figure_5_8_static_curve(thesis_impact, exponents) -> None:
    """Two rigid superelements are the column of two rigid bars and four hinges."""
    push = ColumnPushover("figure 5.8", thesis_impact.column, 0.7)
    response = RIGID(alpha=exponents[0], beta=exponents[1], shear="none").simulate(push)
    force = np.interp(AT, response["displacement"], response["force"])
    np.testing.assert_allclose(force / 1e3, STATIC_KN[exponents], rtol=6e-4)  # measured 2.7e-4
    np.testing.assert_allclose(force / 1e6, COARSER[exponents], rtol=6e-3)


def test_flexible_bars_push_alike(thesis_impact) -> None:
    push = ColumnPushover("figure 5.8", thesis_impact.column, 0.7)
    rigid, flexible = (
        np.interp(AT[2:], r["displacement"], r["force"])
        for r in (
            kind(shear="none").simulate(push) for kind in (RigidSuperelement, FlexibleSuperelement)
        )
    )
    np.testing.assert_allclose(flexible, rigid, rtol=3e-3)


PEAKS = {
    (1.0, 1.3): (0.0900, 0.1910, 0.3232),
    (1.0, 1.0): (0.0932, 0.1937, 0.3341),
    (1.5, 1.5): (0.0878, 0.1910, 0.3192),
}


@pytest.mark.parametrize("exponents", PEAKS)
def test_figure_5_9_with_the_mass_of_the_thesis(thesis_impact, exponents) -> None:
    """Massless bars and a third of the column's mass at the impact point."""
    frame = frame_of(replace(thesis_impact.column, mass_per_length=0.01))
    nodes = tuple(replace(n, mass=95.2467) if n.name == "hit" else n for n in frame.nodes)
    frame = replace(frame, nodes=nodes)
    model = RIGID(
        alpha=exponents[0], beta=exponents[1], inertia="none", time_step=1e-4, shear="none"
    )
    for velocity, expected in zip((10.0, 15.0, 20.0), PEAKS[exponents], strict=True):
        impact = FrameImpact("hit", frame, FrameStriker(1500.0, velocity, node="hit"), 0.06)
        assert peak(model.simulate(impact)) == pytest.approx(expected, rel=5e-3)


def test_figure_5_9_with_distributed_mass(thesis_impact) -> None:
    for velocity, expected in zip((10.0, 15.0, 20.0), (0.0899, 0.1909, 0.3219), strict=True):
        response = RIGID(shear="none").simulate(thesis_impact.at_velocity(velocity))
        assert peak(response) == pytest.approx(expected, rel=5e-3)


@pytest.mark.parametrize(("exponents", "expected"), [((1.0, 1.3), 0.4975), ((1.0, 1.0), 0.5055)])
def test_figure_5_4_clamped_column(clamped_impact, exponents, expected) -> None:
    column = clamped_impact.column
    frame = frame_of(replace(column, mass_per_length=0.01))
    mass = column.properties.impact_mass
    nodes = tuple(replace(n, mass=mass) if n.name == "hit" else n for n in frame.nodes)
    striker = clamped_impact.striker
    impact = FrameImpact(
        "figure 5.4",
        replace(frame, nodes=nodes),
        FrameStriker(striker.mass, striker.velocity, node="hit"),
        0.06,
    )
    response = RIGID(
        alpha=exponents[0], beta=exponents[1], inertia="none", time_step=1e-4, shear="none"
    ).simulate(impact)
    assert peak(response) == pytest.approx(expected, rel=2e-4)  # measured 8.8e-5


def test_plates_alone_change_little(thesis_impact) -> None:
    """Elastic stiffness of three plates instead of the rolled profile."""
    plates = replace(
        thesis_impact.column,
        section=find("HEB 220").without_fillets(),
        area=None,
        second_moment=None,
        mass_per_length=71.435,
    )
    rolled = peak(RIGID().simulate(thesis_impact))
    bare = peak(RIGID().simulate(replace(thesis_impact, column=plates)))
    assert bare == pytest.approx(rolled, rel=1.3e-3)  # measured 6.3e-4
