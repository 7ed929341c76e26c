"""Studies: cases answered by models, the runner, the result store, the assessment of it."""

from workbench.study.assess import Assessment as Assessment
from workbench.study.assess import assess as assess
from workbench.study.assessment.gates import Gate as Gate
from workbench.study.assessment.variations import Budget as Budget
from workbench.study.cells import cells_of as cells_of
from workbench.study.definition import Case as Case
from workbench.study.definition import Figure as Figure
from workbench.study.definition import Study as Study
from workbench.study.loading import load_study as load_study
from workbench.study.manifest import CellStatus as CellStatus
from workbench.study.manifest import State as State
from workbench.study.manifest import gather as gather
from workbench.study.manifest import survey as survey
from workbench.study.runner import RunSummary as RunSummary
from workbench.study.runner import run_study as run_study
from workbench.study.store import Store as Store
