"""Load-slip laws, stiffness, and the fit of curves."""

from __future__ import annotations

import contextlib
import json

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import least_squares

from workbench.base.errors import InputError, OutOfDomainError
from workbench.studs import (
    LAWS,
    BilinearLaw,
    OllgaardLaw,
    RationalLaw,
    fit_load_slip,
)
from workbench.studs.fit_protocol import plain
from workbench.studs.load_slip import (
    Law,
    ascending,
    chord_stiffness,
    fit_curve,
    law_kind,
    law_stiffness,
)
from workbench.studs.tables import curves_of, first_loading

SLIPS = np.linspace(0.0, 8e-3, 60)


@pytest.mark.claim("model:stud-load-slip", "load ratio at 0.2 in", "ollgaard1971", 0.989, 5e-4)
def test_published_ollgaard(claim) -> None:
    law = OllgaardLaw()
    assert law.rate == pytest.approx(708.66, rel=4.1e-6)  # measured 2.0e-6
    inch = 0.0254
    assert law.ratio(0.2 * inch) == pytest.approx((1.0 - np.exp(-3.6)) ** 0.4)
    claim(law.ratio(0.2 * inch))


# 18 x 0.05 in: (1 - exp(-0.9))^0.4; half the yield slip; half the peak slip with k = 5, D = 1/2
@pytest.mark.claim("load-slip:{name}", "load over the largest", "closed form", "{expected}", 1e-9)
@pytest.mark.parametrize(
    ("name", "slip", "expected"),
    [("ollgaard", 1.27e-3, 0.8116109517), ("bilinear", 0.25e-3, 0.5), ("rational", 3e-3, 19 / 21)],
)
def test_laws_by_hand(claim, name: str, slip: float, expected: float) -> None:
    claim(LAWS[name]().ratio(slip))


def test_bilinear_and_its_end() -> None:
    law = BilinearLaw()
    assert law.ratio([0.0, 0.25e-3, 0.5e-3, 6e-3, 6.001e-3]).tolist() == [0.0, 0.5, 1.0, 1.0, 0.0]
    with pytest.raises(InputError, match="slip_capacity"):
        BilinearLaw(1e-3, 0.5e-3)


@given(k=st.floats(1.5, 100.0), d=st.floats(0.0, 1.0))
def test_the_rational_law_has_its_only_maximum_at_the_peak(k: float, d: float) -> None:
    law = RationalLaw(5e-3, k, d)
    q = law.ratio(np.linspace(0.0, 0.05, 400))
    assert law.ratio(5e-3) == pytest.approx(1.0)
    assert np.max(q) <= 1.0 + 1e-12
    assert law.ratio(1e-12) / 1e-12 == pytest.approx(k / 5e-3, rel=4e-8)  # 2e-8 by k s / s_p
    assert law.ratio(0.02) < 1.0


@given(
    law=st.one_of(
        st.builds(OllgaardLaw, rate=st.floats(50, 5000), exponent=st.floats(0.2, 2.0)),
        st.builds(RationalLaw, peak_slip=st.floats(1e-3, 2e-2), stiffness_ratio=st.floats(1.1, 50),
                  softening=st.floats(0.0, 1.0)),
        st.builds(BilinearLaw, yield_slip=st.floats(1e-4, 2e-3)),
    ),
    q=st.floats(0.01, 0.99),
)  # fmt: skip
def test_slip_at_a_level_inverts_the_law(law, q: float) -> None:
    slip = law.slip_at(q)
    assert law.ratio(slip) == pytest.approx(q, rel=1e-6)
    assert law_stiffness(law, 100e3) > 0.0


@pytest.mark.parametrize("kind", LAWS.values(), ids=LAWS)
def test_every_law_rises_from_nothing_and_inverts(kind: type[Law]) -> None:
    law, levels = kind(), np.linspace(0.0, 0.95, 20)
    slips = np.array([law.slip_at(level) for level in levels])
    assert slips[0] == law.ratio(0.0) == 0.0
    assert np.all(np.diff(slips) > 0.0)
    np.testing.assert_allclose(law.ratio(slips), levels, rtol=1e-9)
    for name, bound in kind.bounds.items():
        assert bound.low <= bound.start <= bound.high
        assert hasattr(law, name)


