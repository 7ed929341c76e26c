"""Comparing responses: metrics, numerical uncertainty, bias and scatter, acceptance gates."""

from workbench.assessment.bias import Bias, bias_and_scatter
from workbench.assessment.curves import CURVE_METRICS
from workbench.assessment.gates import CaseVerdict, Gate, GateVerdict, Verdict, judge
from workbench.assessment.histories import HISTORY_METRICS
from workbench.assessment.metric import Metric, Scope, Swap
from workbench.assessment.numerical import ErrorInterval, Ladder, expand, ladder
from workbench.assessment.runs import RUN_METRICS
from workbench.assessment.scalars import SCALAR_METRICS

METRICS: dict[str, Metric] = {
    metric.name: metric
    for metric in (*SCALAR_METRICS, *HISTORY_METRICS, *CURVE_METRICS, *RUN_METRICS)
}

__all__ = [
    "METRICS",
    "Bias",
    "CaseVerdict",
    "ErrorInterval",
    "Gate",
    "GateVerdict",
    "Ladder",
    "Metric",
    "Scope",
    "Swap",
    "Verdict",
    "bias_and_scatter",
    "expand",
    "judge",
    "ladder",
]
