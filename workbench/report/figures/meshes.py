"""Answers of one model on several meshes against the size of their elements.

Options: `sizes`, label to element size in m; `quantity` (a scalar, default the first of the
study); `case` (default the first with an answer). The band is the interval around the reference.
"""

from workbench.content.formatting import axis_label, title_of, unit_of
from workbench.report.drawing.sheet import Drawing, Request, Sheet, nothing
from workbench.report.drawing.style import INK, INTERVAL, MUTED, Style


def draw(request: Request) -> Drawing:
    """Value over element size, with the interval that the reference leaves at size zero."""
    quantity, sizes = request.quantity, request.option("sizes", {})
    unit, reference = unit_of(quantity).factor, request.study.reference
    for case in request.named():
        values = {label: request.number(case, label, quantity) for label in sizes}
        known = {label: value for label, value in values.items() if value is not None}
        if known:
            break
    else:
        return nothing(f"No mesh has an answer with {title_of(quantity)}.")
    sheet = Sheet.table(1, 1, 3.0)
    panel = sheet.panel
    points = sorted((float(sizes[label]), unit * value) for label, value in known.items())
    panel.plot(*zip(*points, strict=True), color=INK, marker="o", label="uniform meshes")
    for label, value in known.items():
        size = float(sizes[label])
        beside: Style = {"xytext": (4, 4), "textcoords": "offset points"}
        panel.annotate(label, (size, unit * value), **beside, fontsize="small", color=MUTED)
        sheet.record(case=case.name, label=label, size_m=size, **{f"{quantity}_SI": value})
    band = request.interval(case, quantity)
    if band is None:
        sheet.said.append(f"The numerical uncertainty of {reference} is unknown.")
    else:
        name = f"{reference}, with its numerical uncertainty"
        panel.axhspan(unit * band[0], unit * band[1], **INTERVAL, zorder=0, label=name)
    panel.set_xlim(0.0, 1.3 * points[-1][0])
    sheet.name(panel, case.name, "element size (m)", axis_label(quantity))
    sheet.legend(*panel.get_legend_handles_labels()[0])
    return sheet.finish(f"{title_of(quantity)} against element size for {', '.join(known)}")
