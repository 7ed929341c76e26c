"""The options of `workbench fit`: the fields of a class are the options of its verb."""

from collections.abc import Iterator
from dataclasses import dataclass, field, fields
from inspect import Parameter, Signature
from typing import Annotated, Any

import typer

from workbench.errors import InputError
from workbench.fields import Number

Names = list[str] | None
_CAMPAIGN = "CAMPAIGN"


def _option(text: str, default: Any = None, metavar: str | None = None, flag: str = "") -> Any:
    """A field of options: its help, default, and how its value and flag are called."""
    flags = (flag,) if flag else ()
    return field(default=default, metadata={"": typer.Option(*flags, metavar=metavar, help=text)})


def _file(metavar: str, rows: str) -> Any:
    text = f"Your table of {rows}.  [default: shipped tables]"
    return field(default=None, metadata={"": typer.Argument(metavar=metavar, help=text)})


@dataclass(frozen=True)
class Common:
    """What every fit is asked: the tables, the campaigns, the confidence, a report."""

    file: str | None = _file("[FILE.csv]", "tests")
    calibrate: Names = _option("A campaign to fit.  [default: all not validating]", None, _CAMPAIGN)
    validate: Names = _option("A campaign to judge the fit by, kept out of it.", None, _CAMPAIGN)
    with_shipped: bool = _option("Add the shipped tables to FILE.", False, None, "--with-shipped")
    keep_good: bool = _option("Leave bad rows of FILE out.", False, None, "--keep-good")
    confidence: float = _option("Confidence of intervals and bands.", 0.9)
    report: Names = _option("Write a report, its curves as CSV beside it.", None, "FILE.html|pdf")


@dataclass(frozen=True)
class StrengthOptions(Common):
    """Options of `workbench fit stud-strength`."""

    model: Names = _option(
        "A formula; of pull-outs en1992-, aci318-, aisc360-tension.  [default: all of shear]",
        None,
        "NAME",
    )
    trend: Names = _option("Fit the exponent that a formula misses in it.", None, "VARIABLE")
    factor: Names = _option("Fit this factor of the formula itself.", None, "steel|concrete")
    loss: str = _option("linear, huber or bisquare.", "linear", "NAME")
    prior: Names = _option(
        "Known from elsewhere: tau or bias, spread of its logarithm.", None, "NAME=VALUE:SD"
    )
    slab: str = _option("solid, or deck: reduced by the rules of the codes.", "solid", "NAME")
    variation: Names = _option("Scatter of a variable in structures, for D.8.", None, "NAME=V")
    points: str | None = _option("Load-slip curves, for slip capacities.", None, "POINTS.csv")
    specified: float | None = _option(
        "Specified stud strength.  [default: 450 in Annex B, as tested in D.8]",
        None,
        "MPA",
        "--specified-fu",
    )


@dataclass(frozen=True)
class LoadSlipOptions(Common):
    """Options of `workbench fit load-slip`."""

    file: str | None = _file("[POINTS.csv]", "points")
    law: Names = _option("ollgaard, bilinear or rational.  [default: all]", None, "NAME")
    loss: str = _option("linear, huber or soft_l1.", "linear", "NAME")
    least_points: int = _option("Points that a curve needs to count.", 3)


@dataclass(frozen=True)
class ResidualOptions(Common):
    """Options of `workbench fit residual`."""

    quantity: str = _option("strength, stiffness or both.", "both", "NAME")
    predamage: str | None = _option("Tests after this damage only.", None, "KIND")
    measure: str | None = _option("Tests with this measure of damage only.", None, "NAME")
    loss: str = _option("linear, huber or bisquare.", "linear", "NAME")
    prior: Names = _option(
        "Known from elsewhere: tau=MEDIAN:LOG_SPREAD, linear.c=MEAN:SPREAD.", None, "NAME=VALUE:SD"
    )
    predicted_reference: bool = _option(
        "Predict undamaged strengths that no test gave.", False, None, "--predicted-reference"
    )
    mechanical: bool = _option("Let the mechanical model predict, or compete.", True)
    diameter_mm: float | None = _option("Stud to predict for.  [default: those of FILE, else 19]")
    height_mm: float | None = _option("Height of that stud.  [default: as in FILE, else 100]")
    fcm_mpa: float | None = _option("Mean strength of its slab.  [default: as in FILE, else 30]")
    fu_mpa: float | None = _option("Its tensile strength.  [default: as in FILE, else 450]")


@dataclass(frozen=True)
class InteractionOptions(Common):
    """Options of `workbench fit interaction`."""

    loss: str = _option("linear, huber or bisquare.", "linear", "NAME")


@dataclass(frozen=True)
class FewOptions(Common):
    """Options of `workbench fit few-tests`."""

    known_variation: float | None = _option("V_r that earlier tests have shown; needed.", None, "V")


def signature_of(kind: type[Common]) -> Signature:
    """The options of a verb as the parameters of its command."""
    return Signature(
        [
            Parameter(
                each.name,
                Parameter.KEYWORD_ONLY,
                default=each.default,
                annotation=Annotated[each.type, each.metadata[""]],
            )
            for each in fields(kind)
        ]
    )


def priors_of(texts: Names) -> dict[str, tuple[float, float]]:
    """Values and spreads by name from texts like ``tau=0.06:0.5``. Raises `InputError`."""
    rule, priors = Number(0.0, 1000.0, low_included=False), {}
    for name, numbers in _numbers("--prior", texts, "tau=0.06:0.5"):
        value, spread = (float(rule.check(f"--prior {name}", each)) for each in numbers)
        priors[name] = value, spread
    return priors


def variations_of(texts: Names) -> dict[str, float]:
    """Coefficients of variation from texts like ``diameter=0.02``. Raises `InputError`."""
    from workbench.studs.strength_fit import VARIATIONS

    rule = Number(0.0, 1.0)
    given = _numbers("--variation", texts, "concrete_strength=0.15", tuple(VARIATIONS))
    own = {name: float(rule.check(f"--variation {name}", value)) for name, (value,) in given}
    return VARIATIONS | own


def _numbers(
    flag: str, texts: Names, example: str, known: tuple[str, ...] = ()
) -> Iterator[tuple[str, list[float]]]:
    """Names, `known` ones if any are, and their numbers, as many as the example has."""
    for text in texts or ():
        name, _, rest = text.partition("=")
        if known and name not in known:
            raise InputError(flag, text, "must name one of " + ", ".join(known))
        try:
            numbers = [float(part) for part in rest.split(":")]
        except ValueError:
            numbers = []
        if len(numbers) != 1 + example.count(":"):
            raise InputError(flag, text, f"must look like {example}")
        yield name, numbers
