"""Answers as notebooks show them: a title, a sentence, a table."""

from collections.abc import Mapping
from html import escape
from typing import Any

import pandas as pd


def html_of(title: str, table: pd.DataFrame | Mapping[str, Any], text: str = "") -> str:
    """HTML of a table, or of names and values, below a title and a sentence."""
    if not isinstance(table, pd.DataFrame):
        rows = [f"<tr><th>{escape(n)}</th><td>{escape(str(v))}</td></tr>" for n, v in table.items()]
        body = f"<table>{''.join(rows)}</table>"
    else:
        body = table.to_html(index=False, na_rep="", float_format="{:.4g}".format, border=0)
    sentence = f"<p>{escape(text)}</p>" if text else ""
    return f"<div><b>{escape(title)}</b>{sentence}{body}</div>"
