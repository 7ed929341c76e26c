"""The corrected curve against its exact oracle, and the faults that its band must survive."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

from workbench.base.errors import InputError
from workbench.extras.uncertainty.critical_ratio import columns_of, learn
from workbench.extras.uncertainty.fragility_curve import (
    Population,
    fragility_curve,
    place_references,
)

# y ~ N(mean, spread), e = bias + bend t + scatter: F(u) is a normal distribution function
MEAN, SPREAD, BIAS, BEND, SCATTER = 2.7, 0.065, -0.02, 0.01, 0.015
PROBABILITIES = np.array([0.05, 0.2, 0.5, 0.8, 0.95])
WHOLE = np.linspace(0.02, 0.98, 97)


def exact(probabilities):
    width = np.hypot(SPREAD + BEND, SCATTER)
    return MEAN + BIAS + width * norm.ppf(probabilities)


def drawn(seed, samples=4096):
    random = np.random.default_rng(seed)
    z = random.standard_normal((samples, 3))
    y = MEAN + SPREAD * z[:, 0]
    scrambles, classes = np.arange(samples) % 16, np.zeros(samples, dtype=int)
    return random, Population(y, z, classes, scrambles)


def ratios_of(population, places, random):
    t = population.inputs[places, 0]
    return BIAS + BEND * t + SCATTER * random.standard_normal(len(places))


def within(curve, low, high, probabilities):
    u = exact(probabilities)
    below = np.interp(u, curve.log_velocity, low) <= probabilities
    return below & (probabilities <= np.interp(u, curve.log_velocity, high))


def covered(repetitions, count=25, treat=lambda curve, _: curve):
    pointwise, together = np.zeros(len(PROBABILITIES)), 0
    for seed in range(repetitions):
        random, population = drawn(seed)
        places = place_references(population, count, random.random())
        ratios = ratios_of(population, places, random)
        curve = treat(fragility_curve(population, places, ratios, random), seed)
        pointwise += within(curve, curve.low, curve.high, PROBABILITIES)
        together += within(curve, curve.low_all, curve.high_all, WHOLE).all()
    return pointwise / repetitions, together / repetitions


@pytest.mark.thorough
def test_band_holds_the_exact_curve():
    pointwise, together = covered(60)
    assert pointwise.min() >= 0.80
    assert 0.85 <= pointwise.mean() <= 0.99
    assert together >= 0.85


@pytest.mark.slow
def test_band_holds_the_exact_curve_in_200_repetitions():
    pointwise, together = covered(200)
    assert pointwise.min() >= 0.85
    assert pointwise.mean() <= 0.97
    assert together >= 0.90


@pytest.mark.thorough
def test_references_from_one_half_are_noticed_by_coverage():
    """The fault that the random places exclude: references below the median only."""
    misses = 0
    for seed in range(30):
        random, population = drawn(seed)
        order = np.argsort(population.log_velocity)[: len(population.log_velocity) // 8]
        places = random.choice(order, 25, replace=False)
        # a ratio that turns at the median cannot be seen from below it
        ratios = np.where(population.inputs[places, 0] > 0, 0.05, 0.0)
        ratios = ratios + 0.001 * random.standard_normal(25)
        curve = fragility_curve(population, places, ratios, random)
        u = MEAN + SPREAD * norm.ppf(0.8) + 0.05
        misses += not np.interp(u, curve.log_velocity, curve.low) <= 0.8
    assert misses >= 25


def test_constant_ratio_leaves_the_error_of_samples_only():
    random, population = drawn(1)
    places = place_references(population, 12, 0.3)
    curve = fragility_curve(population, places, np.full(12, 0.02), random, sampling=False)
    # what is left is a sample or two on either side: the curve is a staircase
    assert curve.half_width < 2.0 / len(population.log_velocity) + 1e-3
    assert curve.velocity(0.5)[1] == pytest.approx(
        np.median(population.log_velocity) + 0.02, abs=1e-3
    )


def test_unit_of_velocity_and_order_of_references_do_not_matter():
    random, population = drawn(2)
    places = place_references(population, 16, 0.3)
    ratios = ratios_of(population, places, random)

    def median(shift, order):
        moved = replace(population, log_velocity=population.log_velocity + shift)
        fresh = np.random.default_rng(5)
        return fragility_curve(moved, places[order], ratios[order], fresh).velocity(0.5)

    straight, turned = np.arange(16), np.arange(16)[::-1]
    known = np.array(median(0.0, straight))
    assert np.allclose(np.array(median(np.log(3.6), straight)) - np.log(3.6), known, atol=1e-9)
    assert np.allclose(median(0.0, turned), known, atol=2e-3)


def test_numerical_half_width_is_added_to_both_edges():
    random, population = drawn(3)
    places = place_references(population, 16, 0.3)
    curve = fragility_curve(population, places, ratios_of(population, places, random), random)
    wider = curve.widened(0.01)
    for p in (0.2, 0.5, 0.8):
        (low, middle, high), (least, same, most) = curve.velocity(p), wider.velocity(p)
        assert same == middle
        assert low - least == pytest.approx(0.01, abs=5e-4)
        assert most - high == pytest.approx(0.01, abs=5e-4)


def test_failed_references_widen_the_band_to_the_worst_case():
    random, population = drawn(4)
    places = place_references(population, 24, 0.3)
    ratios = ratios_of(population, places, random)
    held = fragility_curve(population, places, ratios, np.random.default_rng(1))
    open_ = fragility_curve(population, places, ratios, np.random.default_rng(1), failed=2)
    assert np.all(open_.low <= held.low + 1e-9)
    assert np.all(open_.high >= held.high - 1e-9)
    assert open_.half_width > held.half_width + 0.02


def test_samples_without_an_answer_are_above_the_upper_edge():
    random, population = drawn(5)
    silent = population.log_velocity.copy()
    silent[:205] = np.nan  # 5 %
    places = place_references(replace(population, log_velocity=silent), 16, 0.3)
    assert not np.isnan(silent[places]).any()
    ratios = ratios_of(population, places, random)
    curve = fragility_curve(
        replace(population, log_velocity=silent), places, ratios, np.random.default_rng(1)
    )
    assert curve.low[-1] <= 0.96
    assert curve.high[-1] == pytest.approx(1.0, abs=0.01)


def test_samples_that_never_reach_the_limit_bound_the_curve():
    random, population = drawn(6)
    never = population.log_velocity.copy()
    never[never > np.quantile(never, 0.7)] = np.inf
    given = replace(population, log_velocity=never)
    places = place_references(given, 16, 0.3)
    curve = fragility_curve(given, places, ratios_of(population, places, random), random)
    assert curve.median[-1] == pytest.approx(0.7, abs=0.02)


def test_places_are_nested_and_every_class_has_its_share():
    _, population = drawn(7)
    classes = (population.inputs[:, 1] > 1.5).astype(int)  # 7 %
    given = replace(population, classes=classes)
    few, many = place_references(given, 12, 0.4), place_references(given, 40, 0.4)
    assert len(set(many.tolist())) == 40
    assert classes[many].sum() >= 3
    assert classes[few].sum() >= 2


def test_classes_have_means_of_their_own():
    random, population = drawn(8)
    classes = (population.inputs[:, 1] > 1.0).astype(int)
    given = replace(population, classes=classes)
    places = place_references(given, 24, 0.4)
    ratios = -0.1 * classes[places] + 0.002 * random.standard_normal(24)
    curve = fragility_curve(given, places, ratios, random)
    truth = np.sort(population.log_velocity - 0.1 * classes)
    for p in (0.1, 0.5, 0.9):
        low, middle, high = curve.velocity(p)
        assert low <= np.quantile(truth, p) <= high
        assert middle == pytest.approx(np.quantile(truth, p), abs=0.01)


def test_posterior_is_that_of_least_squares_without_prior():
    random, population = drawn(9, 256)
    columns = columns_of(population.log_velocity, np.zeros((256, 0)), np.zeros(256, dtype=int))
    places = np.arange(0, 256, 8)
    ratios = 0.01 + 0.02 * columns.values[places, 1] + 1e-9 * random.standard_normal(32)
    posterior = learn(columns, places, ratios)
    assert posterior.mean[:2] == pytest.approx([0.01, 0.02], abs=1e-7)
    assert posterior.weights.sum() == pytest.approx(1.0)


@pytest.mark.parametrize("count", [0, 7])
def test_fewer_than_eight_references_are_refused(count):
    random, population = drawn(10, 256)
    with pytest.raises(InputError, match="references"):
        fragility_curve(population, np.arange(count), np.zeros(count), random)
