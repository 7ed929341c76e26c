"""What a model answers: the response dataset, its outcome and its provenance."""

from workbench.responses.build import (
    Response,
    add_warnings,
    build_response,
    check_response,
    failed_response,
    outcome_of,
    peak_contact_force,
    peak_of,
    residual_of,
    scalars_of,
    warnings_of,
)
from workbench.responses.outcome import Finding, Outcome
from workbench.responses.provenance import provenance
from workbench.responses.variables import (
    COORDINATES,
    ENERGIES,
    SCALARS,
    TIMES,
    VARIABLES,
    VOLATILE,
)

__all__ = [
    "COORDINATES",
    "ENERGIES",
    "SCALARS",
    "TIMES",
    "VARIABLES",
    "VOLATILE",
    "Finding",
    "Outcome",
    "Response",
    "add_warnings",
    "build_response",
    "check_response",
    "failed_response",
    "outcome_of",
    "peak_contact_force",
    "peak_of",
    "provenance",
    "residual_of",
    "scalars_of",
    "warnings_of",
]
