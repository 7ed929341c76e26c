"""What a column refuses, and what follows from its supports."""

from __future__ import annotations

from dataclasses import replace

import pytest

from workbench.base.errors import InputError
from workbench.scenarios import Column, ColumnPushover
from workbench.steel.sections import find

COLUMN = Column(find("HEB 220"), 0.8, 3.2)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_loads_stay_below_the_squash_load_in_tension_and_compression(sign: float) -> None:
    squash = COLUMN.properties.squash_load
    assert replace(COLUMN, axial_load=0.99 * sign * squash).axial_load == 0.99 * sign * squash
    with pytest.raises(InputError, match=r"column\.axial_load.*below the squash load"):
        replace(COLUMN, axial_load=1.01 * sign * squash)


def test_a_push_ends_where_the_shorter_segment_does() -> None:
    assert ColumnPushover("far", COLUMN, 1.59).displacement == 1.59
    with pytest.raises(InputError, match=r"displacement.*twice the shorter segment, 1\.6 m"):
        ColumnPushover("too far", COLUMN, 1.61)


def test_stubs_are_no_columns() -> None:
    stocky = replace(COLUMN, length_below=0.2, length_above=0.25)
    assert stocky.length == pytest.approx(0.45)
    with pytest.raises(InputError, match="section heights long"):
        replace(COLUMN, length_below=0.2, length_above=0.23)


@pytest.mark.parametrize(
    ("base", "head", "factor"),
    [
        ("clamped", "guided", 0.5),
        ("clamped", "fixed", 0.5),
        ("clamped", "pinned", 0.699156),
        ("pinned", "guided", 0.699156),
        ("pinned", "pinned", 1.0),
    ],
)
def test_buckling_lengths_are_those_of_euler(base: str, head: str, factor: float) -> None:
    assert replace(COLUMN, base=base, head=head).effective_length_factor() == factor
