"""The errors that the workbench raises, each with all that its message needs."""

from __future__ import annotations


class WorkbenchError(Exception):
    """Base of every error that the workbench raises on purpose."""


class InputError(WorkbenchError, ValueError):
    """An input cannot be used: which field, its value, what is allowed, what to do.

    Arguments: `field`, dotted path of the key, e.g. ``column.axial_load``; `value`, what was
    given (None: nothing); `allowed`, the allowed range or choice in words; `advice`, what to do
    about it.
    """

    def __init__(self, field: str, value: object, allowed: str, advice: str = "") -> None:
        self.field, self.value, self.allowed, self.advice = field, value, allowed, advice
        shown = repr(value)
        if len(shown) > 80:
            shown = shown[:77] + "..."
        text = f"{field}: {allowed}" if value is None else f"{field} = {shown}: {allowed}"
        super().__init__(text + (f"; {advice}" if advice else ""))

    def __reduce__(self) -> tuple[type, tuple[object, ...]]:
        return type(self), (self.field, self.value, self.allowed, self.advice)


class SolverError(WorkbenchError):
    """A solver did not converge: at which step, with which residual, what was tried.

    Arguments: `step`, what was being solved (with time or displacement); `residual`, the
    scaled residual that was left; `tried`, the remedies that had been applied.
    """

    def __init__(self, step: str, residual: float, tried: str) -> None:
        self.step, self.residual, self.tried = step, residual, tried
        super().__init__(f"no convergence at {step}: residual {residual:.3g}; tried {tried}")

    def __reduce__(self) -> tuple[type, tuple[object, ...]]:
        return type(self), (self.step, self.residual, self.tried)


class OutOfDomainError(WorkbenchError):
    """A model met a state outside its assumptions; the message says which and what to do."""
