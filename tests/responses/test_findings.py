"""The table of findings: every name that is used is there, with the values of its sentence."""

from __future__ import annotations

import ast
import re
import tomllib
from pathlib import Path
from string import Formatter

import pytest

import workbench
from workbench.responses import Finding, finding

ROOT = Path(workbench.__file__).parent
TABLE = tomllib.loads((ROOT / "responses" / "findings.toml").read_text(encoding="utf-8"))
NOT_VALUES = {"subject", "refusal", "parts"}


def calls() -> list[tuple[str, str, set[str]]]:
    """File, pattern of the name and values of every finding that the package makes."""
    result = []
    for path in sorted(ROOT.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            made = isinstance(node, ast.Call) and ast.unparse(node.func) == "finding"
            if made and node.args:
                names = ast.unparse(node.args[0])
                pattern = re.sub(r"\{[^}]*\}", ".*", names.removeprefix("f").strip("'\""))
                if isinstance(node.args[0], ast.Name | ast.IfExp):
                    pattern = ".*"
                values = {str(keyword.arg) for keyword in node.keywords} - NOT_VALUES
                values |= {"number"} if len(node.args) > 1 else set()
                result.append((path.name, pattern, values))
    return result


def wanted(name: str) -> set[str]:
    """The values that the sentence and the remedy of an entry ask for."""
    entry = TABLE[name]
    texts = entry["sentence"] + entry.get("remedy", "") + "".join(entry.get("parts", {}).values())
    values = {value for _, value, _, _ in Formatter().parse(texts) if value}
    limit = entry.get("limit")
    return values | ({limit} if isinstance(limit, str) else set())


def test_every_finding_is_in_the_table_with_its_values() -> None:
    for file, pattern, values in calls():
        names = [name for name in TABLE if re.fullmatch(pattern, name)]
        assert names, f"{file}: {pattern}"
        if not pattern.startswith(".*"):
            for name in names:
                known = "None" in values or wanted(name) <= values  # values of a mapping
                assert known, f"{file}: {name} lacks {wanted(name) - values}"


def test_every_entry_is_used() -> None:
    text = "\n".join(path.read_text(encoding="utf-8") for path in ROOT.rglob("*.py"))
    patterns = {pattern for _, pattern, _ in calls()} - {".*"}
    for name in TABLE:
        known = any(re.fullmatch(pattern, name) for pattern in patterns)
        assert known or f'"{name}"' in text or name.rpartition("-shear-")[0] in text, name


def test_a_finding_carries_its_number_and_the_limit() -> None:
    made = finding("yield-ratio", 0.97, least=0.99)
    assert (made.subject, made.number, made.limit) == ("yield-ratio", 0.97, 0.99)
    assert made.text.startswith("yield ratio 0.9700 is below 0.99")
    assert Finding.from_dict(made.as_dict()) == made
    with pytest.raises(KeyError):
        finding("yield-ratio", 0.97)
