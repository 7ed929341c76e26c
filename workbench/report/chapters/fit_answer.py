"""What a fit to tests on studs says, from the content of its JSON object.

The terminal shows its tables and warnings (`shown`); a report begins with its grade and its answer
in words, and tells formulas and method.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from workbench.content.bibliography import cited
from workbench.content.formatting import count, number, percent
from workbench.content.tree import Block, Bullets, Callout, Definitions, Paragraph, Section
from workbench.report.chapters import stud_design
from workbench.report.chapters import stud_tables as tables
from workbench.report.chapters.stud_tables import LEAST_IN_SERIES, Content
from workbench.responses import Finding
from workbench.studs.fit_protocol import ranked
from workbench.studs.formulas import FORMULAS
from workbench.studs.load_slip import LAWS
from workbench.studs.relations import ANCHORED, RELATIONS, SOURCES
from workbench.studs.statistics.annex_d import LEAST_FOR_DESIGN

CODE, CODE_FACTOR = "en1994", 1.25  # whose partial factor designers know
_MOST_SERIES = 4  # that the answer names
_MIXED = (
    "Campaigns have a random effect each: restricted maximum likelihood, with profile intervals "
    "of the parameters [@pinheiro-bates2000]."
)
# where the contents of a fit are, and what names each of them
_PLACES = {
    "stud-strength": ("models", "model"),
    "load-slip": ("laws", "law"),
    "residual": ("quantities", "quantity"),
    "interaction": ("laws", "law"),
    "few-tests": ("", ""),
}


def labelled(result: Content) -> Content:
    """The content with formulas under the names of their sources; `key` keeps their own."""
    place, name = _PLACES[result["fit"]]
    labels = {n: each.label for n, each in FORMULAS.items()} if name == "model" else {}
    contents = []
    for each in contents_of(result):
        key = each["fit"][name]
        contents.append({**each, "fit": {**each["fit"], name: labels.get(key, key), "key": key}})
    return {**result, place: contents} if place else result


def contents_of(result: Content) -> list[Content]:
    """The contents of all that was fitted; none where nothing is."""
    return list(result.get(_PLACES[result["fit"]][0], ()))


def named_of(result: Content) -> Mapping[str, Content]:
    """The contents by the names of formulas, laws or quantities."""
    _, name = _PLACES[result["fit"]]
    return {content["fit"][name]: content for content in contents_of(result)}


def warnings_of(result: Content) -> list[Finding]:
    """Every warning once, the decisive ones first; those of some alone are said to be theirs."""
    owners: dict[Finding, list[str]] = {}
    contents, (_, name) = contents_of(result), _PLACES[result["fit"]]
    for content in contents:
        for each in dict.fromkeys(map(Finding.from_dict, content["findings"])):
            owners.setdefault(each, []).append(content["fit"][name])
    common = ranked(each for each, names in owners.items() if len(names) == len(contents))
    single = ranked(each for each in owners if each not in common)
    words = (", ".join(dict.fromkeys(owners[each])) for each in single)
    return common + [replace(e, text=f"{w}: {e.text}") for e, w in zip(single, words, strict=True)]


def sources_of(result: Content) -> str:
    """The tables in words."""
    return " and ".join("shipped tables" if t == "shipped" else t for t in result["tables"])


def left_out(result: Content) -> Iterator[str]:
    """Rows, curves and formulas that were left out, and why."""
    skipped = (text for each in contents_of(result)[:1] for text in each["fit"].get("skipped", ()))
    for text in (*result["rows_left_out"], *skipped):
        yield f"left out: {text}"
    for name, why in result.get("not_fitted", {}).items():
        yield f"not fitted: {name}: {why}"


def shown(result: Content) -> Iterator[Block]:
    """What was fitted and what was left out, the answer, every warning once."""
    yield Paragraph(f"{_subject(result)} ({sources_of(result)})")
    yield from map(Paragraph, left_out(result))
    if result["fit"] == "residual":
        yield Callout("bad", f"GRADE: {result['grade']}")
        yield Paragraph(f"The grade holds {holds(result)}")
    yield from _answer_tables(result)
    yield from tables_of(result)
    callouts = tuple(Callout("doubt", f"warning: {each}") for each in warnings_of(result))
    if callouts:
        yield Section("warnings", "", callouts)


def _subject(result: Content) -> str:
    fits = [content["fit"] for content in contents_of(result)]
    campaigns = ", ".join(fits[0]["campaigns"]) if fits else ""
    match result["fit"]:
        case "stud-strength":
            return f"{fits[0]['tests']} tests of {campaigns}"
        case "load-slip":
            return f"{fits[0]['curves']} curves of {campaigns}"
        case "interaction":
            return f"{fits[0]['tests']} combined tests of {campaigns}: {fits[0]['grade']}"
        case "residual":
            return f"{max(fit['tests'] for fit in fits)} tests after pre-damage"
    return f"V_r = {number(result['known_variation'], 3)} is known from earlier tests"


def _answer_tables(result: Content) -> Iterator[Block]:
    """The tables that are the answer, on a terminal and in a report."""
    match result["fit"]:
        case "load-slip":
            yield from tables.load_slip(named_of(result))
        case "residual":
            yield from tables.residual(contents_of(result))
        case "interaction":
            yield from stud_design.interaction(contents_of(result)[0])
        case "few-tests":
            yield from stud_design.few(result["groups"])


def tables_of(result: Content) -> Iterator[Block]:
    """All tables of a fit, but those that are its answer in a report."""
    named, contents = named_of(result), contents_of(result)
    kinds, caption = {"judgement": "as fitted"}, "Unseen tests, test over prediction:"
    match result["fit"]:
        case "stud-strength":
            kinds = {"judgement": "as it is", "corrected": "as fitted"}
            caption = f"Unseen tests of {', '.join(result['validate'])}, test over prediction:"
            yield from tables.fitted(named)
            yield Paragraph(tables.least_scatter(result))
            yield from tables.exponents(named)
            yield from stud_design.posterior(contents, "model")
            yield from tables.unseen(named, kinds, caption)
            yield from tables.design_values(named)
            yield from tables.left_out(named)
            yield from tables.series(result["series"])
        case "load-slip":
            names = (f"median_{kind}_of_published_ollgaard" for kind in ("rms", "bias"))
            rms, bias = (number(contents[0]["fit"][name], 3) for name in names)
            published = f"misfit {rms}, bias {bias} of the load."
            yield Paragraph(f"Ollgaard's published law on these curves: {published}")
            yield from tables.band_coverage(named, result["confidence"])
            yield from tables.unseen_curves(named)
        case "residual":
            yield from tables.relations(contents)
            yield from stud_design.residual_design(contents)
            yield from stud_design.posterior(contents, "relation")
            yield from tables.unseen(named, kinds, caption)
        case "interaction":
            yield from tables.unseen(named, kinds, caption)


def size(result: Content) -> str:
    """How much was fitted."""
    fits = [content["fit"] for content in contents_of(result)]
    if not fits:
        return count(len(result["groups"]), "group") + " of nominally equal tests"
    what = "curve" if result["fit"] == "load-slip" else "test"
    most = max(fits, key=lambda fit: int(fit[f"{what}s"]))
    after = " after pre-damage" if result["fit"] == "residual" else ""
    if not most["campaigns"]:
        return f"no {what}{after}"
    campaigns = count(len(most["campaigns"]), "campaign")
    return f"{count(most[f'{what}s'], what)}{after} of {campaigns}"


def holds(result: Content) -> str:
    """Where the grade holds."""
    told = dict.fromkeys(c["fit"].get("holds", "for these tests") for c in contents_of(result))
    return "; ".join(told) or "for these tests"


def stud_of(content: Content) -> str:
    """The stud of a residual capacity, or the damage of tests of unknown studs."""
    fit = content["fit"]
    return str(fit["stud"] or f"{fit['predamage']}, {fit['measure']}")


def formula(result: Content) -> tuple[str, Content]:
    """The formula of least scatter within campaigns, among equals the first."""
    best = result["least_scatter"]
    return next((n, c) for n, c in named_of(result).items() if c["fit"]["key"] == best)


def grade(result: Content) -> Iterator[Block]:
    """The grade of the evidence, and where it holds."""
    contents = contents_of(result)
    if not contents:
        known = number(result["known_variation"], 3)
        text = f"rests on a scatter that is taken as known, V_r = {known}, not on these tests"
        yield Callout("doubt", f"Grade: {text}.")
        return
    grades = "; ".join(dict.fromkeys(content["fit"]["grade"] for content in contents))
    tone = "doubt"
    if result["fit"] == "residual":
        tone = "good" if all(content["validated"] for content in contents) else "bad"
    yield Callout(tone, f"Grade: {grades}. It holds {holds(result)}.")


def answer(result: Content) -> Iterator[Block]:
    """What the tests say, the first thing that a reader wants to know."""
    yield from _answer_tables(result)
    texts = []
    if result["fit"] == "stud-strength":
        texts = list(_strength(result))
    elif result["fit"] == "residual":
        texts = list(_left(result))
    unseen = [
        f"{name}: {stud_design.judged(content['judgement'])}."
        for name, content in named_of(result).items()
        if content["judgement"]
    ]
    yield from (Bullets(tuple(items)) for items in (texts, unseen) if items)


def _left(result: Content) -> Iterator[str]:
    """What a designer takes at the end of the tested damage."""
    for content in contents_of(result):
        for row in content["design"][-1:]:
            text = f"{content['fit']['quantity']} at damage {row['level']:.3g}, the largest "
            text += f"tested: {number(row['median'], 3)} left in the median, "
            if row["characteristic"] is None:
                text += stud_design.NO_VALUE
            else:
                text += f"{number(row['characteristic'], 3)} as characteristic value"
            if row["design"] is not None:
                text += f", {number(row['design'], 3)} that 0.1 % of new tests fall below"
            yield f"{text}."


def _strength(result: Content) -> Iterator[str]:
    fits = {content["fit"]["key"]: content["fit"] for content in contents_of(result)}
    code = fits[CODE]["d8"] if CODE in fits else None
    if code is not None and code["count"] >= LEAST_FOR_DESIGN and code["gamma_m_star"] is not None:
        star = code["gamma_m_star"]
        verdict = "these tests are covered" if star <= CODE_FACTOR else "these tests ask for more"
        yield (
            f"Partial factor: EN 1990 D.8 [@en1990] asks for γ_M* = {number(star, 3)} on the "
            f"characteristic resistance of EN 1994-1-1 [@en1994-1-1], which has {CODE_FACTOR:g}: "
            f"{verdict}."
        )
    for series in [group for group in result["series"] if group["result"]][:_MOST_SERIES]:
        found = series["result"]
        loads = (number(tables.KILO * found[name], 4) for name in ("P_Rk", "P_Rd"))
        yield "Annex B of EN 1994-1-1, {}, {}: P_Rk = {} kN and P_Rd = {} kN per stud.".format(
            series["name"], count(series["tests"], "test"), *loads
        )
    for series in result["series"]:
        if not series["result"] and series["tests"] >= LEAST_IN_SERIES:
            tests = count(series["tests"], "test")
            yield f"Annex B does not apply to {series['name']}, {tests}: {series['refusal']}."
    name, content = formula(result)
    bias, sigma = content["fit"]["parameters"]["bias"], content["fit"]["sigma"]["value"]
    yield (
        f"{tables.least_scatter(result)} By {name} the tests bore "
        f"{number(bias['value'], 3)} ({tables.span(bias['profile'])}) of its value in the median "
        f"and scatter by {percent(sigma, signed=False)} within campaigns."
    )


def method(result: Content) -> Iterator[Block]:
    """Formulas with their sources, and how they were fitted."""
    named = named_of(result)
    match result["fit"]:
        case "stud-strength":
            yield _formulas(named, FORMULAS)
            yield Paragraph(
                "Shank d, height h after welding, area A_s = π d²/4, tensile strength f_u, mean "
                "cylinder strength f_c and modulus E_c of the concrete, per stud and with the "
                "values of the tests. The logarithm of test over prediction is regressed on a "
                "constant, whose exponential is the median ratio. " + _MIXED
            )
            content = next(iter(named.values()))
            if content["fit"]["d8"]["count"] >= LEAST_FOR_DESIGN:
                yield stud_design.reference_stud(content["fit"]["reference"])
        case "load-slip":
            yield _formulas(named, LAWS)
            yield Paragraph(
                "Slip s, load over its largest value q. Every curve gives its own parameters, "
                "whose logarithms are regressed on a constant: a curve of many points counts once. "
                + _MIXED
            )
        case "residual":
            relations = [(name, each.formula) for name, each in (RELATIONS | ANCHORED).items()]
            yield Definitions(tuple(relations))
            sources = " ".join(map(cited, (*SOURCES, "en1990")))
            yield Paragraph(
                "Damage D, share left R: of the test over its undamaged reference. Relations are "
                "averaged by how well they predict campaigns (with one campaign specimens) that "
                "are left out; the band is that of a new test of a new campaign, its "
                "fractiles of 5 and 0.1 %, as in EN 1990 D.8, are characteristic and design share. "
                f"{_MIXED} Sources: {sources}."
            )
        case "interaction":
            sources = " ".join(map(cited, ("aisc360-22", "aci318-19")))
            yield Paragraph(
                "Tension t and shear v, each over the mean resistance of pull-outs and push-outs "
                "of the same campaign and diameter. The logarithm of how far out a test lies in "
                f"its direction is regressed on that of t^p + v^p = 1. {_MIXED} Laws of the codes: "
                f"{sources}."
            )
        case "few-tests":
            yield Paragraph(
                "EN 1990 D.8.4 [@en1990]: the characteristic value is the mean times η_k, which "
                "the scatter known from earlier tests with the same resistance gives for one to "
                "three tests within 10 % of their mean. These tests do not tell that scatter."
            )


def _formulas(named: tables.Named, known: Mapping[str, Any]) -> Definitions:
    """Formulas or laws with their sources; `known`, by their own keys."""
    fitted = ((name, known[content["fit"]["key"]]) for name, content in named.items())
    return Definitions(tuple((n, f"{e.formula} {' '.join(map(cited, e.keys))}") for n, e in fitted))
