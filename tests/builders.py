"""What many tests share: structures, counts of answered random scenarios, of words of a page."""

from __future__ import annotations

import fcntl
import os
import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import scipy
from hypothesis import settings

from workbench.mechanics.frames.structure import FrameStructure
from workbench.mechanics.structures.assembly import PlanarAssembly
from workbench.mechanics.structures.explicit import explicit_impact
from workbench.mechanics.structures.impact import PointMass
from workbench.models.base import Model
from workbench.models.frame_model import as_frame
from workbench.models.references import fiber
from workbench.models.references.fiber import FiberReference
from workbench.responses import Outcome, Response, outcome_of
from workbench.scenarios import (
    ColumnImpact,
    Frame,
    FrameImpact,
    Joint,
    Load,
    regular_frame,
)
from workbench.steel.hinges import ShearSurface
from workbench.steel.sections import Section, square

SQUARE = square(0.2)
MOST_WORDS = 250  # in sight on a first page
UNCERTAIN = """
kind = "column-impact"
name = "uncertain column"
[column]
section = "HEB 220"
length_below = 2.0
length_above = 2.0
axial_load = { lognormal = { mean = 500e3, cov = 0.15 } }
[steel]
yield_stress = { jcss = "S355" }
[striker]
"""  # what strikes is added
# assumptions of Heng 2017 that lumped columns have as options
THESIS_SPRINGS = {"rotational_stiffness": 6.0}
THESIS_CURVE = {**THESIS_SPRINGS, "interaction": "linear"}


def portal(
    *joints: Joint,
    section: Section = SQUARE,
    height: float = 4.0,
    base: str = "clamped",
    loads: tuple[Load, ...] = (),
    **members: object,
) -> Frame:
    """One bay of 6 m and one storey: columns A0-A1 and B0-B1, beam A1-B1, all of one section.

    Arguments: `joints`, of which the first stands at both ends of the beam; `section`; `height`
    in m; `base`, clamped or pinned; dead `loads`; `members`, overrides of every member.
    """
    frame = regular_frame((6.0,), (height,), section, section, base=base)
    parts = [replace(member, **members) for member in frame.members]
    if joints:
        name = joints[0].name
        parts[2] = replace(parts[2], joint_start=name, joint_end=name)
    given = tuple(joint for joint in joints if joint.name not in ("rigid", "pinned"))
    return replace(frame, members=tuple(parts), joints=given, loads=loads)


def thesis_frame(base: str = "clamped") -> Frame:
    """The frame of Heng 2017, figures 5.13 and 5.14: four bays, two storeys, 0.2 m square."""
    return regular_frame((3.0,) * 4, (4.0, 4.0), SQUARE, SQUARE, base=base)


def absorbed(
    lengths: tuple[float, float], moment: float, ends: tuple[float, float], load: float = 0.0
) -> float:
    """Energy (J) that the rigid-plastic mechanism of a struck member absorbs before it collapses.

    Arguments: `lengths` (m) of its segments; plastic moments (N m) at the impact point, `moment`,
    and at the `ends`, 0 at a pin; axial `load` (N), compression positive. It collapses where its
    displacement v is 0.9 of the shorter segment, beyond which models mean nothing, or before, where
    the load, which sinks by v^2 / 2 (1 / a + 1 / b), does more work than the hinges.
    """
    a, b = lengths
    slope = 1.0 / a + 1.0 / b
    resistance, softening = ends[0] / a + moment * slope + ends[1] / b, load * slope
    v = 0.9 * min(lengths)
    if softening * v > resistance:
        v = resistance / softening
    return (resistance - 0.5 * softening * v) * v


def lumped(model: FiberReference, scenario: ColumnImpact | FrameImpact) -> FrameStructure:
    """The structure of a fiber reference with its mass at the nodes."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fiber, "PlanarAssembly", partial(PlanarAssembly, lumped=True))
        return model.structure(scenario)


def explicit_peak(
    model: FiberReference, scenario: ColumnImpact | FrameImpact
) -> tuple[float, float]:
    """Peak (m) and impulse (N s) of a fiber reference with lumped mass, by explicit steps."""
    event, stood = as_frame(scenario), lumped(model, scenario)
    dof, sign = stood.dof(event.striker.node, event.striker.direction)
    start, peak, impulse = float(stood.assembly.displacement[dof]), 0.0, 0.0
    spans = [(event.duration, 1e-4)]
    striker = PointMass.of(scenario)
    for step in explicit_impact(stood.assembly, dof, striker, spans, sign=sign):
        peak = max(peak, sign * (float(stood.assembly.displacement[dof]) - start))
        impulse += step.impulse
    return peak, impulse


def made_once(factory: pytest.TempPathFactory, name: str, make: Callable[[Path], object]) -> Path:
    """A directory that the first process of a test run lets `make` fill; the others read it."""
    root = factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        root = root.parent
    directory, done = root / f"shared-{name}", root / f"shared-{name}.done"
    with (root / f"shared-{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not done.exists():
            make(directory)
            done.touch()
    return directory


def examples(many: int) -> settings:
    """So many random examples in the long runs (--run-slow), in proportion to them otherwise."""
    return settings(max_examples=many * settings().max_examples // 100)


@dataclass
class Answers:
    """Which of the random scenarios that a model's domain admits it also answers."""

    given: list[bool] = field(default_factory=list)

    def note(
        self, model: Model, scenario: object, response: Response, *, asked: bool = True
    ) -> bool:
        """Count a response unless the domain refuses the scenario; whether it is an answer.

        Only scenarios that are `asked` count: those whose energy the structure can absorb.
        """
        answered = outcome_of(response) is Outcome.OK
        if asked and not any(finding.refusal for finding in model.domain(scenario)):
            self.given.append(answered)
        return answered

    def demand(self, share: float = 0.95, of: int = 10) -> None:
        """At least this share of the admitted scenarios, at least `of` of them, is answered."""
        assert len(self.given) >= of
        answered = sum(self.given)
        assert answered >= share * len(self.given), f"{answered} of {len(self.given)} answered"


def words_in_sight(html: str) -> int:
    """Words of the first page of a report that are neither folded nor in a picture."""
    page = html[html.index("<header") : html.index("<nav")]
    seen = re.sub(r"<details.*?</details>|<svg.*?</svg>", " ", page, flags=re.DOTALL)
    return len(re.sub(r"<[^>]*>", " ", seen).split())


def plateau(surface: ShearSurface, lengths: tuple[float, float]) -> float:
    """Limit load (N) at the impact point of two clamped panels of these lengths (m), without N.

    Both bend, V L = 2 M_c(V), or the shorter one slides and its flanges alone bend the other.
    """
    shorter, longer = sorted(lengths)
    record = surface.record

    def bent(length: float, passed: float) -> float:
        """Shear force with M_c at one end and at most `passed` at the other."""

        def excess(V: float) -> float:
            capacity = float(surface.moment_capacity(0.0, V))
            return V * length - capacity - min(passed, capacity)

        top = float(record["shear"])
        return top if excess(top) <= 0.0 else float(scipy.optimize.brentq(excess, 0.0, top))

    below = bent(shorter, np.inf)
    flanges = float(record["flange_moment"])
    return below + bent(longer, flanges if below >= record["shear"] else np.inf)
