"""Columns struck as shells: how far models of sections that keep their shape are from them.

Twelve columns are cases of the study: three sections hit at 0, 30 and 90 degrees, and on the edge
of a flange. Two data sets of the workbench are drawn and written here as well, row by row:
`python studies/struck_shells.py pairs FILE` hits columns of six families through their shear
centre and beside it (`eccentric-hits`), `slender FILE` columns with slender plates
(`slender-shells`).

Masses are such that the mechanism takes the energy over a share of the shorter segment.
"""

import csv
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import product
from math import radians, sqrt
from pathlib import Path

import numpy as np

from workbench.cli import main
from workbench.models.domain import features_beside, mechanism_demand
from workbench.models.four_dof import FourDof
from workbench.models.references.fiber_space import FiberSpace
from workbench.models.references.shell import Shell
from workbench.models.seven_dof import SevenDof
from workbench.models.superelement_space import SuperelementSpace
from workbench.models.superelements import FlexibleSuperelement
from workbench.responses import Outcome, Response, outcome_of
from workbench.scenarios import Column, ColumnImpact, Striker
from workbench.steel.materials import Steel
from workbench.steel.sections import Section, find, i_section
from workbench.steel.sections.slenderness import plate_classes, plates_of, shares_by_class
from workbench.study import Case, Figure, Study

Row = dict[str, float | str]

# --- twelve columns ---------------------------------------------------------------------------

SECTIONS = {
    "HEB 220": find("HEB 220"),
    "IPE 300": find("IPE 300"),
    "I 300x200x5x8": i_section(0.3, 0.2, 0.005, 0.008),
}
HITS = {  # angle in degrees, eccentricity over the width
    "0 degrees, centre": (0.0, 0.0),
    "0 degrees, edge": (0.0, 0.5),
    "30 degrees, centre": (30.0, 0.0),
    "90 degrees, centre": (90.0, 0.0),
}
BELOW, ABOVE, PACE, REACHED, LOADED = 1.4, 2.6, 10.0, 0.04, 0.1  # m, m, m/s, over BELOW, of Npl
SHELLS, FIBERS = "shells", "fibers in space"
models = {
    SHELLS: Shell(),
    FIBERS: FiberSpace(levels=2),
    "seven-dof": SevenDof(),
    "superelements in space": SuperelementSpace(),
}


def heavy(column: Column, reach: float, speed: float) -> Striker:
    """A striker whose energy the mechanism takes over a `reach` (m)."""
    below, above = column.length_below, column.length_above
    resistance = 2.0 * column.properties.plastic_moment * (1.0 / below + 1.0 / above)
    return Striker(round(2.0 * resistance * reach / speed**2, 1), speed)


def struck(name: str, hit: str) -> ColumnImpact:
    """One of the twelve columns."""
    section, (degrees, beside) = SECTIONS[name], HITS[hit]
    column = Column(section, BELOW, ABOVE, restraint_stiffness=5e6)
    column = column.changed(axial_load=LOADED * column.properties.squash_load)
    striker = replace(heavy(column, REACHED * BELOW, PACE), angle=radians(degrees))
    impact = ColumnImpact(f"{name}, {hit}", column, striker, 0.4)
    lasting = 2.0 * float(SevenDof().simulate(impact)["time_of_peak"])
    striker = replace(striker, eccentricity=beside * section.width)
    return replace(impact, striker=striker, duration=round(lasting, 4))


cases = tuple(
    Case(
        impact.name,
        impact,
        parameters={"degrees off the web": HITS[hit][0], "eccentricity over width": HITS[hit][1]},
        quick=hit == "0 degrees, centre",
    )
    for name, hit in product(SECTIONS, HITS)
    for impact in (struck(name, hit),)
)
study = Study(
    name="struck_shells",
    title="Columns struck as shells",
    question="How far are models of sections that keep their shape from folded plates?",
    cases=cases,
    models=models,
    reference=FIBERS,
    references=(SHELLS, FIBERS),
    quantities=("peak_displacement", "residual_displacement"),
    figures=(Figure("peaks", "peaks", "Peaks against shells", "By case."),),
    decisive="peaks",
    quick_models=(FIBERS, "seven-dof"),
)

