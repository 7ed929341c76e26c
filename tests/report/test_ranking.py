"""What the first page advises over many drawn columns."""

from __future__ import annotations

from types import SimpleNamespace

from workbench.content.terminal import render_text
from workbench.models.single_dof import SingleDof
from workbench.report.chapters import choice

FIRST = {
    **{"group": "slow", "label": "panels", "asked": 64, "judged": 60, "within": 50},
    **{"low": 8, "high": 2, "false_alarm": 0, "false_safe": 1, "refused": 4, "median": 0.98},
    **{"least": 0.85, "most": 1.05, "against": "panels", "pairs": 0, "wins": 0, "chance": None},
}
WORSE = {**FIRST, "label": "bars", "against": "panels", "pairs": 58, "wins": 50, "chance": 1e-8}
EQUAL = {**WORSE, "label": "frames", "wins": 30, "chance": 0.45}


def stored(*rows: dict) -> SimpleNamespace:
    return SimpleNamespace(rows={"ranking": list(rows)}, costs={"panels": 0.01})


def test_it_says_what_to_take_what_to_expect_and_what_is_not_surely_worse() -> None:
    text = choice.best_ranked([FIRST, WORSE, EQUAL], {"panels": 0.01})
    assert text.startswith(
        "take panels; peak within 10\u2009% in 50 of 60, expect \u22122.0\u2009% ("
    )
    assert "false safe in 1" in text
    assert "no answer in 4" in text
    assert "Not surely worse: frames." in text
    assert "bars" not in text
    assert text.endswith("Time: 1/100 of the reference")


def test_the_tree_says_which_model_where_and_how_it_did_unseen() -> None:
    leaf = {**FIRST, "region": "V/Vpl below 0.5", "count": 60, "asked": 12, "right": 11}
    rows = {"advice": [leaf, {**leaf, "region": ""}]}
    study = SimpleNamespace(models={"panels": SingleDof(resistance="panel", hit_mass="waves")})
    held = SimpleNamespace(rows=rows, study=study, costs={})
    text = " ".join(render_text(*choice.tree(held)).split())
    assert "on 22 of 24 hold-out columns" in text
    asked = "single-dof --option resistance=panel --option hit_mass=waves"
    assert f"V/Vpl below 0.5: take panels (`{asked}`); peak within 10 % in 50 of 60, expect" in text
    assert "any column: take panels" in text
    assert not (choice.tree(SimpleNamespace(rows={"advice": []}, costs={})))


def test_the_table_counts_pairs() -> None:
    section = choice.ranking(stored(FIRST, WORSE, EQUAL))
    assert section is not None
    text = " ".join(render_text(*section.blocks).split())
    assert "50 of 60" in text
    assert "50 of 58 pairs (1e-08)" in text
    assert "itself" in text
    assert choice.ranking(stored()) is None
