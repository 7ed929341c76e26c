"""What every integrator declares, measured."""

from __future__ import annotations

import runpy
from math import asin, inf
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from workbench.base.errors import InputError, SolverError
from workbench.extras.laboratory.complementarity import Restitution
from workbench.extras.laboratory.problems import oscillator, problem
from workbench.extras.laboratory.schemes import (
    CLASSICAL,
    ENERGY,
    LAW,
    LINEAR_ENERGY,
    MOMENTUM,
    SCHEMES,
    event_driven,
    scheme,
)
from workbench.extras.laboratory.schemes.newmark import energy_penalty, generalized_alpha, hht_alpha
from workbench.extras.laboratory.schemes.time_stepping import (
    energy_midpoint,
    gear_gupta_leimkuhler,
    moreau_jean,
)
from workbench.extras.laboratory.system import springs
from workbench.extras.laboratory.systems import SystemRecord, run
from workbench.report.drawing.style import house_style

NAMES = tuple(SCHEMES)
CONVERGENT = tuple(name for name in NAMES if name not in CLASSICAL)
LAWFUL = tuple(name for name in NAMES if SCHEMES[name].restitution == LAW)
ELASTIC = Restitution(1.0)


def follow(name: str, of: str, steps: int) -> SystemRecord:
    """A problem by an integrator."""
    given = problem(of)
    system = given.system()
    return run(
        scheme(name).stepper, system, given.law, given.start, given.duration, given.duration / steps
    )


def slope(errors: list[float]) -> float:
    """Order over halved steps."""
    return float(-np.polyfit(np.arange(len(errors)), np.log2(errors), 1)[0])


def duffing_spring(distance: float | None = None):
    """A hardening oscillator, free or with a stop."""
    stop = ([{0: 1.0}], [distance]) if distance is not None else ()
    return springs([1.0], [({0: 1.0}, (1.0, 1.0), 0.0)], *stop)


@pytest.fixture(scope="module")
def free_duffing() -> float:
    solution = solve_ivp(
        lambda _, y: (y[1], -y[0] - y[0] ** 3), (0.0, 3.0), (1.0, 0.0), rtol=1e-13, atol=1e-14
    )
    return float(solution.y[0, -1])


@pytest.mark.claim("scheme:{name}", "swing on a spring: cos 3, m", "closed form", -0.9899925, 1e-5)
@pytest.mark.parametrize("name", NAMES)
def test_a_mass_swings_on_a_spring(claim, name: str) -> None:
    spring = springs([1.0], [({0: 1.0}, (1.0,), 0.0)])
    claim(run(scheme(name).stepper, spring, ELASTIC, ([1.0], [0.0]), 3.0, 0.005).q[-1, 0])


BACK = dict.fromkeys(LAWFUL, 0.5) | {"newmark-rates": 1.0, "newmark-penalty": 1.0}  # know no law


@pytest.mark.claim("scheme:{name}", "back from a wall, m/s", "closed form", "{expected}", 1e-9)
@pytest.mark.parametrize(("name", "expected"), BACK.items())
def test_a_ball_comes_back_from_a_wall(claim, name: str, expected: float) -> None:
    ball = springs([1.0], contacts=[{0: 1.0}], gaps=[0.0])
    start = [2.35], [-1.0]
    claim(run(scheme(name).stepper, ball, Restitution(0.5), start, 12.0, 1.0).v[-1, 0])


@pytest.mark.thorough
@pytest.mark.parametrize("name", NAMES)
def test_the_order_of_smooth_motion(name: str, free_duffing: float) -> None:
    errors = []
    for steps in (40, 80, 160, 320, 640)[: 5 if SCHEMES[name].order < 4 else 4]:
        result = run(
            scheme(name).stepper, duffing_spring(), ELASTIC, ([1.0], [0.0]), 3.0, 3 / steps
        )
        errors.append(abs(float(result.q[-1, 0]) - free_duffing))
    assert slope(errors) == pytest.approx(SCHEMES[name].order, abs=0.1)


