"""Templates as pages: structure comes from the template alone, values are never read as such."""

from __future__ import annotations

from pathlib import Path

import pytest
from jinja2 import UndefinedError
from pages import views

from workbench.report.page.page import Page

TEMPLATE = """
{% macro part(title, name, items, rows) %}
# [!part] {{ title }}

{{ name }} begins a paragraph
that goes on, *as it should*.

{% for item in items %}
- {{ item }}
{% endfor %}

> [!doubt] careful, {{ twice(name) }}

## [!inner-{{ name }} folded] Inner

{% call table("rows", rows, [
  text("name", "row.name"),
  number("half", "(row.size / 2) | valued(2)", 0.5),
  text("twice", both, 2.0),
]) %}
Rows of {{ name }}.
{% endcall %}

## [!/]

after
{% endmacro %}

{% macro twice(name) %}
{{ name }}
{{ name }}
{% endmacro %}

{% macro both(row) %}{{ twice(row.name) }}{% endmacro %}
"""
HOSTILE = (
    *("a", "- # x", "> [!bad] y", "{{ 7 * 7 }}", "two\nlines", "1. one", "    code", "~~~"),
    *("<script>alert(1)</script>", "a | b", "*bold* _it_ **b**", "# head", "back\\slash\\"),
    *("[!table=x] [link](http://x) ![i](y)", "&amp; &lt;", "`", "a\n\n- b\n\n> c", "=== ---"),
    *("[!/]", "| a |\n|---|\n| b |", "\\", "$x$ ~x~ ^x^ :x: @x", "end  "),
)


@pytest.fixture
def page(tmp_path: Path) -> Page:
    (tmp_path / "chapter.jinja").write_text(TEMPLATE, encoding="utf-8")
    return Page(str(tmp_path / "chapter.py"))


@pytest.mark.parametrize("name", HOSTILE)
def test_values_are_never_structure(page: Page, name: str) -> None:
    text = page.blocks(
        "part", title=name, name=name, items=[name, "b"], rows=[{"name": name, "size": 3.0}]
    )
    section, words, bullets, callout, inner, table, after = views(text)
    assert (section.key, section.title) == ("part", name)
    assert words.text == f"{name} begins a paragraph that goes on, as it should."
    assert bullets.items == [name, "b"]
    assert (callout.tone, callout.text) == ("doubt", f"careful, {name} {name}")
    assert (inner.key, inner.title, inner.folded) == (f"inner-{name}", "Inner", True)
    assert (table.key, table.text) == ("rows", f"Rows of {name}.")
    assert table.numeric == [False, True, False]
    assert [cell.text for cell in table.rows[0]] == [name, "1.5", f"{name} {name}"]
    assert table.rows[0][1].sort == 1.5
    assert after.text == "after"
    assert page.words("twice", name=name) == f"{name} {name}"


def test_what_has_no_content_is_left_out(page: Page) -> None:
    text = page.blocks("part", title="t", name="n", items=[], rows=[])
    kinds = [view.kind for view in views(text)]
    assert kinds == ["section", "paragraph", "callout", "paragraph"]


def test_a_name_that_is_missing_is_an_error(page: Page) -> None:
    with pytest.raises(UndefinedError):
        page.words("part", title="t", name="n", items=[])
