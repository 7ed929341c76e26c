"""A struck column of an I section as bricks of CalculiX: its deck, its run, what it printed.

Three plates without fillets of quadratic bricks with reduced integration (C3D20R). Ends are
clamped; the head moves along the column against its spring, which is unstressed under the axial
load. That load grows, over a period of the column along its axis, while the striker flies: so the
column is nearly at rest when it is hit. The striker, a mass on a line along the hit, presses
through a spring without tension on the mean of a face in the middle planes of the plates, that of
`shell`. Von Mises plasticity, large displacements, implicit steps of Hilber, Hughes and Taylor with
the damping that the program takes by itself (alpha = -0.05).

Pitfalls of version 2.20: C3D8I diverges in plastic steps; an initial stress counts twice in an
elastic-plastic brick; a static step before the hit stops the striker; a first number without a
point below *SPRING is read as a dof; steps of more than 0.2 ms diverge at the struck edge.
"""

from __future__ import annotations

import re
import subprocess
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np

from workbench.mechanics.structures.assembly import graded_lengths
from workbench.models.references.shell.mesh import face_of, target_of, walls_of
from workbench.scenarios import ColumnImpact
from workbench.steel.materials import POISSON_RATIO

FACE = (0.12, 0.12)  # m, across and along the column, as of `shell`
ROUND = ((-1, -1), (1, -1), (1, 1), (-1, 1))  # corners of a brick across the column
SIDES = ((0, -1), (1, 0), (0, 1), (-1, 0))
CORNERS = [(*at, z) for z in (-1, 1) for at in ROUND]
MIDDLES = [(*at, z) for z in (-1, 1) for at in SIDES] + [(*at, 0) for at in ROUND]
OF_CORNER, OF_SIDE = -1.0 / 12.0, 1.0 / 3.0  # share of a node in the mean over a face of a brick


class Bricks(NamedTuple):
    """Places (nodes, 3) in m, which of them are in middle planes, nodes (bricks, 20).

    `section` and `along` as of a mesh of shells.
    """

    place: np.ndarray
    middle: np.ndarray
    nodes: np.ndarray

    @property
    def section(self) -> np.ndarray:
        """Places (nodes, 2) across the column."""
        return self.place[:, :2]

    @property
    def along(self) -> np.ndarray:
        """Places (nodes,) along the column."""
        return self.place[:, 2]

    def weights(self, level: float) -> np.ndarray:
        """Shares (nodes,) in the mean displacement of the section at a level (m)."""
        weights = np.zeros(len(self.place))
        for brick in self.nodes[np.isclose(self.along[self.nodes[:, 0]], level)]:
            area = np.prod(np.ptp(self.section[brick[:4]], axis=0))
            weights[brick[:4]] += OF_CORNER * area
            weights[brick[8:12]] += OF_SIDE * area
        return weights / weights.sum()


