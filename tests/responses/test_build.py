"""Reductions of histories to scalars against closed forms; the response contract."""

from __future__ import annotations

import numpy as np
import pytest

from workbench.errors import WorkbenchError
from workbench.responses import (
    build_response,
    check_response,
    failed_response,
    outcome_of,
    peak_contact_force,
    peak_of,
    residual_of,
)
from workbench.responses.outcome import Outcome


def test_peak_between_samples_is_that_of_the_parabola() -> None:
    time = np.linspace(0.0, 1.0, 12)
    peak = peak_of(time, 3.0 - (time - 0.4321) ** 2)
    assert peak["peak_displacement"] == pytest.approx(3.0, abs=1e-12)
    assert peak["time_of_peak"] == pytest.approx(0.4321, abs=1e-12)


def test_a_growing_record_has_no_peak() -> None:
    assert peak_of(np.arange(5.0), np.arange(5.0)) == {}


def test_residual_is_the_mean_of_whole_cycles() -> None:
    time = np.linspace(0.0, 1.0, 5001)
    rise = 0.5 * (1.0 - np.cos(np.pi * np.minimum(time / 0.2, 1.0)))
    swing = np.where(time > 0.2, 0.05 * (np.cos(40.0 * (time - 0.2)) - 1.0), 0.0)
    assert residual_of(time, rise + swing) == pytest.approx(0.95, abs=1e-4)


def test_residual_is_absent_without_a_whole_cycle() -> None:
    time = np.linspace(0.0, 0.3, 301)
    assert residual_of(time, np.sin(np.pi * time / 0.4)) is None


def test_contact_force_is_the_mean_over_a_millisecond() -> None:
    time = np.arange(1, 101) * 1e-4
    percussion = np.full(100, 50.0 * 1e-4)
    assert peak_contact_force(time, percussion) == pytest.approx(50.0, rel=1e-9)
    blow = np.zeros(100)
    blow[40] = 2.0
    assert peak_contact_force(time, blow) == pytest.approx(2.0 / 1e-3, rel=1e-9)


def test_contract_violations_are_found() -> None:
    good = build_response({"displacement": [0.0, 1.0]}, time=[0.0, 1.0])
    check_response(good)
    with pytest.raises(WorkbenchError, match="not finite"):
        check_response(build_response({"displacement": [0.0, np.nan]}, time=[0.0, 1.0]))
    with pytest.raises(WorkbenchError, match="does not increase"):
        check_response(build_response({"displacement": [0.0, 1.0]}, time=[1.0, 1.0]))
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


@pytest.mark.parametrize("outcome", list(Outcome))
def test_every_outcome_says_what_to_do(outcome: Outcome) -> None:
    response = failed_response(outcome, "reason")
    assert outcome_of(response) is outcome
    assert response.attrs["message"] == f"reason. {outcome.advice}"
    assert outcome.advice.endswith(".")
