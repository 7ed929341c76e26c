"""`workbench new`: scenarios, studies, models and tables to start from, to be put into a file."""

import sys
from collections.abc import Iterable
from pathlib import Path

import typer

from workbench.cli.output import Answer, Json, group_of, option, verb

app = group_of("new")
TEMPLATES = Path(__file__).with_name("templates")
_STARTS = {
    "column.toml": "A column that is hit: for `workbench simulate`.",
    "uncertain.toml": "A column with uncertain inputs: for `fragility`, `sample` and `rare`.",
    "frame.toml": "A frame that is hit at a column: for `workbench simulate`.",
    "pulse.toml": "A member under a blast: for `workbench simulate`.",
    "study.py": "A study of a column at three velocities: for `workbench run`.",
    "model.py": "A model of your own, held to the contract: for Python.",
}


def printed(text: str, as_json: bool) -> Answer:
    """Answer of a template. The template as it is: no line of a file may be wrapped."""
    if not as_json:
        sys.stdout.write(text)
    return Answer({"template": text})


@app.command("striker")
@verb
def striker(
    traffic: str = typer.Argument(metavar="TRAFFIC", help="Such as motorway, urban or garage."),
    distance: float = option("From where it leaves its lane to the column, m.", 0.0, "M"),
    deceleration: float = option("On this way, m/s2.", 3.0, "A"),
    angle: float = option("To the road, degrees.", 10.0, "DEGREES"),
    crushing: bool = option("It crushes, with 300 kN/m.", False, flag="--crushing"),
    as_json: Json = False,
) -> Answer:
    """A vehicle of EN 1991-1-7, Table C.2, as the table [striker] of a scenario."""
    from workbench.scenarios.pulse import TRAFFIC, VEHICLE_STIFFNESS, design_striker

    made = design_striker(traffic, distance, deceleration, angle)
    front = "# rigid, an upper bound: --crushing gives it the stiffness of a vehicle\n"
    if crushing:
        front = (
            f"stiffness = {VEHICLE_STIFFNESS!r}  # Annex C; JCSS Probabilistic Model Code, 2.18\n"
        )
    text = (
        f"# {TRAFFIC[traffic].title}: EN 1991-1-7, Table C.2, recalled and not verified in print\n"
        f"# braked by {deceleration:g} m/s2, {distance:g} m from its lane, at {angle:g} degrees\n"
        f"[striker]\nmass = {made.mass!r}\nvelocity = {made.velocity:.9g}\n{front}"
    )
    return printed(text, as_json)


@app.command("missile")
@verb
def missile(
    file: Path = typer.Argument(metavar="FILE", help="station_m,mass_kg_per_m,crushing_force_N"),
    velocity: float = option("At which it hits, m/s.", ..., "V"),
    as_json: Json = False,
) -> Answer:
    """The force of a missile that crushes at a rigid wall (Riera), as the table [pulse]."""
    from workbench.base.datafiles import open_input
    from workbench.scenarios.pulse import missile_of, missile_pulse

    with open_input(file, "missile") as stream:
        pulse = missile_pulse(missile_of(stream.read(), str(file)), velocity)
    text = (
        f"# {file.name} at {velocity:g} m/s: {pulse.whole:.6g} N s in {pulse.end:.4g} s\n"
        f'[pulse]\nshape = "table"\npeak = {pulse.peak:.9g}\nload = "point"\n'
        f"times = {_listed(pulse.times or ())}\nfactors = {_listed(pulse.factors or ())}\n"
    )
    return printed(text, as_json)


@app.command("near-fault")
@verb
def near_fault(
    amplitude: float = option("Of the velocity, m/s.", ..., "A"),
    frequency: float = option("Of the wave, Hz.", ..., "F"),
    cycles: float = option("Periods of the wave in the pulse.", 2.0, "GAMMA"),
    phase: float = option("Of the wave, degrees.", 90.0, "NU"),
    as_json: Json = False,
) -> Answer:
    """The ground near a fault (Mavroeidis and Papageorgiou), as the table [ground] of a frame."""
    from workbench.scenarios.pulse import near_fault_motion

    step, acceleration = near_fault_motion(amplitude, frequency, cycles, phase)
    text = f"[ground]\ntime_step = {step!r}\nacceleration = {_listed(acceleration)}\n"
    return printed(text, as_json)


def _listed(numbers: Iterable[float]) -> str:
    return "[" + ", ".join(f"{number:.12g}" for number in numbers) + "]"


@app.command("studs")
@verb
def studs(
    kind: str = option(
        "strength, load-slip, residual, fatigue, combined or deck.", "strength", "NAME"
    ),
    example: bool = option("With the rows of the example: it runs.", False, flag="--example"),
    as_json: Json = False,
) -> Answer:
    """A table of tests on studs, commented, with an example: for `workbench fit`."""
    from workbench.studs.schema import template

    return printed(template(kind, example), as_json)


def _command(file: str, text: str) -> None:
    """The template of a file as a command, called as the file is without its ending."""

    def start(as_json: Json = False) -> Answer:
        return printed((TEMPLATES / f"{file}.txt").read_text(encoding="utf-8"), as_json)

    start.__doc__ = text
    app.command(file.partition(".")[0])(verb(start))


for _file, _text in _STARTS.items():
    _command(_file, _text)