def bricks(scenario: ColumnImpact, refinement: int, least: float, layers: int = 1) -> Bricks:
    """Bricks of a column.

    Arguments: `refinement`, so that across the plates two shells of it are one brick; `least`
    length of a brick along the column in m, at ends and struck section; `layers`, bricks through
    the thickness of a plate, 1 or 2.
    """
    column = scenario.column
    section = column.strength_section.about("strong")
    shape, walls = section.shape, walls_of(section, refinement - 1)
    high, wide, thin = 0.5 * shape.height, 0.5 * shape.width, 0.5 * shape.web
    inner, plane = high - shape.flange, high - 0.5 * shape.flange
    beside = halved(np.linspace(thin, wide, walls[0].elements // 2 + 1))
    web, flange = (
        halved(np.linspace(*faces, layers + 1)) for faces in ((-thin, thin), (inner, high))
    )
    across = np.concatenate([-beside[:0:-1], web, beside[1:]])
    plates = [(-flange[::-1], across), (flange, across)]
    plates.append((halved(np.linspace(-inner, inner, walls[2].elements + 1)), web))
    parts = (column.length_below, column.length_above)
    lengths = np.concatenate([graded_lengths(part, least, 2.0 * least, 1.2) for part in parts])
    z = halved(np.append(0.0, np.cumsum(lengths)))
    numbers: dict[tuple[float, ...], int] = {}
    nodes = []
    for x, y in plates:
        for i, j, k in product(*(range(1, len(places), 2) for places in (x, y, z))):
            around = [(x[i + a], y[j + b], z[k + c]) for a, b, c in CORNERS + MIDDLES]
            keys = [tuple(np.round(at, 9).tolist()) for at in around]
            nodes.append([numbers.setdefault(key, len(numbers)) for key in keys])
    place, table = np.array(list(numbers)), np.array(nodes)
    middle = np.isclose(np.abs(place[:, 0]), plane)
    middle |= (np.abs(place[:, 0]) < inner) & (place[:, 1] == 0.0)
    if layers == 2:  # without those in the middle of sides
        middle &= np.isin(np.arange(len(place)), table[:, :8])
    return Bricks(place, middle, table)


def halved(places: np.ndarray) -> np.ndarray:
    """Places with the middles between them."""
    return np.interp(np.arange(2 * len(places) - 1) / 2.0, np.arange(len(places)), places)


def flight(scenario: ColumnImpact) -> float:
    """Time in s before the hit: a period of the column along its axis."""
    column = scenario.column
    stiffness = column.strength_section.area * column.steel.elastic_modulus
    return 4.0 * column.length * np.sqrt(column.properties.mass_per_length / stiffness)


def deck(scenario: ColumnImpact, mesh: Bricks, step: float) -> str:
    """Input of CalculiX for a striker with a `stiffness`; longest `step` in s."""
    column, striker, steel = scenario.column, scenario.striker, scenario.column.steel
    assert (column.base, column.head, steel.rate) == ("clamped", "guided", None)
    section, angle, along = (
        column.strength_section.about("strong"),
        scenario.angle_from_height,
        mesh.along,
    )
    head, face, hitting = (len(mesh.place) + number for number in (1, 2, 3))
    seen = np.flatnonzero(mesh.middle)
    target = target_of(section, angle, striker.eccentricity)
    planes = Bricks(mesh.place[seen], mesh.middle[seen], mesh.nodes)
    pressed, shares = face_of(planes, column.length_below, FACE, target)
    mean = [
        (seen[node] + 1, dof, cosine * share)
        for node, share in zip(pressed, shares, strict=True)
        for dof, cosine in ((1, np.cos(angle)), (2, np.sin(angle)))
        if abs(cosine) > 1e-9
    ]
    base, top = (np.flatnonzero(along == end) + 1 for end in (0.0, along.max()))
    struck = np.flatnonzero(mesh.weights(column.length_below)) + 1
    rise, last = flight(scenario), len(mesh.nodes)
    away = striker.velocity * rise
    stretch = column.length / (section.area * steel.elastic_modulus)
    load = column.axial_load * (1.0 + column.restraint_stiffness * stretch)
    hardening = steel.hardening_modulus or 0.0
    lines = [
        "*NODE, NSET=ALL",
        *(f"{n}, {x:.9f}, {y:.9f}, {z:.9f}" for n, (x, y, z) in enumerate(mesh.place, 1)),
        f"{head}, 0., 0., {column.length + 1.0}\n{face}, 0., 0., -1.\n{hitting}, -1., 0., -1.",
        "*ELEMENT, TYPE=C3D20R, ELSET=STEEL",
    ]
    for number, brick in enumerate(mesh.nodes + 1, 1):
        lines += [", ".join(map(str, [number, *brick[:10]])) + ",", ", ".join(map(str, brick[10:]))]
    lines += [
        f"*ELEMENT, TYPE=SPRING1, ELSET=HEAD\n{last + 1}, {head}",
        f"*ELEMENT, TYPE=SPRINGA, ELSET=CONTACT\n{last + 2}, {hitting}, {face}",
        f"*ELEMENT, TYPE=MASS, ELSET=STRIKER\n{last + 3}, {hitting}",
        f"*SPRING, ELSET=HEAD\n3\n{column.restraint_stiffness:.9e}",
        "*SPRING, ELSET=CONTACT, NONLINEAR",
        f"{-striker.stiffness:.9e}, {-away - 1.0:.9e}\n0., {-away:.9e}\n0., 10.",
        f"*MASS, ELSET=STRIKER\n{striker.mass:.9e}",
        f"*MATERIAL, NAME=STEEL\n*ELASTIC\n{steel.elastic_modulus:.9e}, {POISSON_RATIO}",
        f"*DENSITY\n{column.properties.mass_per_length / section.area:.9e}",
        f"*PLASTIC\n{steel.yield_stress:.9e}, 0.\n{steel.yield_stress + hardening:.9e}, 1.",
        "*SOLID SECTION, ELSET=STEEL, MATERIAL=STEEL",
        "*BOUNDARY",
        *(f"{node}, 1, 3" for node in base),
        *(f"{node}, 1, 2" for node in [*top, head]),
        *(f"{node}, 2, 3" for node in (face, hitting)),
        f"*INITIAL CONDITIONS, TYPE=VELOCITY\n{hitting}, 1, {striker.velocity:.9e}",
        f"*NSET, NSET=SEEN\n{face},\n{head},",
        *(f"{node}," for node in struck),
        *(equation([(node, 3, 1.0), (head, 3, -1.0)]) for node in top),
        equation([(face, 1, -1.0), *mean]),
        f"*AMPLITUDE, NAME=RISE\n0., 0., {rise:.9e}, 1., 1., 1.",
        "*STEP, NLGEOM, INC=100000\n*DYNAMIC",
        f"{step:.9e}, {rise + scenario.duration:.9e}, 1e-9, {step:.9e}",
        "*CONTROLS, PARAMETERS=TIME INCREMENTATION\n5, 8, 9, 16, 10, 5, , 9, ,",
        "0.6, 0.6, 0.75, 0.85, , , 1.25,",
        "*CONTROLS, PARAMETERS=FIELD\n0.05, 0.02",  # forces over their mean, which is small
        f"*CLOAD, AMPLITUDE=RISE\n{head}, 3, {-load:.9e}",
        "*NODE PRINT, NSET=SEEN\nU\n*EL PRINT, ELSET=STEEL, TOTALS=ONLY\nELSE, ELKE\n*END STEP\n",
    ]
    return "\n".join(lines)


def equation(terms: list[tuple[int, int, float]]) -> str:
    """Equation of dofs (node, number, factor), the first of which depends on the rest."""
    rows = (f"{node}, {dof}, {factor:.12e}" for node, dof, factor in terms)
    return "\n".join(["*EQUATION", str(len(terms)), *rows])


def run(text: str, program: str, folder: Path) -> str:
    """What CalculiX prints of the nodes that are seen; raises CalledProcessError."""
    (folder / "column.inp").write_text(text)
    command = [program, "-i", "column"]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return (folder / "column.dat").read_text()


def histories(scenario: ColumnImpact, mesh: Bricks, printed: str) -> np.ndarray:
    """Time from the hit on in s, displacement of face and axis along it in m: (3, steps)."""
    angle, rows = scenario.angle_from_height, []
    weights = mesh.weights(scenario.column.length_below)
    heading = r"displacements .* time +(\S+)\n\n((?: +\d+(?: +\S+){3}\n)+)"
    for time, table in re.findall(heading, printed):
        moved = {int(row.split()[0]): row.split()[1:] for row in table.splitlines()}
        face = float(moved[len(mesh.place) + 2][0])
        u = np.zeros((len(mesh.place), 2))
        for node in np.flatnonzero(weights):
            u[node] = [float(x) for x in moved[node + 1][:2]]
        axis = weights @ u @ [np.cos(angle), np.sin(angle)]
        rows.append((float(time) - flight(scenario), face, axis))
    return np.array(rows).T
