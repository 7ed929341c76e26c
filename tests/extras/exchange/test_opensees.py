"""OpenSees as a model and as a script: against fiber beams, its typed failures, what it refuses."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from dataclasses import replace
from importlib.util import find_spec
from math import pi

import numpy as np
import pytest

from workbench.base.errors import InputError
from workbench.extras.exchange.opensees import model as opensees
from workbench.extras.exchange.opensees.deck import FORMS
from workbench.extras.exchange.opensees.model import OpenSees
from workbench.extras.exchange.opensees.script import script_of, write_script
from workbench.models.base import make_model
from workbench.responses import findings_of, outcome_of
from workbench.responses.uncertainty import uncertainty_of
from workbench.scenarios import (
    Column,
    ColumnImpact,
    ColumnPushover,
    Frame,
    FrameImpact,
    FrameStriker,
    Joint,
    Striker,
    regular_frame,
)
from workbench.steel.sections import find
from workbench.testing import check_model

installed = pytest.mark.skipif(
    find_spec(opensees.PACKAGE) is None,
    reason="OpenSeesPy is not installed: pip install 'steel-impact-workbench[opensees]'",
)
COLUMN = Column(find("HEB 220"), 0.8, 3.2, fillets=False, axial_load=5e5, restraint_stiffness=1e7)
HIT = ColumnImpact("hit", COLUMN, Striker(1500.0, 10.0), 0.04)
OBLIQUE = replace(HIT, striker=replace(HIT.striker, angle=pi / 6.0))


def frame(joint: Joint | str = "rigid") -> FrameImpact:
    whole: Frame = regular_frame([5.0], [3.5], "HEB 200", "IPE 270", beam_joint=joint)
    struck = whole.split("A0-A1", 1.0, "hit")
    return FrameImpact("frame", struck, FrameStriker(800.0, 6.0, node="hit"), 0.06)


SEMI_RIGID = Joint("semi-rigid", rotational_stiffness=1e7, plastic_moment=6e4)


def peak(model, scenario) -> float:
    response = model.simulate(scenario)
    assert outcome_of(response).value == "ok", response.attrs["message"]
    return float(response["peak_displacement"])


@installed
@pytest.mark.thorough
@pytest.mark.parametrize("element", FORMS)
def test_every_form_is_near_fiber_beams(element) -> None:
    """Without elastic shear, as displacement-based elements are; hinges have half the mass."""
    if element == "displacement-based":
        other = make_model("fiber-corotational", {"levels": 1, "shear_flexible": False})
        near = 0.004
    else:
        other, near = make_model("fiber-reissner", {"levels": 1}), 0.05
    assert peak(OpenSees(element, levels=1), HIT) == pytest.approx(peak(other, HIT), rel=near)


@installed
@pytest.mark.thorough
def test_agreement_within_both_stated_uncertainties() -> None:
    ours, theirs = make_model("fiber-reissner").simulate(HIT), OpenSees().simulate(HIT)
    widths = [uncertainty_of(each, "peak_displacement") for each in (ours, theirs)]
    assert None not in widths
    away = abs(float(ours["peak_displacement"] - theirs["peak_displacement"]))
    assert away <= sum(widths)
    assert sum(widths) < 0.1 * float(ours["peak_displacement"])


@installed
@pytest.mark.thorough
def test_forces_and_contact_are_those_of_fiber_beams() -> None:
    ours = make_model("fiber-corotational", {"levels": 1}).simulate(HIT)
    theirs = OpenSees(levels=1).simulate(HIT)
    assert float(theirs["impulse"]) == pytest.approx(float(ours["impulse"]), rel=0.05)
    moments = [each["moment"].sel(hinge=["base", "head"]) for each in (ours, theirs)]
    first, second = (each.interp(time=np.linspace(0.005, 0.015, 11)).values for each in moments)
    assert np.abs(first - second).max() < 0.15 * np.abs(first).max()


@installed
@pytest.mark.thorough
@pytest.mark.parametrize("restitution", [0.2, 0.6])
def test_a_striker_that_rebounds(restitution) -> None:
    hit = replace(HIT, striker=Striker(400.0, 12.0, restitution=restitution))
    fibers = make_model("fiber-corotational", {"levels": 1})
    finer = OpenSees(levels=1, refinement=1)  # the masses of nodes count against a light striker
    assert peak(finer, hit) == pytest.approx(peak(fibers, hit), rel=0.04)


@pytest.mark.claim("model:opensees", "oblique peak over fiber-space", "independent code", 1, 0.02)
@installed
@pytest.mark.thorough
def test_a_hit_off_the_plane(claim) -> None:
    fibers = make_model("fiber-space", {"levels": 1})
    element = {"element": "displacement-based", "refinement": -1}
    theirs = OpenSees(**element, levels=1)
    claim(peak(theirs, OBLIQUE) / peak(fibers, OBLIQUE))


@pytest.mark.claim("model:opensees", "peak of a frame, ratio", "independent code", 1, 0.03)
@installed
@pytest.mark.thorough
@pytest.mark.parametrize("joint", ["rigid", "pinned", SEMI_RIGID], ids=["rigid", "pinned", "semi"])
def test_frames_with_their_joints(joint, claim) -> None:
    fibers = make_model("fiber-corotational", {"levels": 1, "refinement": 0})
    claim(peak(OpenSees(levels=1), frame(joint)) / peak(fibers, frame(joint)))


@installed
def test_a_false_path_is_no_answer() -> None:
    """Hinges without hardening lose their element its strength; nothing else tells."""
    hard = OpenSees("hinges", hardening_ratio=1e-5, levels=1)
    response = hard.simulate(HIT.at_velocity(20.0))
    assert outcome_of(response).value == "not-converged"
    assert "sections have taken other work" in response.attrs["message"]


@installed
@pytest.mark.thorough
def test_a_collapse_is_an_answer() -> None:
    pressed = replace(COLUMN, axial_load=1.5e6, restraint_stiffness=0.0)
    hit = ColumnImpact("pressed", pressed, Striker(3000.0, 20.0), 0.2)
    assert outcome_of(OpenSees("hinges", levels=1).simulate(hit)).value == "collapse"


@installed
@pytest.mark.thorough
def test_the_contract_of_models() -> None:
    check_model(OpenSees(levels=1), [HIT], energy_tolerance=0.02)


@installed
@pytest.mark.thorough
@pytest.mark.parametrize(
    "scenario", [HIT, OBLIQUE, frame("pinned")], ids=["column", "off", "frame"]
)
def test_a_script_is_the_model(scenario, tmp_path) -> None:
    model, path = OpenSees(levels=1), tmp_path / "my column.py"
    then, _ = write_script(scenario, path, levels=1)
    assert then.endswith("run python my column.py")
    command = [sys.executable, path.name, "history.csv"]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    told = float(re.search(r"peak displacement (\S+) m", run.stdout).group(1))
    assert told == pytest.approx(peak(model, scenario), rel=1e-4)
    history = np.loadtxt(tmp_path / "history.csv", delimiter=",", skiprows=1)
    response = model.simulate(scenario)
    assert history[:, 1] == pytest.approx(response["displacement"].values, abs=1e-12)


def test_a_script_needs_no_workbench() -> None:
    text, warned = script_of(HIT, OpenSees())
    assert [each.subject for each in warned] == ["shear"]
    compile(text, "column.py", "exec")
    assert set(re.findall(r"^(?:import|from) (\w+)", text, re.M)) <= {
        *("sys", "openseespy", "collections", "math", "typing")
    }
    masses = [line for line in text.splitlines() if line.startswith("ops.mass(")]
    told = sum(float(line.split(",")[1]) for line in masses)
    assert told == pytest.approx(COLUMN.properties.mass_per_length * COLUMN.length)
    areas = [float(a) for a in re.findall(r"^ops\.fiber\(\S+, 0\.0, (\S+), 1\)", text, re.M)]
    assert sum(areas) == pytest.approx(2 * COLUMN.strength_section.area, rel=1e-9)  # two members


def test_a_name_is_no_code() -> None:
    hostile = '"""\'\'\'); import os; os.system("rm x") #'
    text, _ = script_of(replace(HIT, name=hostile), OpenSees(), "x.py")
    imports = [each for each in ast.walk(ast.parse(text)) if isinstance(each, ast.Import)]
    assert {name.name for each in imports for name in each.names} == {
        "sys",
        "openseespy.opensees",
    }


