"""Tables of fits to tests on studs: the same in a report and below `workbench fit`.

Every function takes contents of fits, as `Fit.content` and stored answers hold them, under the name
that their rows are to carry.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from textwrap import wrap
from typing import Any

from workbench.content.formatting import number, percent, share, valued
from workbench.content.tree import Block, Callout, Cell, Column, Table
from workbench.studs.formulas import FORMULAS
from workbench.studs.statistics.annex_d import LEAST_FOR_DESIGN
from workbench.studs.statistics.intervals import LIKE

Content = dict[str, Any]
Named = Mapping[str, Content]  # the contents by the name of their rows
Finder = Callable[[Any], Cell | str | int | None]
KILO, MILLI = 1e-3, 1e3
UNITS = {"rate": (1e-3, "1/mm"), "yield_slip": (1e3, "mm"), "peak_slip": (1e3, "mm")}
LEAST_IN_SERIES = 3  # tests, EN 1994-1-1, B.2.5
_LEVELS = (0.25, 0.5, 0.75, 1.0)  # of damage
_GRADE_WIDTH = 30  # characters of a line


def found(record: Any, path: str) -> Any:
    """The entry at a dotted path of a nesting, None where there is none."""
    for key in path.split("."):
        record = None if record is None else record.get(key)
    return record


def span(interval: Content | None, factor: float = 1.0) -> str:
    """An interval in words."""
    if interval is None:
        return "too few campaigns"
    ends = (interval["low"], interval["high"])
    low, high = ("open" if end is None else number(factor * end, 3) for end in ends)
    return f"{low} to {high}"


def value_of(path: str, digits: int = 3, factor: float = 1.0) -> Finder:
    """A cell with the number at a dotted path of a record, times a factor."""
    return lambda record: valued(found(record, path), digits, factor=factor)


def span_of(path: str) -> Finder:
    """The interval at a dotted path of a record in words."""
    return lambda record: span(found(record, path), record.get("factor", 1.0))


def _covered(value: float | None) -> Cell:
    return Cell("too few to tell", tone="doubt") if value is None else share(value)


_NAME = Column("formula", width=2.2, of="name")


def table(
    key: str,
    caption: str,
    columns: Iterable[Column],
    rows: list[Content],
    printed: int | None = None,
) -> Iterator[Block]:
    """A table of some rows, nothing without any."""
    if rows:
        yield Table.of(key, caption, columns, rows, printed)


def _rows(named: Named, of: Callable[[Content], Iterable[Content]]) -> list[Content]:
    return [{"name": name, **row} for name, each in named.items() for row in of(each)]


def fitted(named: Named) -> Iterator[Block]:
    """Test over prediction of every formula, with its scatters."""
    columns = (
        _NAME,
        Column("median", True, of=value_of("parameters.bias.value")),
        Column("interval", True, of=span_of("parameters.bias.profile")),
        Column("within", True, of=value_of("sigma.value")),
        Column("between", True, of=value_of("tau.value")),
        Column("5 % of a new campaign", True, of=value_of("new_campaign_factor")),
    )
    yield Table.of("fitted", "Test over prediction:", columns, _rows(named, lambda c: [c["fit"]]))


def least_scatter(result: Content) -> str:
    """Which formula scatters least, and which ones the tests do not tell from it."""
    title = FORMULAS[result["least_scatter"]].title
    alike = [FORMULAS[e["name"]].label for e in result["rivals"] if not e["apart"]]
    if not alike:
        return f"Formula{' of least scatter' if result['rivals'] else ''}: {title}."
    return (
        f"By their scatter within campaigns the tests cannot tell {title} from {', '.join(alike)}: "
        f"the {100 * result['confidence']:g} % interval of the ratio of scatters reaches down to "
        f"{LIKE:g} or less, or there are too few tests."
    )


def exponents(named: Named) -> Iterator[Block]:
    """Exponents that formulas miss, and factors of the formulas themselves, where fitted."""

    def trends(content: Content) -> Iterator[Content]:
        for name, parameter in content["fit"]["parameters"].items():
            if name != "bias":
                yield {"variable": name, **parameter}

    def factors(content: Content) -> Iterator[Content]:
        own = content.get("factors") or {"factors": {}}
        for name, value in own["factors"].items():
            yield {"variable": name, "value": value, "profile": own["profile"][name]}

    variable = Column("variable", of="variable")
    interval = Column("interval", True, of=span_of("profile"))
    for of, title, caption in (
        (trends, "exponent", "Exponents that the formulas miss:"),
        (factors, "factor", "Fitted factors of the formulas:"),
    ):
        columns = (_NAME, variable, Column(title, True, of=value_of("value")), interval)
        yield from table(f"{title}s", caption, columns, _rows(named, of))


def unseen(named: Named, kinds: Mapping[str, str], caption: str) -> Iterator[Block]:
    """Test over prediction in unseen tests; `kinds`, entry of a content: its words."""

    def judged(content: Content) -> Iterator[Content]:
        return ({"kind": kinds[key], **content[key]} for key in kinds if content.get(key))

    columns = (
        _NAME,
        Column("prediction", of="kind"),
        Column("tests", True, of="tests"),
        Column("median", True, of=value_of("test_over_prediction")),
        Column("interval", True, of=span_of("interval")),
        Column("least", True, of=value_of("least_test_over_prediction")),
        Column("which", of="worst"),
    )
    return table("unseen", caption, columns, _rows(named, judged))


def design_values(named: Named) -> Iterator[Block]:
    """EN 1990 D.8, without a design value where EN 1990 has no fractile factor."""

    def record(content: Content) -> Content:
        d8 = dict(content["fit"]["d8"])
        if d8["count"] < LEAST_FOR_DESIGN:
            d8 |= dict.fromkeys(("r_d", "gamma_m", "gamma_m_star"))
        return d8

    plain = {"b": "b", "V_δ": "V_delta", "V_rt": "V_rt", "V_r": "V_r", "k_n": "k_n"}
    plain["k_d,n"] = "k_dn"
    loads = {"g_rt(X_m)": "r_m", "r_k": "r_k", "r_d": "r_d"}
    columns = (
        _NAME,
        *(Column(title, True, 0.75, value_of(name)) for title, name in plain.items()),
        *(Column(f"{t} (kN)", True, 0.95, value_of(name, 4, KILO)) for t, name in loads.items()),
        Column("γ_M", True, 0.75, value_of("gamma_m", 4)),
        Column("γ_M*", True, 0.75, value_of("gamma_m_star", 4)),
    )
    caption = (
        "EN 1990 D.8, all tests independent, for the stud in the middle of the tests: correction "
        "b, scatter of the formula V_δ, of the basic variables V_rt and of both V_r, fractile "
        "factors, resistance g_rt of the formula itself at mean values, characteristic and design "
        "value with the correction; γ_M* is the nominal value of the code over r_d."
    )
    yield Table.of("design-d8", caption, columns, _rows(named, lambda c: [record(c)]))


def left_out(named: Named) -> Iterator[Block]:
    """Every campaign predicted from the others."""
    columns = (
        _NAME,
        Column("campaign left out", width=1.6, of="campaign"),
        Column("tests", True, 0.7, "count"),
        Column("bias of the log ratio", True, 1.3, lambda r: valued(r["bias"], percent)),
        Column("its root mean square", True, 1.4, lambda r: share(r["rms"])),
        Column("inside the 90 % band", True, 1.8, lambda r: _covered(r["covered"])),
    )
    caption = (
        "Every campaign predicted by the formula with the bias of the others: negative, the tests "
        "bore less than predicted."
    )
    rows = _rows(named, lambda c: c["fit"]["left_out"])
    return table("design-left-out", caption, columns, rows)


def series(groups: list[Content]) -> Iterator[Block]:
    """EN 1994-1-1 Annex B.2 on every series of three tests or more, or why there is none."""
    if groups and not any(group["result"] for group in groups):
        largest = max(group["tests"] for group in groups)
        yield Callout(
            "doubt",
            f"EN 1994-1-1, B.2 [@en1994-1-1] cannot be applied: none of the {len(groups)} groups "
            f"of nominally equal tests has three within 10 % of their mean (the largest has "
            f"{largest}). A table of your own with such a series is evaluated by `workbench fit "
            "stud-strength FILE.csv`.",
        )
    words = {True: "ductile", False: "brittle", None: "not known"}

    def class_of(group: Content) -> Cell:
        if not group["result"]:
            return Cell(group["refusal"], tone="muted")
        ductile, note = group["result"]["ductile"], group["result"]["note"]
        return Cell(words[ductile if ductile is None else bool(ductile)] + f": {note}" * bool(note))

    columns = (
        Column("series", width=3.2, of="name"),
        Column("tests", True, 0.7, "tests"),
        Column("P_Rk (kN)", True, 1.0, value_of("result.P_Rk", 4, KILO)),
        Column("P_Rd (kN)", True, 1.0, value_of("result.P_Rd", 4, KILO)),
        Column("δ_uk (mm)", True, 1.0, value_of("result.slip_capacity", 3, MILLI)),
        Column("class, or why there is none", width=3.2, of=class_of),
    )
    rows = [group for group in groups if group["tests"] >= LEAST_IN_SERIES]
    caption = "EN 1994-1-1, Annex B.2: every series of three tests or more."
    yield from table("design-series", caption, columns, rows, 12)


def load_slip(named: Named) -> Iterator[Block]:
    """Parameters of load-slip laws over the curves."""

    def parameters(content: Content) -> Iterator[Content]:
        for name, own in content["fit"]["population"].items():
            factor, unit = UNITS.get(name, (1.0, ""))
            words = name.replace("_", " ") + (f" ({unit})" if unit else "")
            yield {"parameter": words, "factor": factor, "rms": content["fit"]["median_rms"], **own}

    columns = (
        Column("law", width=3.0, of="name"),
        Column("parameter", width=1.7, of="parameter"),
        Column("median", True, 0.9, lambda r: valued(r["median"], 3, factor=r["factor"])),
        Column("profile interval", True, 1.5, span_of("profile")),
        Column("σ", True, 0.6, value_of("sigma.value")),
        Column("τ", True, 0.6, value_of("tau.value")),
        Column("misfit", True, 0.7, value_of("rms")),
    )
    caption = (
        "Load-slip laws: median of each parameter over the curves with its intervals, scatter of "
        "its logarithm within (σ, the error of each curve's fit included) and between (τ) "
        "campaigns, median misfit of the load over the largest load."
    )
    return table("design-load-slip", caption, columns, _rows(named, parameters))


def band_coverage(named: Named, confidence: float) -> Iterator[Block]:
    """What the bands of load-slip laws hold of curves and campaigns that are left out."""
    columns = (
        Column("law", of="name"),
        Column("of a curve left out", True, of=lambda r: _covered(r["curves"])),
        Column("of a campaign left out", True, of=lambda r: _covered(r["campaigns"])),
    )
    rows = _rows(named, lambda c: [c["fit"]["coverage"]])
    caption = f"Share of the points inside the {100 * confidence:.3g} % band of the other curves:"
    return table("band-coverage", caption, columns, rows)


def unseen_curves(named: Named) -> Iterator[Block]:
    """Load-slip laws on unseen curves."""
    columns = (
        Column("law", of="name"),
        Column("curves", True, of="curves"),
        Column("misfit", True, of=value_of("median_rms")),
        Column("inside the band", True, of=lambda r: share(r["coverage"])),
        Column("stiffness, test over law", True, of=value_of("stiffness.test_over_prediction")),
        Column("interval", True, of=span_of("stiffness.interval")),
    )
    rows = _rows(named, lambda c: [c["judgement"]] if c["judgement"] else [])
    return table("unseen-curves", "Unseen curves:", columns, rows)


def residual(contents: Iterable[Content]) -> Iterator[Block]:
    """What is left after damage, with the grade of the evidence."""

    def left(level: float) -> Finder:
        def cell(content: Content) -> Cell:
            curve = content["curve"]
            at = min(range(len(curve["level"])), key=lambda i: abs(curve["level"][i] - level))
            value = curve["left"][at]
            text = number(value, 3)
            if curve["extrapolated"][at]:
                return Cell(f"{text}\nextrapolated", value, tone="bad")
            if value is not None and curve["low"] is not None:
                text += f"\n({number(curve['low'][at], 2)} to {number(curve['high'][at], 2)})"
            return Cell(text, value)

        return cell

    def damage(content: Content) -> str:
        fit = content["fit"]
        kind = ", ".join(fit[key] for key in ("quantity", "predamage", "measure"))
        return f"{kind}\n{fit['stud']}" if fit["stud"] else kind

    def grade(content: Content) -> Cell:
        words = f"{content['fit']['grade']}; {content['fit']['holds']}"
        lines = wrap(words, _GRADE_WIDTH, break_on_hyphens=False)
        return Cell("\n".join(lines), tone="" if content["validated"] else "bad")

    contents = list(contents)
    top = max((content["curve"]["level"][-1] for content in contents), default=1.0)
    levels = (*_LEVELS, top) if top > _LEVELS[-1] else _LEVELS
    columns = (
        Column("what is left", width=2.4, of=damage),
        *(Column(f"level {level:g}", True, 1.1, left(level)) for level in levels),
        Column("relation", width=1.1, of=lambda content: str(content["fit"]["relation"])),
        Column("grade", width=2.6, of=grade),
    )
    caption = (
        "Share that is left after damage, with its range: the band of a new test, or, for the "
        "mechanical model, what its assumed parameters leave open. Level 1: what an undamaged stud "
        "bears. Beyond the tested damage no test tells which relation goes on: no band is given."
    )
    return table("design-residual", caption, columns, contents)


def relations(contents: Iterable[Content]) -> Iterator[Block]:
    """Parameters of the relations that were fitted, and what the choice between them rests on."""
    for content in contents:
        fit = content["fit"]
        if not fit["tests"]:
            continue
        columns = (
            Column("parameter", of="name"),
            Column("value", True, of=value_of("value")),
            Column("interval", True, of=span_of("profile")),
        )
        rows = [
            {"name": name, "value": value, "profile": fit["profile"][name]}
            for name, value in fit["parameters"].items()
        ]
        scores = ", ".join(
            f"{each['name']} {share(each['weight']).text} ({each['rms']:.3f})"
            for each in fit["scores"]
        )
        caption = (
            f"{fit['quantity']}: {fit['formula']} ({fit['tests']} tests, {fit['grade']}, "
            f"{fit['holds']}); weights in the average, and root mean square of what is left out, "
            f"by {fit['scores'][0]['by']}: {scores}"
        )
        yield Table.of("relation", caption, columns, rows)