def impact_errors(name: str, phases: int = 2) -> list[float]:
    """Errors after one elastic impact, in the mean over where it falls in a step."""
    out = []
    for steps in (20, 40, 80, 160, 320)[: 5 if SCHEMES[name].order < 4 else 4]:
        h, result = 1.2 / steps, []
        for phase in range(phases):
            distance = np.sin(h * (asin(0.6) // h + (phase + 0.5) / phases))
            given = oscillator(float(distance))
            end = run(scheme(name).stepper, given.system(), given.law, given.start, 1.2, h).q[-1]
            assert given.exact is not None
            result.append(float(end[0] - given.exact(np.array([1.2]))[0, 0]))
        out.append(float(np.sqrt(np.mean(np.square(result)))))
    return out


@pytest.mark.thorough
@pytest.mark.parametrize("name", CONVERGENT)
def test_the_order_through_impacts(name: str) -> None:
    assert slope(impact_errors(name)) == pytest.approx(SCHEMES[name].impact_order, abs=0.1)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
def test_the_restitution_of_a_free_ball_is_that_declared(name: str, e: float) -> None:
    """Whatever the share of a step that the wall is ahead."""
    back = []
    for share in (0.1, 0.35, 0.6, 0.9):
        ball = springs([1.0], contacts=[{0: 1.0}], gaps=[0.0])
        end = run(scheme(name).stepper, ball, Restitution(e), ([2.0 + share], [-1.0]), 12.0, 1.0)
        back.append(float(end.v[-1, 0]))
    declared = {LAW: e, "elastic": 1.0, "none": None}[SCHEMES[name].restitution]
    if declared is None:
        assert np.ptp(back) > 0.3  # the grid's
    else:
        np.testing.assert_allclose(back, declared, atol=1e-12)


@pytest.mark.thorough
def test_a_penalty_keeps_the_energy_of_a_bar_and_velocities_to_first_order() -> None:
    """Reconstructions after Zolghadr Jahromi and Izzuddin; 20 elements, one contact, any step."""
    given = problem("bar")
    drifts = {}
    for name, ladder in (("newmark-penalty", (100, 400)), ("newmark-rates", (400, 800, 1600))):
        for steps in ladder:
            stepper, h = scheme(name).stepper, 3.5 / steps
            result = run(stepper, given.system(), ELASTIC, given.start, 3.5, h)
            assert result.gaps[-1, 0] > 0.0  # it has left
            drifts.setdefault(name, []).append(result.drift)
    assert max(drifts["newmark-penalty"]) < 1e-13
    assert drifts["newmark-rates"][0] < 0.011  # measured 0.0103
    assert slope(drifts["newmark-rates"]) == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize(("name", "forces"), [("ggl-studer", (2.0, 0.0)), ("ggl", (1.0, 1.0))])
def test_studers_contact_oscillates_at_rest_and_acarys_does_not(name, forces) -> None:
    """A body on the floor: it falls g h^2 / 2 in every other step, and is caught with 2 m g."""
    g, h = 9.81, 0.1
    body = springs([2.0], contacts=[{0: 1.0}], gaps=[0.0], load=[-2.0 * g])
    result = run(scheme(name).stepper, body, Restitution(0.0), ([0.0], [0.0]), 2.0, h)
    weights = result.impulses[2:, 0] / (2.0 * g * h)
    np.testing.assert_allclose(weights, np.tile(forces, 10)[: weights.size], atol=1e-9)
    fall = 0.5 * g * h * h if name == "ggl-studer" else 0.0
    assert result.q.min() == pytest.approx(-fall, abs=1e-12)
    assert (result.chatter > 0.8) == (name == "ggl-studer")


@pytest.mark.parametrize("name", CLASSICAL)
def test_classical_contact_does_not_converge(name: str) -> None:
    errors = impact_errors(name)
    assert min(errors) > 0.1
    assert abs(slope(errors)) < 0.4


@pytest.mark.parametrize("name", NAMES)
def test_momentum_is_kept(name: str) -> None:
    assert MOMENTUM in SCHEMES[name].conserves
    for of, mass in (("two-masses", [1500.0, 100.0]), ("cradle", [1.0, 1.0, 1.0])):
        momentum = follow(name, of, 40).v @ np.array(mass)
        np.testing.assert_allclose(momentum, momentum[0], rtol=1e-13)


@pytest.mark.thorough
@pytest.mark.parametrize("name", NAMES)
def test_energy_is_kept_where_that_is_declared(name: str) -> None:
    declared = SCHEMES[name].conserves
    linear = springs([1.0], [({0: 1.0}, (1.0,), 0.0)])
    drift = run(scheme(name).stepper, linear, ELASTIC, ([1.0], [0.0]), 20.0, 0.1).drift
    keeps = ENERGY in declared or LINEAR_ENERGY in declared
    assert (drift < 1e-12) == keeps
    if ENERGY in declared:
        stopped = duffing_spring(0.5)
        result = run(scheme(name).stepper, stopped, ELASTIC, ([1.0], [0.0]), 60.0, 0.02)
        assert result.impacts > 10
        assert result.drift < 1e-12


@pytest.mark.slow
def test_ten_thousand_elastic_steps_keep_their_energy() -> None:
    stepper = scheme("midpoint").stepper
    result = run(stepper, duffing_spring(0.5), ELASTIC, ([1.0], [0.0]), 1e2, 1e-2)
    assert len(result.t) == 10_001
    assert result.impacts > 30
    assert result.drift < 1e-10


@pytest.mark.thorough
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("e", [0.0, 0.5])
def test_penetration_stays_within_its_bound(name: str, e: float) -> None:
    a, b = SCHEMES[name].penetration
    worst = 0.0
    for height in np.linspace(0.28, 0.32, 7):
        ball = springs([1.0], contacts=[{0: 1.0}], gaps=[0.0], load=[-9.81])
        result = run(scheme(name).stepper, ball, Restitution(e), ([height], [0.0]), 0.6, 0.02)
        bound = a * 0.02 * -result.rates.min() + b * 0.02**2 * 9.81
        assert result.conditions.penetration <= bound + 1e-10
        assert result.conditions.pull <= 1e-12
        worst = max(worst, result.conditions.penetration / max(bound, 1e-300))
    assert worst > 0.1 or a == 0.0  # the bound is no idle one


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["ggl", "ggl-split"])
def test_gap_closing_leaves_no_penetration_whatever_the_masses_and_open_gaps(name: str) -> None:
    """Between floor and ceiling 3 m apart, where the other gaps are nanometres."""
    sides = [{0: -1.0, 1: 1.0}, {0: 1.0}, {1: -1.0}]
    for masses in ([0.01, 1000.0], [0.1, 100.0]):
        for k in range(6):
            load = [-9.81 * m for m in masses]
            system = springs(masses, [], sides, [0.0, 0.0, 3.0], load)
            start = [0.3 + 0.1 * k, 1.0 + 0.14 * k], [2.0, -4.0]
            result = run(scheme(name).stepper, system, Restitution(0.3), start, 1.0, 0.005)
            assert result.impacts > 3
            assert result.conditions.penetration < 1e-12


@pytest.mark.parametrize("name", NAMES)
def test_the_limit_of_stability(name: str) -> None:
    limit = SCHEMES[name].stable

    def grows(h: float) -> bool:
        spring = springs([1.0], [({0: 1.0}, (1.0,), 0.0)])
        try:
            result = run(scheme(name).stepper, spring, ELASTIC, ([1.0], [0.1]), 300.0 * h, h)
        except SolverError:
            return True
        return bool(np.abs(result.q[-30:]).max() > 100.0)

    if limit == inf:
        assert not grows(30.0)
    else:
        assert not grows(0.98 * limit)
        assert grows(1.05 * limit)


# 91/27, the mean of (3 - 4 s)^2 up to s = 2/3 and of (8 s - 5)^2 beyond
@pytest.mark.claim("scheme:newmark", "energy over that before", "closed form", 3.37037, "0.1 %")
def test_newmark_puts_the_derived_energy_into_an_impact(claim) -> None:
    factors = []
    for s in (np.arange(100) + 0.5) / 100:  # where in its step a free body arrives
        ball = springs([1.0], contacts=[{0: 1.0}], gaps=[0.0])
        result = run(scheme("newmark").stepper, ball, ELASTIC, ([2.0 + s], [-1.0]), 8.0, 1.0)
        factors.append(float(result.v[-1, 0]) ** 2)
        expected = 3.0 - 4.0 * s if s < 2.0 / 3.0 else 8.0 * s - 5.0
        assert result.v[-1, 0] == pytest.approx(expected, abs=1e-9)
    claim(np.mean(factors))


@pytest.mark.parametrize("name", CONVERGENT)
@pytest.mark.parametrize("of", ["ball", "cradle", "oscillator"])
def test_the_conditions_of_contact_hold_at_every_step(name: str, of: str) -> None:
    result = follow(name, of, 60)
    assert result.conditions.pull <= 1e-12
    assert result.conditions.complementarity <= 1e-9
    # laws between velocities of middles; a force that is there for the next step too
    if name not in ("central-differences", "newmark-rates"):
        assert result.conditions.created <= 1e-12 * result.energies.max()


@pytest.mark.parametrize("name", [n for n in LAWFUL if n != "event-driven"])
def test_time_stepping_goes_through_the_accumulation_of_impacts(name: str) -> None:
    result, exact = follow(name, "ball", 400), problem("ball").answer(np.linspace(0.0, 1.0, 401))
    assert np.abs(result.q - exact).max() < 2e-2
    np.testing.assert_allclose(result.v[-20:], 0.0, atol=0.06)


def test_event_driven_steps_pass_the_accumulation_exactly() -> None:
    for of in ("ball", "ball-lively"):
        result = follow("event-driven", of, 40)
        np.testing.assert_allclose(
            result.q, problem(of).answer(np.linspace(0.0, 1.0, 41)), atol=1e-11
        )


@pytest.mark.thorough
def test_a_second_of_the_ball_is_right() -> None:
    given = problem("ball")
    stepper = scheme("moreau-midpoint").stepper
    result = run(stepper, given.system(), given.law, given.start, 1.0, 1e-4)
    assert np.abs(result.q - given.answer(result.t)).max() < 5e-4  # measured 1.8e-4


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"h": 0.0}, "problem.time_step = 0.0: must be a number above 0"),
        ({"h": 1e-12}, "at most 20000000"),
        ({"duration": -1.0}, "problem.duration"),
        ({"law": Restitution((0.5, 0.5))}, "one number or 1"),
        ({"h": "a"}, "problem.time_step = 'a'.*without quotes"),
        ({"duration": float("nan")}, "problem.duration = nan"),
        ({"start": ([1.0, 2.0], [0.0])}, "problem.start.q = .*must be 1, one per unknown"),
        ({"start": ([1.0], [0.0, 1.0])}, "problem.start.v = .*must be 1, one per unknown"),
        ({"start": ([float("nan")], [0.0])}, "problem.start.q.0 = nan"),
        ({"start": ([1.0],)}, "problem.start = .*velocities"),
        ({"start": ([-1.0], [0.0])}, "no gap below 0 m, contact 0 has -1 m; move the bodies"),
    ],
)
def test_bad_runs_get_one_clear_message(change: dict, message: str) -> None:
    ball = springs([1.0], contacts=[{0: 1.0}], gaps=[0.0])
    given = {"law": ELASTIC, "start": ([1.0], [0.0]), "duration": 1.0, "h": 0.1, **change}
    with pytest.raises(InputError, match=message):
        run(event_driven(), ball, **given)


