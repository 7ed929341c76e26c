"""Comparing responses: metrics, numerical uncertainty, bias and scatter, acceptance gates."""

from workbench.assessment.bias import Bias as Bias
from workbench.assessment.bias import bias_and_scatter as bias_and_scatter
from workbench.assessment.curves import CURVE_METRICS
from workbench.assessment.gates import CaseVerdict as CaseVerdict
from workbench.assessment.gates import Gate as Gate
from workbench.assessment.gates import GateVerdict as GateVerdict
from workbench.assessment.gates import Verdict as Verdict
from workbench.assessment.gates import judge as judge
from workbench.assessment.histories import HISTORY_METRICS
from workbench.assessment.metric import Metric as Metric
from workbench.assessment.metric import Scope as Scope
from workbench.assessment.metric import Swap as Swap
from workbench.assessment.numerical import ErrorInterval as ErrorInterval
from workbench.assessment.numerical import Ladder as Ladder
from workbench.assessment.numerical import expand as expand
from workbench.assessment.numerical import ladder as ladder
from workbench.assessment.runs import RUN_METRICS
from workbench.assessment.scalars import SCALAR_METRICS

METRICS: dict[str, Metric] = {
    metric.name: metric
    for metric in (*SCALAR_METRICS, *HISTORY_METRICS, *CURVE_METRICS, *RUN_METRICS)
}
