"""The output streams of a process made to take any text: closed ones, and those not UTF-8."""

import codecs
import os
import re
import sys
import unicodedata
from pathlib import Path

_PLAIN = {
    **{"±": "+/-", "−": "-", "–": "-", "—": "-", "─": "-", "×": "x", "·": ".", "→": "->"},
    **{"≤": "<=", "≥": ">=", "√": "sqrt ", "∞": "inf", "½": "1/2", "µ": "u", "ß": "ss"},
}
_RAISED = re.compile("[⁰¹²³⁴-⁹⁻]+")  # exponents


def prepare() -> None:
    """Let both streams replace what they cannot encode; one that is closed leads nowhere."""
    codecs.register_error("workbench", _replaced)
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, Path(os.devnull).open("w", encoding="utf-8"))  # noqa: SIM115
        getattr(sys, name).reconfigure(errors="workbench")


def plain(text: str) -> str:
    """A text in ASCII: signs as programmers write them, Greek letters by name, ? for the rest."""
    return "".join(map(_letter, _RAISED.sub(lambda match: f"^{match[0]}", text)))


def _letter(letter: str) -> str:
    whole = unicodedata.normalize("NFKD", _PLAIN.get(letter, letter))
    known = "".join(_PLAIN.get(part, part) for part in whole).encode("ascii", "ignore").decode()
    name = unicodedata.name(letter, "")
    return known or (name.split()[-1].lower() if name.startswith("GREEK") else "?")


def _replaced(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return plain(error.object[error.start : error.end]), error.end
