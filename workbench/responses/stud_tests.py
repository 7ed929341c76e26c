"""Quantities by which models of studs are judged: pure numbers over the judged tests."""

from __future__ import annotations

STUD_TESTS: dict[str, str] = {
    "tests_fitted": "tests that a fit has used",
    "fitted_test_over_prediction": "median of test over prediction in the tests fitted",
    "test_over_prediction": "median of test over prediction in tests not used by a fit",
    "least_test_over_prediction": "smallest test over prediction in tests not used by a fit",
    "stiffness_test_over_prediction": "median of stiffness, test over prediction, in tests not "
    "used by a fit",
    "coverage": "share of the tests not used by a fit that lie inside the band",
}
