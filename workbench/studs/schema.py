"""One schema for tests on studs: push-out, pull-out, combined, and after pre-damage.

A table is a CSV file with the unit of every number in the name of its column. `TESTS` holds one
row per specimen, `POINTS` the points of measured curves. An empty cell means that the quantity
was not reported; it never means zero.
"""

from __future__ import annotations

from dataclasses import dataclass

from workbench.fields import Choice, Number, Text

EXTRA = "x_"  # columns of the user's own begin with this and are kept as they are
NO_PREDAMAGE = "none"
TEST_KINDS = ("push-out", "pull-out", "combined")
PREDAMAGES = (
    NO_PREDAMAGE, "pull-out", "push-out", "fatigue", "explosion", "corrosion", "fire", "other",
)  # fmt: skip
PREDAMAGE_MEASURES = (
    "load ratio", "displacement ratio", "life fraction", "section loss", "other",
)  # fmt: skip
ORIGINS = ("measured", "digitised", "synthetic")
HEADED = "headed stud"

_LONG = Text(1000)
_MM = "lengths are in mm: a 19 mm stud is 19"
_KN = "loads are in kN per stud: 100 kN is 100"
_MPA = "stresses are in MPa: 30 MPa is 30"


@dataclass(frozen=True, slots=True)
class Column:
    """A column: its name with the unit, what it means, the rule of its cells, if it must exist.

    `filled` says that no cell may be empty; `default` fills empty cells of words and flags.
    """

    name: str
    meaning: str
    rule: Number | Choice | Text
    required: bool = False
    filled: bool = False
    default: str = ""

    @property
    def is_number(self) -> bool:
        """Whether cells hold numbers."""
        return isinstance(self.rule, Number)


@dataclass(frozen=True, slots=True)
class Table:
    """A kind of table: its columns, and the columns that together must not repeat (or none)."""

    name: str
    columns: tuple[Column, ...]
    key: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""
        return tuple(column.name for column in self.columns)

    def column(self, name: str) -> Column:
        """The column of this name."""
        return next(column for column in self.columns if column.name == name)


def _number(
    name: str,
    meaning: str,
    low: float,
    high: float,
    unit: str,
    advice: str = "",
    *,
    above: bool = False,
    needed: bool = False,
) -> Column:
    rule = Number(low, high, unit, low_included=not above, advice=advice)
    return Column(name, meaning, rule, required=needed, filled=needed)


def _flag(name: str, meaning: str, default: str) -> Column:
    return Column(name, meaning, Number(0, 1, integer=True), default=default)


def _word(name: str, meaning: str, words: tuple[str, ...], default: str = "") -> Column:
    return Column(name, meaning, Choice(words), default=default)


_IDENTITY = (
    Column("campaign", "test campaign: one laboratory, one programme", _LONG, True, True),
    Column("specimen", "name of the specimen, unique in its campaign", _LONG, True, True),
)

_TEST = (
    Column("test", "kind of test", Choice(TEST_KINDS), True, True),
    _word("origin", "how the numbers came about", ORIGINS, "measured"),
    _word("role", "what the row may be used for", ("calibrate", "validate", "verify"), "calibrate"),
    _flag("use_for_fit", "1: may enter a fit of the standard headed stud", "1"),
)

_GEOMETRY = (
    Column("connector", "kind of connector", _LONG, default=HEADED),
    _number("diameter_mm", "shank diameter", 5.0, 40.0, "mm", _MM),
    _number("height_mm", "height after welding", 15.0, 400.0, "mm", _MM),
    _number("embedment_mm", "effective embedment depth of the head", 15.0, 600.0, "mm", _MM),
    _number("head_diameter_mm", "diameter (or width) of the head", 6.0, 120.0, "mm", _MM),
    _number("collar_diameter_mm", "diameter of the weld collar", 5.0, 60.0, "mm", _MM),
    _number("collar_height_mm", "height of the weld collar", 0.0, 30.0, "mm", _MM),
    Column("slab", "slab: solid, precast pocket, deck transverse, block, ...", _LONG),
    Column("stud_spacing", "arrangement of the studs", _LONG),
    _number("n_studs", "studs in the specimen", 1, 200, ""),
    _number("deck_depth_mm", "depth of the profiled deck", 10.0, 250.0, "mm", _MM),
    _number("deck_width_mm", "mean width of the rib (b0)", 10.0, 500.0, "mm", _MM),
    _number("deck_thickness_mm", "thickness of the deck", 0.3, 3.0, "mm", _MM),
    _number("studs_per_rib", "studs in one rib", 1, 4, ""),
    _number("free_width_mm", "width of the concrete if it cuts the cone", 20.0, 5000.0, "mm", _MM),
)

_MATERIAL = (
    _number("fcm_MPa", "mean cylinder strength of the concrete", 5.0, 250.0, "MPa", _MPA),
    Column("fcm_basis", "what the concrete strength was measured on", _LONG),
    _number("Ecm_MPa", "measured modulus of the concrete", 3e3, 9e4, "MPa",
            "moduli are in MPa: 30 GPa is 30000"),
    _number("density_kg_per_m3", "density of the concrete", 900.0, 3000.0, "kg/m3",
            "normal-weight concrete has 2400"),
    _number("fu_MPa", "tensile strength of the stud", 200.0, 1500.0, "MPa", _MPA),
    _number("fy_MPa", "yield stress of the stud", 150.0, 1400.0, "MPa", _MPA),
    Column("fu_basis", "where the stud strength is from", _LONG),
)  # fmt: skip

