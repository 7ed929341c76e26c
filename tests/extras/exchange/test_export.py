"""`workbench export`: decks hold column, supports and load; what they cannot carry is refused."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from workbench.api.answers import simulate
from workbench.cli import run
from workbench.extras.exchange.deck import DeckChoices, MoreNodes, deck_text, flight
from workbench.extras.exchange.meshes import MESHES, DeckMesh
from workbench.extras.exchange.vtk import write_shapes
from workbench.scenarios import Column, ColumnImpact, ColumnPushover, Striker, to_toml
from workbench.steel.materials import Steel
from workbench.steel.sections import circular_tube, find, rectangular_tube

THESIS = Column(find("HEB 220"), 0.8, 3.2, fillets=False, axial_load=0.5e6, restraint_stiffness=1e7)
HIT = ColumnImpact("hit", THESIS, Striker(1500.0, 15.0), 0.05)
SOLID = ("bricks", "shells")


def cards(text: str) -> list[tuple[str, list[list[float]]]]:
    """Keyword lines of a deck with the numbers below them."""
    blocks: list[tuple[str, list[list[float]]]] = []
    for line in re.sub(r",\n(?=[^*])", ", ", text).splitlines():
        if line.startswith("**") or not line:
            continue
        if line.startswith("*"):
            blocks.append((line, []))
        else:
            words = [word for word in line.split(",") if word.strip()]
            if not any(re.search(r"[A-Za-df-z]", word) for word in words):
                blocks[-1][1].append([float(word) for word in words])
    return blocks


def below(text: str, keyword: str) -> list[list[float]]:
    """Numbers below all cards that begin so."""
    return [row for head, rows in cards(text) if head.startswith(keyword) for row in rows]


def written(
    scenario: ColumnImpact = HIT, mesh: str = "plane-stress", **options: object
) -> tuple[DeckMesh, str]:
    choices = DeckChoices(mesh=mesh, **options)  # type: ignore[arg-type]
    choices.check_scenario(scenario)
    places = MESHES[mesh](scenario.column, choices.refinement)
    return places, deck_text(scenario, places, choices)


@pytest.mark.parametrize("refinement", [-1, 0, 1])
@pytest.mark.parametrize(("mesh", "away"), [("plane-stress", 0), ("bricks", 0), ("shells", 0.023)])
def test_a_mesh_has_area_and_second_moments_of_the_section(mesh, away, refinement) -> None:
    """Shells have no thickness along the height, so that flanges lack their own second moment."""
    places, section = MESHES[mesh](THESIS, refinement), THESIS.strength_section
    areas, (x, y) = places.areas(0.8), places.section.T
    assert areas.sum() == pytest.approx(section.area, rel=1e-9)
    assert areas @ x == pytest.approx(0.0, abs=1e-12)
    assert areas @ x**2 == pytest.approx(section.second_moment, rel=1e-9 + 0.2 * away)
    if mesh in SOLID:
        second = section.about("weak").second_moment
        assert areas @ y**2 == pytest.approx(second, rel=1e-9 + away)


@pytest.mark.parametrize("mesh", MESHES)
def test_a_deck_has_the_mass_of_the_rolled_column(mesh: str) -> None:
    """Volume by the elements that the text lists, times its density."""
    _, text = written(mesh=mesh)
    place = {int(n): np.array(at) for n, *at in below(text, "*NODE, NSET=ALL")}
    volume, size = 0.0, 8 if mesh == "bricks" else 4
    sections = [rows for head, rows in cards(text) if " SECTION" in head]
    elements = [rows for head, rows in cards(text) if "ELSET=PLATE" in head and "TYPE=" in head]
    for nodes, thickness in zip(elements, sections, strict=True):
        for _, *numbers in nodes:
            sides = np.ptp([place[int(number)] for number in numbers[:size]], axis=0)
            across = thickness[0][0] if thickness else 1.0
            volume += across * np.prod(sides[sides > 0.0])
    mass = volume * below(text, "*DENSITY")[0][0]
    assert mass == pytest.approx(THESIS.properties.mass_per_length * 4.0, rel=1e-6)
    numbers = [int(row[0]) for rows in elements for row in rows]
    assert numbers == list(range(1, len(numbers) + 1))


@pytest.mark.parametrize(("mesh", "last"), [("plane-stress", 2), ("bricks", 3), ("shells", 6)])
def test_ends_are_held_and_the_struck_section_goes_with_its_node(mesh: str, last: int) -> None:
    places, text = written(mesh=mesh)
    more, held = MoreNodes.after(places), {tuple(row) for row in below(text, "*BOUNDARY")}
    assert {(node, 1, last) for node in places.at(0.0)} < held
    assert {(node, 1, 1) for node in places.at(4.0)} < held
    assert ((places.at(4.0)[0], 3, last) in held) == (last > 2)
    tied = [tuple(row) for row in below(text, "*EQUATION") if len(row) > 1]
    assert {(n, 2, 1, more.head, 2, -1) for n in places.at(4.0)} < set(tied)
    assert {(n, 1, 1, more.face, 1, -1) for n in places.at(0.8)} < set(tied)
    assert len(tied) == len(places.at(4.0)) + len(places.at(0.8))


def test_load_spring_and_striker_are_those_of_the_scenario() -> None:
    places, text = written()
    more, rise = MoreNodes.after(places), flight(THESIS)
    axial = THESIS.strength_section.area * 210e9 / 4.0
    (load,) = below(text, "*CLOAD")
    assert load[:2] == [more.head, 2]
    # the column and its spring shorten together, the column under the axial load
    assert load[2] == pytest.approx(-0.5e6 - 1e7 * 0.5e6 / axial)
    assert below(text, "*SPRING, ELSET=HEAD") == [[2.0], [1e7]]
    assert below(text, "*INITIAL") == [[more.striker, 1, 15.0]]
    assert below(text, "*MASS") == [[1500.0]]
    law = np.array(below(text, "*SPRING, ELSET=CONTACT"))
    assert law[1:, 0].tolist() == [0.0, 0.0]
    assert law[1:, 1] == pytest.approx([-15.0 * rise, 10.0])
    stiffness = law[0, 0] / (law[0, 1] - law[1, 1])
    assert stiffness == pytest.approx(5e9)
    place = {int(n): at for n, *at in below(text, "*NODE, NSET=ALL")}
    assert place[more.striker][0] < -15.0 * (rise + 0.05)  # the spring never turns over
    assert below(text, "*DYNAMIC")[0][1] == pytest.approx(rise + 0.05)
    assert below(text, "*PLASTIC") == [[355e6, 0.0], [355e6, 1.0]]


def test_a_fixed_head_hardening_masses_and_a_crush_law() -> None:
    steel = Steel(yield_stress=300e6, hardening_modulus=2.1e9)
    column = THESIS.changed(head="fixed", steel=steel, head_mass=200.0, impact_mass=500.0)
    striker = Striker(1500.0, 10.0, crush=((0.0, 0.0), (0.1, 2e5), (0.2, 3e5)))
    places, text = written(ColumnImpact("hit", column, striker, 0.02))
    more, head = MoreNodes.after(places), THESIS.strength_section.area * 210e9 / 4.0
    (held,) = [row for row in below(text, "*BOUNDARY, AMPLITUDE") if len(row) == 4]
    assert held == pytest.approx([more.head, 2, 2, -0.5e6 / head])
    assert "*CLOAD" not in text
    assert "ELSET=HEAD" not in text
    assert below(text, "*MASS") == [[1500.0], [200.0], [pytest.approx(column.attached_mass)]]
    assert below(text, "*PLASTIC") == [[300e6, 0.0], [2.4e9, 1.0]]
    law = np.array(below(text, "*SPRING, ELSET=CONTACT"))
    assert law[:, 0].tolist() == [-3e5, -2e5, 0.0, 0.0]
    assert np.diff(law[:3, 1]) == pytest.approx([0.1, 0.1])


@pytest.mark.parametrize("mesh", SOLID)
@pytest.mark.parametrize(
    ("angle", "eccentricity", "column"),
    [
        (0.0, 0.05, THESIS),
        (0.5, 0.0, THESIS),
        (0.5 * np.pi, 0.0, THESIS),
        (0.0, 0.0, THESIS.changed(fillets=True)),
    ],
)
def test_a_face_presses_on_the_middle_planes(angle, eccentricity, column, mesh) -> None:
    """Shares along the hit sum to 1, and the force acts at its eccentricity."""
    striker = Striker(1500.0, 10.0, angle=angle, eccentricity=eccentricity)
    places, text = written(ColumnImpact("hit", column, striker, 0.02), mesh, struck="face")
    (terms,) = [row for row in below(text, "*EQUATION") if row[:2] == [row[0], 1] and row[2] == -1]
    assert terms[0] == MoreNodes.after(places).face
    node, dof, share = np.reshape(terms[3:], (-1, 3)).T
    force = np.array([share[dof == 1].sum(), -share[dof == 3].sum()])
    assert force == pytest.approx([np.cos(angle), np.sin(angle)], abs=1e-9)
    height, width = places.section[node.astype(int) - 1].T
    lever = share[dof == 1] @ width[dof == 1] + share[dof == 3] @ height[dof == 3]
    assert lever == pytest.approx(eccentricity, abs=1e-9)


@pytest.mark.parametrize("section", [circular_tube(0.2, 0.01), find("IPE 300").about("weak")])
def test_layers_in_plane_stress_hold_any_section(section) -> None:
    places = MESHES["plane-stress"](Column(section, 1.0, 2.0), 0)
    assert places.areas(1.0).sum() == pytest.approx(section.area, rel=1e-6)


def test_a_tube_is_folded_of_shells() -> None:
    section = rectangular_tube(0.25, 0.15, 0.01)
    places = MESHES["shells"](Column(section, 1.0, 2.0), 0)
    assert places.areas(1.0).sum() == pytest.approx(section.area, rel=1e-9)
    assert len(np.unique(places.section, axis=0)) == len(places.at(1.0))


@pytest.mark.parametrize(
    ("settings", "options", "words"),
    [
        (["column.base=pinned"], [], "column.base"),
        (["column.head=pinned"], [], "column.head"),
        (["column.head_weak=pinned"], [], "column.head"),
        (["steel.rate=S355"], [], "CalculiX has no such law of strain rate"),
        (["striker.direction=down"], [], "--set gravity=false"),
        (["striker.restitution=0.2"], [], "striker.restitution = 0.2: must be 0 in a deck"),
        (["striker.friction=0.3"], [], "striker.friction"),
        (["striker.angle=0.5"], [], "striker.angle = 0.5: must be 0 in plane stress"),
        (["striker.eccentricity=0.05"], [], "where the struck section moves as one"),
        ([], ["struck=face"], "option.struck = 'face': must be section in plane stress"),
        ([], ["steps=1e-4"], "did you mean step?"),
        ([], ["step=1.0"], "option.step = 1.0"),
        ([], ["refinement=9"], "option.refinement"),
        (["column.section=CHS 219.1x10"], ["mesh=bricks"], "must be an I section for this mesh"),
        (["striker.eccentricity=2.0"], ["mesh=bricks", "struck=face"], "misses the column"),
    ],
)
def test_a_deck_refuses_what_it_cannot_carry(settings, options, words, tmp_path, capsys) -> None:
    file, out = tmp_path / "hit.toml", tmp_path / "hit.inp"
    file.write_text(to_toml(HIT), encoding="utf-8")
    given = [f"--set={each}" for each in settings] + [f"--option={each}" for each in options]
    assert run(["export", str(file), "--to", "calculix", "--out", str(out), *given]) == 2
    message = capsys.readouterr().err
    assert words in message
    assert message.count("\n") == 1
    assert not out.exists()


def test_the_verb_writes_a_deck_and_says_how_to_run_it(tmp_path, capsys, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("hit.toml").write_text(to_toml(HIT), encoding="utf-8")
    arguments = ["export", "hit.toml", "--mesh", "shells", "--set", "steel.rate=S355", "--json"]
    assert run([*arguments, "--to", "abaqus"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["file"] == "hit-abaqus.inp"
    assert told["then"] == "384 elements S8R; run abaqus job=hit-abaqus"
    assert told["warnings"] == []
    text = Path("hit-abaqus.inp").read_text(encoding="utf-8")
    assert below(text, "*RATE DEPENDENT") == [[500.0, 5.0]]
    assert "*CONTROLS" not in text
    assert "ELSET=CONTACT, NONLINEAR\n\n" in text  # a spring without a dof begins with no line
    given = ["--set", "column.area=91e-4", "--out", "other.inp"]
    assert run(["export", "hit.toml", "--to", "calculix", *given]) == 0
    output = capsys.readouterr().out
    assert "192 elements CPS8R; run ccx -i other" in output
    assert "area = 0.0091 against 0.008826" in " ".join(output.split())
    assert "*CONTROLS" in Path("other.inp").read_text(encoding="utf-8")


def test_a_name_cannot_be_a_keyword() -> None:
    _, text = written(HIT.changed(name="*STEP"))
    assert [head for head, _ in cards(text) if head.startswith("*STEP")] == [
        "*STEP, NLGEOM, INC=1000000"
    ]


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (["--to", "nastran"], "--to = 'nastran': must be one of"),
        (["--to", "vtu", "--mesh", "bricks"], "--mesh = 'bricks': is for decks, not for vtu"),
        (
            ["--to", "calculix", "--option", "program=abaqus"],
            "--option program = 'abaqus': is said already; leave it out: --to and --mesh say it",
        ),
        (
            ["--to", "abaqus", "--mesh", "shells", "--option", "mesh=bricks"],
            "--option mesh = 'bricks': is said already",
        ),
        (["--to", "vtu", "--out", "hit.inp"], "must end in pvd"),
        (["--to", "calculix", "--out", "hit.toml"], "is a file that is read here"),
        (["--to", "calculix", "--out", "nowhere/hit.inp"], "there is no directory"),
        (["--to", "calculix"], "kind = 'column-pushover': must be column-impact"),
    ],
)
def test_the_verb_refuses_in_one_line(given, words, tmp_path, capsys, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    push = ColumnPushover("push", THESIS, 0.1)
    Path("hit.toml").write_text(to_toml(push), encoding="utf-8")
    assert run(["export", "hit.toml", *given]) == 2
    message = capsys.readouterr().err
    assert words in message
    assert message.count("\n") == 1
    assert [each.name for each in tmp_path.iterdir()] == ["hit.toml"]


@pytest.mark.thorough
def test_vtu_holds_the_answer_of_the_model_of_the_advice(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    Path("hit.toml").write_text(to_toml(HIT), encoding="utf-8")
    assert run(["export", "hit.toml", "--to", "vtu"]) == 0
    assert "open it in ParaView" in capsys.readouterr().out
    write_shapes(Path("same.pvd"), HIT, simulate(HIT))
    shapes = [sorted(Path(name).glob("*.vtu")) for name in ("hit-vtu", "same")]
    assert len(shapes[0]) > 10
    for one, other in zip(*shapes, strict=True):
        assert one.read_bytes() == other.read_bytes()
