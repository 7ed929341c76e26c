"""Properties that every metric declares, generated from its fields, and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from builders import examples
from hypothesis import given
from hypothesis import strategies as st

from workbench.base.errors import InputError
from workbench.responses import Response, build_response
from workbench.study.assessment import METRICS, Metric, Scope, Swap
from workbench.study.assessment.metric import absolute_area, product_integral

QUANTITY = {Scope.HISTORY: "velocity", Scope.CURVE: "force"}
QUANTITY |= dict.fromkeys((Scope.SCALAR, Scope.RUN), "peak_displacement")
COMPARING = {name: metric for name, metric in METRICS.items() if metric.scope is not Scope.RUN}
metrics = pytest.mark.parametrize("metric", COMPARING.values(), ids=COMPARING)


def response(metric: Metric, seed: int, scale: float = 1.0, base: float = 1.0) -> Response:
    """A random response for a metric; `scale` acts on the quantity, `base` on its abscissa."""
    random = np.random.default_rng(seed)
    if metric.scope is Scope.SCALAR:
        return build_response({"peak_displacement": scale * random.uniform(0.1, 1.0)}, steps=0)
    count = int(random.integers(5, 40))
    start, end = random.uniform(0.0, 0.2), random.uniform(0.5, 1.0)
    x = start + (end - start) * np.concatenate([[0.0], np.cumsum(random.uniform(0.1, 1.0, count))])
    x = base * (start + (end - start) * (x - x[0]) / (x[-1] - x[0]))
    y = scale * (np.cumsum(random.uniform(-0.5, 1.0, count + 1)) + 0.5)
    if metric.scope is Scope.HISTORY:
        return build_response({"velocity": y}, time=x)
    return build_response({"force": y, "displacement": x}, steps=count + 1)


seeds = st.integers(0, 10_000)
factors = st.sampled_from([1e-9, 1e-3, 0.5, 7.0, 1e6, 1e9])


@metrics
@examples(25)
@given(seed=seeds)
def test_equal_inputs_give_the_perfect_value(metric, seed):
    one = response(metric, seed)
    assert metric(one, one, QUANTITY[metric.scope]) == pytest.approx(metric.perfect, abs=1e-12)


@metrics
@examples(25)
@given(seed=seeds, factor=factors)
def test_a_change_of_unit_scales_as_declared(metric, seed, factor):
    quantity = QUANTITY[metric.scope]
    value = metric(response(metric, seed), response(metric, seed + 1), quantity)
    scaled = metric(response(metric, seed, factor), response(metric, seed + 1, factor), quantity)
    assert scaled == pytest.approx(value * factor**metric.unit_power, rel=1e-7, abs=1e-9)


@metrics
@examples(25)
@given(seed=seeds, factor=factors)
def test_the_unit_of_the_abscissa_does_not_matter(metric, seed, factor):
    quantity = QUANTITY[metric.scope]
    value = metric(response(metric, seed), response(metric, seed + 1), quantity)
    rescaled = metric(
        response(metric, seed, base=factor), response(metric, seed + 1, base=factor), quantity
    )
    assert rescaled == pytest.approx(value, rel=1e-7, abs=1e-9)


@metrics
@examples(40)
@given(seed=seeds, factor=st.sampled_from([-1.0, 1e-6, 1.0, 1e3]))
def test_values_stay_in_the_declared_range(metric, seed, factor):
    one, other = response(metric, seed, factor), response(metric, seed + 1)
    try:
        value = metric(one, other, QUANTITY[metric.scope])
    except InputError:
        assert metric.name == "log_ratio"
        assert factor < 0.0
        return
    assert metric.low <= value <= metric.high


@metrics
@examples(25)
@given(seed=seeds)
def test_swapping_sides_does_what_is_declared(metric, seed):
    quantity = QUANTITY[metric.scope]
    one, other = response(metric, seed), response(metric, seed + 1)
    there, back = metric(one, other, quantity), metric(other, one, quantity)
    if metric.swap is Swap.SAME:
        assert back == pytest.approx(there, rel=1e-9)
    elif metric.swap is Swap.OPPOSITE:
        assert back == pytest.approx(-there, rel=1e-9)


@metrics
def test_a_worse_answer_is_farther_from_perfect(metric):
    quantity = QUANTITY[metric.scope]
    reference = response(metric, 3)
    near, far = reference.copy(deep=True), reference.copy(deep=True)
    shape = np.linspace(1.0, 2.0, reference[quantity].size) if reference[quantity].ndim else 1.0
    near[quantity] = reference[quantity] * (1.0 + 0.05 * shape)
    far[quantity] = reference[quantity] * (1.0 + 0.20 * shape)
    distances = [abs(metric(r, reference, quantity) - metric.perfect) for r in (near, far)]
    assert 0.0 < distances[0] < distances[1]


@metrics
def test_an_absent_quantity_is_named(metric):
    empty = build_response({}, steps=0)
    with pytest.raises(InputError, match=QUANTITY[metric.scope]):
        metric(empty, response(metric, 0), QUANTITY[metric.scope])


def test_names_are_keys_and_meanings_are_given():
    for name, metric in METRICS.items():
        assert name == metric.name
        assert metric.title
        assert metric.meaning
        assert metric.citation


def sine(phase: float, gain: float, points: int = 4001) -> Response:
    time = np.linspace(0.0, 1.0, points)
    return build_response({"velocity": gain * np.sin(2 * np.pi * time + phase)}, time=time)


def ramp(start: float, end: float) -> Response:
    return build_response({"velocity": [start, end]}, time=[0.0, 1.0])


def curve(x, y) -> Response:
    return build_response({"displacement": x, "force": y}, steps=len(x))


def number(value: float, **attributes: object) -> Response:
    return build_response({"peak_displacement": value}, steps=0).assign_attrs(attributes)


LEVEL, TILTED = curve([0.0, 1.0], [1.0, 1.0]), curve([0.0, 0.5, 1.0], [0.8, 1.0, 1.2])
WIDTHS = {"numerical_uncertainty": '{"peak_displacement": 0.01}'}
SINES, HIGHER = (sine(0.3, 1.2), sine(0.0, 1.0)), (ramp(0.5, 3.5), ramp(0.0, 2.0))
# name, both sides, what they are, value by hand
BY_HAND = (
    ("difference", number(0.324), number(0.32), "0.324 and 0.320", 0.004),
    ("relative_error", number(0.324), number(0.32), "0.324 and 0.320", 0.0125),
    ("log_ratio", number(1.0), number(4.0), "1 and 4: -2 ln 2", -1.3862943611),
    ("shortfall", number(0.0, yield_ratio=0.998), number(0.0), "a share of 0.998", 0.002),
    ("relative_uncertainty", number(-0.25, **WIDTHS), number(0.0), "-0.25 +- 0.01", 0.04),
    ("sprague_geers_magnitude", *SINES, "sines 1.2 to 1 and 0.3 rad apart", 0.2),
    ("sprague_geers_phase", *SINES, "sines 0.3 rad apart: 0.3 / pi", 0.0954929659),
    ("sprague_geers_phase", sine(np.pi, 1.0), sine(0.0, 1.0), "opposite sines", 1.0),
    # root of 0.04 + 0.09 / pi^2
    ("sprague_geers_comprehensive", *SINES, "sines 1.2 to 1, 0.3 rad apart", 0.2216278559),
    # 0.5 + t over the peak 2 of the reference: 1 / 2, and sqrt(1 / 12) / 2
    ("residual_mean", *HIGHER, "lines 0.5 + 3 t and 2 t", 0.5),
    ("residual_deviation", *HIGHER, "lines 0.5 + 3 t and 2 t", 0.1443375673),
    ("area_difference", TILTED, LEVEL, "0.8 to 1.2 across a level 1: two triangles", 0.1),
    ("work_difference", curve([0.0, 1.0], [0.8, 1.6]), LEVEL, "0.8 to 1.6 over a level 1", 0.2),
    # a rise of 4 over a width of 2, shifted up by 1: a quarter of the rise everywhere
    ("arc_length_distance", curve([0.0, 2.0], [1.0, 5.0]), curve([0.0, 2.0], [0.0, 4.0]),
     "a line shifted by a quarter of its rise", 0.25),
)  # fmt: skip


@pytest.mark.claim("metric:{name}", "{what}", "closed form", "{expected}", "1e-9")
@pytest.mark.parametrize(("name", "one", "other", "what", "expected"), BY_HAND)
def test_metrics_by_hand(claim, name, one, other, what, expected):
    quantity = "yield_ratio" if name == "shortfall" else QUANTITY[METRICS[name].scope]
    claim(METRICS[name](one, other, quantity))


def test_histories_are_compared_where_both_are_known():
    long = build_response({"velocity": [1.0, 1.0, 9.0]}, time=[0.0, 1.0, 2.0])
    short = build_response({"velocity": [1.0, 1.0]}, time=[0.0, 1.0])
    assert METRICS["sprague_geers_comprehensive"](long, short, "velocity") == 0.0
    late = build_response({"velocity": [1.0, 1.0]}, time=[3.0, 4.0])
    with pytest.raises(InputError, match="overlap"):
        METRICS["residual_mean"](late, short, "velocity")


def test_product_integral_is_exact_for_linear_functions():
    time = np.array([0.0, 0.3, 1.0])
    assert product_integral(time, time, 1.0 - time) == pytest.approx(1.0 / 6.0, rel=1e-14)


def test_absolute_area_counts_both_sides_of_a_crossing():
    assert absolute_area(np.array([0.0, 1.0]), np.array([-1.0, 1.0])) == pytest.approx(0.5)
    assert absolute_area(np.array([0.0, 1.0]), np.array([0.0, 0.0])) == 0.0


def test_curves_that_cross_have_no_work_between_them():
    assert METRICS["work_difference"](TILTED, LEVEL, "force") == pytest.approx(0.0, abs=1e-15)


def test_curves_are_compared_over_the_common_range():
    short, long = curve([0.0, 1.0], [0.0, 1.0]), curve([0.0, 1.0, 2.0], [0.0, 1.0, 50.0])
    for name in ("area_difference", "work_difference", "arc_length_distance"):
        assert METRICS[name](long, short, "force") == pytest.approx(0.0, abs=1e-12)


def test_a_curve_that_turns_back_is_refused_by_area_but_not_by_arc_length():
    back = curve([0.0, 1.0, 0.5], [0.0, 1.0, 0.0])
    with pytest.raises(InputError, match="increase"):
        METRICS["area_difference"](back, back, "force")
    assert METRICS["arc_length_distance"](back, back, "force") == 0.0


def test_relative_error_needs_a_reference_that_is_not_zero():
    zero, one = (build_response({"impulse": value}, steps=0) for value in (0.0, 1.0))
    with pytest.raises(InputError, match="zero"):
        METRICS["relative_error"](one, zero, "impulse")
    assert METRICS["relative_error"](zero, one, "impulse") == -1.0


def test_the_shortfall_of_a_number_about_the_run():
    run = build_response({"peak_displacement": 0.25}, steps=0)
    metric = METRICS["shortfall"]
    assert metric(run, run, "peak_displacement") == 0.75
    for absent in ("impulse", "outcome"):
        with pytest.raises(InputError, match=absent):
            metric(run, run, absent)


def test_the_relative_uncertainty_of_a_run():
    run = build_response({"peak_displacement": -0.25, "impulse": 2.0}, steps=0)
    run.attrs["numerical_uncertainty"] = '{"peak_displacement": 0.01, "impulse": null}'
    metric = METRICS["relative_uncertainty"]
    for unknown in ("impulse", "peak_force"):
        with pytest.raises(InputError, match=unknown):
            metric(run, run, unknown)