def test_reversed_slips_are_outside() -> None:
    for kind in LAWS.values():
        with pytest.raises(OutOfDomainError, match="reversed loading"):
            kind().ratio([-1e-3])
        with pytest.raises(InputError):
            kind().slip_at(1.0)
    with pytest.raises(InputError, match="must be one of ollgaard"):
        law_kind("hyperbolic")


def test_chord_stiffness_of_a_known_curve() -> None:
    # straight pieces: 200 kN/mm to 20 kN, then 50 kN/mm to 50 kN and beyond
    slip = np.array([0.0, 0.1, 0.7, 1.7]) * 1e-3
    load = np.array([0.0, 20.0, 50.0, 100.0]) * 1e3
    # 10 kN at 0.05 mm, 40 kN at 0.5 mm
    assert chord_stiffness(slip, load) == pytest.approx(30e3 / 0.45e-3)
    assert np.isnan(chord_stiffness([0.0, 0.0, 1e-3], [0.0, 50e3, 100e3]))


def test_noise_loops_and_softening_drop_out_of_the_ascending_branch() -> None:
    s, q = ascending([1, 2, 3, 4, 5, 6], [10, 20, 15, 30, 25, 5])
    assert s.tolist() == [0, 1, 2, 4]
    assert q.tolist() == [0, 10, 20, 30]
    with pytest.raises(InputError, match="two or more points"):
        ascending([1.0], [1.0])
    with pytest.raises(InputError, match="positive load"):
        ascending([1.0, 2.0], [-1.0, 0.0])


def test_a_curve_made_by_a_law_is_found_again() -> None:
    slip = np.linspace(0.0, 0.012, 40)
    for law in (OllgaardLaw(900.0, 0.55), RationalLaw(6e-3, 8.0, 0.4)):
        fit = fit_curve(slip, 80e3 * law.ratio(slip) / np.max(law.ratio(slip)), law.name)
        assert fit.rms < 1.1e-4  # measured 5.5e-5
        assert not fit.near_interpolation
    exact = fit_curve(slip, RationalLaw(6e-3, 8.0, 0.4).ratio(slip), "rational")
    assert exact.parameters["stiffness_ratio"] == pytest.approx(8.0, rel=9e-5)  # measured 4.4e-5
    held = fit_curve(slip, RationalLaw(6e-3, 8.0, 0.4).ratio(slip), "rational",
                     held={"softening": 0.4})  # fmt: skip
    assert held.parameters["softening"] == 0.4
    bilinear = fit_curve(slip, BilinearLaw(2e-3, 0.012).ratio(slip), "bilinear")
    assert bilinear.parameters["yield_slip"] == pytest.approx(2e-3, rel=1e-8)  # measured: round-off


def test_a_robust_loss_is_not_led_by_an_outlier() -> None:
    slip = np.linspace(2e-4, 8e-3, 30)
    load = 100e3 * OllgaardLaw(900.0, 0.55).ratio(slip)
    load[4] *= 0.4
    plain, robust = (fit_curve(slip, load, loss=loss) for loss in ("linear", "soft_l1"))
    # measured 0.21
    assert abs(robust.parameters["exponent"] - 0.55) < 0.25 * abs(
        plain.parameters["exponent"] - 0.55
    )
    with pytest.raises(InputError, match="loss"):
        fit_curve(slip, load, loss="median")
    with pytest.raises(InputError, match="points or more"):
        fit_curve([1e-3], [1.0])


@pytest.mark.thorough
def test_population_counts_curves_not_points(curves: pd.DataFrame) -> None:
    fit = fit_load_slip(curves)
    assert len(fit.rows) == 24
    assert len(fit.skipped) == 4  # the noisy initial branches
    assert fit.summary()["campaigns"] == "lehigh279, mcgarraugh1971, provines2019"
    for result in fit.population.values():
        median = result.parameters["median"]
        assert median.low < median.value < median.high
    dense = curves[(curves["specimen"] == "P4") & (curves["use_for_fit"] == 1.0)]
    repeated = pd.concat([curves, dense, dense], ignore_index=True)
    again = fit_load_slip(repeated)
    assert again.medians["rate"] == pytest.approx(fit.medians["rate"], rel=1e-8)  # measured 4.0e-11
    json.dumps(plain(fit.tables()), allow_nan=False)


