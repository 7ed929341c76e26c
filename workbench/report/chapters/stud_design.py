"""Tables from fit to design: fractiles of shares left, posteriors, few tests, interaction."""

from collections.abc import Iterable, Iterator

from workbench.content.formatting import percent, share, valued
from workbench.content.tree import Block, Cell, Column, Table
from workbench.report.chapters.stud_tables import KILO, Content, span, span_of, table, value_of

NO_VALUE = (
    "no characteristic value: fewer than three campaigns do not tell how much campaigns differ, "
    "and no prior does (--prior tau=MEDIAN:SPREAD)"
)
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
