"""Tension and shear together: interaction laws and the mechanical model against tests."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from workbench.errors import InputError
from workbench.fields import Choice, checked
from workbench.responses import Finding
from workbench.scenarios.stud import StudTests
from workbench.studs.answers.common import Found, Split, StudModel
from workbench.studs.answers.mechanical import calibrated
from workbench.studs.fitting import judge
from workbench.studs.interaction import INTERACTIONS, combined_tests
from workbench.studs.mechanical import Stud, interaction_points
from workbench.studs.quantities import Array

MECHANICAL = "mechanical"
SHARES = (0.0, 0.25, 0.5, 0.75, 0.9, 0.95, 0.98)  # of the pull-out strength
SOURCES = {"five-thirds": ("aisc360-22",), "linear": (), "trilinear": ("aci318-19",)}
# two ways to fail under tension: the concrete cone of a usual stud, the shank of a deep slim one
STUDS = {"cone": (0.019, 0.1, 30e6, 450e6), "steel": (0.0127, 0.12, 60e6, 450e6)}


@dataclass(frozen=True)
class StudInteraction(StudModel):
    """Shear that is left under tension, both over what the stud bears alone.

    Options: `law`, a name in `workbench.studs.INTERACTIONS` or ``mechanical``; `governed`, for the
    mechanical model, whether cone or steel governs the pull-out of the stud that is computed.
    """

    law: str = checked(Choice((*INTERACTIONS, MECHANICAL)), "five-thirds")
    governed: str = checked(Choice(tuple(STUDS)), "cone")

    name: ClassVar[str] = "stud-interaction"
    asks: ClassVar[tuple[str, ...]] = ("interaction",)
    assumptions: ClassVar[tuple[str, ...]] = (
        "Tension and shear over the resistances of equal studs under one of them alone.",
        "Mechanical model: a constant tension on the flange during the push-out; the slip counts "
        "up to that at which the stud tears without tension.",
    )

    @property
    def sources(self) -> tuple[str, ...]:
        """Bibliography keys of the law."""
        return SOURCES.get(self.law, ())

    def find(self, scenario: StudTests, split: Split) -> Found:
        """The curve of the law, and how it meets combined tests."""
        content: dict[str, Any] = {}
        findings: tuple[Finding, ...] = ()
        if self.law == MECHANICAL:
            stud = Stud.of_concrete(*STUDS[self.governed])
            fit = calibrated(scenario)
            tension, shear = interaction_points(stud, fit.around, SHARES)
            size = f"{1e3 * stud.diameter:g} x {1e3 * stud.height:g} mm"
            content["stud"] = f"{size}, f_c {stud.concrete_strength / 1e6:g} MPa"
            findings = (Finding("evidence", fit.basis),)
        else:
            tension = np.linspace(0.0, 1.0, 101)
            shear = np.append(INTERACTIONS[self.law].shear_left(tension), 0.0)
            tension = np.append(tension, 1.0)
        held = not split.validation.empty
        tests = combined_tests(split.validation if held else split.calibration)
        content |= {"tension": tension, "shear": shear, "tests": tests}
        judged = None
        if held and not tests.empty:
            reached = np.hypot(tests["shear"], tests["tension"])
            judged = judge(tests, reached, _borne(tests, tension, shear), scenario.confidence)
            content["judgement"] = judged.to_dict()
        elif self.law != MECHANICAL:
            # a law of the books is drawn all the same; that nothing validates it is said
            text = "no combined test in the validating campaigns"
            findings = (Finding("evidence", text),)
        return Found(content, findings, judged, {"tests_fitted": 0.0})


def _borne(tests: pd.DataFrame, tension: Array, shear: Array) -> Array:
    """Distance (n,) of the curve from the origin in the direction of every test."""
    angle = np.arctan2(shear, tension)
    order = np.argsort(angle)
    radius = np.hypot(shear, tension)[order]
    wanted = np.arctan2(tests["shear"].to_numpy(float), tests["tension"].to_numpy(float))
    if wanted.min() < angle.min() - 1e-9 or wanted.max() > angle.max() + 1e-9:
        raise InputError("tests", float(wanted.min()), "lie outside the curve of the law")
    return np.interp(wanted, angle[order], radius)
