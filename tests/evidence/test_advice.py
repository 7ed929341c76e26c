"""Advice on which model to take instead: it goes up in trust, ends, and ends inside a domain."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from workbench.evidence.advice import NONE, ORDER, advise, with_remedies
from workbench.evidence.descriptors import DEMAND, descriptors
from workbench.references.fiber_shear import FiberShear
from workbench.registry import make_model, model_kind, model_names
from workbench.responses import Finding
from workbench.scenarios import Column, ColumnImpact, Striker
from workbench.sections import find, names, rectangular_tube, square

DRAWN = 100
HELD = ("measured", "published")  # answer what was tested


def drawn() -> list[ColumnImpact]:
    """Columns and hits of all kinds, with fillets and without, some bouncing, some slender."""
    rng = np.random.default_rng(2701)
    rolled = sorted(names())
    hits = []
    for number in range(DRAWN):
        section = find(rolled[rng.integers(len(rolled))])
        if number % 8 == 0:
            section = rectangular_tube(0.2, 0.12, 0.006) if number % 16 else square(0.1)
        below, above = section.height + rng.uniform(0.1, 4.0, 2)
        column = Column(
            section,
            float(below),
            float(above),
            base=str(rng.choice(["clamped", "pinned"])),
            head=str(rng.choice(["guided", "pinned", "fixed"])),
            restraint_stiffness=float(rng.choice([0.0, 10.0 ** rng.uniform(5.0, 9.0)])),
            head_mass=float(rng.choice([0.0, 500.0])),
            fillets=bool(rng.integers(2)),
        )
        load = rng.choice([0.0, rng.uniform(0.0, 0.6)]) * column.properties.squash_load
        mass = column.properties.impact_mass * 10.0 ** rng.uniform(-0.5, 2.5)
        bounce = float(rng.choice([0.0, 0.0, rng.uniform(0.0, 1.0), 1.0]))
        striker = Striker(float(mass), float(10.0 ** rng.uniform(-0.3, 1.6)), bounce)
        column = replace(column, axial_load=float(load))
        hits.append(ColumnImpact(f"hit {number}", column, striker))
    return hits


@pytest.fixture(scope="module")
def models():
    kinds = {name: model_kind(name) for name in model_names() if name not in HELD}
    return {n: make_model(n) for n, kind in kinds.items() if ColumnImpact.KIND in kind.answers}


def test_no_advice_goes_in_a_circle_and_all_of_it_ends_inside_a_domain(models) -> None:
    """Every remedy of every model is followed until it ends."""
    ends = {"inside": 0, "nothing": 0}
    for hit in drawn():
        findings = {n: advise(m, hit) for n, m in models.items()}
        for name in models:
            trails = [(name,)]
            while trails:
                trail = trails.pop()
                assert len(set(trail)) == len(trail), f"{hit.name}: {' -> '.join(trail)}"
                out = [f for f in findings[trail[-1]] if f.outside or f.refusal]
                if len(trail) > 1:
                    assert not out, f"{hit.name}: {' -> '.join(trail)} is outside: {out[0]}"
                told = [f for f in findings[trail[-1]] if f.instead]
                trails += [(*trail, each) for f in told for each in f.instead]
                if not told:
                    assert all(f.remedy for f in out), f"{hit.name}, {trail}: {out}"
                    ends["nothing" if out else "inside"] += 1
    assert min(ends.values()) > 0


def test_the_column_of_the_readme_is_not_sent_to_beams_that_cannot_follow_it(
    thesis_impact: ColumnImpact,
) -> None:
    """Webs slide there by most of the shorter segment: `fiber-shear` does not stretch."""
    assert descriptors(thesis_impact)[DEMAND] > 1.0
    for name in ("four-dof", "four-dof-shear", "rigid-superelement", "fiber-reissner"):
        model = make_model(name)
        findings = advise(model, thesis_impact)
        named = {other for f in findings for other in f.instead or ()}
        assert named
        assert "fiber-shear" not in named
    gentle = thesis_impact.at_velocity(3.0)
    (finding, *_) = advise(make_model("fiber-reissner"), gentle)
    assert finding.remedy == "take fiber-shear"
    slid = Finding("shear-strain", "a mean shear strain of 0.88", number=0.88, instead=())
    (slid,) = with_remedies(FiberShear(), thesis_impact, [slid])
    assert slid.remedy == "take solid-plane-stress"


def test_nothing_is_above_the_last_and_input_that_is_mended_stays(thesis_impact) -> None:
    last = make_model(ORDER[-1])
    own = [Finding("any", "text", instead=()), Finding("no-peak", "text", remedy="take longer")]
    none, kept = with_remedies(last, thesis_impact, own)
    assert none.remedy == NONE
    assert none.instead == ()
    assert kept == own[1]
    assert with_remedies(last, thesis_impact, [none]) == [none]


def test_restitution_alone_makes_no_column_unmeasured(thesis_impact: ColumnImpact) -> None:
    bouncing = replace(thesis_impact, striker=replace(thesis_impact.striker, restitution=0.5))
    (finding,) = (f for f in advise(make_model("four-dof"), bouncing) if f.subject == "measured")
    assert "all without restitution" in finding.text
