"""Impact problems with known answers as scenarios."""

from dataclasses import dataclass
from typing import ClassVar

from workbench.base.fields import Choice, Declared, Text, checked

PROBLEMS = (
    *("ball", "ball-lively", "ball-elastic", "table", "two-masses", "cradle", "oscillator"),
    *("grazing", "bar", "soft-impact", "soft-impact-plastic", "duffing", "column", "frame"),
)


@dataclass(frozen=True)
class ImpactProblem(Declared, table="impact"):
    """A problem of `workbench.extras.laboratory.problems`, or a struck column or frame."""

    name: str = checked(Text(), path="name")
    problem: str = checked(Choice(PROBLEMS))

    KIND: ClassVar[str] = "impact-problem"
    STATIC: ClassVar[bool | None] = None  # no structure, and no peak to compare
