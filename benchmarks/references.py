"""Cost of the references against OpenSeesPy, measured side by side in one run.

The frame of Heng 2017, section 5.3 (four bays, two storeys, squares of 0.2 m, 1500 kg at 50 m/s),
followed to its peak. First with the same elements, fibers and steps: compiled Reissner beam
against OpenSeesPy's displacement-based co-rotational element. Then, with --equal-error, with
meshes that come within 1.5 % of the extrapolated peak. Nothing here passes or fails.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from itertools import pairwise
from time import perf_counter

import numpy as np
from threadpoolctl import threadpool_limits

from workbench.mechanics.structures.assembly import PlanarAssembly, graded_lengths
from workbench.mechanics.structures.explicit import explicit_impact
from workbench.mechanics.structures.fibers import BeamSection
from workbench.mechanics.structures.fibers.section import (
    FiberBeams,
    LinearHardening,
    ReissnerBeams,
    radau_rule,
)
from workbench.mechanics.structures.impact import PointMass, impact

E, FY, SIDE, LAYERS, MASS, HARDENING = 210e9, 355e6, 0.2, 20, 314.0, 1e-6
Y = ((np.arange(LAYERS) + 0.5) / LAYERS - 0.5) * SIDE
AREA = np.full(LAYERS, SIDE**2 / LAYERS)
STRIKER = PointMass(1500.0, 50.0)
DURATION, EXTRAPOLATED, ALLOWED = 0.031, 0.495, 0.015
OURS = (
    ("balanced", 0.2, 0.2, 2e-4),
    ("balanced", 0.2, 0.2, 1e-4),
    ("reissner", 0.0125, 0.1, 1e-4),
)
ATTEMPTS = (
    (1, "Newton"),
    (4, "Newton"),
    (16, "Newton"),
    (16, "KrylovNewton"),
    (64, "Newton"),
    (256, "KrylovNewton"),
    (1024, "Newton"),
)
THEIRS = (
    ("OpenSeesPy", 0.05, 0.2, 1e-4),
    ("OpenSeesPy", 0.025, 0.2, 1e-4),
    ("OpenSeesPy", 0.025, 0.1, 5e-5),
)


class Mesh:
    """Nodes and elements of the frame, `smallest` at the ends of segments, up to `largest` (m)."""

    def __init__(self, smallest: float, largest: float) -> None:
        self.numbers: dict[tuple[float, float], int] = {}
        self.elements: list[tuple[int, int]] = []
        self.far_end: list[bool] = []  # whether an element is nearer to the end of its segment
        for x in 3.0 * np.arange(5):
            for low, high in ((0.0, 0.8), (0.8, 4.0), (4.0, 8.0)):
                self._segment((x, low), (x, high), smallest, largest)
        for y in (4.0, 8.0):
            for x in 3.0 * np.arange(4):
                self._segment((x, y), (x + 3.0, y), smallest, largest)
        self.points = list(self.numbers)
        self.bases = [self.numbers[(3.0 * i, 0.0)] for i in range(5)]
        self.hit = self.numbers[(6.0, 0.8)]

    def _segment(self, start, end, smallest: float, largest: float) -> None:
        length = float(np.hypot(end[0] - start[0], end[1] - start[1]))
        if smallest == largest:
            parts = np.full(round(length / smallest), length / round(length / smallest))
        else:
            parts = graded_lengths(length, smallest, largest)
        shares = np.concatenate([[0.0], np.cumsum(parts)]) / length
        at = np.asarray(start) + shares[:, None] * (np.asarray(end) - np.asarray(start))
        line = []
        for x, y in at:
            key = (round(float(x), 6), round(float(y), 6))
            line.append(self.numbers.setdefault(key, len(self.numbers)))
        self.elements.extend(pairwise(line))
        self.far_end.extend(0.5 * (shares[1:] + shares[:-1]) > 0.5)


def ours(mesh: Mesh, kind: str, step: float) -> Iterator[float]:
    """Displacements of the hit node, step by step."""
    of = np.zeros(len(mesh.elements), dtype=np.int64)
    law = LinearHardening(E, FY, HARDENING * E)
    if kind.startswith("reissner"):
        section = BeamSection(Y, AREA, law, MASS, E / 2.6 * SIDE**2 * 5.0 / 6.0)
        group: ReissnerBeams | FiberBeams = ReissnerBeams(mesh.elements, of, [section])
    else:
        fibers = BeamSection(Y, AREA, law, MASS)
        balanced = kind == "balanced"
        rule = radau_rule(mesh.far_end) if balanced else None
        group = FiberBeams(mesh.elements, of, [fibers], rule, balanced=balanced)
    explicit = kind.endswith("explicit")
    frame = PlanarAssembly(mesh.points, [group], lumped=explicit)
    frame.hold([frame.dof(node, c) for node in mesh.bases for c in ("u", "v", "rotation")])
    dof = frame.dof(mesh.hit, "u")
    with threadpool_limits(1, user_api="blas"):
        if explicit:
            steps = explicit_impact(frame, dof, STRIKER, [(DURATION, 1e-4)])
        else:
            steps = impact(frame, dof, STRIKER, [(DURATION, step)], 0.55)
        for _ in steps:
            yield float(frame.displacement[dof])


def opensees(mesh: Mesh, step: float) -> Iterator[float]:
    """The same by OpenSeesPy; the striker sticks to the node that it has hit."""
    import openseespy.opensees as ops

    ops.wipe()
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    for number, (x, y) in enumerate(mesh.points):
        ops.node(number, x, y)
    for node in mesh.bases:
        ops.fix(node, 1, 1, 1)
    ops.uniaxialMaterial("Steel01", 1, FY, E, HARDENING)
    ops.section("Fiber", 1)
    for height, area in zip(Y, AREA, strict=True):
        ops.fiber(float(height), 0.0, float(area), 1)
    ops.geomTransf("Corotational", 1)
    ops.beamIntegration("Legendre", 1, 1, 2)
    for number, (i, j) in enumerate(mesh.elements):
        ops.element("dispBeamColumn", number, i, j, 1, 1, "-mass", MASS)
    tributary = (
        0.5
        * MASS
        * sum(
            float(np.hypot(*np.subtract(mesh.points[i], mesh.points[j])))
            for i, j in mesh.elements
            if mesh.hit in (i, j)
        )
    )
    ops.mass(mesh.hit, STRIKER.mass, 0.0, 0.0)
    common = STRIKER.mass * STRIKER.velocity / (STRIKER.mass + tributary)
    ops.setNodeVel(mesh.hit, 1, common, "-commit")
    ops.constraints("Plain")
    ops.numberer("RCM")
    ops.system("BandGeneral")
    ops.test("NormDispIncr", 1e-8, 25)
    ops.algorithm("Newton")
    ops.integrator("HHT", 0.9)
    ops.analysis("Transient")
    for number in range(1, round(DURATION / step) + 1):
        for parts, algorithm in ATTEMPTS:  # from where the last attempt has stopped
            ops.algorithm(algorithm)
            if ops.analyze(parts, (number * step - ops.getTime()) / parts) == 0:
                break
        else:
            raise RuntimeError(f"OpenSees does not converge at {number * step:.5f} s")
        yield float(ops.nodeDisp(mesh.hit, 1))


def measure(label: str, history: Iterator[float], mesh: Mesh) -> tuple[float, float]:
    """Run, print and return the peak in m and the wall time in s."""
    start = perf_counter()
    try:
        peak = max(history)
    except RuntimeError as failure:
        print(f"{label:<44}{failure}")
        return float("nan"), float("nan")
    spent = perf_counter() - start
    error = 100.0 * (peak / EXTRAPOLATED - 1.0)
    print(
        f"{label:<44}{len(mesh.elements):>6}{peak:>10.4f} m{error:>8.2f} %{spent:>9.2f} s",
        flush=True,
    )
    return peak, spent


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--size", type=float, default=0.1, help="of the elements, in m")
    parser.add_argument("--equal-error", action="store_true", help="the second table too")
    options = parser.parse_args()
    small = Mesh(0.4, 0.4)
    for kind in ("reissner", "corotational", "balanced", "reissner-explicit"):
        next(ours(small, kind, 1e-4))  # compile
    mesh, step = Mesh(options.size, options.size), options.size / 1000.0
    print(f"{'same elements, fibers and steps':<44}{'elements':>6}{'peak':>10}{'error':>12}")
    _, theirs = measure("OpenSeesPy dispBeamColumn, corotational", opensees(mesh, step), mesh)
    for kind in ("reissner", "corotational", "reissner-explicit"):
        _, spent = measure(kind, ours(mesh, kind, step), mesh)
        print(f"{'':<4}ratio to OpenSeesPy: {spent / theirs:.3f}")
    if not options.equal_error:
        return
    print(
        f"within {100 * ALLOWED:g} % of the extrapolated peak, smallest and largest element, step"
    )
    best = cheapest(ours, OURS)
    theirs = cheapest(lambda mesh, _, step: opensees(mesh, step), THEIRS)
    print(f"{'':<4}ratio to OpenSeesPy: {best / theirs:.3f}")


def cheapest(solve, candidates) -> float:
    """Least wall time (s) among those candidates whose peak is near enough."""
    times = []
    for kind, smallest, largest, step in candidates:
        mesh = Mesh(smallest, largest)
        label = f"{kind} {smallest:g} m {largest:g} m {step:g} s"
        peak, spent = measure(label, solve(mesh, kind, step), mesh)
        if abs(peak / EXTRAPOLATED - 1.0) <= ALLOWED:
            times.append(spent)
    return min(times, default=float("nan"))


if __name__ == "__main__":
    main()
