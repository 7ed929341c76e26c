"""Studs in profiled decks: what EN 1994-1-1 and AISC 360 take off the resistance in a solid slab.

EN 1994-1-1, 6.6.4 (k_l and k_t) is recalled, not read again; AISC 360-22, I8.2a (R_g and R_p) was
read in optical recognition. Check the code before relying on a number. Units: SI.
"""

from typing import NamedTuple

import numpy as np
import pandas as pd

from workbench.arrays import Array, Flags

DEEPEST = 0.085  # m, EN 1994-1-1, 6.6.4.2
THIN = 1.0e-3  # m, of the sheet
# upper limits of k_t, EN 1994-1-1 table 6.2, by (studs per rib, thin sheet): welded through, holes
_LIMITS = {
    (1, True): (0.85, 0.75),
    (1, False): (1.0, 0.75),
    (2, True): (0.70, 0.60),
    (2, False): (0.80, 0.60),
}
_LARGEST = (0.020, 0.022)  # m, diameter: welded through, in holes
STRONG = 0.0508  # m, from the middle of the rib to a stud in the strong position, AISC I8.2a


class Decks(NamedTuple):
    """Decks around tests (n,): `depth`, `width`, `thickness` in m, NaN where not reported.

    `profiled`, whether there is one; `parallel` to the beam, otherwise transverse; studs `per_rib`
    (one where not reported); `holes` in the sheet, otherwise welded through; `strong`, stud in the
    strong position.
    """

    profiled: Flags
    parallel: Flags
    depth: Array
    width: Array
    thickness: Array
    per_rib: Array
    holes: Flags
    strong: Flags

    def reduction_en1994(self, height: Array, diameter: Array) -> Array:
        """Factor k_l or k_t (n,) for studs of `height` and `diameter` (n,) in m.

        NaN outside the range of the rule: decks over 85 mm, ribs narrower than deep, more than two
        studs in a rib, too thick studs, studs not above the deck.
        """
        over = self.width / self.depth
        tall = np.minimum(height, self.depth + 0.075)
        along = np.minimum(0.6 * over * (tall / self.depth - 1.0), 1.0)
        across = 0.7 / np.sqrt(self.per_rib) * over * (height / self.depth - 1.0)
        thin = ~(self.thickness > THIN * (1.0 + 1e-9))  # not reported: thin, the lower limit
        limits = [
            _LIMITS.get((int(n), bool(t)), (np.nan, np.nan))[int(h)]
            for n, t, h in zip(self.per_rib, thin, self.holes, strict=True)
        ]
        largest = np.where(self.holes, _LARGEST[1], _LARGEST[0]) + 1e-9
        inside = (over >= 1.0) & (diameter <= largest)
        across = np.where(inside, np.minimum(across, limits), np.nan)
        found = np.where(self.parallel, along, across)
        valid = (self.depth <= DEEPEST + 1e-9) & (height > self.depth)
        return np.where(self.profiled, np.where(valid, found, np.nan), 1.0)

    def reduction_aisc360(self) -> Array:
        """R_g R_p (n,) over the 0.75 of a solid slab, on the steel term."""
        group = np.select([self.per_rib == 1, self.per_rib == 2], [1.0, 0.85], 0.7)
        wide = np.where(self.width >= 1.5 * self.depth, 1.0, 0.85)
        position = np.where(self.strong, 1.0, 0.6 / 0.75)
        found = np.where(self.parallel, wide, group * position)
        known = np.isfinite(self.depth) & np.isfinite(self.width)
        return np.where(self.profiled, np.where(known, found, np.nan), 1.0)


def profiled(table: pd.DataFrame) -> pd.Series:
    """Whether the tests (n,) of a table stand in a profiled deck."""
    named = table["slab"].str.contains("deck", case=False).astype(bool)
    return named | table[["deck_depth_mm", "deck_width_mm"]].notna().any(axis=1)


def assumed(table: pd.DataFrame) -> str:
    """What of the decks of tests was not reported, how often, and what is taken for it."""
    unknown = {
        "deck_thickness_mm": (table["deck_thickness_mm"].isna(), "a sheet of up to 1 mm"),
        "studs_per_rib": (table["studs_per_rib"].isna(), "one stud"),
        "deck_fixing": (table["deck_fixing"] == "", "welded through"),
        "deck_stud_position_mm": (table["deck_stud_position_mm"].isna(), "weak (AISC R_p 0.6)"),
    }
    told = (f"{n} of {m.sum()} tests: {words}" for n, (m, words) in unknown.items() if m.any())
    return "; ".join(told)


def decks_of(table: pd.DataFrame) -> Decks:
    """The decks of the tests of a table (schema `TESTS`)."""

    def column(name: str) -> Array:
        return np.asarray(table[name].to_numpy(float))

    per_rib, position = column("studs_per_rib"), column("deck_stud_position_mm")
    return Decks(
        profiled=profiled(table).to_numpy(bool),
        parallel=table["slab"].str.contains("parallel", case=False).to_numpy(bool),
        depth=1e-3 * column("deck_depth_mm"),
        width=1e-3 * column("deck_width_mm"),
        thickness=1e-3 * column("deck_thickness_mm"),
        per_rib=np.where(np.isfinite(per_rib), per_rib, 1.0),
        holes=(table["deck_fixing"] == "holes").to_numpy(bool),
        strong=1e-3 * position >= STRONG - 1e-9,
    )