# --- hits beside the shear centre ----------------------------------------------------------------

SEED, PAIRS, FAR_PAIRS = 46, 60, 24
FAMILIES = {
    "HEB": ("HEB 160", "HEB 220", "HEB 300", "HEB 360"),
    "HEA": ("HEA 180", "HEA 240", "HEA 300", "HEA 400"),
    "IPE": ("IPE 270", "IPE 330", "IPE 400", "IPE 450"),
    "HEM": ("HEM 160", "HEM 200", "HEM 240"),
    "UB": ("UB 254x146x31", "UB 305x165x40", "UB 406x178x60", "UB 457x191x82"),
    "UC": ("UC 203x203x46", "UC 254x254x73", "UC 305x305x97"),
}
GRADES = (235e6, 275e6, 355e6)  # Pa
LENGTHS, HEIGHTS = (3.0, 6.0), (0.2, 0.6)  # m; of the impact over the length
PRESSED, OF_EULER = 0.4, 0.7  # most of the squash load, and of the Euler load about the weak axis
REACH, FAR, SPEEDS = (0.015, 0.08), (0.08, 0.3), (3.0, 15.0)  # over the shorter segment; m/s
PLANE = {"four_dof": FourDof(), "superelement": FlexibleSuperelement()}
LONGEST = 2.5  # duration over the time in which the plane model comes to its peak
LATEST = 0.05  # s, of the peak of the plane model
SHORT = 0.05  # s, of hits that are followed on the default mesh too
PEAKS = {
    "axis_m": "shell.axis",
    "edge_m": "shell.edge",
    "face_m": "displacement",
    "sideways_m": "sideways",
    "twist_rad": "twist",
}


def drawn_pairs(seed: int = SEED) -> Iterator[tuple[ColumnImpact, float]]:
    """Columns hit through the shear centre, and the eccentricity (m) of the other hit.

    First those that go a little way, then those that go far. Families take turns; what the plane
    model does not answer, or has its peak late, is drawn again.
    """
    rng, families = np.random.default_rng(seed), tuple(FAMILIES.values())
    for number in range(PAIRS + FAR_PAIRS):
        reach, at = REACH if number < PAIRS else FAR, np.nan
        while not at <= LATEST:
            impact, beside = _drawn(rng, families[number % len(families)], reach)
            at = float(FourDof().simulate(impact).get("time_of_peak", np.nan))
        name = f"{number:02d} {impact.name}"
        yield replace(impact, name=name, duration=round(LONGEST * at, 4)), beside


def _drawn(
    rng: np.random.Generator, names: tuple[str, ...], reach: tuple[float, float]
) -> tuple[ColumnImpact, float]:
    section = find(str(rng.choice(names)))
    length, height = rng.uniform(*LENGTHS), rng.uniform(*HEIGHTS)
    below, above = round(height * length, 3), round((1.0 - height) * length, 3)
    steel = Steel(yield_stress=float(rng.choice(GRADES)))
    spring = float(rng.choice([0.0, 5e6, 2e7]))
    column = Column(section, below, above, steel, restraint_stiffness=spring)
    most = min(PRESSED * column.properties.squash_load, OF_EULER * column.euler_load("weak"))
    column = column.changed(axial_load=round(rng.uniform(0.0, most), -3))
    speed, way = round(rng.uniform(*SPEEDS), 1), rng.uniform(*reach) * min(below, above)
    striker = heavy(column, way, speed)
    beside = round(rng.uniform(0.0, 0.5) * section.width, 4)
    name = f"{section.name}, {below:g} + {above:g} m, {speed:g} m/s, {striker.mass:g} kg"
    return ColumnImpact(name, column, striker, 0.4), max(beside, 1e-4)


