"""The compiled impact of superelements: equal steps, steps by error, records, failures."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest
from superelement_cases import NO_LIMITS, thesis_column

from workbench.base.arrays import Array
from workbench.base.errors import SolverError
from workbench.mechanics.impact.pace import Pace
from workbench.mechanics.structures.assembly import PlanarAssembly
from workbench.mechanics.structures.impact import PointMass
from workbench.mechanics.structures.kernels import solve_band
from workbench.mechanics.structures.march import follow_impact

DURATION = 0.04
BY_ERROR = Pace(DURATION, 1e-6, 4e-4, 1e-4, 1.2e-2, 0.01, 0.0, 100_000)
MASS, SPEED = 1500.0, 15.0


def equal(step: float, duration: float = DURATION) -> Pace:
    """Steps of one length, all of them recorded."""
    return Pace(duration, step, step, inf, inf, inf, 0.0, 100_000)


def finer(pace: Pace, share: float) -> Pace:
    return pace._replace(
        first=share * pace.first,
        longest=share * pace.longest,
        error=share * pace.error,
        vibration=share * pace.vibration,
        flow=share * pace.flow,
    )


def column(**options: object) -> tuple[PlanarAssembly, int]:
    assembly, _, hit = thesis_column(mass=71.4, inertia="nonlinear", **options)
    for node in range(3):
        assembly.add_mass(node, 0.0, rotary=0.1)
    return assembly, hit


def followed(pace: Pace, restitution: float = 0.0, **options: object) -> dict[str, Array]:
    """Histories of the hit column from the start, its energies, and what its steps took."""
    assembly, hit = column(**options)
    striker = PointMass(MASS, SPEED, restitution)
    stored, parts = assembly.stored, []
    for records in follow_impact(assembly, hit, striker, pace, NO_LIMITS):
        table = records.table
        parts.append(
            {
                "x": records.x[:, hit],
                "v": records.v[:, hit],
                **{name: table[name] for name in ("time", "percussion", "plastic")},
                "total": table["kinetic"]
                + table["stored"]
                + table["plastic"]
                + table["contact_loss"]
                - table["external_work"],
                "evaluations": np.array([records.evaluations]),
            }
        )
    run = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    begin = 0.5 * MASS * SPEED**2 + stored
    run["ledger"] = (run["total"] - begin) / begin
    return run


@pytest.mark.thorough
@pytest.mark.parametrize("restitution", [0.0, 0.6])
@pytest.mark.parametrize("kind", [{}, {"flexible": True}], ids=["rigid", "flexible"])
def test_equal_steps_keep_energy_and_reach_the_peak_of_steps_by_error(kind, restitution) -> None:
    step, count = 1e-4, 400
    run, by_error = (
        followed(pace, restitution, **kind) for pace in (equal(step, count * step), BY_ERROR)
    )
    assert len(run["time"]) == count + 1
    np.testing.assert_allclose(np.diff(run["time"]), step, rtol=1e-9)
    assert np.abs(run["ledger"]).max() < 1e-7
    assert run["percussion"].min() >= 0.0
    assert np.count_nonzero(run["percussion"]) > 3
    assert run["plastic"][-1] > 0.5 * 0.5 * MASS * SPEED**2
    assert run["x"].max() == pytest.approx(by_error["x"].max(), rel=5e-3)


@pytest.mark.parametrize("restitution", [0.0, 0.6])
def test_steps_by_error_are_few_and_right(restitution) -> None:
    """0.1 % of the peak against steps 16 times shorter, which take four times the work or more."""
    by_error, fine = (followed(pace, restitution) for pace in (BY_ERROR, finer(BY_ERROR, 1 / 16)))
    assert by_error["x"].max() == pytest.approx(fine["x"].max(), rel=1e-3)
    assert by_error["evaluations"][-1] < 0.25 * fine["evaluations"][-1]
    for run in (by_error, fine):
        assert np.abs(run["ledger"]).max() < 1e-7
        assert run["percussion"].min() >= 0.0


def test_vibrations_after_the_last_flow_keep_their_energy() -> None:
    run = followed(BY_ERROR._replace(duration=0.1, longest=1e-3))
    flows = np.diff(run["plastic"], prepend=0.0) > 0.0
    still = np.flatnonzero(flows | (run["percussion"] > 0.0))[-1]
    assert len(run["x"]) - still > 30
    assert np.ptp(run["total"][still:]) < 1e-8 * 0.5 * MASS * SPEED**2
    swing = run["x"][still:]
    half = len(swing) // 2
    assert np.ptp(swing[half:]) == pytest.approx(np.ptp(swing[:half]), rel=0.15)


def test_records_are_thinned_without_a_loss() -> None:
    """Energies, percussions and the last state are those of all steps."""
    every, thinned = followed(BY_ERROR), followed(BY_ERROR._replace(spacing=1e-3))
    assert len(thinned["x"]) < 0.5 * len(every["x"])
    assert thinned["time"][-1] == pytest.approx(DURATION, rel=1e-12)
    assert np.all(thinned["time"][2:] - thinned["time"][:-2] > 1e-3)
    assert thinned["percussion"].sum() == pytest.approx(every["percussion"].sum(), rel=1e-12)
    for name in ("x", "plastic", "total"):
        assert thinned[name][-1] == every[name][-1]


def test_an_impact_is_stepped_on_to() -> None:
    """A striker on its way meets the column at the instant that its distance says."""
    assembly, hit = column()
    striker = PointMass(MASS, SPEED, position=-0.1)
    pace = BY_ERROR._replace(duration=0.02, longest=5e-3)
    times, hits = [], []
    for records in follow_impact(assembly, hit, striker, pace, NO_LIMITS):
        times.append(records.time)
        hits.append(records.table["percussion"])
    time, percussion = np.concatenate(times), np.concatenate(hits)
    assert time[np.argmax(percussion > 0.0)] == pytest.approx(0.1 / SPEED, abs=1e-5)


def test_what_cannot_be_solved_is_a_typed_failure() -> None:
    assembly, hit = column()
    striker = PointMass(MASS, SPEED)
    with pytest.raises(SolverError, match=r"20 steps; a softer or heavier structure"):
        list(follow_impact(assembly, hit, striker, BY_ERROR._replace(most=20), NO_LIMITS))
    assembly.mass[:] = np.nan
    with pytest.raises(SolverError, match=r"open and closed contact, steps down to"):
        list(follow_impact(assembly, hit, striker, BY_ERROR, NO_LIMITS))


@pytest.mark.parametrize("width", [1, 4, 7])
def test_the_band_solver_pivots(width) -> None:
    """Against a dense solution, with a zero on the diagonal; a singular matrix is told."""
    rng, n = np.random.default_rng(width), 12
    rows = 3 * width + 1
    for diagonal in (1.0, 0.0):
        dense = rng.normal(size=(n, n))
        dense[np.abs(np.subtract.outer(np.arange(n), np.arange(n))) > width] = 0.0
        np.fill_diagonal(dense, diagonal * np.diag(dense))
        band = np.zeros(rows * n)
        for i, j in np.argwhere(dense):
            band[j * rows + 2 * width + i - j] = dense[i, j]
        right = rng.normal(size=n)
        x = right.copy()
        assert solve_band(band, width, x, np.zeros(n, np.int64))
        np.testing.assert_allclose(dense @ x, right, atol=1e-10)
    assert not solve_band(np.zeros(rows * n), width, right, np.zeros(n, np.int64))
