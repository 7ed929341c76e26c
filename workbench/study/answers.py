"""The stored answers of one case of a study."""

from collections.abc import Mapping
from dataclasses import dataclass

from workbench.responses import Outcome, Response, findings_of, outcome_of
from workbench.study.definition import Case, Study


@dataclass(frozen=True)
class Answers:
    """The stored `responses` of one case by label; `asked` are all labels that are to answer."""

    study: Study
    case: Case
    asked: tuple[str, ...]
    responses: Mapping[str, Response]

    def ok(self, label: str) -> Response | None:
        """The response of a label, if it answered."""
        response = self.responses.get(label)
        if response is None or outcome_of(response) is not Outcome.OK:
            return None
        return response

    def why_not(self, label: str) -> str:
        """Why there is no answer of a label."""
        response = self.responses.get(label)
        if label not in self.asked:
            return f"the study does not ask {label}"
        if response is None:
            return f"{label} has not been run"
        refusals = [finding.text for finding in findings_of(response) if finding.refusal]
        said = refusals[0] if refusals else response.attrs["message"]
        return f"{label}: {outcome_of(response)}, {said}"

    def levels(self) -> list[str]:
        """Labels of the ladder that answered, coarse to fine, without a gap up to the finest."""
        levels: list[str] = []
        for label in reversed(self.study.ladder):
            if self.ok(label) is None:
                break
            levels.insert(0, label)
        return levels
