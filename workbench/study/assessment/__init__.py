"""Comparing responses: metrics and their uncertainty, bias and scatter, acceptance gates."""

from workbench.responses.convergence import Ladder as Ladder
from workbench.responses.convergence import ladder as ladder
from workbench.study.assessment.gates import Gate as Gate
from workbench.study.assessment.gates import Verdict as Verdict
from workbench.study.assessment.gates import bias_and_scatter as bias_and_scatter
from workbench.study.assessment.gates import judge as judge
from workbench.study.assessment.metric import METRICS as METRICS
from workbench.study.assessment.metric import Metric as Metric
from workbench.study.assessment.metric import Scope as Scope
from workbench.study.assessment.metric import Swap as Swap
