"""Impacts whose inputs are uncertain as scenarios, which hold the lines of another one."""

from dataclasses import dataclass
from typing import Any, ClassVar

from workbench.base.fields import Declared, Many, Number, Text, checked


@dataclass(frozen=True)
class UncertainImpact(Declared, table="exceedance"):
    """An impact with distributions in place of numbers, over a range of velocities.

    Raises `InputError`.
    """

    name: str = checked(Text(), path="name")
    impact: tuple[str, ...] = checked(
        Many(Text(2000, shortest=0)), help="lines of a scenario file that has distributions"
    )
    low: float = checked(Number(0.01, 500.0, "m/s"), help="first impact velocity")
    high: float = checked(Number(0.01, 500.0, "m/s"), help="last impact velocity")
    displacement: float | None = checked(
        Number(1e-6, 100.0, "m"), optional=True, help="that is exceeded; without it, collapse"
    )

    KIND: ClassVar[str] = "uncertain-impact"
    STATIC: ClassVar[bool | None] = None  # one number of a distribution, no peak to compare

    def check(self) -> None:
        """Refuse a range that does not rise."""
        if not self.low < self.high:
            raise self.refusal("high", f"must be above {self.low:g} m/s, the first velocity")

    @property
    def text(self) -> str:
        """The impact as a scenario file has it."""
        return "\n".join(self.impact)

    @property
    def structure(self) -> Any:
        """Impact at the medians of its inputs."""
        from workbench.extras.uncertainty.inputs import uncertain_from_text

        return uncertain_from_text(self.text).base
