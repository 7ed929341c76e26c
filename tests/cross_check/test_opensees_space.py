"""Ten drawn columns that are hit obliquely: `fiber-space` against OpenSeesPy in space.

The same nodes, fibers and nodal masses on both sides, large rotations, torsion by St Venant, no
shear, no warping; the striker may lift off, the column slides along its face.
"""

from __future__ import annotations

from functools import cache
from math import radians

import numpy as np
import opensees_columns as opensees
import pytest
from threadpoolctl import threadpool_limits

from workbench.models.references.fiber_space import FiberSpace
from workbench.responses import Outcome, outcome_of
from workbench.scenarios import Column, ColumnImpact, Striker

SEED, COUNT = 20261128, 10
SECTIONS = ("HEA 200", "HEB 240", "IPE 300", "UC 254x254x89", "SHS 200x10", "RHS 250x150x10")
STEP = 1e-5  # s, of OpenSees; with 5e-5 a light striker loses 2 % of the peak to its damping
QUICK_STEP = 5e-5  # s
DURATION = 0.1  # s
MOST_BENT = 0.25  # of the Euler load, on the column
LIGHTEST = 300.0  # kg
BOUND = 0.03  # what the peaks may differ by
QUICK = (1, 5)  # columns of the default run, on the coarse mesh


def drawn(number: int, generator: np.random.Generator) -> ColumnImpact:
    """Column of a section, hit from 0 to 90 degrees by a mass that its mechanism stops."""
    uniform = generator.uniform
    length = uniform(3.0, 4.5)
    below = uniform(0.3, 0.5) * length
    degrees, pressed, velocity = uniform(0.0, 90.0), uniform(0.0, 0.25), uniform(4.0, 14.0)
    reach, spring = uniform(0.02, 0.07), 10 ** uniform(6.0, 7.3)
    base, head = ("pinned" if generator.random() < 0.25 else kind for kind in ("clamped", "guided"))
    column = Column(
        SECTIONS[number % len(SECTIONS)],
        below,
        length - below,
        base=base,
        head=head,
        restraint_stiffness=spring,
        fillets=False,
    )
    euler = min(column.euler_load(axis) for axis in ("weak", "strong"))
    load = min(pressed * column.properties.squash_load, MOST_BENT * euler)
    column = column.changed(axial_load=load)
    ends = {"clamped": 2.0, "guided": 2.0, "pinned": 1.0}
    moment = column.properties.plastic_moment
    resistance = moment * (ends[base] / below + ends[head] / (length - below))
    mass = max(2.0 * resistance * reach * below / velocity**2, LIGHTEST)
    striker = Striker(mass, velocity, angle=radians(degrees))
    return ColumnImpact(f"drawn {number}", column, striker, DURATION)


@cache
def hits() -> tuple[ColumnImpact, ...]:
    """All columns, in the order that they are drawn in."""
    generator = np.random.default_rng(SEED)
    return tuple(drawn(number, generator) for number in range(COUNT))


def peaks(number: int, refinement: int, step: float) -> tuple[float, float]:
    """Peak displacements (m) of a column along the hit, here and in OpenSeesPy, on one mesh.

    Arguments: `number` of the column; `refinement` of the mesh; `step` of OpenSees, in s.
    """
    hit = hits()[number]
    model = FiberSpace(levels=1, refinement=refinement)
    response = model.simulate(hit)
    assert outcome_of(response) is Outcome.OK, response.attrs["message"]
    lengths = model.lengths(hit)
    with threadpool_limits(1, user_api="blas"):
        opensees.stand_in_space(hit, np.concatenate(lengths), model.hardening_ratio, model.layers)
        other = opensees.peak_under(hit, len(lengths[0]) + 1, step)
    here = float(response["peak_displacement"])
    print(
        f"{number}, {refinement}: {here:.4f} m, OpenSees {other:.4f} m, {here / other - 1.0:+.1%}"
    )
    return here, other


@pytest.mark.parametrize("number", QUICK)
def test_peak_on_a_coarse_mesh(number: int) -> None:
    here, other = peaks(number, -2, QUICK_STEP)
    assert here == pytest.approx(other, rel=BOUND)


@pytest.mark.slow
@pytest.mark.parametrize("number", range(COUNT))
def test_peak_of_every_column(number: int) -> None:
    here, other = peaks(number, 0, STEP)
    assert here == pytest.approx(other, rel=BOUND)