NAN = float("nan")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"masses": [1.0, -1.0]}, "problem.masses.1 = -1.0: must be a number above 0"),
        ({"masses": ["a"]}, "problem.masses.0 = 'a'.*without quotes"),
        ({"contacts": [{0: 1.0}]}, "problem.gaps .* 1, one per contact"),
        ({"contacts": [{0: 1.0}], "gaps": [NAN]}, "problem.gaps.0 = nan"),
        ({"contacts": [{-1: 1.0}], "gaps": [0.0]}, "problem.contacts.0 = -1.*counted from 0"),
        ({"contacts": [{}], "gaps": [0.0]}, "problem.contacts.0 = {}.*other than 0"),
        ({"laws": [({3: 1.0}, (5.0,), 0.0)]}, "problem.laws.0 = 3: .*from 0 to 0"),
        ({"laws": [({0: 1.0}, (-5.0,), 0.0)]}, "problem.laws.0.law.stiffness = -5.0"),
        ({"laws": [({0: 1.0}, (NAN,), 0.0)]}, "problem.laws.0.law.stiffness = nan"),
        ({"laws": [({0: 1.0}, (), 0.0)]}, "problem.laws.0.law = .*yield force"),
        ({"laws": [({0: 1.0}, (1.0, 2.0, 3.0, 4.0), 0.0)]}, "problem.laws.0.law = "),
        ({"laws": [({0: 1.0}, (1.0, 2.0, 3.0), 0.0)]}, "cubic = 2.0: must be 0 in a spring that"),
        ({"laws": [({0: 1.0}, (1.0, 0.0, -5.0), 0.0)]}, "yield_force = -5.0"),
        ({"laws": [({0: 1.0}, (1.0,), NAN)]}, "problem.laws.offset.0 = nan"),
        ({"laws": [({0: 1.0}, (1.0,))]}, "problem.laws.0 = .*offset"),
        ({"load": [1.0, 2.0]}, "problem.load = .*must be 1, one per mass"),
        ({"swing": (1.0, 2.0, 3.0)}, "problem.swing = .*amplitude and circular frequency"),
    ],
)
def test_bad_systems_get_one_clear_message(change: dict, message: str) -> None:
    with pytest.raises(InputError, match=message):
        springs(**{"masses": [1.0], **change})


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: moreau_jean(0.2), "moreau-jean.theta = 0.2: must be a number from 0.5 to 1"),
        (lambda: moreau_jean(0.0), "moreau-jean.theta = 0.0"),
        (lambda: moreau_jean(reach=3.0), "moreau-jean.reach = 3.0"),
        (lambda: hht_alpha(5.0), "hht-alpha.alpha = 5.0"),
        (lambda: generalized_alpha(3.0), "generalized-alpha.radius = 3.0"),
        (lambda: generalized_alpha(-1.0), "generalized-alpha.radius = -1.0: must .* from 0 to 1"),
        (lambda: energy_midpoint(-1.0), "midpoint.reach = -1.0"),
        (lambda: energy_penalty(0.0), "newmark-penalty.stiffness = 0.0"),
        (lambda: gear_gupta_leimkuhler(NAN), "ggl.reach = nan"),
    ],
)
def test_bad_parameters_of_schemes_get_one_clear_message(make, message: str) -> None:
    with pytest.raises(InputError, match=message):
        make()


def test_squeezed_contacts_say_so_instead_of_asking_for_a_shorter_step() -> None:
    squeezed = springs([1.0], [], [{0: 1.0}, {0: -1.0}], [0.0, 0.0], swing=(0.1, 10.0))
    with pytest.raises(SolverError, match="contradict each other") as raised:
        run(scheme("midpoint").stepper, squeezed, Restitution(0.0), ([0.0], [0.0]), 1.0, 0.01)
    assert "reduce the step" not in str(raised.value)


def test_bad_names_get_one_clear_message() -> None:
    with pytest.raises(InputError, match="did you mean newmark"):
        scheme("newmarc")
    with pytest.raises(InputError, match="did you mean duffing"):
        problem("dufing")


def test_the_figures_of_the_theory_page_are_those_that_its_script_draws() -> None:
    folder = Path(__file__).parents[3] / "docs" / "theory" / "figures"
    drawn = runpy.run_path(str(folder / "integrators.py"))["FIGURES"]
    page = (folder.parent / "integrators.md").read_text(encoding="utf-8")
    for name, draw in drawn.items():
        with house_style():
            assert draw() == (folder / name).read_text(encoding="utf-8")
        assert f"(figures/{name})" in page