def test_scenarios_that_it_is_not_told() -> None:
    crushing = replace(HIT, striker=Striker(1500.0, 10.0, stiffness=1e6))
    for scenario in (crushing, ColumnPushover("push", COLUMN, 0.05)):
        assert outcome_of(OpenSees().simulate(scenario)).value == "out-of-domain"
        with pytest.raises(InputError):
            script_of(scenario, OpenSees())
    ends = replace(COLUMN, base_weak="pinned")
    with pytest.raises(InputError, match="ends that differ about the two axes"):
        script_of(replace(OBLIQUE, column=ends), OpenSees())


@pytest.mark.parametrize("element", FORMS)
@pytest.mark.parametrize("bays", [1, 3])
def test_tags_are_given_once(element, bays) -> None:
    """Also where members are many and elements few."""
    whole = regular_frame(
        [12.0] * bays, [3.5, 3.5], "HEB 200", "IPE 270", beam_joint=SEMI_RIGID
    ).split("A0-A1", 1.0, "hit")
    nodes = tuple(
        replace(node, spring_x=1e6) if node.support == "free" else node for node in whole.nodes
    )
    scenario = FrameImpact("f", replace(whole, nodes=nodes), FrameStriker(8e2, 6.0, node="hit"))
    _, deck, _, _ = OpenSees(element).deck(scenario)
    commands = [each for part in (*deck.standing, *deck.after) for each in part.commands]
    for kind, place in (("uniaxialMaterial", 2), ("element", 2), ("node", 1), ("section", 2)):
        tags = [each[place] for each in commands if each[0] == kind]
        assert len(set(tags)) == len(tags), kind
    members = [each for each in commands if each[0] == "element" and "Beam" in each[1]]
    assert element != "hinges" or len(members) == len(whole.members)


