"""Numbers as the reader sees them: units of the trade, significant digits, typographic signs."""

import math
import tomllib
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from workbench.report.page.markdown import ABSENT, Cell
from workbench.responses.histories import COORDINATES, VARIABLES
from workbench.study.assessment import METRICS, Scope

MINUS, TIMES, PLUS_MINUS = "\u2212", "\u00d7", "\u00b1"
THIN, NO_BREAK = "\u2009", "\u00a0"
_SUPERSCRIPT = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")


class Unit(NamedTuple):
    """A display unit and the factor that SI values are multiplied by."""

    text: str
    factor: float


_UNITS = {
    "m": Unit("mm", 1e3),
    "s": Unit("ms", 1e3),
    "N": Unit("kN", 1e-3),
    "N m": Unit("kN m", 1e-3),
    "N s": Unit("kN s", 1e-3),
    "J": Unit("kJ", 1e-3),
    "1": Unit("", 1.0),
}


def unit_of(quantity: str) -> Unit:
    """Display unit of a response variable or coordinate."""
    variable = VARIABLES.get(quantity) or COORDINATES.get(quantity)
    units = variable.units if variable else "1"
    return _UNITS.get(units, Unit(units, 1.0))


def title_of(quantity: str) -> str:
    """Name of a response variable for headings: ``peak displacement``."""
    return quantity.replace("_", " ")


def axis_label(quantity: str) -> str:
    """Axis label with unit: ``displacement (mm)``."""
    unit = unit_of(quantity).text
    return f"{title_of(quantity)} ({unit})" if unit else title_of(quantity)


def number(value: float | None, digits: int = 4) -> str:
    """A number with `digits` significant digits; a dash for None or NaN."""
    if value is None or math.isnan(value):
        return "–"
    if math.isinf(value):
        return MINUS + "∞" if value < 0 else "∞"
    if value == 0.0:
        return "0"
    exponent = math.floor(math.log10(abs(float(f"{value:.{digits - 1}e}"))))
    if -4 <= exponent < 7:
        text = f"{value:.{max(digits - 1 - exponent, 0)}f}"
    else:
        mantissa, _, _ = f"{value:.{max(digits - 1, 0)}e}".partition("e")
        mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
        text = f"{mantissa}{TIMES}10{str(exponent).translate(_SUPERSCRIPT)}"
    return text.replace("-", MINUS)


def brief(value: float) -> str:
    """A number of the input without needless zeros: ``4``, ``0.8``, ``20000``."""
    text = f"{value:.0f}" if 1e4 <= abs(value) < 1e9 else f"{value:.4g}"
    return text.replace("-", MINUS)


def percent(
    value: float | None, *, signed: bool = True, rough: bool = False, unit: bool = True
) -> str:
    """A share as percentage with two decimals below 10 %, one above; `rough`, with one less.

    `unit`: with the sign of percent.
    """
    if value is None or not math.isfinite(value):
        return number(value)
    share = 100.0 * value
    decimals = (2 if abs(share) < 9.995 else 1) - rough
    text = f"{share:+.{decimals}f}" if signed else f"{share:.{decimals}f}"
    if float(text) == 0.0:
        text = f"{0.0:.{decimals}f}"
    return f"{text.replace('-', MINUS)}{THIN}%" if unit else text.replace("-", MINUS)


def up(value: float) -> str:
    """A share in whole percents, rounded up."""
    return f"{math.ceil(100.0 * value - 1e-9)}{THIN}%"


def rounded(value: float) -> str:
    """A deviation in whole percents, without its sign."""
    return f"{abs(100.0 * value):.0f}{THIN}%"


def in_unit(
    value: float | None,
    quantity: str,
    digits: int = 4,
    width: float | None = 0.0,
    *,
    named: bool = True,
    kind: str = "",
) -> str:
    """A value of a quantity in its display unit, with the unit where that is `named`.

    `width` is the half-width of its uncertainty (zero: none is shown, None: unknown), which is of
    a `kind` such as numerical.
    """
    if value is None or not math.isfinite(value):
        return number(value)
    unit = unit_of(quantity)
    text = number(value * unit.factor, digits)
    if width != 0.0:
        text += f" {PLUS_MINUS} {'unknown' if width is None else number(width * unit.factor, 2)}"
    text = f"{text}{NO_BREAK}{unit.text}" if named and unit.text else text
    return f"{text} ({kind})" if kind and width != 0.0 else text


def metric_title(metric: str) -> str:
    """Title of a metric."""
    return METRICS[metric].title if metric in METRICS else metric.replace("_", " ")


def metric_value(
    metric: str, quantity: str, value: float | None, *, bound: bool = False, unit: bool = True
) -> str:
    """Value of a metric; pure numbers as percentages, others in the unit of the quantity.

    `bound`: without sign, as a limit on the magnitude; `unit`: percentages with their sign.
    """
    if metric in METRICS and METRICS[metric].unit_power:
        return in_unit(value, quantity, 3)
    signed = metric in METRICS and METRICS[metric].signed and not bound
    return percent(value, signed=signed, unit=unit)


