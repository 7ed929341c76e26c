"""A column as a frame: the same structure and the same event, for every base and head."""

from __future__ import annotations

import time
import tomllib

import pytest
from builders import SQUARE, examples
from hypothesis import given
from hypothesis import strategies as st

from workbench.scenarios import (
    Column,
    ColumnImpact,
    ColumnPushover,
    FrameImpact,
    FrameStatic,
    Load,
    Striker,
    frame_of,
    frame_scenario,
    regular_frame,
    scenario_from,
    to_toml,
)
from workbench.steel.sections import find, square

HEADS = {"guided": ("u", "rotation"), "pinned": ("u",), "fixed": ("u", "rotation")}


@st.composite
def columns(draw: st.DrawFn) -> Column:
    optional = {
        "area": st.floats(1e-3, 1e-1),
        "second_moment": st.floats(1e-6, 1e-3),
        "plastic_moment": st.floats(1e4, 1e6),
        "mass_per_length": st.floats(1.0, 1e3),
        "impact_mass": st.floats(1.0, 1e3),
    }
    return Column(
        draw(st.sampled_from([find("IPE 300"), find("HEM 200"), square(0.15)])),
        draw(st.floats(0.5, 5.0)),
        draw(st.floats(0.5, 5.0)),
        base=draw(st.sampled_from(["clamped", "pinned"])),
        head=draw(st.sampled_from(list(HEADS))),
        axial_load=draw(st.sampled_from([0.0, 1e5, -1e5])),
        restraint_stiffness=draw(st.sampled_from([0.0, 1e7])),
        head_mass=draw(st.sampled_from([0.0, 500.0])),
        fillets=draw(st.booleans()),
        **{name: draw(st.one_of(st.none(), values)) for name, values in optional.items()},
    )


@examples(60)
@given(columns())
def test_a_column_stands_on_its_base(column: Column) -> None:
    frame = frame_of(column)
    base, hit, head = frame.nodes
    assert [(n.name, n.x, n.y) for n in frame.nodes] == [
        ("base", 0.0, 0.0),
        ("hit", 0.0, column.length_below),
        ("head", 0.0, column.length),
    ]
    assert base.support == column.base
    assert (hit.held, head.held) == ((), HEADS[column.head])
    assert head.locked == ("y" if column.head == "fixed" else "none")
    assert (head.spring_y, head.mass) == (column.restraint_stiffness, column.head_mass)
    assert [(m.name, m.start, m.end) for m in frame.members] == [
        ("below", "base", "hit"),
        ("above", "hit", "head"),
    ]
    assert sum(load.y for load in frame.loads) == -column.axial_load
    whole = column.properties
    for member in frame.members:
        part = frame.properties(member)
        for name in ("area", "second_moment", "plastic_moment", "squash_load", "mass_per_length"):
            assert getattr(part, name) == getattr(whole, name)
        assert part.shear_resistance == whole.shear_resistance
        assert frame.strength_section(member) == column.strength_section
    mass = sum(frame.properties(m).mass_per_length * frame.length(m) for m in frame.members)
    assert mass == pytest.approx(whole.mass_per_length * column.length, rel=1e-12)


@examples(40)
@given(columns(), st.floats(0.01, 0.5), st.floats(0.0, 1.0))
def test_what_happens_to_a_column_happens_to_its_frame(column, displacement, restitution) -> None:
    push = frame_scenario(ColumnPushover("push", column, displacement))
    assert isinstance(push, FrameStatic)
    assert (push.node, push.direction, push.path) == ("hit", "x", (displacement,))
    assert (push.loads, push.magnitude) == ((Load("hit", x=1.0),), 1.0)
    impact = ColumnImpact("hit", column, Striker(1500.0, 12.0, restitution), 0.07)
    hit = frame_scenario(impact)
    assert isinstance(hit, FrameImpact)
    assert (hit.striker.node, hit.striker.direction) == ("hit", "+x")
    assert hit.striker.restitution == restitution
    assert (hit.input_energy, hit.duration) == (impact.input_energy, impact.duration)
    assert hit.frame == push.frame == frame_of(column)
    for scenario in (push, hit):
        assert scenario_from(tomllib.loads(to_toml(scenario))) == scenario


def test_many_splits_take_the_time_of_one_frame() -> None:
    bays, storeys = (4.0,) * 2, (4.0,) * 100
    frame = regular_frame(bays, storeys, SQUARE, SQUARE)
    splits = [(f"A{i}-A{i + 1}" + "/2" * k, 1.0, f"s{i}.{k}") for i in range(100) for k in range(3)]
    began = time.process_time()
    whole = frame.split_all(splits)
    assert time.process_time() - began < 2.0
    assert len(whole.members) == len(frame.members) + 300
    few = frame
    for member, at, node in splits[:3]:
        few = few.split(member, at, node)
    assert few == frame.split_all(splits[:3])
    assert [m.name for m in few.members[:4]] == [
        "A0-A1/1", "A0-A1/2/1", "A0-A1/2/2/1", "A0-A1/2/2/2",
    ]  # fmt: skip
