"""What a model answers: the response dataset, its outcome and its provenance."""

from workbench.responses.build import (
    Response,
    build_response,
    check_response,
    energy_error,
    failed_response,
    findings_of,
    outcome_of,
    scalars_of,
    set_findings,
    warnings_of,
)
from workbench.responses.histories import peak_contact_force, peak_of
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
    "build_response",
    "check_response",
    "energy_error",
    "failed_response",
    "findings_of",
    "outcome_of",
    "peak_contact_force",
    "peak_of",
    "provenance",
    "scalars_of",
    "set_findings",
    "warnings_of",
]
