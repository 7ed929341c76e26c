"""Reports of stored studies: figures, HTML, PDF, and the summary that is kept in git."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from workbench.report.build import build_report
    from workbench.report.front_page import summary

__all__ = ["build_report", "summary"]


def __getattr__(name: str) -> Any:
    # drawing libraries take half a second to import: only when a report is built
    if name == "build_report":
        from workbench.report.build import build_report

        return build_report
    if name == "summary":
        from workbench.report.front_page import summary

        return summary
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