_RESULT = (
    _number("shear_kN", "largest shear per stud", 0.0, 2e3, "kN", _KN, above=True),
    _number("tension_kN", "largest tension per stud", 0.0, 2e3, "kN", _KN, above=True),
    _number("total_load_kN", "largest load of the specimen", 0.0, 1e5, "kN", _KN, above=True),
    _number("slip_at_max_mm", "slip at the largest load", 0.0, 100.0, "mm", _MM),
    _number("uplift_at_max_mm", "uplift at the largest load", 0.0, 100.0, "mm", _MM),
    _number("stiffness_5_40_kN_per_mm", "slope of a line fitted from 5 to 40 % of the maximum",
            0.0, 1e5, "kN/mm", above=True),
    _number("stiffness_10_40_kN_per_mm", "chord from 10 to 40 % of the maximum",
            0.0, 1e5, "kN/mm", above=True),
    _number("secant_25_kN_per_mm", "secant at 25 % of the maximum", 0.0, 1e5, "kN/mm", above=True),
    _number("secant_40_kN_per_mm", "secant at 40 % of the maximum", 0.0, 1e5, "kN/mm", above=True),
    _number("secant_50_kN_per_mm", "secant at 50 % of the maximum", 0.0, 1e5, "kN/mm", above=True),
    _number("strength_over_nominal", "strength over the nominal value of `nominal_model`, for "
            "sources that report only this", 0.0, 10.0, "", above=True),
    Column("nominal_model", "formula of the nominal value", _LONG),
    Column("failure_mode", "failure as reported", _LONG),
)  # fmt: skip

_PREDAMAGE = (
    _word("predamage", "what damaged the stud before this test", PREDAMAGES, NO_PREDAMAGE),
    _word("predamage_measure", "what the level of damage measures", PREDAMAGE_MEASURES),
    _number("predamage_level", "level of damage: 0 none, 1 the load, displacement or life at "
            "which an undamaged stud fails", 0.0, 1.0, "", "a share: 40 % is 0.4"),
    _number("predamage_cycles", "load cycles before this test", 0.0, 1e9, ""),
    _number("predamage_residual_slip_mm", "slip left before this test", 0.0, 100.0, "mm", _MM),
    _number("predamage_residual_uplift_mm", "uplift left before this test", 0.0, 100.0, "mm", _MM),
    _number("undamaged_shear_kN", "shear strength of an equal undamaged stud", 0.0, 2e3, "kN",
            _KN, above=True),
    _number("undamaged_stiffness_kN_per_mm", "stiffness (10 to 40 %) of an equal undamaged stud",
            0.0, 1e5, "kN/mm", above=True),
)  # fmt: skip

_MEASUREMENT = (
    _number("shear_uncertainty_kN", "standard uncertainty of the shear", 0.0, 500.0, "kN", _KN),
    _number("tension_uncertainty_kN", "standard uncertainty of the tension", 0.0, 500.0, "kN", _KN),
    _number("slip_uncertainty_mm", "standard uncertainty of the slip", 0.0, 20.0, "mm", _MM),
)

_SOURCE = (
    Column("flag", "caveat of this row", _LONG),
    Column("reference", "published source", _LONG),
    Column("source_locator", "page, table or figure", _LONG),
    Column("licence", "licence of the row", _LONG),
)

TESTS = Table(
    "tests",
    (*_IDENTITY, *_TEST, *_GEOMETRY, *_MATERIAL, *_RESULT, *_PREDAMAGE, *_MEASUREMENT, *_SOURCE),
    key=("campaign", "specimen"),
)

POINTS = Table(
    "points",
    (
        *_IDENTITY,
        _number("slip_mm", "slip", -5.0, 200.0, "mm", _MM, needed=True),
        _number("load_kN", "load per connector", -50.0, 2e3, "kN", _KN, needed=True),
        Column("connector", "kind of connector", _LONG),
        Column("point_kind", "how the point arose; points of one curve are not independent", _LONG),
        _word("branch", "part of the curve",
              ("ascending", "ascending envelope", "peak", "post-peak", "envelope",
               "low-load reading", "later loading")),
        _flag("single_specimen", "0: a mean over several specimens, no observation of its own",
              "1"),
        _flag("use_for_fit", "0: doubtful, for the reason in flag", "1"),
        _flag("on_envelope", "1: on the envelope of first loading, as the source classifies it",
              "1"),
        _number("probable_unloading_slip_mm", "inferred: slip from which this low-load reading was "
                "unloaded", 0.0, 200.0, "mm", _MM),
        _number("probable_unloading_load_kN", "inferred: load from which this low-load reading was "
                "unloaded", 0.0, 2e3, "kN", _KN),
        *_SOURCE,
    ),
)  # fmt: skip
