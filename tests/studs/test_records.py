"""Records of the machine: load cycles and falling branches are told apart from the first loading.

Right values: the parameters that the curves were made with, and the fit of the same curves without
the cycles, or with their falling branch labelled.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from workbench.studs import POINTS
from workbench.studs.load_slip import LoadSlipFit, OllgaardLaw, fit_load_slip
from workbench.studs.schema import from_frame
from workbench.studs.tables import recorded

LAW = OllgaardLaw(900.0, 0.55)
RISE = np.array([0.02, 0.06, 0.12, 0.25, 1.0, 1.5, 2.0, 3.0, 4.5, 7.0])  # mm


def loaded(load: float) -> list[tuple[float, float]]:
    """First loading: slips (mm) and loads (kN)."""
    return [(s, load * float(LAW.ratio(1e-3 * s))) for s in RISE]


def cycled(load: float, count: int = 25, drift: float = 0.001) -> list[tuple[float, float]]:
    """The same with cycles of EN 1994-1-1 B.2.4 from the fourth point, 40 % of the load, to 5 %."""
    points = loaded(load)
    slip, top = points[3]
    loop = [(slip - 0.06, 0.05 * load), (slip - 0.02, 0.6 * top), (slip, top)]
    loops = [(s + k * drift, q) for k in range(count) for s, q in loop]
    return [*points[:4], *loops, *points[4:]]


def falling(load: float) -> list[tuple[float, float]]:
    """The same with what follows the largest load, and an unloading at the end."""
    return [*loaded(load), (8.0, 0.9 * load), (10.0, 0.6 * load), (12.0, 0.4 * load), (11.8, 0.0)]


def table(record, **more: object) -> pd.DataFrame:
    rows = [
        {"campaign": "lab", "specimen": f"S{k}", "slip_mm": s, "load_kN": q, **more}
        for k, load in enumerate((100.0, 104.0, 97.0, 110.0))
        for s, q in record(load)
    ]
    return from_frame(pd.DataFrame(rows), POINTS)


def findings(fit: LoadSlipFit) -> str:
    return " ".join(map(str, fit.findings))


@pytest.mark.parametrize("labels", [{}, {"branch": "ascending"}])
def test_load_cycles_are_not_first_loading(labels: dict[str, str]) -> None:
    fit, whole = fit_load_slip(table(cycled, **labels)), fit_load_slip(table(loaded))
    assert fit.medians == pytest.approx({"rate": 900.0, "exponent": 0.55}, rel=1e-2)
    assert fit.medians == pytest.approx(whole.medians, rel=1e-9)
    assert "300 points of 4 curves are unloading and reloading" in findings(fit)
    assert "points of" not in findings(whole)


@pytest.mark.parametrize("law", ["ollgaard", "bilinear", "rational"])
def test_the_law_of_a_rise_is_fitted_to_the_rise(law: str) -> None:
    fit, whole = fit_load_slip(table(falling), law), fit_load_slip(table(loaded), law)
    if law == "rational":  # it knows a falling branch
        assert fit.medians["peak_slip"] < whole.medians["peak_slip"]
        assert fit.rows["points"].tolist() == [13] * 4
    else:
        assert fit.medians == pytest.approx(whole.medians, rel=1e-9)
    assert "12 points of 4 curves without a branch follow the largest load" in findings(fit)
    assert "4 points of 4 curves are unloading" in findings(fit)


def test_noise_and_a_dip_with_growing_slip_are_first_loading() -> None:
    """A pop-in loses load while the slip grows: nothing was unloaded there."""
    dip = [(0.1, 40.0), (0.5, 60.0), (0.6, 50.0), (0.9, 70.0), (0.89, 69.5), (1.4, 80.0)]
    rows = recorded(table(lambda load: dip))
    assert (rows["branch"] == "").all()


def test_labels_of_the_source_are_kept(curves: pd.DataFrame) -> None:
    """Points of a digitised curve stand after its peak in the shipped table, labelled ascending."""
    rows = recorded(curves)
    assert (rows["branch"] == curves["branch"][rows.index]).all()
