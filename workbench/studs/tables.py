"""Tables of tests in use: shipped, joined, split by campaign, not validated by their own rows.

**Second part.** Columns of a table of tests as arrays in SI units, and the rows that a fit may use.

Of studs in profiled decks also what EN 1994-1-1 and AISC 360 take off the resistance in a solid
slab. EN 1994-1-1, 6.6.4 (k_l and k_t) is recalled, not read again; AISC 360-22, I8.2a (R_g and R_p)
was read in optical recognition. Check the code before relying on a number.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from workbench.base.arrays import Array as Array
from workbench.base.arrays import Flags
from workbench.base.catalogue import STUD_POINTS, STUD_TESTS, Dataset, dataset, datasets
from workbench.base.errors import InputError
from workbench.base.fields import Choice, did_you_mean
from workbench.studs.schema import HEADED, NO_PREDAMAGE, POINTS, TESTS, TableSchema, examine

ACI_MODULUS = 4733e6  # Pa; Ec = 4733 sqrt(fc / MPa) MPa, normal-weight concrete, ACI 318
DENSITY_MODULUS = 0.043e6  # Pa; Ec = 0.043 w^1.5 sqrt(fc / MPa) MPa, AISC 360 and ACI 318
# share by which cylinder strengths of one concrete may differ: EN 1994-1-1, B.2.3 lets those of
# specimens be 10 % off what was intended (recalled)
LIKE_CONCRETE = 0.1
NORMAL_WEIGHT_FROM = 2160.0  # kg/m3
HEAD_DIAMETER, HEAD_HEIGHT = 1.65, 0.5  # of usual heads over the diameter, ISO 13918 (recalled)
COLUMNS = {  # quantity: its column in a table of tests, and its unit there in SI
    "diameter": ("diameter_mm", 1e-3),
    "height": ("height_mm", 1e-3),
    "density": ("density_kg_per_m3", 1.0),
    "ultimate_strength": ("fu_MPa", 1e6),
    "head_diameter": ("head_diameter_mm", 1e-3),
    "embedment": ("embedment_mm", 1e-3),
    "free_width": ("free_width_mm", 1e-3),
    "shear": ("shear_kN", 1e3),
    "tension": ("tension_kN", 1e3),
    "slip_at_max": ("slip_at_max_mm", 1e-3),
}


def shank_area(diameter: ArrayLike) -> Array:
    """Area of the shank, pi d^2 / 4, in m2, for diameters in m."""
    return np.asarray(0.25 * np.pi * np.square(np.asarray(diameter, float)))


def embedment_of(diameter: Array, height: Array) -> Array:
    """Embedment (n,) in m of studs with usual heads, to the underside of the head."""
    return np.asarray(height - HEAD_HEIGHT * diameter)


def concrete_modulus(strength: ArrayLike, density: ArrayLike | None = None) -> Array:
    """Modulus of concrete in Pa from its mean cylinder strength (Pa) and density (kg/m3).

    Without a density 4733 sqrt(fc), with one 0.043 w^1.5 sqrt(fc), both in MPa (ACI 318).
    """
    root = np.sqrt(np.asarray(strength, float) / 1e6)
    if density is None:
        return np.asarray(ACI_MODULUS * root)
    return np.asarray(DENSITY_MODULUS * np.asarray(density, float) ** 1.5 * root)


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
        factor = np.where(self.parallel, along, across)
        valid = (self.depth <= DEEPEST + 1e-9) & (height > self.depth)
        return np.where(self.profiled, np.where(valid, factor, np.nan), 1.0)

    def reduction_aisc360(self) -> Array:
        """R_g R_p (n,) over the 0.75 of a solid slab, on the steel term."""
        group = np.select([self.per_rib == 1, self.per_rib == 2], [1.0, 0.85], 0.7)
        wide = np.where(self.width >= 1.5 * self.depth, 1.0, 0.85)
        position = np.where(self.strong, 1.0, 0.6 / 0.75)
        factor = np.where(self.parallel, wide, group * position)
        known = np.isfinite(self.depth) & np.isfinite(self.width)
        return np.where(self.profiled, np.where(known, factor, np.nan), 1.0)


def profiled(table: pd.DataFrame) -> pd.Series:
    """Whether the tests (n,) of a table stand in a profiled deck."""
    named = table["slab"].str.contains("deck", case=False).astype(bool)
    return named | table[["deck_depth_mm", "deck_width_mm"]].notna().any(axis=1)


def decks_of(table: pd.DataFrame) -> Decks:
    """The decks of the tests of a table (schema `TESTS`)."""
    per_rib = _si(table, "studs_per_rib", 1.0)
    return Decks(
        profiled=profiled(table).to_numpy(bool),
        parallel=table["slab"].str.contains("parallel", case=False).to_numpy(bool),
        **{n: _si(table, f"deck_{n}_mm", 1e-3) for n in ("depth", "width", "thickness")},
        per_rib=np.where(np.isfinite(per_rib), per_rib, 1.0),
        holes=(table["deck_fixing"] == "holes").to_numpy(bool),
        strong=_si(table, "deck_stud_position_mm", 1e-3) >= STRONG - 1e-9,
    )


@dataclass(frozen=True)
class Specimens:
    """Tests as arrays (n,) in SI units; NaN where not reported.

    `diameter`, `height`, `embedment` and `head_diameter` (those of a usual head where not reported)
    and `free_width` of the concrete in m; `concrete_strength`, `concrete_modulus`,
    `ultimate_strength`, in Pa; `shear` and `tension` per stud in N; `slip_at_max` in m.
    `decks` around them (None: solid slabs). `modulus_measured` says where the modulus was measured
    and not taken from a formula.
    """

    campaign: NDArray[np.object_]
    diameter: Array
    height: Array
    concrete_strength: Array
    concrete_modulus: Array
    modulus_measured: Flags
    density: Array
    ultimate_strength: Array
    head_diameter: Array
    embedment: Array
    free_width: Array
    shear: Array
    tension: Array
    slip_at_max: Array
    decks: Decks | None = None

    @property
    def area(self) -> Array:
        """Area of the shank, in m2."""
        return shank_area(self.diameter)

    @property
    def slenderness(self) -> Array:
        """Height over diameter."""
        return np.asarray(self.height / self.diameter)

    def quantity(self, name: str) -> Array:
        """A quantity (n,) by its name, also of the decks; NaN where it is not known."""
        if name == "above_deck":
            return self.height - self.quantity("deck_depth")
        if name.startswith("deck_"):
            nothing = np.full(len(self), np.nan)
            return getattr(self.decks, name.removeprefix("deck_"), nothing)
        return np.asarray(getattr(self, name))

    def where(self, kind: str) -> Flags:
        """Tests (n,) in ``lightweight`` concrete, in ``decks``, with ribs ``across``, or all."""
        if kind == "lightweight":
            return np.asarray(self.density < NORMAL_WEIGHT_FROM)
        if not kind or self.decks is None:
            return np.full(len(self), not kind)
        return self.decks.profiled & ~(self.decks.parallel & (kind == "across"))

    def __len__(self) -> int:
        return len(self.diameter)


def specimens(table: pd.DataFrame) -> Specimens:
    """The tests of a table (schema `TESTS`) in SI units.

    Where the modulus of the concrete was not measured it is 4733 sqrt(fc) MPa; with a density
    below 2160 kg/m3, 0.043 w^1.5 sqrt(fc) MPa.
    """
    known = {name: _si(table, column, unit) for name, (column, unit) in COLUMNS.items()}
    strength, measured = _si(table, "fcm_MPa", 1e6), _si(table, "Ecm_MPa", 1e6)
    light = known["density"] < NORMAL_WEIGHT_FROM
    computed = concrete_modulus(strength, known["density"])
    modulus = np.where(light, computed, concrete_modulus(strength))
    diameter, height = known["diameter"], known["height"]
    usual = {"head_diameter": HEAD_DIAMETER * diameter, "embedment": embedment_of(diameter, height)}
    known |= {n: np.where(np.isfinite(known[n]), known[n], usual[n]) for n in usual}
    return Specimens(
        campaign=table["campaign"].to_numpy(object),
        concrete_strength=strength,
        concrete_modulus=np.where(np.isfinite(measured), measured, modulus),
        modulus_measured=np.isfinite(measured),
        decks=decks_of(table) if "slab" in table and profiled(table).any() else None,
        **known,
    )


def equal_studs(table: pd.DataFrame, row: pd.Series) -> pd.DataFrame:
    """Rows of the campaign and diameter of a row, in concrete of about the same strength.

    An unknown strength counts as alike.
    """
    same = table["campaign"] == row["campaign"]
    near = table[same & (table["diameter_mm"] == row["diameter_mm"])]
    other = np.abs(near["fcm_MPa"].astype(float) / row["fcm_MPa"] - 1.0) > LIKE_CONCRETE
    alike: pd.DataFrame = near.loc[~other]
    return alike


_SHOWN = 5  # tests that one sentence names


def named(rows: pd.DataFrame) -> str:
    """The tests of rows by campaign and specimen, the first few of many."""
    names = [f"{a} {b}" for a, b in zip(rows["campaign"], rows["specimen"], strict=True)]
    more = [f"and {len(names) - _SHOWN} more"] * (len(names) > _SHOWN)
    return ", ".join([*names[:_SHOWN], *more])


def _si(table: pd.DataFrame, column: str, factor: float) -> Array:
    if column not in table.columns:
        return np.full(len(table), np.nan)
    return np.asarray(table[column].to_numpy(float) * factor)


SLABS = ("solid", "deck", "any")


LOADS = {"shear": "push-out", "tension": "pull-out"}  # and the tests under it alone


def undamaged_headed_studs(
    table: pd.DataFrame, slab: str = "solid", load: str = "shear"
) -> pd.DataFrame:
    """Rows that a fit of the undamaged headed stud in a kind of slab may use.

    `use_for_fit` = 1, a headed stud, no pre-damage, under one `load` alone (in `LOADS`); `slab`,
    one of `SLABS`, a profiled deck making the difference. Raises `InputError` when none is left,
    saying what took the rows away.
    """
    Choice(SLABS).check("slab", slab)
    in_deck = profiled(table).to_numpy(bool)
    conditions = {
        "in a profiled deck": ~in_deck | (slab != "solid"),
        "in no profiled deck": in_deck | (slab != "deck"),
        f"no {LOADS[load]}": table["test"] == LOADS[load],
        "use_for_fit is 0": table["use_for_fit"] == 1.0,
        "another connector than a headed stud": table["connector"] == HEADED,
        "after pre-damage": table["predamage"] == NO_PREDAMAGE,
        f"no {load}_kN": np.isfinite(table[f"{load}_kN"].astype(float)),
    }
    kept = np.logical_and.reduce([np.asarray(each) for each in conditions.values()])
    if not kept.any():
        out = {name: int((~np.asarray(each)).sum()) for name, each in conditions.items()}
        lost = "; ".join(f"{name}: {count}" for name, count in out.items() if count)
        advice = "those in decks are fitted with --slab deck" if out["in a profiled deck"] else ""
        reason = f"holds no undamaged headed stud ({lost})"
        raise InputError("table", f"{len(table)} rows", reason, advice)
    return table[kept].reset_index(drop=True)


SHIPPED = {
    "stud-push-out": TESTS,
    "stud-pull-out": TESTS,
    "stud-other-connectors": TESTS,
    "stud-load-slip": POINTS,
    "stud-unload-reload": POINTS,
}


def shipped(name: str) -> pd.DataFrame:
    """A table of the stud schemas by its catalogue name, added ones too. Raises `InputError`."""
    schemas = table_schemas()
    Choice(tuple(schemas)).check("dataset", name)
    return examine(dataset(name).path, schemas[name]).accept()


def added(kind: str = STUD_TESTS) -> tuple[Dataset, ...]:
    """The tables of tests, or of another `kind`, that the user has added to the catalogue."""
    return tuple(e for e in datasets() if e.kind == kind and e.name not in SHIPPED)


def table_schemas() -> dict[str, TableSchema]:
    """The schema of every table on studs in the catalogue, by its name."""
    kinds = {STUD_TESTS: TESTS, STUD_POINTS: POINTS}
    own = {entry.name: schema for kind, schema in kinds.items() for entry in added(kind)}
    return {**SHIPPED, **own}


def check_tables() -> list[str]:
    """Problems of the shipped stud tables, one sentence each; empty when all is well."""
    problems: list[str] = []
    for name, table in SHIPPED.items():
        try:
            wrong = examine(dataset(name).path, table).problems
            problems += [f"dataset {name}: {problem.error()}" for problem in wrong]
        except InputError as error:
            problems.append(f"dataset {name}: {error}")
    return problems


def campaigns_of(*tables: pd.DataFrame) -> list[str]:
    """Names of the campaigns of tables, in the order in which they appear."""
    return list(dict.fromkeys(str(name) for table in tables for name in table["campaign"]))


def own_rows(table: pd.DataFrame) -> pd.DataFrame:
    """Rows of campaigns that no shipped table of tests holds: the user's own."""
    tables = (shipped(name) for name, schema in SHIPPED.items() if schema is TESTS)
    return table[~table["campaign"].isin(campaigns_of(*tables))]


