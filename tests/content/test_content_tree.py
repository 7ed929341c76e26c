"""The light markup, and that nothing in a text is ever read as HTML or Typst markup."""

from __future__ import annotations

import re
from dataclasses import replace

from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.base.catalogue import datasets
from workbench.models.registry import offers
from workbench.report.page.bibliography import bibliography, reference_of
from workbench.report.page.documents import render_html, render_markdown, render_pdf
from workbench.report.page.terminal import render_text
from workbench.report.page.tree import (
    ELSEWHERE,
    Column,
    Document,
    Paragraph,
    Picture,
    Run,
    Section,
    Table,
    runs_of,
)
from workbench.study.assessment import METRICS


def test_runs():
    assert list(runs_of("as [@heng2017] says, `a = 1`.")) == [
        Run("plain", "as "),
        Run("cite", "heng2017"),
        Run("plain", " says, "),
        Run("code", "a = 1"),
        Run("plain", "."),
    ]


@given(st.text(max_size=60))
def test_runs_lose_nothing(text):
    back = {"plain": "{}", "code": "`{}`", "cite": "[@{}]", "see": "[#{}]"}
    assert "".join(back[run.kind].format(run.text) for run in runs_of(text)) == text


def test_figures_and_tables_are_numbered_and_named_by_texts():
    table = Table.of("values", "All values.", (Column("x", of=str),), "ab")
    picture = Picture("plot", "A plot", "Seen.", "", "alt")
    text = Paragraph("[#plot] and [#again] draw [#values], not [#nothing].")
    inner = Section("inner", "Inner", (picture, replace(picture, key="again")))
    whole = Document("Title", "", (), (Section("outer", "Outer", (table, inner, text)),))
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
    section = Section("part", text, (Paragraph(text),))
    return Document(text, "", (text,), (section,))


HOSTILE = [
    '<script>alert("x")</script>',
    "#panic() $x$ *bold* _it_ @label <label> \\ \" ' // /* ]",
    '"); #read("/etc/passwd"); ("',
    "{{ 7 * 7 }} {% raw %}",
    "`unclosed and [@unknown-key]",
]


def test_hostile_texts_are_shown_as_they_are_in_html():
    for text in HOSTILE:
        html = render_html(document(text))
        assert "<script>alert" not in html
        assert "49" not in html.partition("<main>")[2].partition("</main>")[0]


def test_hostile_texts_are_shown_as_they_are_in_typst():
    for text in HOSTILE:
        assert render_pdf(document(text)).startswith(b"%PDF")


@settings(max_examples=30)
@given(st.text(max_size=40))
def test_any_text_can_be_set(text):
    assert render_pdf(document(text)).startswith(b"%PDF")


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
