"""How far the answer of a fit may be trusted: its grade, its findings by weight, its influences."""

from collections.abc import Iterable

import numpy as np
import pandas as pd

from workbench.responses import Finding
from workbench.studs.quantities import Array
from workbench.studs.statistics.influence import deleted_residuals, usual_distance
from workbench.studs.statistics.mixed import Estimate
from workbench.studs.statistics.mixture import LEAST_CAMPAIGNS

# subjects of findings: what may void an answer comes first, what hardly moves it last
_DECISIVE = (
    *("data", "evidence", "prior", "fatigue", "outlier", "stud", "tests", "campaigns", "shank"),
    *("range", "bounds", "points", "modulus", "measurement"),
)
_PLACES = {subject: place for place, subject in enumerate(_DECISIVE)}


def ranked(findings: Iterable[Finding]) -> list[Finding]:
    """Findings without repetitions, the decisive ones first."""
    others = _PLACES["bounds"]
    return sorted(dict.fromkeys(findings), key=lambda each: _PLACES.get(each.subject, others))


def grade_of(rows: pd.DataFrame, what: str, *, left_out: bool = False) -> str:
    """How well a fit to `what` is supported, by the campaigns of its rows.

    `left_out`: every campaign was predicted from the others.
    """
    if "origin" in rows and (rows["origin"] == "synthetic").any():
        return f"exercise on synthetic {what}: shows the method, is no evidence"
    campaigns = rows["campaign"].nunique()
    if campaigns == 1:
        return f"fitted to {what} of one campaign, not validated on others"
    if campaigns < LEAST_CAMPAIGNS:
        return f"fitted to {what} of two campaigns, too few to validate it"
    how = "cross-validated over campaigns" if left_out else "not cross-validated"
    return f"fitted to {what} of {campaigns} campaigns, {how}"


def influence_of(
    rows: pd.DataFrame, estimate: Estimate, answer: str, value: float, without: Array
) -> pd.DataFrame:
    """How every test moves an answer, one row each.

    Columns: campaign, specimen; `answer`, its name; `value` with all tests and `without` (n,) this
    one; `distance`, the deleted residual in standard deviations; `outlier`, whether that is more
    than chance explains.
    """
    distance = deleted_residuals(estimate)
    far = np.abs(distance) > usual_distance(estimate)
    told = rows[["campaign", "specimen"]].assign(answer=answer, value=value, without=without)
    return told.assign(distance=distance, outlier=far)
