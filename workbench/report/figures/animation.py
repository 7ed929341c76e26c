"""The motion of a frame: an animation on screen, still pictures on paper.

Options: `case` (a name; default the first with deformed shapes); `instants`, those of the still
pictures (default start, half-way, peak, end). Snapshots are shown as they were stored, without
anything between them.
"""

from dataclasses import replace

from workbench.report.drawing.film import LARGEST, film
from workbench.report.drawing.multiples import multiples
from workbench.report.drawing.shapes import INSTANTS, collected
from workbench.report.drawing.sheet import Drawing, Request, first, nothing

_MOST = 3  # answers side by side


def draw(request: Request) -> Drawing:
    """Stills of up to three answers to one case, and the film that an HTML report shows."""
    said: list[str] = []
    found = collected(request, request.named()[:6], said)
    if not found:
        return nothing("No model states deformed shapes for these cases.", *said)
    case, known = found[0]
    known = dict(first(list(known.items()), _MOST, "answers", said))
    stills = multiples(request, [(case, known)], said, INSTANTS)
    moving, every = film(known)
    said = [f"Case: {case.name}.", *stills.statements]
    if every > 1:
        said.append(
            f"On screen, one of {every} stored snapshots is shown: the animation stays below "
            f"{LARGEST // 1000} kB."
        )
    return replace(stills, statements=tuple(said), moving=moving, alt=f"motion: {stills.alt}")
