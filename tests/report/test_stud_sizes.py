"""Pictures of several stud sizes have room for every panel, title and grade."""

from __future__ import annotations

import warnings

import numpy as np
import pandas as pd
import pytest

from workbench.report.drawing.sheet import drawn
from workbench.report.figures import plot_of
from workbench.studs.fit_protocol import Tables

LEAST = 1.8, 1.3  # inches: of a panel in which a curve and the grade are read
GRADE = "mechanical prediction, not validated by tests after pre-damage"


def answer(quantity: str, stud: str, validated: bool = False) -> Tables:
    level = np.linspace(0.0, 1.0, 21)
    band = {"left": 1.0 - 0.16 * level, "low": 1.0 - 0.36 * level, "high": 1.0 - 0.06 * level}
    curve = pd.DataFrame({"level": level, **band, "extrapolated": False})
    fit = {"quantity": quantity, "stud": stud, "grade": GRADE, "holds": "", "tests": 0}
    fit |= {"predamage": "pull-out", "measure": "displacement ratio", "validated": validated}
    return {"fit": pd.DataFrame([fit]), "curve": curve}


def studs(count: int) -> list[str]:
    return [f"{d} x {5 * d} mm, f_c 31.2 MPa, f_u 472 MPa" for d in (13, 16, 19, 22)[:count]]


@pytest.mark.thorough
@pytest.mark.parametrize("measured", [False, True])
@pytest.mark.parametrize("count", [1, 2, 4])
def test_panels_keep_their_size(count: int, measured: bool) -> None:
    """With `measured`, tests tell the strength: one answer for all studs beside those of each."""
    answers = {f"stiffness, {stud}": answer("stiffness", stud) for stud in studs(count)}
    if measured:
        answers["strength"] = answer("strength", "", True)
    else:
        answers |= {f"strength, {stud}": answer("strength", stud) for stud in studs(count)}
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # such as "axes sizes collapsed to zero"
        canvas = drawn(plot_of("stud-guideline"), answers).canvas
        assert canvas is not None
        canvas.draw_without_rendering()
    page = canvas.bbox
    assert len(canvas.axes) == len(answers)
    for panel in canvas.axes:
        box = panel.get_window_extent()
        assert box.width / canvas.dpi >= LEAST[0]
        assert box.height / canvas.dpi >= LEAST[1]
        inside = [panel.title, panel._left_title, *panel.texts]
        for text in (each for each in inside if each.get_text()):
            frame = text.get_bbox_patch() or text
            extent = frame.get_window_extent()
            assert page.x0 <= extent.x0, text
            assert extent.x1 <= page.x1, text
            if text in panel.texts:  # the grade stays in its panel
                assert box.x0 <= extent.x0, text
                assert extent.x1 <= box.x1, text
