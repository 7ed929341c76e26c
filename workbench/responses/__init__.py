"""What a model answers: the response dataset, its outcome and its provenance."""

from workbench.responses.build import Response as Response
from workbench.responses.build import build_response as build_response
from workbench.responses.build import check_response as check_response
from workbench.responses.build import collapse_of as collapse_of
from workbench.responses.build import collapsed_response as collapsed_response
from workbench.responses.build import energy_error as energy_error
from workbench.responses.build import failed_response as failed_response
from workbench.responses.build import findings_of as findings_of
from workbench.responses.build import is_synthetic as is_synthetic
from workbench.responses.build import outcome_of as outcome_of
from workbench.responses.build import places_of as places_of
from workbench.responses.build import response_of as response_of
from workbench.responses.build import scalars_of as scalars_of
from workbench.responses.build import set_findings as set_findings
from workbench.responses.build import survives as survives
from workbench.responses.build import warnings_of as warnings_of
from workbench.responses.histories import open_share as open_share
from workbench.responses.histories import peak_contact_force as peak_contact_force
from workbench.responses.histories import peak_of as peak_of
from workbench.responses.outcome import Finding as Finding
from workbench.responses.outcome import Outcome as Outcome
from workbench.responses.provenance import provenance as provenance
from workbench.responses.variables import ENERGIES as ENERGIES
from workbench.responses.variables import SCALARS as SCALARS
from workbench.responses.variables import VARIABLES as VARIABLES
