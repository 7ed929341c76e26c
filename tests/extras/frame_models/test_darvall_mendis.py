"""Portal frame of Darvall and Mendis (1985): load and deflection at the second hinge.

Clamped portal, 3.048 m square, load at 0.55 of the beam, E = 20.68 GPa, perfectly plastic hinges
of 158.18 kN m (columns) and 169.48 kN m (beam): second hinge at 11.4 mm and 427 kN.
"""

from __future__ import annotations

from math import sqrt

import numpy as np
import pytest

from workbench.extras.frame_models.hinged_frames import Giberson, PlasticHinge
from workbench.models.frame_model import FrameModel
from workbench.models.superelements import FlexibleSuperelement
from workbench.scenarios import Frame, FrameStatic, Load, Member, Node
from workbench.steel.materials import Steel
from workbench.steel.sections import section_from

MODELS = (
    FlexibleSuperelement(hinge_stiffness=1e4),
    Giberson(shear_flexible=False),
    PlasticHinge(shear_flexible=False),
)
SPAN, AREA, SECOND_MOMENT = 3.048, 0.103, 0.001
COLUMN, BEAM, LARGE = 158.18e3, 169.48e3, 1e9


def portal() -> FrameStatic:
    """The portal, pushed down at the load by 20 mm; axial force does not weaken the hinges."""
    height = sqrt(12.0 * SECOND_MOMENT / AREA)
    section = section_from({"width": AREA / height, "height": height}, "section")
    nodes = (
        Node("a", 0.0, 0.0, support="clamped"),
        Node("b", 0.0, SPAN),
        Node("load", 0.55 * SPAN, SPAN),
        Node("c", SPAN, SPAN),
        Node("d", SPAN, 0.0, support="clamped"),
    )

    def member(start: str, end: str, moment: float) -> Member:
        return Member(
            f"{start}-{end}", start, end, section, plastic_moment=moment, squash_load=LARGE
        )

    members = (
        member("a", "b", COLUMN),
        member("b", "load", BEAM),
        member("load", "c", BEAM),
        member("c", "d", COLUMN),
    )
    steel = Steel(elastic_modulus=20.68e9, yield_stress=1e7, density=2400.0)
    frame = Frame(nodes, members, steel=steel)
    load = (Load("load", y=-1e3),)
    return FrameStatic("Darvall-Mendis", frame, load, "load", "-y", (0.02,))


@pytest.mark.claim("model:{model.name}", "load at the second hinge, N", "darvall1985", 427e3, 640)
@pytest.mark.thorough
@pytest.mark.parametrize("model", MODELS)
def test_second_hinge(model: FrameModel, claim) -> None:
    """427 kN within 2 %; the deflection is 11.4 mm."""
    response = model.simulate(portal())
    assert response.attrs["outcome"] == "ok", response.attrs["message"]
    turned = np.abs(response["plastic_rotation"].values) > 1e-7  # (hinge, step)
    count = turned.sum(axis=0)
    # the two hinges on both sides of the load are one hinge of the beam
    hinges = list(response["hinge"].values)
    sides = [hinges.index("b-load:end"), hinges.index("load-c:start")]
    count = count - (turned[sides].sum(axis=0) > 1)
    second = int(np.argmax(count >= 2))
    assert count[second] >= 2
    claim(response["force"][second])
    # measured 0.0018, and 0.0053 where the axial force bends the members
    assert float(response["displacement"][second]) == pytest.approx(11.4e-3, rel=6e-3)
