"""The page that is kept in git."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from workbench.report.build import summary
from workbench.study.assessor import read_assessment


@pytest.fixture(scope="module")
def study(small):
    """Three of the figures serve as well as all of them."""
    kept = [figure for figure in small.study.figures if figure.key in ("shape", "peaks", "curves")]
    return replace(small.study, figures=tuple(kept))


@pytest.fixture(scope="module")
def page(small, study, tmp_path_factory):
    return summary(read_assessment(small.directory, study), tmp_path_factory.mktemp("kept"))


@pytest.mark.thorough
def test_it_repeats(page, small, study, tmp_path):
    again = summary(read_assessment(small.directory, study), tmp_path)
    assert again.read_bytes() == page.read_bytes()
    pictures = sorted(path.name for path in (page.parent / "figures").iterdir())
    assert pictures == sorted(path.name for path in (tmp_path / "figures").iterdir())
    for name in pictures:
        first, second = page.parent / "figures" / name, tmp_path / "figures" / name
        assert first.read_bytes() == second.read_bytes()


def test_it_holds_verdicts_pictures_and_warnings(page, small, study):
    text = page.read_text(encoding="utf-8")
    rows = re.findall(r"^\| \S+ (?:pass|fail|inconclusive) .*", text, re.MULTILINE)
    assert len(rows) == len(small.study.gates)
    assert all(row.count(" | ") == 5 for row in rows)
    assert text.index("| model | all cases |") < text.index("| verdict | no. |")
    assert "V/Vpl = 1.80" in text
    links = re.findall(r"!\[[^\]]*\]\(([^)]+)\)", text)
    assert len(links) == len(study.figures) + 1  # and that of the convergence
    assert all((page.parent / link).is_file() for link in links)


def test_it_says_nothing_that_varies(page, small):
    text = page.read_text(encoding="utf-8")
    assert str(small.directory) not in text
    assert "/tmp" not in text
    assert not re.search(r"20\d\d-\d\d-\d\d", text)
    assert "wall time" not in text
    assert "cost" not in "".join(path.name for path in (page.parent / "figures").iterdir())


def test_names_are_escaped(page):
    assert "<i>single" not in page.read_text(encoding="utf-8")
