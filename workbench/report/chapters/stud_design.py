"""From fit to design: fractiles of what is left, posteriors, few, combined and unseen tests."""

from collections.abc import Iterable, Iterator

from workbench.content.formatting import count, number, percent, share, valued
from workbench.content.tree import Block, Cell, Column, Paragraph, Table
from workbench.report.chapters.stud_tables import KILO, Content, span, span_of, table, value_of

NO_VALUE = (
    "no characteristic value: fewer than three campaigns do not tell how much campaigns differ, "
    "and no prior does (--prior tau=MEDIAN:SPREAD)"
)
_VERY_FEW = 3  # tests that are named one by one
_NONE = Cell("none: fewer than three campaigns, and no prior of tau", tone="doubt")


def residual_design(contents: Iterable[Content]) -> Iterator[Block]:
    """What a designer takes of the shares that are left, in the tested range."""
    rows = [
        {"what": content["fit"]["quantity"], **row}
        for content in contents
        for row in content["design"]
    ]

    def bounds(row: Content) -> Cell:
        return _NONE if row["low"] is None else Cell(span(row))

    columns = (
        Column("left of", of="what"),
        Column("damage", True, 0.7, value_of("level")),
        Column("median", True, 0.7, value_of("median")),
        Column("its interval", True, 1.3, bounds),
        Column("characteristic", True, 1.0, value_of("characteristic")),
        Column("design", True, 0.8, value_of("design")),
    )
    caption = (
        "From damage to design: median share that is left with what is known of it, and what 5 % "
        "(characteristic) and 0.1 % (design) of new tests in new campaigns fall below, the two "
        "fractiles of EN 1990 D.8 [@en1990]: scatter within and between campaigns and what few "
        "tests leave open of the relation are in them. No design value: nothing is surely left."
    )
    return table("residual-design", caption, columns, rows)


def posterior(contents: Iterable[Content], key: str) -> Iterator[Block]:
    """Parameters under priors; `key`, what names a content in its fit."""
    rows = [
        {"of": content["fit"][key], "name": name, "interval": interval}
        for content in contents
        for name, interval in content["posterior"].items()
    ]
    columns = (
        Column("of", of="of"),
        Column("parameter", of="name"),
        Column("interval", True, of=span_of("interval")),
    )
    return table("posterior", "What tests and priors tell together:", columns, rows)


def few(groups: Iterable[Content]) -> Iterator[Block]:
    """EN 1990 D.8.4 on every group of one to three tests."""

    def value(name: str, digits: int = 4) -> Column:
        def cell(row: Content) -> Cell:
            return valued(row[name], digits, factor=KILO if row["kind"] == "shear" else 1.0)

        return Column(name, True, 1.0, cell)

    columns = (
        Column("tests", width=3.2, of="name"),
        Column(
            "value", width=1.2, of=lambda r: "shear (kN)" if r["kind"] == "shear" else r["kind"]
        ),
        Column("number", True, 0.7, "tests"),
        value("mean"),
        Column("farthest", True, 0.8, lambda r: share(r["deviation"])),
        Column("η_k", True, 0.7, value_of("factor")),
        value("characteristic"),
        Column("why none", width=2.4, of="refusal"),
    )
    caption = (
        "EN 1990 D.8.4 [@en1990]: characteristic value of one to three nominally equal tests, for "
        "a scatter that earlier tests with the same resistance have shown."
    )
    yield Table.of("few-tests", caption, columns, list(groups))


def interaction(content: Content) -> Iterator[Block]:
    """The fitted exponent, and known laws on the same tests."""
    fit = content["fit"]
    own = {"name": "t^p + v^p = 1, fitted", "exponent": fit["exponent"]}
    columns = (
        Column("law", width=2.2, of="name"),
        Column("p", True, 0.7, value_of("exponent.value")),
        Column("interval", True, 1.2, span_of("exponent.profile")),
        Column("within", True, 0.8, lambda r: percent(fit["sigma"]["value"], signed=False)),
        Column("between", True, 0.8, lambda r: percent(fit["tau"]["value"], signed=False)),
    )
    caption = "Tension t with shear v, each over its resistance alone:"
    yield Table.of("interaction", caption, columns, [own])
    columns = (
        Column("law", width=1.6, of="law"),
        Column("median", True, of=value_of("test_over_prediction")),
        Column("interval", True, 1.2, span_of("interval")),
        Column("least", True, of=value_of("least_test_over_prediction")),
        Column("which", width=1.6, of="worst"),
    )
    caption = "Laws of the codes on the same tests, test over law (below 1: unsafe):"
    yield Table.of("interaction-laws", caption, columns, fit["laws"])


def judged(judgement: Content, rows: list[Content] | None = None) -> str:
    """How a fit meets what it has not seen, in words; of very few tests the `rows` one by one."""
    return _curves(judgement) if "curves" in judgement else _tests(judgement, rows or [])


def _tests(judgement: Content, rows: list[Content]) -> str:
    ratio, interval = number(judgement["test_over_prediction"], 3), judgement["interval"]
    bracket = ""
    if interval and None not in (interval["low"], interval["high"]):
        bracket = f"{percent(interval['confidence'], signed=False, rough=True)} interval "
        bracket = f" ({bracket.replace('.0', '')}{span(interval)})"
    least = judgement["least_test_over_prediction"]
    tests = f"{count(judgement['tests'], 'unseen test')} of {', '.join(judgement['campaigns'])}"
    if 1 < len(rows) <= _VERY_FEW:
        each = " and ".join(number(row["ratio"], 3) for row in rows)
        return (
            f"{tests} bore {each} of the prediction; so few cannot tell how good it is: median "
            f"{ratio}{bracket}"
        )
    text = f"{tests} bore {ratio}{bracket} of the prediction in the median"
    return text + (f", {judgement['worst']} only {number(least, 2)}" if least < 1.0 else "")


def _curves(judgement: Content) -> str:
    text = f"on {count(judgement['curves'], 'unseen curve')}"
    if judgement["coverage"] is not None:
        text += f" its 90 % band holds {percent(judgement['coverage'], signed=False)} of the points"
    if judgement["stiffness"]:
        ratio = number(judgement["stiffness"]["test_over_prediction"], 3)
        text += f", stiffness is {ratio} times the predicted one"
    return text


def reference_stud(reference: Content) -> Paragraph:
    """The stud that EN 1990 D.8 was evaluated for, and what was assumed of structures to come."""
    return Paragraph(
        "EN 1990 D.8 [@en1990] for the stud in the middle of the tests: "
        f"d = {number(1e3 * reference['diameter'], 3)} mm, "
        f"h = {number(1e3 * reference['height'], 3)} mm, "
        f"f_cm = {number(reference['concrete_strength'] / 1e6, 3)} MPa, "
        f"f_u = {number((reference['ultimate_strength'] or 0.0) / 1e6, 3)} MPa. The coefficients "
        "of variation of structures to come are assumptions: diameter 1 %, concrete strength 15 %, "
        "its modulus 10 %, stud strength 5 %. γ_M* is the nominal value of the code, without "
        "partial factor, over the design value found here; EN 1994-1-1 has 1.25."
    )
