"""The answer of a fit in words: its grade, what a designer takes from it, formulas and method."""

from collections.abc import Iterator, Mapping

from workbench.content.bibliography import cited
from workbench.content.formatting import count, number, percent
from workbench.content.tree import Block, Bullets, Callout, Definitions, Paragraph
from workbench.report.chapters import stud_design
from workbench.report.chapters import stud_tables as tables
from workbench.report.chapters.stud_answer import contents_of, named_of
from workbench.report.chapters.stud_evidence import judged, reference_stud
from workbench.report.chapters.stud_tables import LEAST_IN_SERIES, Content
from workbench.studs.answers.fits import SOURCES, STATISTICS, StudResidual
from workbench.studs.formulas import FORMULAS
from workbench.studs.relations import ANCHORED, RELATIONS
from workbench.studs.statistics.annex_d import LEAST_FOR_DESIGN

CODE, CODE_FACTOR = "en1994", 1.25  # whose partial factor designers know
_MOST_SERIES = 4  # that the answer names
_LAWS = {
    "ollgaard": "q = (1 − exp(−rate s))^exponent",
    "bilinear": "q = s / yield slip, at most 1",
    "rational": "q = k x / (1 + (k − 2) x + x²), x = s / peak slip, k the stiffness ratio",
}
_MIXED = (
    "Campaigns have a random effect each: restricted maximum likelihood, with profile intervals "
    "of the parameters [@pinheiro-bates2000]."
)


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
    match result["fit"]:
        case "stud-strength":
            yield Bullets(tuple(_strength(result)))
        case "load-slip":
            yield from tables.load_slip(named_of(result))
        case "residual":
            yield from tables.residual(contents_of(result))
            if items := tuple(_left(result)):
                yield Bullets(items)
        case "interaction":
            yield from stud_design.interaction(contents_of(result)[0])
        case "few-tests":
            yield from stud_design.few(result["groups"])
    told = [
        f"{name}: {judged(content['judgement'])}."
        for name, content in named_of(result).items()
        if content["judgement"]
    ]
    if told:
        yield Bullets(tuple(told))


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
            yield _formulas(named, {key: model.formula for key, model in FORMULAS.items()})
            yield Paragraph(
                "Shank d, height h after welding, area A_s = π d²/4, tensile strength f_u, mean "
                "cylinder strength f_c and modulus E_c of the concrete, per stud and with the "
                "values of the tests. The logarithm of test over prediction is regressed on a "
                "constant, whose exponential is the median ratio. " + _MIXED
            )
            content = next(iter(named.values()))
            if content["fit"]["d8"]["count"] >= LEAST_FOR_DESIGN:
                yield reference_stud(content["fit"]["reference"])
        case "load-slip":
            yield _formulas(named, _LAWS)
            yield Paragraph(
                "Slip s, load over its largest value q. Every curve gives its own parameters, "
                "whose logarithms are regressed on a constant: a curve of many points counts once. "
                + _MIXED
            )
        case "residual":
            relations = [(name, each.formula) for name, each in (RELATIONS | ANCHORED).items()]
            yield Definitions(tuple(relations))
            sources = " ".join(map(cited, (*StudResidual.sources, *STATISTICS[:1])))
            yield Paragraph(
                "Damage D, share left R: of the test over its undamaged reference. Relations are "
                "averaged by how well they predict campaigns (with one campaign specimens) that "
                "are left out; the band is that of a new test of a new campaign, whose fractiles of 5 "
                "and 0.1 % (those of EN 1990 D.8) are the characteristic and the design share. "
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


def _formulas(named: tables.Named, words: Mapping[str, str]) -> Definitions:
    """Formulas with their sources; `words`, by their own keys."""
    keys = {name: content["fit"]["key"] for name, content in named.items()}
    pairs = ((n, f"{words[key]} {' '.join(map(cited, SOURCES[key]))}") for n, key in keys.items())
    return Definitions(tuple(pairs))
