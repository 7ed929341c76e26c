"""Whether a column that stood still with its strain rate still stands when it is at rest.

Overstress holds a column up only as long as it moves. Behind the displacement at which the static
strength no longer carries the axial load it creeps on, slowly at first, beyond the end of a record.
"""

from dataclasses import replace

from workbench.errors import OutOfDomainError
from workbench.models.resistance import column_curve
from workbench.responses import Finding, Outcome, Response, finding, outcome_of
from workbench.scenarios import ColumnImpact

REMAINING = ("residual_displacement", "displacement", "peak_displacement")


def creeping(scenario: object, response: Response) -> list[Finding]:
    """Return the finding of a column that stays where its static strength carries no axial load.

    Its analytic resistance with the static yield stress is lost at a smaller displacement (m) than
    the one that remains, or, where that is not known, the last one or the peak.
    """
    if not isinstance(scenario, ColumnImpact) or outcome_of(response) is not Outcome.OK:
        return []
    column = scenario.column
    if column.steel.rate is None or column.axial_load == 0.0:
        return []
    known = (name for name in REMAINING if name in response)
    remaining = float(response[next(known)].values.reshape(-1)[-1])
    static = replace(column, steel=replace(column.steel, rate=None))
    try:
        limit = column_curve(static, None, "analytic").lost_at
    except OutOfDomainError:
        return []
    return [finding("creep", remaining, limit=limit)] if remaining > limit else []