def peaks(response: Response) -> Row:
    """Largest displacements (m) along the hit of axis, struck edge and face, sideways, and twist.

    With the outcome.
    """
    table: Row = {"outcome": outcome_of(response).value}
    for name, variable in PEAKS.items():
        history = response.get(variable)
        table[name] = np.nan if history is None else float(np.abs(history).max())
    table["time_of_peak_s"] = float(response.get("time_of_peak", np.nan))
    return table


def inputs(impact: ColumnImpact) -> Row:
    """Numbers that make a drawn impact, but for its section."""
    column, striker = impact.column, impact.striker
    return {
        "yield_stress_Pa": column.steel.yield_stress,
        "length_below_m": column.length_below,
        "length_above_m": column.length_above,
        "axial_load_N": column.axial_load,
        "restraint_stiffness_N_per_m": column.restraint_stiffness,
        "striker_mass_kg": striker.mass,
        "striker_velocity_m_per_s": striker.velocity,
        "duration_s": impact.duration,
    }


def pair_row(impact: ColumnImpact, beside: float, shell: Shell) -> Row:
    """Inputs of a pair, the peaks of shells in both hits, and those of plane models."""
    away = replace(impact.striker, eccentricity=beside)
    centred = peaks(shell.simulate(impact))
    beside_centre = replace(impact, striker=away)
    eccentric = peaks(shell.simulate(beside_centre))
    plane = {
        f"{name}_m": float(model.simulate(impact).get("peak_displacement", np.nan))
        for name, model in PLANE.items()
    }
    return {
        "case": impact.name,
        "refinement": shell.refinement,
        "section": impact.column.section.name,
        **inputs(impact),
        "eccentricity_m": beside,
        **features_beside(beside_centre),
        **plane,
        **{f"centred_{name}": value for name, value in centred.items()},
        **{f"eccentric_{name}": value for name, value in eccentric.items()},
    }


# --- slender plates -------------------------------------------------------------------------------

SLENDER = 16
FLANGES, WEBS = (7.0, 22.0), (30.0, 75.0)  # width over thickness and epsilon: classes 1 to 4
STOCKY_FLANGES, STOCKY_WEBS, VERY_SLENDER = (7.0, 15.0), (25.0, 50.0), 8  # first columns: FLANGES
DEEP, WIDE = (0.2, 0.4), (0.5, 1.0)  # m; over the height
HIGH_GRADES = (355e6, 460e6)  # Pa
MOST_SHEAR, MOST_PRESSED = 0.6, 0.5  # of the mechanism over Vpl; of the squash load
TILT = 1.0 / 200.0  # of flanges


def drawn_slender(seed: int = SEED, count: int = SLENDER) -> Iterator[ColumnImpact]:
    """So many columns with slender plates, every third hit along its flanges.

    What the plane model does not answer is drawn again.
    """
    rng = np.random.default_rng(seed)
    for number in range(count):
        plane = None
        while plane is None or outcome_of(plane) is not Outcome.OK:
            stocky = number >= VERY_SLENDER
            impact = _slender(rng, "weak" if number % 3 == 2 else "strong", stocky)
            plane = None if impact is None else FourDof().simulate(impact)
        lasting = 2.0 * float(plane["time_of_peak"])
        yield replace(impact, name=f"{number:02d} {impact.name}", duration=round(lasting, 4))