def interval(
    metric: str,
    quantity: str,
    value: float | None,
    width: float | None,
    *ends: float | None,
    unknown: str = " (uncertainty unknown)",
) -> str:
    """Value ± uncertainty of a metric, or value (low to high) by the known `ends`.

    `unknown` stands after a value of unknown uncertainty.
    """
    text = metric_value(metric, quantity, value)
    if value is None or not math.isfinite(value):
        return text
    if metric in METRICS and METRICS[metric].scope is Scope.RUN:
        return text
    known = [metric_value(metric, quantity, end) for end in ends if end is not None]
    if known:
        return f"{text} ({' to '.join(known)})"
    if width is None or math.isnan(width):
        return f"{text}{unknown}"
    wide = metric_value(metric, quantity, width, bound=True)
    return f"{metric_value(metric, quantity, value, unit=False)} {PLUS_MINUS} {wide}"


def duration(seconds: float | None, digits: int = 2) -> str:
    """A wall time in the unit that suits it."""
    if seconds is None or not math.isfinite(seconds):
        return number(seconds)
    for factor, unit in ((1e6, "µs"), (1e3, "ms")):
        if seconds * factor < 999.5:
            return f"{number(seconds * factor, digits)}{NO_BREAK}{unit}"
    if seconds < 120.0:
        return f"{number(seconds, digits)}{NO_BREAK}s"
    return f"{number(seconds / 60.0, digits)}{NO_BREAK}min"


def part(ratio: float | None) -> str:
    """A ratio of times as a reader remembers it, in steps of 1, 2 and 5: ``1/2000``."""
    if ratio is None or not math.isfinite(ratio) or ratio <= 0.0:
        return number(None)
    steps = [step * 10.0**power for power in range(-6, 10) for step in (1.0, 2.0, 5.0)]
    near = min(steps, key=lambda step: abs(math.log(step * min(ratio, 1.0 / ratio))))
    return f"{near:.0f}" if ratio >= 1.0 or near == 1.0 else f"1/{near:.0f}"


def spans(numbers: Sequence[int]) -> str:
    """Whole numbers in rising order, runs of them by their ends: ``1, 3 to 5``."""
    runs: list[list[int]] = []
    for each in numbers:
        if runs and each == runs[-1][-1] + 1:
            runs[-1].append(each)
        else:
            runs.append([each])
    texts = (f"{r[0]} to {r[-1]}" if len(r) > 2 else ", ".join(map(str, r)) for r in runs)
    return ", ".join(texts)


def count(number_of: int, singular: str, plural: str = "") -> str:
    """``1 case``, ``3 cases``."""
    return f"{number_of} {singular if number_of == 1 else plural or singular + 's'}"


def several(names: Sequence[str], most: int = 6) -> str:
    """Names in a row, of many the first few and how many more there are."""
    if len(names) <= most:
        return ", ".join(names)
    return f"{', '.join(names[: most - 2])} and {len(names) - most + 2} more"


def valued(
    value: float | None, text: Callable[[float], str] | int = 4, tone: str = "", factor: float = 1.0
) -> Cell:
    """A value as a table cell that sorts by it; a dash for None and NaN.

    `text` writes it, or is the number of its significant digits after multiplying by `factor`.
    """
    if value is None or math.isnan(value):
        return ABSENT
    shown = text(value) if callable(text) else number(factor * value, text)
    return Cell(shown, value, tone)


def direction(scenario: str) -> str:
    """Direction of a hit in a `scenario` (TOML), empty of one through the web, or along x."""
    tables = tomllib.loads(scenario)
    striker, parts = tables.get("striker", {}), []
    if tables.get("column", {}).get("axis") == "weak":
        parts.append("bent about the weak axis")
    if angle := striker.get("angle", 0.0):
        line = "the height of the section" if "column" in tables else "x towards z"
        parts.append(f"hit at {math.degrees(angle):.3g} degrees off {line}")
    if beside := striker.get("eccentricity", 0.0):
        parts.append(f"hit {1e3 * abs(beside):.3g} mm beside the shear centre")
    return ", ".join(parts)


def quantities(*names: str) -> dict[str, Callable[[Mapping[str, Any]], Cell | None]]:
    """Columns of quantities with units, by their titles; of records with entries of these names."""

    def column(name: str) -> Callable[[Mapping[str, Any]], Cell | None]:
        return lambda row: valued(row[name], lambda value: in_unit(value, name, 3))

    return {title_of(name): column(name) for name in names}


def span_cell(row: Mapping[str, Any]) -> Cell:
    """An interval, the entries `low` and `high` of a row, that sorts by its low end."""
    low, high = row["low"], row["high"]
    return ABSENT if None in (low, high) else Cell(f"{number(low, 3)} to {number(high, 3)}", low)


def share(value: float | None, tone: str = "") -> Cell:
    """A ratio as a cell in percent, without sign."""
    return valued(value, lambda ratio: percent(ratio, signed=False), tone)
