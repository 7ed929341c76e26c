"""Pictures of answers, ``response.workbench.plot``: the figures of reports.

A figure draws a study of one case that is kept in memory.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas

from workbench.base.errors import InputError, one_line
from workbench.models.base import make_model, model_names
from workbench.report.drawing.sheet import Drawing, Request
from workbench.report.drawing.style import looks
from workbench.report.figures import draw
from workbench.report.gallery import save
from workbench.responses import Outcome, Response, attribute, outcome_of
from workbench.scenarios import Scenario
from workbench.study import Case, Figure, Study
from workbench.study.assessor import assessment_of

_CASE, _TITLE = "scenario", 48  # characters, of which more would crush a panel


@dataclass(frozen=True)
class Plots:
    """Pictures of answers to one `scenario`, by label; the `reference` among them is black.

    Every method returns the axes of matplotlib on a figure of their own, ``axes.figure``, which a
    notebook shows and `save` writes. Raises `InputError` where the answers have nothing to show.
    """

    scenario: Scenario
    responses: Mapping[str, Response]
    reference: str = ""

    def history(self, quantity: str = "displacement", hinge: str = "") -> Axes:
        """A `quantity` over time; pushed structures: force over displacement.

        Where all have collapsed, and none is kept: the structure, as on the command line.
        """
        if self.scenario.STATIC:
            return self.axes("force-displacement")[0]
        fallen = all(outcome_of(each) is Outcome.COLLAPSE for each in self.responses.values())
        if fallen and not self._followed:
            return self.structure()
        return self.axes("history", quantity=quantity, hinge=hinge)[0]

    def structure(self) -> Axes:
        """The structure to scale, with supports, loads and what happens to it."""
        return self.axes("structure")[0]

    def deformed(self, *instants: str | float) -> Axes:
        """Deformed shapes, of frames at ``"start"``, ``"peak"``, ``"end"`` or times in s.

        Columns lie on their side, at the peak and at the end.
        """
        return self.axes("deformed", **({"instants": instants} if instants else {}))[0]

    def interaction(self, *hinges: str) -> Axes:
        """Paths of the `hinges` (names; default, those that turn most) in the N-M plane."""
        return self.axes("interaction", hinges=hinges)[0]

    def energy(self) -> Axes:
        """The energy ledger over time."""
        return self.axes("energy")[0]

    def axes(self, kind: str, **options: Any) -> list[Axes]:
        """All panels of a figure of a report, see `workbench.report.figures.KINDS`."""
        return list(self._canvas(kind, **options).axes)

    def save(self, path: Path | str, kind: str = "", **options: Any) -> None:
        """Write a figure as PNG, SVG or PDF, by the ending; by default history or structure.

        Raises `InputError` for other endings.
        """
        target = Path(path)
        if target.suffix.lower() not in (".png", ".svg", ".pdf"):
            raise InputError("plot", str(path), "must end in .png, .svg or .pdf")
        usual = "force-displacement" if self.scenario.STATIC else "history"
        chosen = kind or (usual if self._followed else "structure")
        save(self._canvas(chosen, **options), target)

    @property
    def _followed(self) -> bool:
        """Whether one of the answers has a history or a curve."""
        return any({"time", "step"} & set(each.dims) for each in self.responses.values())

    def _canvas(self, kind: str, **options: Any) -> Canvas:
        canvas = self.drawing(kind, **options).canvas
        assert canvas is not None
        return canvas

    def drawing(self, kind: str, **options: Any) -> Drawing:
        """The drawing with its numbers and statements. Raises `InputError` if it is empty."""
        figure = Figure(kind, kind, kind, kind, options=options)
        case = Case(one_line(self.scenario.name, _TITLE), self.scenario)
        what = self.scenario.KIND
        models: dict[str, Any] = {n: _model_of(r, what) for n, r in self.responses.items()}
        first = self.reference or next(iter(models))
        study = Study(_CASE, _CASE, _CASE, (case,), models, first, quantities=())
        answers = assessment_of(study, self.responses)
        drawing = draw(Request(study, figure, answers, (case,), tuple(models), looks(study)))
        if drawing.canvas is None:
            raise InputError("plot", kind, " ".join(drawing.statements))
        return drawing


def _model_of(response: Response, kind: str) -> Any:
    """The model that answered; of one that is not installed, its name and what it answered."""
    name, options = response.attrs["model"], attribute(response, "options")
    if name in model_names():
        return make_model(name, {n: value for n, value in options.items() if value is not None})
    return SimpleNamespace(name=name, answers=(kind,))
