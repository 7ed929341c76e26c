"""What `workbench fit` shows, from the content of its JSON object."""

from collections.abc import Iterator

from workbench.content.formatting import number
from workbench.content.tree import Block, Callout, Paragraph, Section
from workbench.report.chapters import stud_tables as tables
from workbench.report.chapters.stud_tables import Content


def _shown(result: Content, what: str, contents: list[Content], *blocks: Block) -> Iterator[Block]:
    """What was fitted and what was left out, the blocks, every warning once."""
    where = " and ".join("shipped tables" if t == "shipped" else t for t in result["tables"])
    yield Paragraph(f"{what} ({where})")
    for text in (*result["rows_left_out"], *contents[0]["fit"].get("skipped", ())):
        yield Paragraph(f"left out: {text}")
    yield from blocks
    warnings = dict.fromkeys(text for c in contents for text in c["fit"]["warnings"])
    if warnings:
        callouts = tuple(Callout("doubt", f"warning: {text}") for text in warnings)
        yield Section("warnings", "", callouts)


def strength(result: Content) -> Iterator[Block]:
    """Formulas of shear strength against tests, EN 1990 D.8, Annex B."""
    named = {content["fit"]["model"]: content for content in result["models"]}
    fit = result["models"][0]["fit"]
    kinds = {"judgement": "as it is", "corrected": "as fitted"}
    caption = f"Unseen tests of {', '.join(result['validate'])}, test over prediction:"
    yield from _shown(
        result,
        f"{fit['tests']} tests of {', '.join(fit['campaigns'])}",
        result["models"],
        *(Paragraph(f"not fitted: {name}: {why}") for name, why in result["not_fitted"].items()),
        *tables.fitted(named),
        *tables.exponents(named),
        *tables.unseen(named, kinds, caption),
        *tables.design_values(named),
        *tables.left_out(named),
        *tables.series(result["series"]),
    )


def load_slip(result: Content) -> Iterator[Block]:
    """Load-slip laws over curves, and on unseen ones."""
    named = {content["fit"]["law"]: content for content in result["laws"]}
    fit = result["laws"][0]["fit"]
    names = (f"median_{kind}_of_published_ollgaard" for kind in ("rms", "bias"))
    rms, bias = (number(fit[name], 3) for name in names)
    published = f"Ollgaard's published law on these curves: misfit {rms}, bias {bias} of the load."
    yield from _shown(
        result,
        f"{fit['curves']} curves of {', '.join(fit['campaigns'])}",
        result["laws"],
        *tables.load_slip(named),
        Paragraph(published),
        *tables.band_coverage(named, result["confidence"]),
        *tables.unseen_curves(named),
    )


def residual(result: Content) -> Iterator[Block]:
    """The grade first, then what is left after pre-damage."""
    contents = result["quantities"]
    named = {content["fit"]["quantity"]: content for content in contents}
    most = max(content["fit"]["tests"] for content in contents)
    yield from _shown(
        result,
        f"{most} tests after pre-damage",
        contents,
        Callout("bad", f"GRADE: {result['grade']}"),
        Paragraph(
            "The grade holds " + "; ".join(dict.fromkeys(c["fit"]["holds"] for c in contents))
        ),
        *tables.residual(contents),
        *tables.relations(contents),
        *tables.unseen(named, {"judgement": "as fitted"}, "Unseen tests, test over prediction:"),
    )
