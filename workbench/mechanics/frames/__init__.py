"""Common parts of all models of frames: structure, runs, snapshots, limits of their domain."""

from typing import Any

from workbench.base.errors import OutOfDomainError
from workbench.responses import finding


def out_of_domain(name: str, **values: Any) -> OutOfDomainError:
    """Return the error of a scenario that cannot be answered, in the words of that finding."""
    return OutOfDomainError(finding(name, **values).text)
