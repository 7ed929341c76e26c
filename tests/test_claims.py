"""Traceability: what is registered has an independent check; the table says what tests claim."""

from __future__ import annotations

from collections.abc import Iterable

import pytest
from claims import WITHOUT_PAPER, Claim, marked, stored

from workbench.base.catalogue import datasets
from workbench.extras.laboratory.schemes import SCHEMES
from workbench.models.base import model_names
from workbench.models.references.fiber_beams import LAWS as STEEL_LAWS
from workbench.report.page.bibliography import bibliography
from workbench.steel.hinges.interaction import RULES
from workbench.steel.materials import COWPER_SYMONDS
from workbench.studs.formulas import FORMULAS
from workbench.studs.load_slip import LAWS
from workbench.study.assessment import METRICS

# what needs a claim; subjects of other kinds are free
REGISTERED = {
    **{"model": model_names(), "metric": METRICS, "scheme": SCHEMES, "load-slip": LAWS},
    **{"dataset": [entry.name for entry in datasets()], "formula": FORMULAS},
    **{"steel": (*STEEL_LAWS, COWPER_SYMONDS), "surface": RULES},
}


def lacks(markers: Iterable[Claim], rows: Iterable[Claim]) -> list[str]:
    """What is wrong with markers and rows of the table, one sentence each."""
    markers, rows = list(markers), list(rows)
    named = {name for row in rows for name in row.subject.split()}
    known = {f"{kind}:{name}" for kind, names in REGISTERED.items() for name in names}
    strange = {name for name in named - known if name.partition(":")[0] in REGISTERED}
    works = {*bibliography(), *WITHOUT_PAPER}
    return [
        *(f"{m.test}: {m.says}: no row" for m in markers if not any(m.fits(r) for r in rows)),
        *(f"{r.test}: {r.says}: no marker" for r in rows if not any(m.fits(r) for m in markers)),
        *(f"{r.test}: {r.source}: not in the bibliography" for r in rows if r.source not in works),
        *(f"{name}: not registered" for name in sorted(strange)),
        *(f"{name}: no claim, mark an independent check" for name in sorted(known - named)),
    ]


def test_all_that_is_registered_is_claimed() -> None:
    assert lacks(marked(), stored()) == [], "after changes of markers: make manual"


def test_a_marker_that_goes_is_missed() -> None:
    markers, rows = list(marked()), list(stored())
    wrong = len(lacks(markers, rows))
    for gone in range(0, len(markers), 7):
        assert len(lacks([*markers[:gone], *markers[gone + 1 :]], rows)) > wrong
    assert len(lacks(markers, rows[:-1])) > wrong


def test_a_value_that_moved_is_told() -> None:
    said = Claim("model:four-dof", "peak, m", "property", "0.2", "2 %", "")
    assert said.width == pytest.approx(0.004)
    assert said.moved(0.2005, 0.2)
    assert not said.moved(0.2005, 0.199, many=True)
    assert said.line(0.20123456)["computed"] == "0.20123"
