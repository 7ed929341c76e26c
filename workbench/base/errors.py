"""The errors that the workbench raises, each with all that its message needs."""

from enum import StrEnum
from typing import Any, NamedTuple


class WorkbenchError(Exception):
    """Base of every error that the workbench raises on purpose.

    Examples
    --------
    >>> issubclass(wb.InputError, wb.WorkbenchError)
    True
    """


class InputError(WorkbenchError, ValueError):
    """An input cannot be used: which field, its value, what is allowed, what to do.

    Parameters
    ----------
    field : str
        Dotted path of the key, such as ``column.axial_load``.
    value : object
        The input; None where there is none.
    allowed : str
        Allowed range or choice, in words.
    advice : str
        Remedy.

    Examples
    --------
    >>> try:
    ...     wb.Column("HEB 220", length_below=800, length_above=3.2)
    ... except wb.InputError as error:
    ...     print(error.field, error.value, error.advice)
    column.length_below 800 lengths are in metres, not millimetres
    """

    def __init__(self, field: str, value: object, allowed: str, advice: str = "") -> None:
        self.field, self.value, self.allowed, self.advice = field, value, allowed, advice
        given = "" if value is None else f" = {shown(value)}"
        rule = f"{allowed}; {advice}" if advice else allowed
        super().__init__(one_line(f"{one_line(field, 200)}{given}: {rule}"))

    def __reduce__(self) -> tuple[type, tuple[object, ...]]:
        return type(self), (self.field, self.value, self.allowed, self.advice)


def message_of(error: BaseException) -> str:
    """The message of an error; with its type if it is not of this package."""
    known = isinstance(error, WorkbenchError)
    return str(error) if known else f"{type(error).__name__}: {error}"


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
    """A model met a state outside its assumptions; the message, or a finding, says which.

    And what to do.
    """


class CrumpledError(OutOfDomainError):
    """An element has lost its length to a hinge under compression: another mesh may go on."""


class Mechanism(StrEnum):
    """How a structure collapses, as a model sees it.

    Geometry: chords have left their supports, and displacements grow without end. Squash: axial
    compression has used up the strength. Buckling: its axial force has used up the resistance.
    Shear: an end has slid off its support.
    """

    GEOMETRY = "geometry"
    SQUASH = "squash"
    BUCKLING = "buckling"
    SHEAR = "shear"


class Collapse(NamedTuple):
    """A structure that does not survive: the `mechanism`, and the members or segments it is in.

    `displacement` (m) that was reached where it is recorded; `time` in s (None: the model or the
    scenario has none).
    """

    mechanism: Mechanism
    parts: tuple[str, ...]
    displacement: float
    time: float | None = None

    def __str__(self) -> str:
        when = "" if self.time is None else f"{self.time:.4g} s and "
        return f"collapse at {when}{self.displacement:.4g} m"


class CollapseError(WorkbenchError):
    """The structure collapsed, which is an answer: the `collapse`, and the `reason` in words.

    `findings` are what the run until then says of itself.
    """

    def __init__(self, collapse: Collapse, reason: str, findings: tuple[Any, ...] = ()) -> None:
        self.collapse, self.reason, self.findings = collapse, reason, findings
        super().__init__(f"{collapse}: {reason}; the model means nothing beyond")

    def __reduce__(self) -> tuple[type, tuple[object, ...]]:
        return type(self), (self.collapse, self.reason, self.findings)
