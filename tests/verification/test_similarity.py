"""Geometric similarity: a column k times as large answers k times as much, k times as slowly.

Lengths and times go with k, masses with k^3, axial forces with k^2, the restraint with k; steel
and velocities stay. Scales are powers of two, which round-off does not see: what differs holds a
length, a mass, a time or a force of its own, which is another thing in a laboratory than in a
building.
"""

from __future__ import annotations

from dataclasses import fields

import pytest
from builders import examples
from hypothesis import given
from hypothesis import strategies as st

from workbench.models.base import make_model, model_kind, model_names
from workbench.responses import Outcome, Response, outcome_of
from workbench.scenarios import Column, ColumnImpact, Striker
from workbench.steel.sections import i_section, square

# answer printed or measured numbers, or those of a server; is a rule for frames; refines its mesh
# by its own uncertainty, too slowly
LEFT_OUT = (
    *("published", "measured", "imported", "remote", "opensees"),
    *("column-of-frame", "solid-plane-stress", "shell"),
)
SPATIAL = ("fiber-space", "superelement-space")  # minutes; held to fiber-corotational, which is
SCALED = {"striker_stiffness": 1, "crush_force": 2, "time_step": 1}  # options go with the size
EQUAL = {"time_step": 5e-5}  # s at the scale of 1: steps by error follow round-off
REDUCED = (
    *(("single-dof", {"resistance": law}) for law in ("analytic", "cubic", "linear", "panel")),
    *(("soft-impact", {"striker_stiffness": 2e7, "crush_force": force}) for force in (None, 6e5)),
    *((name, {}) for name in ("four-dof", "four-dof-shear", "energy-estimate")),
    *((name, EQUAL) for name in ("rigid-superelement", "flexible-superelement")),
    ("seven-dof", EQUAL),
    ("rigid-superelement", {"elements": 2, "inertia": "linear", **EQUAL}),
    *((name, {}) for name in ("biggs", "hand-estimate", "trilinear-catenary", "yin-wang")),
    *(("izzuddin", {}), ("en-1991-hard-impact", {"striker_stiffness": 2e7})),
)
REFERENCES = ("fiber-corotational", "fiber-reissner", "fiber-shear")
FRAMES = ("giberson", "plastic-hinge", "refined-plastic-hinge", "quasi-plastic-hinge")
FIBER_FRAMES = ("force-based-beam", "fiber-hinge", "bounding-surface", "modified-tangent-modulus")
EXPONENTS = {"peak_displacement": 1, "residual_displacement": 1, "time_of_peak": 1, "impulse": 3}


def impact(
    scale: float, shape: str, velocity: float, restitution: float, head: float
) -> ColumnImpact:
    """A column of 4 m times `scale`, with `head` of its restraint and mass."""
    k = scale
    plates = (0.24 * k, 0.2 * k, 0.02 * k, 0.03 * k)
    column = Column(
        i_section(*plates) if shape == "I" else square(0.2 * k),
        length_below=1.1 * k,
        length_above=2.9 * k,
        axial_load=3e5 * k**2,
        restraint_stiffness=head * 1e7 * k,
        head_mass=head * 200.0 * k**3,
    )
    striker = Striker(1200.0 * k**3, velocity, restitution)
    return ColumnImpact("similar", column, striker, 0.04 * k)


def check(
    name: str, options: dict[str, object], scale: float, *how: object, within: float = 1e-9
) -> None:
    def answer(k: float) -> Response:
        sized = {
            key: value and value * k ** SCALED[key]
            for key, value in options.items()
            if key in SCALED
        }
        return make_model(name, {**options, **sized}).simulate(impact(k, *how))

    one, other = answer(1.0), answer(scale)
    assert outcome_of(one) is outcome_of(other)
    if outcome_of(one) is not Outcome.OK:
        return
    if within < 1e-8:
        assert one.sizes.get("time") == other.sizes.get("time")
    for quantity, exponent in EXPONENTS.items():
        if quantity in one:
            expected = float(one[quantity]) * scale**exponent
            assert float(other[quantity]) == pytest.approx(expected, rel=within), quantity


def test_every_column_model_is_held_to_it() -> None:
    held = {name for name, _ in REDUCED} | {
        *REFERENCES,
        *FRAMES,
        *FIBER_FRAMES,
        *LEFT_OUT,
        *SPATIAL,
    }
    columns = {n for n in model_names() if {*model_kind(n).answers} & {ColumnImpact.KIND}}
    assert columns <= held


@pytest.mark.parametrize(("name", "options"), REDUCED)
@examples(7)
@given(
    st.sampled_from((0.125, 0.25, 0.5, 4.0)),
    st.sampled_from(("I", "square")),
    st.floats(2.0, 14.0),
    st.sampled_from((0.0, 0.5)),
    st.sampled_from((0.0, 1.0)),
)
def test_reduced_models_answer_alike_at_every_scale(
    name: str, options: dict[str, object], scale: float, shape: str, velocity: float,
    restitution: float, head: float,
) -> None:  # fmt: skip
    check(name, options, scale, shape, velocity, restitution, head)


@pytest.mark.thorough
@pytest.mark.parametrize("name", REFERENCES)
def test_references_answer_alike_at_every_scale(name: str) -> None:
    coarse = (
        {"refinement": -1} if "refinement" in {f.name for f in fields(model_kind(name))} else {}
    )
    check(name, {"levels": 1, "layers": 6, **coarse}, 0.25, "I", 6.0, 0.0, 0.0)


@pytest.mark.thorough
@pytest.mark.parametrize("name", [*FRAMES, *FIBER_FRAMES])
def test_frame_models_of_practice_answer_alike_at_every_scale(name: str) -> None:
    within = 1e-6 if name in FRAMES else 1e-3  # what Newton's method leaves; steps that it cuts
    check(name, {}, 0.25, "I", 6.0, 0.0, 0.0, within=within)
