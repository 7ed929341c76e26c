"""How well tests after pre-damage support a residual capacity, and what is to be said of them."""

from collections.abc import Iterator
from enum import StrEnum

import pandas as pd

from workbench.responses import Finding
from workbench.studs.fit_protocol import Fitted, prior_findings
from workbench.studs.relations import Relation
from workbench.studs.schema import PREDICTED
from workbench.studs.statistics.mixture import LEAST_CAMPAIGNS, TAU, Priors

ONSET_OF_FATIGUE_LOSS = 0.15  # share of life; Hanswille, Porsch and Ustundag 2007, abstract


class Grade(StrEnum):
    """How well a residual capacity is supported, from weakest to strongest."""

    MECHANICAL = "mechanical prediction, not validated by tests after pre-damage"
    SYNTHETIC = "exercise on synthetic rows: shows the method, is no evidence"
    NARROW = "fitted to tests whose damage hardly varies: supports no relation"
    ONE_CAMPAIGN = "fitted to tests after pre-damage of one campaign, not validated on others"
    PREDICTED = "fitted to tests after pre-damage over predicted, not measured, undamaged strengths"
    TWO_CAMPAIGNS = "fitted to tests after pre-damage of two campaigns, too few to validate it"
    CROSS_VALIDATED = "fitted to tests after pre-damage, cross-validated over campaigns"


LEAST_RANGE = 0.25  # of damage, over which a relation may be called validated


def grade_of(rows: pd.DataFrame, quantity: str) -> Grade:
    """The grade of tests after pre-damage (with `level`)."""
    if (rows["origin"] == "synthetic").any():
        return Grade.SYNTHETIC
    campaigns, levels = rows["campaign"].nunique(), rows["level"]
    if levels.max() < LEAST_RANGE or levels.nunique() < 2:
        return Grade.NARROW
    if quantity == "strength" and (rows["undamaged_basis"] == PREDICTED).any():
        return Grade.PREDICTED
    few = {1: Grade.ONE_CAMPAIGN, 2: Grade.TWO_CAMPAIGNS}
    return few.get(campaigns, Grade.CROSS_VALIDATED)


def residual_findings(
    rows: pd.DataFrame, found: Fitted, relation: Relation, priors: Priors
) -> Iterator[Finding]:
    """What is to be said of a fit to tests after pre-damage."""
    synthetic = int((rows["origin"] == "synthetic").sum())
    if synthetic:
        yield Finding("evidence", f"{synthetic} of {len(rows)} rows are synthetic")
    campaigns = rows["campaign"].nunique()
    yield from prior_findings(priors)
    if campaigns < LEAST_CAMPAIGNS and TAU in priors:
        text = "bands rest on the prior of the scatter between campaigns"
        yield Finding("campaigns", f"{campaigns} of {LEAST_CAMPAIGNS} campaigns: {text}")
    elif campaigns < LEAST_CAMPAIGNS:
        text = (
            f"{campaigns} of {LEAST_CAMPAIGNS} campaigns do not tell how much campaigns differ: no "
            "characteristic or design value and no band for a new one; intervals lack that scatter"
        )
        if campaigns == 1:
            text += "; candidates were weighed by leaving out specimens, not campaigns"
        remedy = "give that scatter: --prior tau=MEDIAN:SPREAD, in shares; SPREAD of its logarithm"
        yield Finding("campaigns", text, remedy=remedy)
    if found.at_bound:
        yield Finding("bounds", f"parameters on a bound: {', '.join(found.at_bound)}")
    left = float(relation(ONSET_OF_FATIGUE_LOSS, list(found.estimates.values())))
    if rows["predamage"].iloc[0] == "fatigue" and left >= 1.0:
        text = "no loss at 15 % of the fatigue life contradicts Hanswille, Porsch and Ustundag"
        yield Finding("fatigue", f"{text} (2007)")
