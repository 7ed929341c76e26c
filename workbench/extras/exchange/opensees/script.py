"""Script for OpenSees: a scenario as commands that anyone can run, read and change.

It holds the text of `driver` and needs openseespy alone; its peak is that of the model `opensees`
on one mesh.
"""

import inspect
from pathlib import Path
from typing import Any

from workbench.base.errors import InputError
from workbench.extras.exchange.opensees import driver
from workbench.extras.exchange.opensees.deck import Commands
from workbench.extras.exchange.opensees.model import PROGRAM, OpenSees, striker_of
from workbench.models.base import findings_before, options_of, with_options
from workbench.models.strain_rate import with_strain_rate
from workbench.responses import Finding
from workbench.responses.build import refusal_message
from workbench.scenarios import canonical
from workbench.study.store import write_atomically

HEAD = """{name}, for OpenSees.

Options of the model `opensees` of the workbench: {options}
Yield stress times {factor:.6g} for strain rate. SI units: m, N, kg, s.
Run it: python {file} [history.csv]

{scenario}"""
IMPORTS = """
import sys

import openseespy.opensees as ops
"""
TAIL = """
if len(sys.argv) > 2 or sys.argv[-1].startswith("-"):
    raise SystemExit(f"usage: python {{sys.argv[0]}} [history.csv]")
strike = Strike(ops, {strike})
rows = [(0.0, 0.0, 0.0)]
for at in strike.follow({spans}):
    rows.append((at.time, at.moved, at.speed))
peak = max(rows, key=lambda row: abs(row[1]))
print(f"peak displacement {{peak[1]:.9g}} m at {{peak[0]:.6g}} s")
if len(sys.argv) > 1:
    with open(sys.argv[1], "w") as file:
        file.write("time_s,displacement_m,velocity_m_per_s\\n")
        file.writelines(",".join(map(repr, row)) + "\\n" for row in rows)
"""


def write_script(scenario: Any, target: Path, **options: Any) -> tuple[str, list[Finding]]:
    """Write the script of a scenario into the `target`; `options` of the model by name.

    Returns how to go on and the warnings of the model. Raises `InputError` for a scenario that it
    refuses, an option that there is not and a file that cannot be written.
    """
    model: OpenSees = with_options(OpenSees, options)
    text, findings = script_of(scenario, model, target.name)
    write_atomically(target, text.encode())
    return f"script of {text.count('ops.element(')} elements; run python {target.name}", findings


def script_of(scenario: Any, model: OpenSees, file: str = "column.py") -> tuple[str, list[Finding]]:
    """Text of the script, to be kept as `file`, and warnings. Raises `InputError` as above."""
    if scenario.KIND not in model.answers:
        allowed = f"must be one of {', '.join(model.answers)} for OpenSees"
        raise InputError("kind", scenario.KIND, allowed)
    solved, factor, left_out = with_strain_rate(model, scenario)
    findings = findings_before(model, scenario, left_out)
    refusals = [f for f in findings if f.refusal and f.subject != PROGRAM]  # it is not run here
    if refusals:
        raise InputError("scenario", scenario.name, refusal_message(refusals))
    structure, deck, event, spans = model.deck(solved)
    options = ", ".join(f"{name} = {value}" for name, value in options_of(model).items())
    given = {"options": options, "factor": factor, "scenario": canonical(scenario)[0]}
    program = inspect.getsource(driver).partition('"""')[2].partition('"""')
    lines = [
        _said(HEAD.format(name=scenario.name, file=file, **given)),
        IMPORTS,
        _said(program[0]),
        program[2],
        *_lines(deck.standing),
        *(["", "stand(ops)"] if deck.loaded else []),
        *_lines(deck.after),
    ]
    strike = ", ".join(map(repr, (*deck.watched, *striker_of(structure, event))))
    warned = [each for each in findings if not each.refusal]
    return "\n".join(lines) + "\n" + TAIL.format(strike=strike, spans=spans), warned


def _said(text: str) -> str:
    """A text as comments: names are a user's, and no code."""
    return "\n".join(f"# {line}".rstrip() for line in text.strip().splitlines())


def _lines(parts: list[Commands]) -> list[str]:
    """The commands of a deck as statements."""
    rows = []
    for title, commands in parts:
        rows += ["", f"# {title}"]
        rows += [f"ops.{name}({', '.join(map(repr, given))})" for name, *given in commands]
    return rows
