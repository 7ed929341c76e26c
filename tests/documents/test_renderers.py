"""One page on a terminal and in Markdown; HTML and Typst are looked at in `tests/report`."""

from __future__ import annotations

import pytest

from workbench.report.page.documents import Document, render_markdown
from workbench.report.page.markdown import (
    ABSENT,
    MOST_ROWS,
    Cell,
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
from workbench.report.page.terminal import render_text

RECORDS = [{"name": "a | b", "value": 1.5, "count": 3}, {"name": "c", "value": None, "count": 40}]
TABLE = Table.of(
    "numbers",
    "Values [@heng2017].",
    (
        PageColumn("name", of="name"),
        PageColumn(
            "value",
            True,
            of=lambda r: (
                None if r["value"] is None else Cell(f"{r['value']:.2f}", r["value"], "bad")
            ),
        ),
        PageColumn("count", True, of="count"),
    ),
    RECORDS,
)


def test_a_table_of_records():
    assert TABLE.rows[0] == (Cell("a | b"), Cell("1.50", 1.5, "bad"), Cell("3", 3))
    assert TABLE.rows[1] == (Cell("c"), ABSENT, Cell("40", 40))
    assert Table.of("k", "", (PageColumn("x", of="text"),), [Cell("t")]).rows == ((Cell("t"),),)
    long = Table.of("k", "All.", (PageColumn("x", of=str),), range(MOST_ROWS + 2))
    assert len(long.rows) == MOST_ROWS
    assert long.caption.endswith(f"{MOST_ROWS + 2} rows; the stored tables hold all.")


def test_the_terminal_gets_aligned_columns_and_no_line_of_a_pipe_is_broken():
    long = "word " * 100
    text = render_text(paragraph(long), TABLE, callout("bad", "careful"))
    lines = text.splitlines()
    assert lines[:3] == [long.strip(), "", "Values (Heng, P. 2017)."]
    head, _, first, second = lines[3:7]
    assert head.index("count") + len("count") == len(first) == len(second)
    assert first.index("1.50") + 3 == second.index("–")
    assert lines[7:] == ["", "careful"]
    assert "\x1b" not in text


def test_the_terminal_is_fitted_and_coloured_on_demand():
    text = render_text(TABLE, paragraph("word " * 30), width=40, colour=True)
    assert "\x1b[31m" in text
    assert max(map(len, render_text(TABLE, paragraph("word " * 30), width=40).splitlines())) <= 40


def test_sections_and_lists_on_the_terminal():
    blocks = (
        paragraph("before"),
        section("s", "Title", bullets(("one", "two")), definitions((("term", "`code`"),))),
        listing("file", "a = 1"),
    )
    assert render_text(*blocks).splitlines() == [
        "before",
        "",
        "Title",
        "  - one",
        "  - two",
        "  term  `code`",
        "file",
        "  a = 1",
    ]


@pytest.fixture(scope="module")
def page() -> str:
    picture = Picture("p", "t", "caption", "", "alt", statements=("said",), image="figures/p.png")
    sections = (
        section("a", "", paragraph("asked <b>"), TABLE, callout("doubt", "two\nlines")),
        section("b", "Part", picture, definitions((("term", "text"),)), listing("l", "x = 1")),
    )
    return render_markdown(
        Document("Name", "", ("made by `x`",), literal(sections), {"p": picture})
    )


def test_markdown(page):
    assert page.startswith("# Name\n\nasked &lt;b>\n\n**Table 1.** Values (Heng, P. 2017).\n\n")
    assert "\n| name | value | count |\n|---|---:|---:|\n| a \\| b | ❌ 1.50 | 3 |\n" in page
    assert (
        "\n> two lines\n\n## Part\n\n![alt](figures/p.png)\n\n**Figure 1.** caption\n\n- said\n\n"
        in page
    )
    assert "\n- term: text\n\nl\n\n```\nx = 1\n```\n\n---\n\nmade by `x`\n" in page
