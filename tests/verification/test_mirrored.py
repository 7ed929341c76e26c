"""Mirrored input, mirrored answer: every model, every kind of scenario that can be mirrored.

The peak is the value of largest magnitude of a history, with its sign: what is turned round has the
same peak with the other sign.

Columns that are hit or pushed cannot be mirrored: a velocity and a push of a column are above 0 by
their fields, and the models that answer nothing else know no other way. The frame of such a column
can, from the other side. Studs and the impact problems of the laboratory have no sides.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import asdict, fields, replace
from typing import Any

import numpy as np
import pytest
from builders import portal
from test_registered_models import model_of

from workbench.api.accessor import headline
from workbench.base.errors import InputError
from workbench.extras.uncertainty.critical_velocity import Asked
from workbench.models import frame_model
from workbench.models.base import Model, make_model, model_kind, model_names
from workbench.responses import (
    Outcome,
    Response,
    build_response,
    outcome_of,
    scalars_of,
    warnings_of,
)
from workbench.responses.histories import largest_of
from workbench.scenarios import (
    Column,
    ColumnImpact,
    Frame,
    FrameGroundMotion,
    FrameImpact,
    FramePulse,
    FrameStatic,
    FrameStriker,
    Load,
    Member,
    MemberPulse,
    Node,
    Pulse,
    Striker,
)
from workbench.steel.sections import find
from workbench.study.assessment import METRICS, bias_and_scatter
from workbench.study.assessment.metric import ResponsePair
from workbench.study.error_model.error_model import ExpectedError

CLOSE = 1e-6  # of the peak; measured: at most 6e-10, of fibers in hinges
READ = ("published", "imported", "remote", "opensees")  # what is printed, or said elsewhere
# no more steps, fibers and bars than a side needs; steps by error are part of the test
QUICK = {"time_step": 1e-4, "layers": 6, "elements": 2}
BY_ERROR = ("rigid-superelement", "flexible-superelement", "single-dof", "biggs")
MIRRORED = ("peak_displacement", "residual_displacement")  # scalars with a sign
HEB = find("HEB 200")
# pushed one way first, then farther the other way: yields there
FACTORS = 0.0, 0.4, 0.0, -1.0, -1.0, 0.0
TIMES = 0.0, 0.001, 0.002, 0.003, 0.006, 0.007


def bent(sign: float) -> Frame:
    """A bent post under a dead load, without symmetry, or its mirror image (`sign` -1)."""
    nodes = (
        Node("foot", 0.0, 0.0, "clamped"),
        Node("hit", 0.0, 1.2, mass=800.0),
        Node("top", sign * 0.5, 2.2, "guide-y"),
    )
    members = Member("lower", "foot", "hit", HEB), Member("upper", "hit", "top", HEB)
    return Frame(nodes, members, loads=(Load("hit", x=sign * 2e4, y=-1e5),))


def table(sign: float) -> Pulse:
    return Pulse("table", 9e5, times=TIMES, factors=tuple(sign * f for f in FACTORS))


def point(sign: float) -> MemberPulse:
    return MemberPulse("pulse", Column(HEB, 1.2, 1.8, axial_load=2e5), table(sign), "point", 0.014)


def uniform(sign: float) -> MemberPulse:
    return replace(point(sign), pulse=replace(table(sign), peak=6e5), load="uniform")


def straight(sign: float) -> FrameImpact:
    """A column between a support and a beam, for the model that cuts it out."""
    frame = portal(section=HEB, loads=(Load("A1", x=sign * 2e4, y=-1e5),)).split(
        "A0-A1", 1.2, "hit"
    )
    turned = tuple(replace(node, x=sign * node.x) for node in frame.nodes)
    return replace(impact(sign), frame=replace(frame, nodes=turned), duration=0.03)


def impact(sign: float) -> FrameImpact:
    """Displacements are along the strike: the same answer from the other side."""
    striker = FrameStriker(300.0, 8.0, node="hit", direction="+x" if sign > 0.0 else "-x")
    return FrameImpact("hit", bent(sign), striker, 0.015)


def pulse(sign: float) -> FramePulse:
    loads = (Load("hit", x=1.0),)
    return FramePulse("pulse", bent(sign), table(sign), "hit", "+x", loads, duration=0.015)


def ground(sign: float) -> FrameGroundMotion:
    """The frame lags behind: against the ground it moves the other way, which is farther here."""
    shaken = tuple(sign * a for a in (0.0, -300.0, 0.0, 1000.0, 1000.0, 0.0))
    return FrameGroundMotion("shaken", bent(sign), shaken, 0.002, "hit", duration=0.02)


def push(sign: float) -> FrameStatic:
    """Back farther than there."""
    path = sign * 0.005, -sign * 0.01
    return FrameStatic("push", bent(sign), (Load("hit", x=1.0),), "hit", "x", path)


def load(sign: float) -> FrameStatic:
    """The same by load: displacements are the answer."""
    path = sign * 5.0, -sign * 20.0
    return replace(push(sign), loads=(Load("hit", x=1e4),), path=path, control="load")


SCENARIOS = {each.__name__: each for each in (point, impact, pulse, ground, push, load)}
LUMPED = {"point": point, "uniform": uniform, "straight": straight}  # of models that are no frames


def cases() -> Iterator[object]:
    for name in model_names():
        answered = () if name in READ else model_kind(name).answers
        kinds = SCENARIOS if FramePulse.KIND in answered else LUMPED
        for kind, make in kinds.items():
            if make(1.0).KIND in answered:
                yield pytest.param(name, make, id=f"{name} {kind}")


@pytest.fixture(autouse=True)
def few_load_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """Static paths in few load steps: both sides take the same ones."""
    monkeypatch.setattr(frame_model, "PUSH_STEPS", 60)


def quick(name: str) -> Model:
    """A registered model with few steps, fibers and bars."""
    model = model_of(name)
    if name in BY_ERROR:
        return model
    known = {field.name for field in fields(model)}
    return replace(model, **{key: value for key, value in QUICK.items() if key in known})


@pytest.mark.thorough
@pytest.mark.parametrize(("name", "make"), [*cases()])
def test_mirrored_input_has_the_mirrored_answer(name: str, make: Callable[[float], Any]) -> None:
    model, struck = quick(name), make in (impact, straight)
    one, other = (model.simulate(make(sign)) for sign in (1.0, -1.0))
    for response in (one, other):
        assert outcome_of(response) is Outcome.OK, response.attrs["message"]
    sign = 1.0 if struck else -1.0
    moved, back = one["displacement"].values, other["displacement"].values
    largest = largest_of(moved)
    assert back == pytest.approx(sign * moved, abs=CLOSE * abs(largest))
    for history in ("velocity", "force", "reaction"):
        if history in one:
            values, size = one[history].values, np.abs(one[history].values).max()
            assert other[history].values == pytest.approx(sign * values, abs=CLOSE * size), history
    assert (largest > 0.0) == struck  # back it goes farther than it began
    scalars, turned = scalars_of(one), scalars_of(other)
    assert scalars.keys() == turned.keys()
    for quantity, value in scalars.items():
        expected = sign * value if quantity in MIRRORED else value
        assert turned[quantity] == pytest.approx(expected, rel=CLOSE, abs=1e-9), quantity
    if make is not push:  # there the displacement is no answer
        assert scalars["peak_displacement"] == pytest.approx(largest, rel=5e-3)
    assert [f.subject for f in warnings_of(one)] == [f.subject for f in warnings_of(other)]


# -- users of a peak that is negative ----------------------------------------------------------


def test_a_push_to_the_other_side_tells_its_largest_force() -> None:
    """A cantilever against its pattern of loads: d / F = L^3 / 3EI + L / GA_w, A_w = 90 x 6 mm2."""
    post = find("HEB 100")
    nodes = Node("foot", 0.0, 0.0, "clamped"), Node("top", 0.0, 1.0)
    frame = Frame(nodes, (Member("post", "foot", "top", post),))
    pushed = FrameStatic("push", frame, (Load("top", x=1.0),), "top", "-x", (0.005,))
    response = make_model("rigid-superelement").simulate(pushed)
    force = -0.005 / (1.0 / (3.0 * 210e9 * post.second_moment) + 1.0 / (80.8e9 * 540e-6))
    assert largest_of(response["force"].values) == pytest.approx(force, rel=0.03)
    assert "largest force \u221213.3\u00a0kN" in headline(response)


def test_errors_and_bias_of_negative_peaks_are_those_of_positive_ones() -> None:
    one, other = (ResponsePair(sign * 5.0, sign * 4.0, "peak_displacement") for sign in (1.0, -1.0))
    for name in ("relative_error", "log_ratio"):
        assert METRICS[name].compute(one) == METRICS[name].compute(other) > 0.0
    model, data = np.array([5.0, 4.1, 3.0]), np.array([4.0, 4.0, 4.0])
    assert bias_and_scatter(-model, -data) == bias_and_scatter(model, data)
    with pytest.raises(InputError, match="one sign"):
        bias_and_scatter(model, -data)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_limits_ask_for_magnitudes_and_intervals_are_in_order(sign: float) -> None:
    time = np.linspace(0.0, 1.0, 101)
    response = build_response({"displacement": 0.2 * sign * np.sin(2.0 * time)}, time=time)

    class Swings:
        def simulate(self, scenario: object) -> Response:
            return response

    striker = ColumnImpact("hit", Column(HEB, 1.0, 1.0), Striker(1.0, 1.0))
    assert Asked(Swings(), striker).peak_at(0.0) == pytest.approx(0.2, rel=1e-4)
    error = ExpectedError("anchor", expected=0.0, low=-0.1, high=0.25, chance=0.1)
    attributes = {"model": "toy", "error": json.dumps(asdict(error))}
    text = headline(response.assign_attrs(attributes)).replace("\u2212", "-")
    assert ("160 to 222" if sign > 0.0 else "-222 to -160") in text
