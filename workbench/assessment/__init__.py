"""Comparing responses: metrics and their uncertainty, bias and scatter, acceptance gates."""

from workbench.assessment import curves as curves
from workbench.assessment.bias import bias_and_scatter as bias_and_scatter
from workbench.assessment.gates import Gate as Gate
from workbench.assessment.gates import Verdict as Verdict
from workbench.assessment.gates import judge as judge
from workbench.assessment.metric import METRICS as METRICS
from workbench.assessment.metric import Metric as Metric
from workbench.assessment.metric import Scope as Scope
from workbench.assessment.metric import Swap as Swap
from workbench.responses.convergence import Ladder as Ladder
from workbench.responses.convergence import ladder as ladder
