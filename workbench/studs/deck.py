"""Reduction of shear resistance for studs in profiled steel deck: EN 1994-1-1 and AISC 360.

As given in the codes, recalled and not read again: check the code before relying on a number.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

from workbench.errors import OutOfDomainError
from workbench.fields import Choice, Declared, Flag, Number, checked

_LENGTH = Number(1e-4, 1.0, "m", advice="lengths are in metres")
DEEPEST_DECK = 0.085  # m, EN 1994-1-1, 6.6.4.2
# upper limits of k_t, EN 1994-1-1 table 6.2: (studs per rib, thin deck): (welded through, holes)
_LIMITS = {
    (1, True): (0.85, 0.75),
    (1, False): (1.0, 0.75),
    (2, True): (0.70, 0.60),
    (2, False): (0.80, 0.60),
}
_THIN = 1.0e-3  # m


@dataclass(frozen=True)
class Deck(Declared, table="deck"):
    """Profiled deck around a stud.

    Arguments: `depth` h_p of the deck and mean `width` b_0 of the rib in m; `direction` of the
    ribs to the beam; `studs_per_rib`; `thickness` of the sheet in m; `welded_through` the sheet
    or through holes; `middle_distance`, from the middle of the rib to the stud on its loaded side
    (AISC's e_mid-ht) in m.
    """

    depth: float = checked(_LENGTH)
    width: float = checked(_LENGTH)
    direction: str = checked(Choice(("transverse", "parallel")), "transverse")
    studs_per_rib: int = checked(Number(1, 4, integer=True), 1)
    thickness: float = checked(_LENGTH, 1.0e-3)
    welded_through: bool = checked(Flag(), True)
    middle_distance: float = checked(Number(0.0, 0.5, "m"), 0.051)

    def reduction_en1994(self, height: float, diameter: float) -> float:
        """Factor k_l or k_t on the resistance in a solid slab (EN 1994-1-1, 6.6.4).

        Arguments: `height` and `diameter` of the stud, in m. Raises `OutOfDomainError` outside
        the range of the rule.
        """
        if self.width < self.depth and self.direction == "transverse":
            raise OutOfDomainError("k_t needs ribs at least as wide as deep (6.6.4.2)")
        if self.depth > DEEPEST_DECK:
            raise OutOfDomainError(f"k_t and k_l end at decks of {DEEPEST_DECK:g} m depth")
        if height <= self.depth:
            raise OutOfDomainError("the stud does not rise above the deck")
        if self.direction == "parallel":
            tall = min(height, self.depth + 0.075)
            return min(0.6 * self.width / self.depth * (tall / self.depth - 1.0), 1.0)
        if self.studs_per_rib > 2:
            raise OutOfDomainError("k_t knows one or two studs per rib")
        largest = 0.020 if self.welded_through else 0.022
        if diameter > largest + 1e-9:
            raise OutOfDomainError(
                f"k_t ends at studs of {1e3 * largest:g} mm "
                f"{'welded through the deck' if self.welded_through else 'in holes'}"
            )
        slope = 0.7 / sqrt(self.studs_per_rib) * self.width / self.depth
        limits = _LIMITS[self.studs_per_rib, self.thickness <= _THIN + 1e-12]
        limit = limits[0] if self.welded_through else limits[1]
        return min(slope * (height / self.depth - 1.0), limit)

    def factors_aisc360(self) -> tuple[float, float]:
        """Group and position factors (R_g, R_p) of AISC 360-22, I8.2a, on the steel term.

        A solid slab has (1, 0.75).
        """
        if self.direction == "parallel":
            return (1.0 if self.width >= 1.5 * self.depth else 0.85), 0.75
        group = {1: 1.0, 2: 0.85}.get(self.studs_per_rib, 0.7)
        return group, (0.75 if self.middle_distance >= 0.0508 - 1e-9 else 0.6)
