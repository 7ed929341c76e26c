"""The motion of a frame: an animation on screen, still pictures on paper.

Options: `case` (a name; default the first with deformed shapes); `instants`, those of the still
pictures (default start, half-way, peak, end). Snapshots are shown as they were stored, without
anything between them.
"""

from __future__ import annotations

from dataclasses import replace

from workbench.report.figures.deformed import collected
from workbench.report.figures.drawing import Drawing, Request, nothing
from workbench.report.figures.film import LARGEST, film
from workbench.report.figures.shapes import INSTANTS
from workbench.report.figures.small_multiples import multiples

_MOST = 3  # answers side by side


def draw(request: Request) -> Drawing:
    """Stills of up to three answers to one case, and the film that an HTML report shows."""
    named = request.option("case", "")
    cases = tuple(case for case in request.cases if not named or case.name == named)
    found, statements = collected(replace(request, cases=cases))
    if not found:
        return nothing("No model states deformed shapes for these cases.", *statements)
    case, by_label = found[0]
    if len(by_label) > _MOST:
        statements.append(f"Shown are the first {_MOST} of {len(by_label)} answers.")
        by_label = dict(list(by_label.items())[:_MOST])
    stills = multiples(request, [(case, by_label)], statements, INSTANTS)
    moving, every = film(by_label)
    said = [f"Case: {case.name}.", *stills.statements]
    if every > 1:
        said.append(
            f"On screen, one of {every} stored snapshots is shown: the animation stays below "
            f"{LARGEST // 1000} kB."
        )
    return replace(stills, statements=tuple(said), moving=moving, alt=f"motion: {stills.alt}")