def _slender(rng: np.random.Generator, axis: str, stocky: bool) -> ColumnImpact | None:
    """A column that is hit; none where its webs would yield in shear."""
    grade = float(rng.choice(HIGH_GRADES))
    epsilon = sqrt(235e6 / grade)
    height = rng.uniform(*DEEP)
    width = rng.uniform(*WIDE) * height
    ratios = (STOCKY_FLANGES, STOCKY_WEBS) if stocky else (FLANGES, WEBS)
    flange, web = (rng.uniform(*each) * epsilon for each in ratios)
    thick = 0.5 * width / (flange + 0.5)
    sizes = height, width, (height - 2.0 * thick) / web, thick
    section = i_section(*(round(size, 4) for size in sizes))
    length, place = rng.uniform(3.0, 5.0), rng.uniform(0.25, 0.5)
    below, above = round(place * length, 3), round((1.0 - place) * length, 3)
    column = Column(section, below, above, Steel(yield_stress=grade), axis=axis)
    most = min(MOST_PRESSED * column.properties.squash_load, 0.5 * column.euler_load("weak"))
    column = column.changed(axial_load=round(rng.uniform(0.0, most), -3))
    speed, reach = round(rng.uniform(4.0, 14.0), 1), rng.uniform(0.02, 0.06) * below
    if max(mechanism_demand(column).values()) > MOST_SHEAR:
        return None
    striker = heavy(column, reach, speed)
    name = f"{section.name}, {axis}, {below:g} + {above:g} m, {speed:g} m/s, {striker.mass:g} kg"
    return ColumnImpact(name, column, striker, 0.4)


def slender_row(impact: ColumnImpact, shell: Shell) -> Row:
    """Inputs of a column with slender plates, peaks of shells and of fibers in space."""
    column = impact.column
    section: Section = column.section.about("strong")
    plates, shape = plates_of(section), section.shape
    classes = plate_classes(column.section, column.steel)
    epsilon = sqrt(235e6 / column.steel.yield_stress)
    area, modulus = shares_by_class(section, section, column.steel)
    beam = FiberSpace(levels=1).simulate(impact)
    return {
        "case": impact.name,
        "refinement": shell.refinement,
        **{f"{part}_m": getattr(shape, part) for part in ("height", "width", "web", "flange")},
        **inputs(impact),
        "axis": column.axis,
        "axial_over_squash": column.axial_load / column.properties.squash_load,
        "flange_over_epsilon": plates.flange / plates.flange_thickness / epsilon,
        "web_over_epsilon": plates.web / plates.web_thickness / epsilon,
        "class_pressed": classes.pressed,
        "class_bent": classes.bent,
        "effective_area_share": area,
        "effective_modulus_share": modulus,
        "fiber_space_m": float(beam["peak_displacement"]),
        **{f"shell_{name}": value for name, value in peaks(shell.simulate(impact)).items()},
    }


# --- files ----------------------------------------------------------------------------------------


def asked(what: str) -> Iterator[tuple[ColumnImpact, Shell, Callable[[], Row]]]:
    """Impacts of a set, the shells that answer them, and what makes their rows."""
    if what == "slender":
        shell = Shell(levels=1, tilt=TILT)
        for impact in drawn_slender():
            yield impact, shell, partial(slender_row, impact, shell)
        return
    for refinement in (-1, 0):
        shell = Shell(levels=1, refinement=refinement)
        for impact, beside in drawn_pairs():
            near = int(impact.name[:2]) < PAIRS
            if refinement < 0 or (near and impact.duration <= SHORT):
                yield impact, shell, partial(pair_row, impact, beside, shell)


def write(path: Path, what: str) -> None:
    """Write the rows that the file at `path` does not hold yet, one after another.

    Pairs on the coarser mesh, those that are short on the default one too.
    """
    known: set[tuple[str, str]] = set()
    if path.exists():
        with path.open(newline="") as file:
            known = {(line["case"], line["refinement"]) for line in csv.DictReader(file)}
    for impact, shell, ask in asked(what):
        if (impact.name, str(shell.refinement)) in known:
            continue
        kept = {name: _shown(value) for name, value in ask().items()}
        with path.open("a", newline="") as file:
            writer = csv.DictWriter(file, fieldnames=list(kept))
            if file.tell() == 0:
                writer.writeheader()
            writer.writerow(kept)


def _shown(value: float | str) -> float | str:
    """A cell of a table: six digits, empty for a number that is not known."""
    if not isinstance(value, float):
        return value
    return "" if np.isnan(value) else float(f"{value:.6g}")


if __name__ == "__main__":
    if sys.argv[1:2] in (["pairs"], ["slender"]):
        write(Path(sys.argv[2]), sys.argv[1])
    else:
        main(["run", __file__, *sys.argv[1:]])
