"""Plastic collapse load of a frame by the static theorem, as a linear programme.

Independent of the package's mechanics: unknowns are the end forces (N, M at start, M at end) of
every straight member and the load factor; equilibrium of the undeformed frame is an equality,
yielding an inequality. The largest factor is the collapse load (Livesley 1975, chapter 3).
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import linprog

from workbench.scenarios import Frame, FrameStatic


def collapse_factor(scenario: FrameStatic, interaction: bool = False) -> float:
    """Largest factor on the scenario's pattern that equilibrium and yielding allow.

    `interaction`: |M|/Mp + |N|/Np <= 1 at both ends of a member, else |M| <= Mp alone.
    """
    frame = scenario.frame
    free = _free(frame)
    members = len(frame.members)
    unknowns = 3 * members + 1
    equality = np.zeros((len(free), unknowns))
    for number, member in enumerate(frame.members):
        start, end = frame.node(member.start), frame.node(member.end)
        chord = np.array([end.x - start.x, end.y - start.y])
        length = float(np.hypot(*chord))
        c, s = chord / length
        # elongation and end rotations against the chord per unit of the six displacements
        rows = np.array(
            [
                [-c, -s, 0.0, c, s, 0.0],
                [-s / length, c / length, 1.0, s / length, -c / length, 0.0],
                [-s / length, c / length, 0.0, s / length, -c / length, 1.0],
            ]
        )
        dofs = [(name, i) for name in (member.start, member.end) for i in range(3)]
        for local, dof in enumerate(dofs):
            if dof in free:
                equality[free[dof], 3 * number : 3 * number + 3] += rows[:, local]
    for load in scenario.loads:
        for i, value in enumerate((load.x, load.y, load.moment)):
            if (load.node, i) in free:
                equality[free[load.node, i], -1] -= value
    inequality, bounds = _yielding(frame, unknowns, interaction)
    objective = np.zeros(unknowns)
    objective[-1] = -1.0
    # forces in units of the largest plastic moment keep the programme well scaled
    result = linprog(
        objective,
        A_ub=inequality,
        b_ub=bounds,
        A_eq=equality,
        b_eq=np.zeros(len(free)),
        bounds=[(None, None)] * unknowns,
        method="highs",
    )
    assert result.success, result.message
    return -float(result.fun)


def _free(frame: Frame) -> dict[tuple[str, int], int]:
    names = ("u", "v", "rotation")
    dofs = [(node.name, i) for node in frame.nodes for i in range(3) if names[i] not in node.held]
    return {dof: number for number, dof in enumerate(dofs)}


def _yielding(frame: Frame, unknowns: int, interaction: bool) -> tuple[np.ndarray, np.ndarray]:
    rows = []
    for number, member in enumerate(frame.members):
        properties = frame.properties(member.name)
        for end in (1, 2):
            for of_moment in (1.0, -1.0):
                for of_force in (1.0, -1.0) if interaction else (0.0,):
                    row = np.zeros(unknowns)
                    row[3 * number + end] = of_moment / properties.plastic_moment
                    row[3 * number] = of_force / properties.squash_load
                    rows.append(row)
    return np.array(rows), np.ones(len(rows))
