"""How far models of frames are off under impact, on portals and small frames drawn at random.

One or two storeys of one or two bays, rolled columns and tubes of five steels, clamped or pinned
bases, rigid or pinned beams, with and without dead loads; a striker hits a column between its
joints, mostly of the ground floor, with the energy to push its mechanism, or that of the frame if
that is weaker, some hundredths to half of the shorter segment. Light strikers, which are rare by
themselves, are drawn apart: every model is in error there. The reference is the frame of fibers
whose webs yield. The peaks are the data of the error model.
"""

import sys
from collections.abc import Iterator
from dataclasses import replace
from itertools import chain
from math import exp, log, sqrt

import numpy as np
from drawn_columns import with_law

from workbench.cli import main
from workbench.mechanics.frames.collapse import collapse_factor
from workbench.mechanics.frames.column_estimate import column_like
from workbench.mechanics.frames.elastic import dead_load_state
from workbench.models.column_of_frame import ColumnOfFrame
from workbench.models.domain import shear_demand
from workbench.models.references.fiber_beams import FiberShear
from workbench.models.superelements import FlexibleSuperelement
from workbench.scenarios import Frame, FrameImpact, FrameStriker, Load, regular_frame
from workbench.steel.materials import Steel
from workbench.steel.sections import find, rectangular_tube
from workbench.study import Case, Figure, Study

SEED, LIGHT_SEED, LARGE_SEED, RATE_SEED, QUICK = 29, 58, 59, 61, 6
FRAMES, LIGHT, LARGE, RATES = 100, 90, 48, 44
REFERENCE, FLEXIBLE = "web-yielding frame", "flexible superelements"
models = {
    REFERENCE: FiberShear(levels=1),
    FLEXIBLE: FlexibleSuperelement(),
    "column of the frame": ColumnOfFrame(),
}
COLUMNS = (
    *(find(name) for name in ("HEA 160", "HEA 200", "HEA 260", "HEB 160", "HEB 220", "HEB 300")),
    *(find(name) for name in ("IPE 240", "IPE 330", "IPE 450")),
    rectangular_tube(0.2, 0.2, 0.01),
)
BEAMS = tuple(find(name) for name in ("IPE 200", "IPE 270", "IPE 330", "IPE 400", "HEA 220"))
STEELS = (355e6, 355e6, 235e6, 275e6, 460e6)  # yield stress, Pa
HEAVIEST, LEAST = 6e4, 0.3  # striker: kg, and over the lumped mass of the column
LIGHTEST, FASTEST = 0.15, 40.0  # of the light ones: over the lumped mass, and m/s
GRAVITY = 9.81


def _rounded(value: float) -> float:
    return float(f"{value:.4g}")


def drawn_frame(rng: np.random.Generator, large: bool = False) -> Frame:
    """A frame, of up to three bays and six storeys if `large`; dead loads and masses on joints."""
    section, beam = COLUMNS[rng.integers(len(COLUMNS))], BEAMS[rng.integers(len(BEAMS))]
    steel = Steel(yield_stress=STEELS[rng.integers(len(STEELS))])
    spans = rng.integers(1, 4) if large else 1 + (rng.random() < 0.4)
    bays = [_rounded(rng.uniform(3.5, 7.0)) for _ in range(spans)]
    levels = rng.integers(2, 7) if large else 1 + (rng.random() < 0.4)
    storeys = [_rounded(rng.uniform(2.8, 4.5)) for _ in range(levels)]
    joint = "pinned" if rng.random() < 0.15 else "rigid"
    base = "pinned" if joint == "rigid" and rng.random() < 0.25 else "clamped"
    frame = regular_frame(bays, storeys, section, beam, base, steel, beam_joint=joint)
    share = 0.0 if rng.random() < 0.25 else rng.uniform(0.02, 0.25) / len(storeys)
    load, part = share * steel.yield_stress * section.area, rng.uniform(0.3, 1.2)
    if not load:
        return frame
    joints = [node.name for node in frame.nodes if node.y > 0.0]
    mass = _rounded(part * load / GRAVITY)
    nodes = tuple(replace(n, mass=mass) if n.name in joints else n for n in frame.nodes)
    loads = tuple(Load(name, y=-_rounded(load)) for name in joints)
    return replace(frame, nodes=nodes, loads=loads)


