"""Marks of pages, and that nothing in a value is ever read as HTML, Markdown or Typst."""

from __future__ import annotations

import html as entities
import re
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.base.catalogue import datasets
from workbench.models.base import offers
from workbench.report.page.bibliography import bibliography, reference_of
from workbench.report.page.documents import (
    Document,
    render_html,
    render_markdown,
    render_pdf,
    typst_source,
)
from workbench.report.page.markdown import (
    PageColumn,
    Picture,
    Table,
    bullets,
    callout,
    definitions,
    listing,
    literal,
    paragraph,
    section,
)
from workbench.report.page.reading import ELSEWHERE, Run, read, words_of
from workbench.report.page.terminal import render_text
from workbench.study.assessment import METRICS


def runs_of(text: str) -> list[Run]:
    (block,) = read(paragraph(text))
    return list(words_of(block).runs)


def test_runs():
    assert runs_of("as [@heng2017] says, `a = 1`.") == [
        Run("plain", "as "),
        Run("cite", "heng2017"),
        Run("plain", " says, "),
        Run("code", "a = 1"),
        Run("plain", "."),
    ]


@given(st.text(st.characters(exclude_categories=["Cs", "Co", "Z", "Cc"]), min_size=1, max_size=60))
def test_runs_lose_nothing(text):
    back = {"code": "`{}`", "cite": "[@{}]", "see": "[#{}]"}
    assert "".join(back.get(run.kind, "{}").format(run.text) for run in runs_of(text)) == text


def test_figures_and_tables_are_numbered_and_named_by_texts():
    table = Table.of("values", "All values.", (PageColumn("x", of=str),), "ab")
    picture = Picture("plot", "A plot", "Seen.", "", "alt")
    text = paragraph("[#plot] and [#again] draw [#values], not [#nothing].")
    inner = section("inner", "Inner", picture, replace(picture, key="again"), level=2)
    page = section("outer", "Outer", table, inner, text)
    whole = Document("Title", "", (), page, dict.fromkeys(("plot", "again"), picture))
    assert whole.named == {"values": "Table 1", "plot": "Figure 1", "again": "Figure 2"}
    page, html = render_markdown(whole), render_html(whole)
    words = f"Figure 1 and Figure 2 draw Table 1, not {ELSEWHERE}."
    assert words in page
    assert words in re.sub("<[^>]*>", "", html)
    for target, name in (("plot-again", "Figure 2"), ("table-values", "Table 1")):
        assert f'href="#{target}">{name}</a>' in html
        assert f'id="{target}"' in html
        assert f"<b>{name}.</b>" in html
    assert "**Figure 2.** Seen." in page
    assert render_pdf(whole).startswith(b"%PDF")
    assert "Table" not in render_text(table)  # no document, no number


def document(text: str) -> Document:
    page = section(
        *("part", text, paragraph(text), bullets([text]), callout("bad", text)),
        *(definitions([(text, text)]), listing(text, text)),
        Table.of(text, text, (PageColumn(text, of=str),), [text]),
    )
    return Document(text, "", (text,), page)


HOSTILE = [
    '<script>alert("x")</script>',
    "#panic() $x$ *bold* _it_ @label <label> \\ \" ' // /* ]",
    '"); #read("/etc/passwd"); ("',
    "{{ 7 * 7 }} {% raw %}",
    "`unclosed and [@unknown-key]",
    "a|b \\| c\\",
    "# head ** __x__ ~~~ > [!bad] - 1. [a](b) &lt;",
]


@pytest.mark.parametrize("text", HOSTILE)
def test_hostile_texts_are_shown_as_they_are(text):
    whole = document(text)
    html = render_html(whole)
    body = html.partition("<main>")[2].partition("</main>")[0]
    assert "<script>alert" not in html
    assert "49" not in body
    words = text.replace("[@unknown-key]", "[1]")
    shown = entities.unescape(re.sub("<[^>]*>", "\n", body.replace('<a class="cite" href="#ref-'
        'unknown-key">[1]</a>', "[1]"))).split("\n")  # fmt: skip
    assert shown.count(words) >= 6  # heading, texts, terms, the table and its cells
    spoken = text.replace("[@unknown-key]", "(unknown-key)")
    terminal = render_text(whole.text)
    assert terminal.count(spoken) >= 5
    source = typst_source(whole)
    plain = text.partition("[@")[0].replace("\\", "\\\\").replace('"', '\\"')
    assert source.count(f'plain("{plain}') >= 5
    assert render_pdf(whole).startswith(b"%PDF")


@settings(max_examples=30)
@given(st.text(max_size=40))
def test_any_text_can_be_set(text):
    assert render_pdf(Document(text, "", (text,), section("part", text, paragraph(text)))
    ).startswith(b"%PDF")  # fmt: skip


def test_values_of_values_stay_as_they_are():
    once = literal("a *b* `c|d` [@heng2017] \\")
    assert literal(str(once)) == once


def test_every_source_of_models_metrics_and_data_is_in_the_bibliography():
    keys = {metric.citation for metric in METRICS.values()}
    keys |= {key for dataset in datasets() for key in dataset.key.split()}
    keys |= {"roache1994", "celik2008", "asme-vv20", "fds-validation"}
    for offer in offers():
        # a property (published series) is answered by the catalogue above
        sources = getattr(offer.kind, "sources", ())
        keys |= set(sources if isinstance(sources, tuple) else ())
    assert keys <= set(bibliography())


def test_works_are_complete():
    for key, work in bibliography().items():
        assert work.key == key
        assert work.authors
        assert work.year.isdigit() or work.year == "n.d."
        assert work.title
        assert work.where
    assert reference_of("a private report").title == "a private report"
