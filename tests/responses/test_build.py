"""Reductions of histories to scalars against closed forms; the response contract."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr

from workbench.base.errors import WorkbenchError
from workbench.responses import (
    Finding,
    Outcome,
    build_response,
    check_response,
    failed_response,
    findings_of,
    outcome_of,
    peak_contact_force,
    peak_of,
    places_of,
    set_findings,
    warnings_of,
)
from workbench.responses.histories import EXTREMES, open_share, residual_of


def test_peak_between_samples_is_that_of_the_parabola() -> None:
    time = np.linspace(0.0, 1.0, 12)
    peak = peak_of(time, 3.0 - (time - 0.4321) ** 2)
    assert peak["peak_displacement"] == pytest.approx(3.0, abs=1e-12)
    assert peak["time_of_peak"] == pytest.approx(0.4321, abs=1e-12)


@pytest.mark.parametrize("end", [1.6, 3.4, 12.9])
def test_time_of_peak_is_that_of_the_first_nearly_largest_cycle(end) -> None:
    time = np.linspace(0.0, end, int(37 * end))
    cycles = np.cos(2.0 * np.pi * (time - 0.3)) * (1.0 + 2e-4 * time)
    peak = peak_of(time, cycles)
    assert peak["time_of_peak"] == pytest.approx(0.3, abs=2e-3)
    assert peak["peak_displacement"] == pytest.approx(cycles.max(), rel=4e-3)
    assert peak["peak_displacement"] >= cycles.max()
    growing = peak_of(time, cycles * (1.0 + 0.01 * time))
    assert end < 2.0 or growing["time_of_peak"] > 1.0  # 1 % a cycle is another peak


def test_a_growing_record_has_no_peak() -> None:
    assert peak_of(np.arange(5.0), np.arange(5.0)) == {}


both_ways = pytest.mark.parametrize("sign", [1.0, -1.0])


@both_ways
def test_the_peak_is_the_value_of_largest_magnitude_with_its_sign(sign) -> None:
    """1.81 mm one way, then 4.76 the other."""
    time = np.linspace(0.0, 1.0, 2001)
    back = -4.76 * np.sin(np.pi * (time - 0.4) / 0.6)
    moved = np.where(time < 0.4, 1.81 * np.sin(np.pi * time / 0.4), back)
    peak = peak_of(time, sign * moved)
    assert peak["peak_displacement"] == pytest.approx(-4.76 * sign, rel=1e-5)
    assert peak["time_of_peak"] == pytest.approx(0.7, abs=1e-5)


@both_ways
def test_of_swings_as_large_either_way_the_first_counts(sign) -> None:
    """Samples of a vibration show more of one crest than of the other; 0.5 % more counts."""
    time = np.linspace(0.0, 5.0, 101)
    wave = sign * np.sin(2.0 * np.pi * time)
    for growth, first in ((1e-3, True), (2e-2, False)):
        peak = peak_of(time, wave * np.where(wave * sign < 0.0, 1.0 + growth, 1.0))
        assert peak["peak_displacement"] == pytest.approx(
            sign if first else -sign * (1.0 + growth), rel=2e-3
        )
        assert peak["time_of_peak"] == pytest.approx(0.25 if first else 0.75, abs=2e-3)


@both_ways
def test_a_record_grows_either_way(sign) -> None:
    assert peak_of(np.arange(5.0), sign * np.arange(5.0)) == {}
    assert peak_of(np.arange(5.0), sign * np.array([0.0, 1.0, 0.0, -2.0, -3.0])) == {}


@both_ways
def test_a_residual_either_way_is_that_behind_peak_and_load(sign) -> None:
    """A mass on a spring from -1.9 on, at rest about -0.95; under a load until 0.5 s about -2."""
    time = np.linspace(0.0, 1.4, 7001)
    free = -0.95 - 0.05 * np.cos(40.0 * time)
    pushed = -2.0 - 1.0 * np.cos(40.0 * time)
    load = np.where(time < 0.5, -3e3, 0.0)
    moved = np.where(time < 0.5, pushed, free)
    moved[time < 0.02] *= time[time < 0.02] / 0.02
    values = {"displacement": sign * moved, "load": sign * load}
    left = float(build_response(values, time=time)["residual_displacement"])
    assert left == pytest.approx(-0.95 * sign, rel=1e-4)
    for stays in (np.full(7001, 1e3), np.minimum(time / 0.1, 1.0), np.exp(-time / 1.0)):
        assert "residual_displacement" not in build_response({**values, "load": stays}, time=time)
    fades = build_response({**values, "load": np.exp(-time / 0.05)}, time=time)
    assert "residual_displacement" in fades


def test_residual_is_the_mean_of_whole_cycles() -> None:
    time = np.linspace(0.0, 1.0, 5001)
    rise = 0.5 * (1.0 - np.cos(np.pi * np.minimum(time / 0.2, 1.0)))
    swing = np.where(time > 0.2, 0.05 * (np.cos(40.0 * (time - 0.2)) - 1.0), 0.0)
    assert residual_of(time, rise + swing) == pytest.approx(0.95, abs=5.3e-8)  # measured 2.6e-8


def test_residual_is_absent_without_a_whole_cycle() -> None:
    time = np.linspace(0.0, 0.3, 301)
    assert residual_of(time, np.sin(np.pi * time / 0.4)) is None


def test_residual_is_absent_between_two_crossings_of_which_one_is_missing() -> None:
    """After 0.5 s a cycle of 0.4 s: the next upward crossing comes after 0.8 and 1.2 s."""
    for end, whole in ((1.1, False), (1.3, True)):
        time = np.linspace(0.0, end, 1301)
        wave = 1.0 + 0.1 * np.cos(5.0 * np.pi * (time - 0.5))
        moved = np.where(time < 0.5, 2.2 * time, wave)
        assert (residual_of(time, moved) is not None) == whole


def test_contact_force_is_the_mean_over_a_millisecond() -> None:
    time = np.arange(1, 101) * 1e-4
    percussion = np.full(100, 50.0 * 1e-4)
    assert peak_contact_force(time, percussion) == pytest.approx(50.0, rel=1e-9)
    blow = np.zeros(100)
    blow[40] = 2.0
    assert peak_contact_force(time, blow) == pytest.approx(2.0 / 1e-3, rel=1e-9)


def test_a_response_is_what_xarray_builds_of_its_parts() -> None:
    """The short way past the search for conflicts leaves the same data set, indexes too."""
    values = {"displacement": [0.0, 1.0], "moment": np.ones((3, 2)), "input_energy": 2.0}
    hinges = ("base", "hit", "head")
    response = build_response(values, time=[0.0, 0.5], hinges=hinges)
    plain = xr.Dataset(
        {name: (array.dims, array.values, array.attrs) for name, array in response.items()},
        {name: (array.dims, array.values, array.attrs) for name, array in response.coords.items()},
        response.attrs,
    )
    xr.testing.assert_identical(response, plain)
    assert dict(response.sizes) == dict(plain.sizes)
    assert set(response.xindexes) == set(plain.xindexes) == {"time", "hinge"}
    assert response.indexes["hinge"].equals(plain.indexes["hinge"])
    assert float(response["moment"].sel(hinge="hit", time=0.5)) == 1.0
    response["hinge"].attrs["units"] = "changed"
    assert (
        build_response(values, time=[0.0, 0.5], hinges=hinges)["hinge"].attrs["units"] != "changed"
    )


@pytest.mark.parametrize(
    ("values", "named"),
    [
        ({"displacement": [0.0, 1.0, 2.0]}, "coordinates"),
        ({"moment": np.ones((2, 2)), "displacement": [0.0, 1.0]}, "coordinates"),
        ({"displacement": [0.0, 1.0], "velocity": [0.0]}, "velocity"),
        ({"velocity": 1.0}, "velocity"),
    ],
)
def test_shapes_that_do_not_belong_together_are_refused(values: Any, named: str) -> None:
    with pytest.raises(ValueError, match=named):
        build_response(values, time=[0.0, 1.0], hinges=("base", "hit", "head"))


@pytest.mark.parametrize("steps", [3, 2000])
@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf])
def test_numbers_that_are_none_are_found_in_any_layout(steps: int, wrong: float) -> None:
    time, moment = np.linspace(0.0, 1.0, steps), np.ones((steps, 2))
    for values in (moment.T, moment.T.copy()):
        response = build_response({"moment": values}, time=time, hinges=("base", "head"))
        check_response(response)
        response["moment"].values[1, -1] = wrong
        with pytest.raises(WorkbenchError, match="'moment' holds numbers that are not finite"):
            check_response(response)


def test_contract_violations_are_found() -> None:
    good = build_response({"displacement": [0.0, 1.0]}, time=[0.0, 1.0])
    check_response(good)
    with pytest.raises(WorkbenchError, match="not finite"):
        check_response(build_response({"displacement": [0.0, np.nan]}, time=[0.0, 1.0]))
    for time in ([1.0, 1.0], [0.0, np.nan], [0.0, np.inf]):
        with pytest.raises(WorkbenchError, match="does not increase"):
            check_response(build_response({"displacement": [0.0, 1.0]}, time=time))
    with pytest.raises(WorkbenchError, match="does not increase"):
        build_response({"displacement": [0.0, 2.0, 1.0]}, time=[0.0, 1.0, 1.0])
    stranger = good.assign(colour=("time", [0.0, 1.0]))
    with pytest.raises(WorkbenchError, match="colour"):
        check_response(stranger)
    bare = good.copy()
    bare["displacement"].attrs.clear()
    with pytest.raises(WorkbenchError, match="lacks units"):
        check_response(bare)


def test_unknown_variables_cannot_be_built_and_unknown_quantities_are_absent() -> None:
    with pytest.raises(KeyError):
        build_response({"colour": 1.0})
    assert "impulse" not in build_response({"impulse": None, "peak_force": 3.0})


def test_snapshots_of_a_frame_have_their_coordinates() -> None:
    members, hinges = ["A0-A1", "A1-B1"], ["A0-A1:start", "A0-A1:end"]
    response = build_response(
        {
            "load_factor": [0.0, 1.0, 2.0, 1.5],
            "snapshot_at": [0.0, 2.0, 3.0],
            "shape_x": np.zeros((2, 9, 3)),
            "shape_y": np.ones((2, 9, 3)),
            "utilisation": np.full((2, 3), 0.5),
            "shear_utilisation": [0.1, 0.2],
        },
        steps=4,
        hinges=hinges,
        segments=members,
        members=members,
    )
    check_response(response)
    assert response["load_factor"].dims == ("step",)
    assert response["shape_x"].dims == ("member", "point", "snapshot")
    assert list(response["point"].values) == pytest.approx(np.arange(9) / 8.0)
    assert list(response["snapshot"].values) == [0, 1, 2]
    assert list(response["member"].values) == members
    assert response["utilisation"].sel(hinge="A0-A1:end").sizes == {"snapshot": 3}
    assert {"member", "point", "snapshot"}.isdisjoint(
        build_response({"force": [1.0]}, steps=1).dims
    )
    with pytest.raises(ValueError, match="snapshot"):
        build_response({"snapshot_at": [0.0, 1.0], "utilisation": np.zeros((1, 3))}, hinges=["a"])


def test_states_of_hinges_and_storeys_imply_their_extremes_and_places() -> None:
    response = build_response(
        {
            "axial_force": [[-2e5, 1e4, 0.0], [-1e5, -5e5, 3e4]],
            "plastic_rotation": [[0.0, 0.01, 0.01], [0.0, -0.02, -0.03]],
            "drift": [0.01, 0.004],
        },
        time=[0.0, 0.1, 0.2],
        hinges=["foot", "top"],
        uprights=["left", "right"],
    )
    check_response(response)
    values = {name: float(response[name]) for name in response.data_vars if "largest" in str(name)}
    assert values == {
        "largest_drift": 0.01,
        "largest_plastic_rotation": 0.03,
        "largest_compression": 5e5,
        "largest_tension": 3e4,
    }
    assert places_of(response) == {
        "largest_drift": "left",
        "largest_plastic_rotation": "top",
        "largest_compression": "top",
        "largest_tension": "top",
    }
    elastic = build_response({"plastic_rotation": [[0.0, 0.0]]}, steps=2, hinges=["foot"])
    assert places_of(elastic) == {}


def test_an_extreme_over_time_alone_has_no_place(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(EXTREMES, "largest_drift", ("velocity", (1,)))
    response = build_response({"velocity": [0.0, 2.0, 1.0]}, time=[0.0, 0.1, 0.2])
    assert response["largest_drift"] == 2.0
    assert places_of(response) == {}


@pytest.mark.parametrize("outcome", list(Outcome))
def test_every_outcome_says_what_to_do(outcome: Outcome) -> None:
    response = failed_response(outcome, "reason")
    assert outcome_of(response) is outcome
    assert response.attrs["message"] == f"reason. {outcome.advice}"
    assert outcome.advice.endswith(".")


def test_histories_imply_their_scalars_and_what_a_model_gives_itself_counts() -> None:
    time = np.linspace(0.0, 1.0, 201)
    displacement, percussion = np.sin(np.pi * np.minimum(time, 0.6)), np.full(201, 0.5)
    histories = {"displacement": displacement, "percussion": percussion}
    response = build_response(histories, time=time)
    assert response["peak_displacement"].item() == pytest.approx(1.0, abs=1e-12)
    assert response["time_of_peak"].item() == pytest.approx(0.5, abs=1e-12)
    assert response["impulse"].item() == pytest.approx(100.5)
    assert response["peak_force"].item() == pytest.approx(0.5 * 200.0)
    assert "residual_displacement" not in response  # no whole cycle
    given = build_response({**histories, "impulse": 7.0, "peak_force": None}, time=time)
    assert given["impulse"].item() == 7.0
    assert "peak_force" not in given
    growing = build_response({**histories, "displacement": time}, time=time)
    assert "peak_displacement" not in growing
    (finding,) = findings_of(growing)
    assert (finding.subject, finding.refusal) == ("no-peak", False)
    assert finding.remedy == "extend time.duration to find the peak"
    push = build_response({"displacement": [0.0, 1.0], "force": [0.0, 2.0]}, steps=2)
    assert set(push.data_vars) == {"displacement", "force"}


def test_energies_imply_how_far_their_balance_is_open() -> None:
    loss, dead = np.array([0.0, 2.0, 2.0]), np.array([0.0, 0.5, 1.0])
    energies = {
        "kinetic": np.array([10.0, 5.0, 1.0]),
        "elastic": np.array([3.0, 5.5, 4.0]),
        "dissipated": np.array([0.0, 1.0, 7.0]),
        "external_work": dead,
        "contact_loss": loss,
    }
    blow = {"percussion": np.zeros(3), "input_energy": 10.0}
    response = build_response({**energies, **blow}, time=[0.0, 1.0, 2.0])
    assert response["balance_error"].values == pytest.approx([0.0, 0.0, 0.0])
    # without a striker the work of loads and ground is all that comes in
    shaken = build_response({**energies, "input_energy": 1.0}, time=[0.0, 1.0, 2.0])
    assert shaken["balance_error"].values == pytest.approx([-10.0, -10.0, -10.0])
    static = {name: energies[name] for name in ("elastic", "dissipated", "external_work")}
    pushed = build_response(static, steps=3)["balance_error"].values
    assert pushed == pytest.approx(dead - (energies["elastic"] - 3.0) - energies["dissipated"])
    del static["external_work"]
    assert "balance_error" not in build_response(static, steps=3)


@pytest.mark.parametrize(
    ("given", "stored", "share"),
    [
        (10.0, 0.0, 0.2),
        (10.0, 5e3, 0.2),  # a ten-thousandth of what the dead loads store is less
        (0.1, 1e5, 0.2),  # and more
    ],
)
def test_an_imbalance_counts_over_the_blow_whatever_dead_loads_store(given, stored, share) -> None:
    for sign in (-1.0, 1.0):
        assert open_share(sign * np.array([0.0, 2.0, 1.0]), given, stored) == pytest.approx(share)


def test_findings_stay_data_whatever_their_sentences_hold() -> None:
    findings = [
        Finding("shear", "V/Vpl = 1.79; webs yield: first", remedy="take another", number=1.79),
        Finding("buckling", 'it "buckles"', refusal=True),
    ]
    response = failed_response(Outcome.OUT_OF_DOMAIN, "two reasons", findings)
    assert findings_of(response) == findings
    assert warnings_of(response) == findings[:1]
    assert str(findings[0]) == "V/Vpl = 1.79; webs yield: first: take another"
    set_findings(response, findings[1:])
    assert findings_of(response) == findings[1:]