def test_band_holds_the_curves_it_was_made_of(curves: pd.DataFrame) -> None:
    fit = fit_load_slip(curves)
    low, high = fit.band(SLIPS, 0.9)
    assert np.all(low <= high)
    middle = fit.shape.ratio(SLIPS)
    assert np.all((middle >= low) & (middle <= high))


def test_what_is_left_out_is_covered_as_if_it_were_unseen(curves: pd.DataFrame) -> None:
    few = curves[curves["campaign"] != "provines2019"]
    fit = fit_load_slip(few, "bilinear")
    for kind, keys in (("curves", ["campaign", "specimen"]), ("campaigns", ["campaign"])):
        inside: list[float] = []
        for _, left in few.groupby(keys):
            rest = few.drop(left.index)
            with contextlib.suppress(InputError):  # a mean curve, or one of a single point
                rows = fit_load_slip(rest, "bilinear").judge(left).rows
                inside += rows.loc[rows["points"] >= 3, "inside"].tolist()
        assert fit.coverage[kind] == pytest.approx(np.mean(inside), rel=1e-9)
    alone = fit_load_slip(few[few["campaign"] == "lehigh279"], "bilinear")
    assert alone.coverage["campaigns"] is None


def test_rational_law_holds_what_ascending_curves_cannot_tell(curves: pd.DataFrame) -> None:
    fit = fit_load_slip(curves, "rational")
    assert fit.held == {"softening": 0.0}
    assert set(fit.population) == {"peak_slip", "stiffness_ratio"}


def test_doubtful_points_and_means_are_left_out(curves: pd.DataFrame) -> None:
    used = first_loading(curves, falling=True)
    assert not used["specimen"].str.startswith("MEAN").any()
    assert len(used) == 543 - 13 - 29 - 10
    with pytest.raises(InputError, match="hold no point"):
        first_loading(curves[curves["single_specimen"] == 0.0], falling=True)


def squares(law: str, start: np.ndarray, curve: tuple[np.ndarray, np.ndarray]) -> float:
    """Sum of squares of a law of logarithms of parameters, from one start down."""
    names = [name for name in LAWS[law].bounds if name not in LAWS[law].held]
    slip, ratio = curve

    def error(theta: np.ndarray) -> np.ndarray:
        values = {**dict(zip(names, np.exp(theta).tolist(), strict=True)), **LAWS[law].held}
        return LAWS[law].fitted(values, float(slip.max())).ratio(slip) - ratio

    low, high = (np.log([LAWS[law].bounds[name][k] for name in names]) for k in (0, 1))
    tight = {"xtol": 1e-10, "ftol": 1e-10, "gtol": 1e-10}
    begin = low + 1e-3 + start[: len(names)] * (high - low - 2e-3)
    return 2.0 * float(least_squares(error, begin, bounds=(low + 1e-9, high - 1e-9), **tight).cost)


def no_start_is_better(curves: pd.DataFrame, law: str, starts: int) -> None:
    generator, count = np.random.default_rng(27), 0
    for name, slip, load in curves_of(curves, falling=LAWS[law].falling):
        if len(slip) < 3:
            continue
        fit = fit_curve(slip, load, law, held=LAWS[law].held)
        curve, count = (np.maximum(slip, 0.0), load / load.max()), count + 1
        least = min(squares(law, start, curve) for start in generator.uniform(size=(starts, 2)))
        assert fit.points * fit.rms**2 <= least * (1.0 + 1e-6) + 1e-12, name
    assert count >= 24


@pytest.mark.thorough
@pytest.mark.parametrize("law", LAWS)
def test_no_other_start_finds_a_better_curve(curves: pd.DataFrame, law: str) -> None:
    no_start_is_better(curves, law, 2)


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
def test_no_start_of_fifty_finds_a_better_curve(curves: pd.DataFrame, law: str) -> None:
    no_start_is_better(curves, law, 50)
