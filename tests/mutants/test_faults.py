"""The list of faults is kept: every text stands once in the package, every test file is there."""

from __future__ import annotations

from mutants.run import faults, mistakes


def test_every_fault_of_the_list_can_be_put_in() -> None:
    listed = faults()
    assert list(mistakes(listed)) == []
    assert len(set(listed)) == len(listed) >= 100
    assert all(fault.tests for fault in listed)