def drawn(
    number: int, rng: np.random.Generator, light: bool = False, large: bool = False
) -> FrameImpact | None:
    """A hit on a frame, of a `light` striker or not, on a `large` frame or not.

    None on a frame that hardly carries its dead loads, or where a light striker is too fast.
    """
    frame = drawn_frame(rng, large)
    storeys = sorted({node.y for node in frame.nodes})
    axis = "ABCD"[rng.integers(len({node.x for node in frame.nodes}))]
    level = int(len(storeys) > 2 and rng.random() < 0.2)
    height = storeys[level + 1] - storeys[level]
    member = frame.member(f"{axis}{level}-{axis}{level + 1}")
    least = max(0.15, 1.8 * member.section.height / height)
    at = _rounded(rng.uniform(least, 1.0 - least) * height)
    speed, reach = exp(rng.uniform(log(1.5), log(25.0))), exp(rng.uniform(log(0.01), log(0.5)))
    bounce = 0.0 if rng.random() < 0.7 else _rounded(rng.random())
    hit = frame.split(member.name, at, "hit")
    if hit.loads and (dead_load_state(hit).factor or 0.0) < 2.0:
        return None
    strength = collapse_factor(hit, [Load("hit", x=1.0)], hit.loads)
    column = column_like(FrameImpact("unit", hit, FrameStriker(1.0, 1.0, node="hit"), 1.0))
    if column is None or strength is None:
        return None
    properties = column.column.properties
    sheared = sum(min(each, 1.0) for each in shear_demand(column).values())
    resistance = min(strength, sheared * properties.shear_resistance)
    energy = resistance * reach * min(at, height - at)
    mass = min(max(2.0 * energy / speed**2, LEAST * properties.impact_mass), HEAVIEST)
    if light:  # with the same energy
        mass = exp(rng.uniform(log(LIGHTEST), 0.0)) * properties.impact_mass
        speed = sqrt(2.0 * energy / mass)
        if speed > FASTEST:
            return None
    lasts = 2.5 * mass * speed / resistance + 0.06  # 2.5 times what a constant force takes
    struck = FrameStriker(_rounded(mass), _rounded(speed), bounce, node="hit")
    shape = f"{len({n.x for n in frame.nodes}) - 1} x {len(storeys) - 1}"
    name = f"{number:03d} {member.section.name}, {shape}, {axis}{level} at {at / height:.2f}, "
    name += f"{mass:.0f} kg, {speed:.1f} m/s"
    return FrameImpact(name, hit, struck, _rounded(lasts))


def drawn_hits(
    seed: int,
    count: int,
    light: bool = False,
    first: int = 0,
    large: bool = False,
    rate: bool = False,
) -> Iterator[FrameImpact]:
    """Hits on frames, the same of a seed however many, numbered from the `first` on.

    On `large` frames, or on steel with a drawn rate law (`rate`), a third by light strikers.
    """
    rng, number = np.random.default_rng(seed), first
    while number < first + count:
        is_light = light or ((large or rate) and rng.random() < 0.35)
        impact = drawn(number, rng, is_light, large)
        if impact is not None:
            yield with_law(impact, rng) if rate else impact
            number += 1


def case_of(number: int, scenario: FrameImpact) -> Case:
    """The case of a drawn frame; large ones and those with a rate have anchor and truth alone."""
    asked = tuple(models) if number < FRAMES + LIGHT else (REFERENCE, FLEXIBLE)
    return Case(scenario.name, scenario, models=asked, quick=number < QUICK)


hits = chain(
    drawn_hits(SEED, FRAMES),
    drawn_hits(LIGHT_SEED, LIGHT, light=True, first=FRAMES),
    drawn_hits(LARGE_SEED, LARGE, first=FRAMES + LIGHT, large=True),
    drawn_hits(RATE_SEED, RATES, first=FRAMES + LIGHT + LARGE, rate=True),
)
cases = tuple(case_of(*pair) for pair in enumerate(hits))
study = Study(
    name="drawn_frames",
    title="Frames under impact: models of frames on drawn ones",
    question="How far are models of frames off under impact, and where?",
    cases=cases,
    models=models,
    reference=REFERENCE,
    quantities=("peak_displacement", "residual_displacement", "peak_force"),
    figures=(
        Figure("structure", "structure", "The frames", "One of them."),
        Figure("peaks", "peaks", "Peaks of every model against the web-yielding frame", "By case."),
    ),
    decisive="peaks",
)

if __name__ == "__main__":
    main(["run", __file__, *sys.argv[1:]])