def split_table(
    table: pd.DataFrame, calibrate: Sequence[str] = (), validate: Sequence[str] = ()
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Rows that a fit may use, and rows that it is judged by (either may be empty).

    Arguments: `table` (schema `TESTS` or `POINTS`); campaigns to `calibrate` (empty: all that do
    not validate) and to `validate`. Rows whose role is not calibrate are never fitted; those whose
    role is validate are held out with the others. Raises `InputError` where a campaign is to do
    both, or has no row that may be fitted.
    """
    for campaign in (name for name in validate if name in calibrate):
        reason = "calibrates too: a fit is not validated by its own rows"
        advice = "validate on campaigns that the fit has not seen"
        raise InputError("validate", campaign, reason, advice)
    held = table["campaign"].isin(list(validate))
    used = named = table["campaign"].isin(list(calibrate)) if calibrate else ~held
    if "role" in table.columns:
        used = named & (table["role"] == "calibrate")
        held |= table["role"] == "validate"
    if calibrate and named.any() and not used.any():
        reason = "has no row whose role is calibrate"
        advice = "rows that validate or verify are never fitted"
        raise InputError("calibrate", ", ".join(calibrate), reason, advice)
    return table[used].reset_index(drop=True), table[held].reset_index(drop=True)


def check_campaigns(wanted: Sequence[str], *tables: pd.DataFrame) -> None:
    """Refuse names of campaigns that no table has. Raises `InputError` with the nearest name."""
    known = tuple(campaigns_of(*tables))
    for name in wanted:
        Choice(known, did_you_mean(name, known)).check("campaign", name)


def joined(tables: Sequence[pd.DataFrame], *, unique: bool = True) -> pd.DataFrame:
    """Several tables of one schema below each other.

    `unique`: refuse a specimen that stands in two of them (`InputError`).
    """
    rows = pd.concat(tables, ignore_index=True) if len(tables) > 1 else tables[0]
    names = rows["campaign"].str.cat(rows["specimen"], sep=" ")
    for name in sorted(names[rows.duplicated(["campaign", "specimen"])] if unique else ()):
        advice = "give the campaign another name, or leave one table out"
        raise InputError("tables", name, "stands in two tables", advice)
    return rows


LOOP = 0.02  # of the largest load: a larger fall with the slip going back is no noise


def recorded(points: pd.DataFrame) -> pd.DataFrame:
    """Points of single specimens that a fit may use, with the `branch` that each record tells.

    Points are in the order of the test. Unloading and reloading before the largest load is
    ``later loading``. In a curve without any label what follows the largest load is ``post-peak``
    while the slip grows, and later loading where it goes back.
    """
    kept = (points["single_specimen"] == 1.0) & (points["on_envelope"] == 1.0)
    kept &= (points["use_for_fit"] == 1.0) & (points["branch"] != "low-load reading")
    rows, branch = points[kept], points["branch"][kept].copy()
    for _, curve in rows.groupby(["campaign", "specimen"], sort=False):
        slip, load = (curve[name].to_numpy(float) for name in ("slip_mm", "load_kN"))
        place, peak = np.arange(len(load)), int(np.argmax(load))
        farthest, top = (np.maximum.accumulate(each) for each in (slip, load))
        first = np.diff(top, prepend=-np.inf) > 0.0
        last = np.maximum.accumulate(np.where(first, place, 0))  # point of the envelope before
        falls = (load < top - LOOP * load[peak]) & (slip < farthest) & (place < peak)
        later = np.isin(last, last[falls]) & ~first
        if (curve["branch"] == "").all():
            onward = np.diff(farthest, prepend=-np.inf) > 0.0
            branch[curve.index[(place > peak) & onward]] = "post-peak"
            later |= (place > peak) & ~onward
        branch[curve.index[later]] = "later loading"
    return rows.assign(branch=branch)


def first_loading(points: pd.DataFrame, *, falling: bool) -> pd.DataFrame:
    """Points that belong to the first loading of single specimens, with loads and slips in SI.

    Unloading and reloading, mean curves and doubtful points (`use_for_fit` 0) are left out, and the
    `falling` branch unless it is wanted. Raises `InputError` if nothing is left.
    """
    rows = recorded(points)
    kept = ~rows["branch"].isin(["later loading", *["post-peak"] * (not falling)])
    if not kept.any():
        raise InputError("points", len(points), "hold no point of a first loading to be fitted")
    rows = rows[kept]
    slip, load = 1e-3 * rows["slip_mm"].astype(float), 1e3 * rows["load_kN"].astype(float)
    return rows[["campaign", "specimen"]].assign(slip=slip, load=load)


def points_of(fitted: pd.DataFrame, unseen: pd.DataFrame) -> pd.DataFrame:
    """First loading of fitted and `unseen` curves (schema `POINTS`) to their ends, in SI."""
    parts = ((fitted, False), (unseen, True))
    known = [
        first_loading(each, falling=True).assign(unseen=new) for each, new in parts if len(each)
    ]
    return pd.concat(known, ignore_index=True)


def curves_of(
    points: pd.DataFrame, *, falling: bool
) -> Iterator[tuple[dict[str, str], Array, Array]]:
    """Names, slips (m) and loads (N) of every curve of a table (schema `POINTS`)."""
    used = first_loading(points, falling=falling)
    for (campaign, specimen), curve in used.groupby(["campaign", "specimen"], sort=False):
        names = {"campaign": str(campaign), "specimen": str(specimen)}
        yield names, curve["slip"].to_numpy(float), curve["load"].to_numpy(float)


_CONTENT = [
    *("diameter_mm", "height_mm", "embedment_mm", "fcm_MPa", "fu_MPa", "shear_kN", "tension_kN"),
    *("slip_at_max_mm", "predamage_level"),
]
_ENOUGH = 4  # equal numbers that two different tests do not share by chance
_MISSING = -1.0  # stands for a number that is not reported: no cell can hold it
Row = tuple[tuple[str, str], tuple[float, ...]]


@dataclass(frozen=True)
class RowIdentity:
    """Names (campaign, specimen) of rows, and the numbers that give a renamed row away."""

    names: frozenset[tuple[str, str]]
    contents: frozenset[tuple[float, ...]]

    @property
    def campaigns(self) -> frozenset[str]:
        """Campaigns of the rows."""
        return frozenset(campaign for campaign, _ in self.names)

    def refuse_overlap(self, table: pd.DataFrame) -> None:
        """Refuse a table that holds one of these rows, also under another name.

        Raises `InputError`: a fit is not validated by the rows it was made of.
        """
        for name, content in _rows(table):
            telling = sum(value != _MISSING for value in content) >= _ENOUGH
            renamed = name[0] not in self.campaigns and telling and content in self.contents
            if name in self.names or renamed:
                how = "equals a row of the fit under other names"
                how = "was used for the fit" if name in self.names else how
                advice = "validate on tests that the fit has not seen, or leave campaigns out of it"
                raise InputError("validation", " ".join(name), how, advice)


def same_contents(table: pd.DataFrame) -> list[tuple[str, str]]:
    """Names of rows that hold the same load and other numbers, enough of them to be one test."""
    names = table[["campaign", "specimen"]].to_numpy(str)
    return copies(
        (" ".join(name), content)
        for (_, content), name in zip(_rows(table), names, strict=True)
        if sum(value != _MISSING for value in content) >= _ENOUGH
    )


def copies(named: Iterable[tuple[str, tuple[float, ...]]]) -> list[tuple[str, str]]:
    """Names of equal contents, each with the first name of its content."""
    seen: dict[tuple[float, ...], str] = {}
    pairs = ((seen.setdefault(content, name), name) for name, content in named)
    return [(first, name) for first, name in pairs if first != name]


def identity_of(table: pd.DataFrame) -> RowIdentity:
    """The identity of the rows of a table of tests."""
    rows = _rows(table)
    return RowIdentity(frozenset(n for n, _ in rows), frozenset(content for _, content in rows))


def _rows(table: pd.DataFrame) -> list[Row]:
    pairs = zip(table["campaign"], table["specimen"], strict=True)
    names = [(str(a).strip().casefold(), str(b).strip().casefold()) for a, b in pairs]
    numbers = table.reindex(columns=_CONTENT).to_numpy(float)
    contents = np.where(np.isfinite(numbers), numbers, _MISSING).tolist()
    return [(name, tuple(content)) for name, content in zip(names, contents, strict=True)]
