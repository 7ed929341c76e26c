"""Studies: cases answered by models, the runner, the result store, the assessment of it."""

from workbench.assessment.gates import Gate
from workbench.study.assess import Assessment, assess
from workbench.study.cells import Cell, cells_of
from workbench.study.definition import Case, Figure, Study
from workbench.study.gather import gather
from workbench.study.loading import LoadedStudy, load_study, study_files
from workbench.study.manifest import CellStatus, State, survey
from workbench.study.runner import RunSummary, run_study
from workbench.study.store import Store

__all__ = [
    "Assessment",
    "Case",
    "Cell",
    "CellStatus",
    "Figure",
    "Gate",
    "LoadedStudy",
    "RunSummary",
    "State",
    "Store",
    "Study",
    "assess",
    "cells_of",
    "gather",
    "load_study",
    "run_study",
    "study_files",
    "survey",
]
