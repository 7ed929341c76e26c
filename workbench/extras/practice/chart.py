"""`workbench chart`: ductility charts and pressure-impulse curves of pulses."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite
from operator import itemgetter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from workbench.base.errors import InputError
from workbench.cli.output import (
    Answer,
    Names,
    Options,
    ScenarioFile,
    Settings,
    option,
    pairs_of,
    verb,
    writable,
)
from workbench.report.page.markdown import Table, paragraph

if TYPE_CHECKING:
    from workbench.report.drawing.sheet import Line

app = typer.Typer(help="Charts of what pulses do.", rich_markup_mode=None, no_args_is_help=False)
Shape = Annotated[str, option("Shape of the pulse.")]
Picture = Annotated[str | None, option("Draw it as well.", ..., "CHART.svg", "--figure")]
_LENGTHS = tuple(10.0 ** (k / 4.0) for k in range(-6, 7))
_STRENGTHS = (0.2, 0.3, 0.5, 0.7, 0.9, 1.0, 1.2, 1.5, 2.0)
_DUCTILITIES = (1.0, 2.0, 5.0, 10.0, 20.0)


@app.command("ductility")
@verb
def ductility(shape: Shape = "triangular", figure: Picture = None) -> Answer:
    """Ductility of an elastic-plastic mass over the length of a pulse, by strength over force.

    Computed for this call: the charts of UFC 3-340-02 for any shape.
    """
    from workbench.extras.practice.charts import ductility_chart, step_ductility
    from workbench.report.drawing.sheet import Line

    target = writable("--figure", figure, "svg")
    _shape(shape)
    chart = ductility_chart(shape, _LENGTHS, _STRENGTHS)
    table = [[value if isfinite(value) else None for value in row] for row in chart.tolist()]
    names = ["t_d / T", *(f"R_m / F = {strength:g}" for strength in _STRENGTHS)]
    rows = [[length, *row] for length, row in zip(_LENGTHS, table, strict=True)]
    columns = {name: itemgetter(i) for i, name in enumerate(names)}
    lines = {
        f"R/F = {strength:g}": Line(_LENGTHS, chart[:, i].tolist())
        for i, strength in enumerate(_STRENGTHS)
    }
    _draw(target, lines, "length of the pulse over the period", "ductility")
    steps = {f"{r:g}": step_ductility(1.0 / r) for r in _STRENGTHS if r > 1.0}
    content = {
        "shape": shape,
        "lengths": list(_LENGTHS),
        "strengths": list(_STRENGTHS),
        "ductility": table,
        "step": steps,
    }
    title = f"ductility under {shape} pulses; T the elastic period, R_m / F strength over force"
    return Answer(content, (paragraph(title), Table.of("ductility", "", columns, rows)))


@app.command("iso-ductility")
@verb
def iso_ductility(shape: Shape = "triangular", figure: Picture = None) -> Answer:
    """Pressure-impulse curves of an elastic-plastic mass: pulses that take it to one ductility.

    In units of its resistance R_m and of R_m / w; dotted, what an impulse and a step reach.
    """
    from workbench.extras.practice import charts
    from workbench.report.drawing.sheet import Line

    target = writable("--figure", figure, "svg")
    _shape(shape)
    curves = {mu: charts.pressure_impulse(shape, mu, _LENGTHS) for mu in _DUCTILITIES}
    ends = {mu: (charts.impulse_asymptote(mu), charts.step_force(mu)) for mu in _DUCTILITIES}
    lines = {
        f"ductility {mu:g}": Line([p.impulse for p in points], [p.force for p in points], *ends[mu])
        for mu, points in curves.items()
    }
    _draw(target, lines, "impulse, I w / R_m", "force, F / R_m")
    columns = {
        "ductility": lambda row: row[0],
        "t_d / T": lambda row: row[1].length,
        "F / R_m": lambda row: row[1].force,
        "I w / R_m": lambda row: row[1].impulse,
    }
    rows = [(mu, point) for mu, points in curves.items() for point in points]
    content = {
        "shape": shape,
        "curves": [
            {
                "ductility": mu,
                "impulse_asymptote": ends[mu][0],
                "step_force": ends[mu][1],
                "points": [point._asdict() for point in points],
            }
            for mu, points in curves.items()
        ],
    }
    title = f"{shape} pulses that take an elastic-plastic mass to one ductility; w = 2 pi / T"
    return Answer(content, (paragraph(title), Table.of("iso-ductility", "", columns, rows)))


@app.command("pressure-impulse")
@verb
def pressure_impulse(
    scenario: ScenarioFile,
    displacement: float = option("Displacement to reach, in m."),
    model: Names = option("Name of a model, once for each.", None),
    settings: Settings = None,
    options: Options = None,
    figure: Picture = None,
) -> Answer:
    """The pulses that take a member or a frame to one displacement, over their length.

    For a scenario member-pulse or frame-pulse: its shape, at 1/30 to 30 times its length.
    """
    from workbench.base.fields import Number
    from workbench.models.base import make_model
    from workbench.report.drawing.sheet import Line
    from workbench.scenarios import FramePulse, MemberPulse, load_scenario
    from workbench.scenarios.pulse import UNIFORM
    from workbench.study.limit import pressure_impulse_curve

    target = writable("--figure", figure, "svg", inputs=[scenario])
    given = load_scenario(scenario, settings or [])
    if not isinstance(given, MemberPulse | FramePulse):
        raise InputError("kind", given.KIND, "must be member-pulse or frame-pulse")
    if given.pulse.length is None:
        raise InputError("pulse.shape", given.pulse.shape, "must have a length, not be a table")
    Number(1e-6, 50.0, "m").check("--displacement", displacement)
    lengths = [given.pulse.length * factor for factor in _LENGTHS]
    models = [make_model(each, pairs_of("--option", options)) for each in model or ["biggs"]]
    curves = {
        each.name: pressure_impulse_curve(each, given, displacement, lengths) for each in models
    }
    pressed = getattr(given, "load", "") == UNIFORM or getattr(given, "members", ())
    unit = "N/m" if pressed else "N"
    columns = {
        "model": lambda row: row[0],
        "length (s)": lambda row: row[1].length,
        f"peak ({unit})": lambda row: row[1].peak,
        f"impulse ({unit} s)": lambda row: row[1].impulse,
        "remark": lambda row: row[1].reason,
    }
    rows = [(name, point) for name, points in curves.items() for point in points]
    lines = {}
    for name, points in curves.items():
        known = [p for p in points if p.peak is not None]
        if known:
            lines[name] = Line([p.impulse or 0.0 for p in known], [p.peak or 0.0 for p in known])
    _draw(target, lines, f"impulse ({unit} s)", f"peak ({unit})")
    content = {
        "scenario": given.name,
        "displacement": displacement,
        "shape": given.pulse.shape,
        "curves": {name: [vars(point) for point in points] for name, points in curves.items()},
    }
    title = f"{given.name}: {given.pulse.shape} pulses that reach {displacement:g} m"
    blocks = (paragraph(title), Table.of("pressure-impulse", "", columns, rows))
    silent = any(point.peak is None for _, point in rows)
    return Answer(content, blocks, int(silent))


def _shape(shape: str) -> None:
    from workbench.base.fields import Choice
    from workbench.scenarios.pulse import PULSES, TABLE

    Choice(tuple(each for each in PULSES if each != TABLE)).check("--shape", shape)


def _draw(target: Path | None, lines: Mapping[str, Line], x: str, y: str) -> None:
    if target is None:
        return
    from workbench.report.drawing.sheet import chart
    from workbench.report.gallery import save

    save(chart(lines, x, y), target)
