from __future__ import annotations

import pytest
from toy_models import Spring

from workbench.scenarios import ColumnImpact
from workbench.study import Case, Study


@pytest.fixture
def toy_study(thesis_impact: ColumnImpact) -> Study:
    """Three impacts, a ladder of three levels and one reduced model: 12 cells."""
    return Study(
        name="toy",
        title="Toy",
        question="Does the runner run?",
        cases=tuple(
            Case(f"v{v}", thesis_impact.at_velocity(v), parameters={"velocity": v})
            for v in (10.0, 15.0, 20.0)
        ),
        models={
            "soft": Spring(stiffness=4e6),
            "coarse": Spring(error=0.08),
            "middle": Spring(error=0.08, level=1),
            "fine": Spring(error=0.08, level=2),
        },
        reference="fine",
        ladder=("coarse", "middle", "fine"),
        quick_models=("soft", "middle", "fine"),
    )
