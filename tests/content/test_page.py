"""Templates as blocks: structure comes from the template alone, values are never read as such."""

from __future__ import annotations

from pathlib import Path

import pytest
from jinja2 import UndefinedError

from workbench.report.page.page import Page
from workbench.report.page.tree import Bullets, Callout, Paragraph, Section, Table

TEMPLATE = """
{% macro part(title, name, items, rows) %}
# part: {{ title }}

{{ name }} begins a paragraph
that goes on.

{% for item in items %}
- {{ item }}
{% endfor %}

! doubt: careful, {{ twice(name) }}

## inner: Inner

{% call table("rows", rows, [
  text("name", "row.name"),
  number("half", "(row.size / 2) | valued(2)", 0.5),
  text("twice", both, 2.0),
]) %}
Rows of {{ name }}.
{% endcall %}
{% endmacro %}

{% macro twice(name) %}
{{ name }}
{{ name }}
{% endmacro %}

{% macro both(row) %}{{ twice(row.name) }}{% endmacro %}
"""


@pytest.fixture
def page(tmp_path: Path) -> Page:
    (tmp_path / "chapter.jinja").write_text(TEMPLATE, encoding="utf-8")
    return Page(str(tmp_path / "chapter.py"))


@pytest.mark.parametrize("name", ["a", "- # x", "! bad: y", "{{ 7 * 7 }}", "two\nlines"])
def test_values_are_never_structure(page: Page, name: str) -> None:
    section = page.section(
        "part", title=name, name=name, items=[name, "b"], rows=[{"name": name, "size": 3.0}]
    )
    assert section is not None
    assert section.title == name
    text, bullets, callout, inner = section.blocks
    assert text == Paragraph(f"{name} begins a paragraph that goes on.")
    assert bullets == Bullets((name, "b"))
    assert callout == Callout("doubt", f"careful, {name} {name}")
    assert isinstance(inner, Section)
    (table,) = inner.blocks
    assert isinstance(table, Table)
    assert table.caption == f"Rows of {name}."
    assert [column.numeric for column in table.columns] == [False, True, False]
    assert table.rows[0][1].text == "1.5"
    assert table.rows[0][1].sort == 1.5


def test_what_has_no_content_is_left_out(page: Page) -> None:
    section = page.section("part", title="t", name="n", items=[], rows=[])
    assert section is not None
    assert [block.kind for block in section.blocks] == ["paragraph", "callout"]


def test_a_name_that_is_missing_is_an_error(page: Page) -> None:
    with pytest.raises(UndefinedError):
        page.words("part", title="t", name="n", items=[])