@installed
@pytest.mark.thorough
def test_a_frame_in_space_is_drawn_where_it_stands() -> None:
    whole = regular_frame([5.0], [3.5], "HEB 200", "IPE 270", depths=[5.0])
    struck = whole.split("Aa0-Aa1", 1.0, "hit")
    striker = FrameStriker(800.0, 6.0, node="hit", angle=pi / 6.0)
    scenario = FrameImpact("space", struck, striker, 0.02)
    response = OpenSees("hinges", levels=1).simulate(scenario)
    rest = [response[f"shape_{axis}"].isel(snapshot=0).values for axis in "xyz"]
    places = struck.places
    for values, known in zip(rest, places.T, strict=True):
        assert (values.min(), values.max()) == pytest.approx((known.min(), known.max()), abs=1e-3)
    other = make_model("superelement-space", {}).simulate(scenario)
    assert float(response["displacement"].max()) == pytest.approx(
        float(other["displacement"].max()), rel=0.1
    )


@installed
def test_a_light_striker_is_warned_of() -> None:
    light = replace(HIT, striker=Striker(20.0, 30.0), duration=0.01)
    response = OpenSees(levels=1).simulate(light)
    told = [each.text for each in findings_of(response)]
    assert any("the collision takes" in text for text in told), told


@pytest.mark.parametrize(
    ("element", "option"),
    [
        ("hinges", {"points": 5}),
        ("force-based", {"hinge_length": 0.5}),
        ("hinges", {"smallest_element": 0.1}),
    ],
)
def test_options_of_other_elements_are_refused(element, option) -> None:
    with pytest.raises(InputError, match="is an option of element = "):
        OpenSees(element, **option)


def test_without_the_program(monkeypatch) -> None:
    monkeypatch.setattr(opensees, "find_spec", lambda _name: None)
    response = OpenSees().simulate(HIT)
    assert outcome_of(response).value == "out-of-domain"
    (refusal,) = [each for each in findings_of(response) if each.refusal]
    assert "pip install openseespy" in str(refusal)
    script_of(HIT, OpenSees())  # takes no program
