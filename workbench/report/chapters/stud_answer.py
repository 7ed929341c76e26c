"""What `workbench fit` shows, from the content of its JSON object."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

from workbench.content.formatting import number
from workbench.content.tree import Block, Callout, Paragraph, Section
from workbench.report.chapters import stud_design
from workbench.report.chapters import stud_tables as tables
from workbench.report.chapters.stud_tables import Content
from workbench.responses import Finding
from workbench.studs.formulas import FORMULAS
from workbench.studs.trust import ranked

# where the contents of a fit are, and what names each of them
_PLACES = {
    "stud-strength": ("models", "model"),
    "load-slip": ("laws", "law"),
    "residual": ("quantities", "quantity"),
    "interaction": ("laws", "law"),
}


def labelled(result: Content) -> Content:
    """The content with formulas under the names of their sources; `key` keeps their own."""
    if result["fit"] not in _PLACES:
        return result
    place, name = _PLACES[result["fit"]]
    formulas = result["fit"] == "stud-strength"
    contents = [
        {**each, "fit": {**each["fit"], name: FORMULAS[key].label if formulas else key, "key": key}}
        for each in result[place]
        for key in [each["fit"][name]]
    ]
    return {**result, place: contents}


def contents_of(result: Content) -> list[Content]:
    """The contents of all that was fitted; none where nothing is."""
    return list(result[_PLACES[result["fit"]][0]] if result["fit"] in _PLACES else ())


def named_of(result: Content) -> Mapping[str, Content]:
    """The contents by the names of formulas, laws or quantities."""
    return {content["fit"][_name(result)]: content for content in contents_of(result)}


def _name(result: Content) -> str:
    return _PLACES.get(result["fit"], ("", ""))[1]


def warnings_of(result: Content) -> list[Finding]:
    """Every warning once, the decisive ones first; those of some alone are said to be theirs."""
    owners: dict[Finding, list[str]] = {}
    contents, name = contents_of(result), _name(result)
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
    known, contents, blocks = named_of(result), contents_of(result), tuple[Block, ...]()
    fit: Content = contents[0]["fit"] if contents else {}
    campaigns = ", ".join(fit.get("campaigns", ()))
    match result["fit"]:
        case "stud-strength":
            what = f"{fit['tests']} tests of {campaigns}"
        case "load-slip":
            what, blocks = f"{fit['curves']} curves of {campaigns}", (*tables.load_slip(known),)
        case "interaction":
            what = f"{fit['tests']} combined tests of {campaigns}: {fit['grade']}"
            blocks = (*stud_design.interaction(contents[0]),)
        case "residual":
            what = f"{max(each['fit']['tests'] for each in contents)} tests after pre-damage"
            holds = "; ".join(dict.fromkeys(each["fit"]["holds"] for each in contents))
            grade = Callout("bad", f"GRADE: {result['grade']}")
            blocks = (grade, Paragraph(f"The grade holds {holds}"), *tables.residual(contents))
        case _:
            what = f"V_r = {number(result['known_variation'], 3)} is known from earlier tests"
            blocks = (*stud_design.few(result["groups"]),)
    yield Paragraph(f"{what} ({sources_of(result)})")
    yield from map(Paragraph, left_out(result))
    yield from blocks
    yield from tables_of(result)
    callouts = tuple(Callout("doubt", f"warning: {each}") for each in warnings_of(result))
    if callouts:
        yield Section("warnings", "", callouts)


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
