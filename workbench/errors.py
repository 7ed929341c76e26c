"""The errors that the workbench raises, each with all that its message needs."""


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
        given = "" if value is None else f" = {shown(value)}"
        said = f"{allowed}; {advice}" if advice else allowed
        super().__init__(one_line(f"{one_line(field, 200)}{given}: {said}"))

    def __reduce__(self) -> tuple[type, tuple[object, ...]]:
        return type(self), (self.field, self.value, self.allowed, self.advice)


def told(error: BaseException) -> str:
    """What an error says; an error that is not of this package with its type."""
    own = isinstance(error, WorkbenchError)
    return str(error) if own else f"{type(error).__name__}: {error}"


def one_line(text: str, longest: int = 4000) -> str:
    """A text that fits into a line of a message: characters without a picture as their codes."""
    line = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text[:longest])
    return line if len(text) <= longest else line[: longest - 3] + "..."


def shown(value: object) -> str:
    """A value as messages show it: short, and never an error of its own."""
    try:
        return one_line(repr(value), 80)
    except (ValueError, RecursionError):  # more digits than Python prints; lists without end
        return f"({type(value).__name__} too large to show)"


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
