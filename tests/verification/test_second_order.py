"""Second-order benchmarks of AISC 360 (commentary to chapter C, cases 1 and 2), elastic.

W14x48, 28 ft, E = 200 GPa. The closed forms are those of the beam-column without shear strain and
shortening: amplification of a uniform load (case 1, P-delta) and of a cantilever's tip load
(case 2, P-Delta).
"""

from __future__ import annotations

from math import cos, sqrt, tan

import pytest

from workbench.models.references.fiber_beams import FiberCorotational
from workbench.models.superelements import FlexibleSuperelement
from workbench.scenarios import Frame, FrameStatic, Load, Member, Node
from workbench.steel.materials import Steel
from workbench.steel.sections import section_from

SECOND_MOMENT, AREA = 484.0 * 0.0254**4, 14.1 * 0.0254**2
LENGTH = 28 * 0.3048
STEEL = Steel(elastic_modulus=200e9, yield_stress=3e9)
STIFFNESS = STEEL.elastic_modulus * SECOND_MOMENT
UNIFORM, TIP = 2.92e3, 4.45e3  # N/m, N
ELEMENTS = 16


def section():
    """A rectangle with the area and second moment of the W14x48."""
    height = sqrt(12.0 * SECOND_MOMENT / AREA)
    return section_from({"width": AREA / height, "height": height}, "section")


def column(supports: tuple[str, str], axial: float) -> Frame:
    """A column of several members, upright, under an axial dead load."""
    ticks = [LENGTH * i / ELEMENTS for i in range(ELEMENTS + 1)]
    ends = {0: supports[0], ELEMENTS: supports[1]}
    nodes = tuple(Node(f"n{i}", 0.0, y, support=ends.get(i, "free")) for i, y in enumerate(ticks))
    members = tuple(Member(f"m{i}", f"n{i}", f"n{i + 1}", section()) for i in range(ELEMENTS))
    loads = (Load(f"n{ELEMENTS}", y=-axial),) if axial else ()
    return Frame(nodes, members, loads=loads, steel=STEEL)


MODELS = {
    "flexible superelement": FlexibleSuperelement(hinge_stiffness=1e6),
    "fiber beam": FiberCorotational(
        shear_flexible=False, smallest_element=0.5, layers=40, refinement=0, levels=1
    ),
}


@pytest.mark.thorough
@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("axial", [0.0, 667e3, 1334e3, 2001e3])
def test_case_1_member_with_uniform_load(model, axial) -> None:
    """Mid-height deflection and moment of a pinned column, sixteen members."""
    part = LENGTH / ELEMENTS
    inner = tuple(Load(f"n{i}", x=UNIFORM * part) for i in range(1, ELEMENTS))
    end = UNIFORM * part**2 / 12.0  # moments of the uniform load at the ends of the member
    loads = (*inner, Load("n0", moment=-end), Load(f"n{ELEMENTS}", moment=end))
    scenario = FrameStatic(
        "case 1",
        column(("pinned", "roller-y"), axial),
        loads,
        f"n{ELEMENTS // 2}",
        "x",
        (1.0,),
        control="load",
    )
    response = MODELS[model].simulate(scenario)
    assert response.attrs["outcome"] == "ok", response.attrs["message"]
    u = sqrt(axial * LENGTH**2 / (4.0 * STIFFNESS))
    deflection = 5.0 * UNIFORM * LENGTH**4 / (384.0 * STIFFNESS)
    moment = UNIFORM * LENGTH**2 / 8.0
    if axial:
        deflection *= 12.0 * (2.0 / cos(u) - u**2 - 2.0) / (5.0 * u**4)
        moment *= 2.0 * (1.0 / cos(u) - 1.0) / u**2
    assert float(response["displacement"][-1]) == pytest.approx(deflection, rel=5e-3)
    result = response["moment"].sel(hinge=f"m{ELEMENTS // 2}:start").values[-1]
    # nodal moments of a member under a uniform load, without those of the load itself
    assert abs(float(result)) - end == pytest.approx(moment, rel=5e-3)


@pytest.mark.thorough
@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("axial", [0.0, 445e3, 667e3, 890e3])
def test_case_2_cantilever(model, axial) -> None:
    """Tip deflection and base moment of a cantilever with a lateral load, sixteen members."""
    scenario = FrameStatic(
        "case 2",
        column(("clamped", "free"), axial),
        (Load(f"n{ELEMENTS}", x=TIP),),
        f"n{ELEMENTS}",
        "x",
        (1.0,),
        control="load",
    )
    response = MODELS[model].simulate(scenario)
    assert response.attrs["outcome"] == "ok", response.attrs["message"]
    a = sqrt(axial * LENGTH**2 / STIFFNESS)
    deflection, moment = TIP * LENGTH**3 / (3.0 * STIFFNESS), TIP * LENGTH
    if axial:
        deflection *= 3.0 * (tan(a) - a) / a**3
        moment *= tan(a) / a
    assert float(response["displacement"][-1]) == pytest.approx(deflection, rel=5e-3)
    result = response["moment"].sel(hinge="m0:start").values[-1]
    assert abs(float(result)) == pytest.approx(moment, rel=5e-3)
