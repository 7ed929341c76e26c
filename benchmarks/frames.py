"""Cost of frame models, measured side by side in one run.

The frame of Heng 2017, figure 5.13 (four bays, two storeys, squares of 0.2 m, 1500 kg at 50 m/s),
followed for 0.05 s: superelements; the fiber reference at its own mesh, whose grid convergence
index is 1.1 %, and at a cheaper one, 0.8 % off the extrapolated peak without proof of its own. Then
solving alone, one rigid superelement per member: the compiled march
against OpenSeesPy with one force-based element per member (five Lobatto points, 20 fibers,
co-rotational), also with a hardening of 1e-3 E, with which it converges but stiffens the frame.
Both in the setting that takes least time within 1 % of their own converged peak, as all finer ones
are: equal steps, or our steps by error. Nothing here passes or fails.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from statistics import median
from time import perf_counter

from column_models import cheapest
from opensees import peak_of

from workbench.base.datafiles import data_directory
from workbench.models.references.fiber_beams import FiberReissner
from workbench.models.superelements import FlexibleSuperelement, RigidSuperelement
from workbench.responses import Response
from workbench.scenarios import FrameImpact, load_scenario

DURATION, TURNS = 0.05, 5
ACCURACIES = (0.1, 0.05, 0.03, 0.02, 0.01, 3e-3, 1e-3)  # that steps by error are asked for
LOOSE = 1e-5  # m, tolerance of OpenSees' steps; 1e-7 takes up to a sixth longer, 1e-3 fails more
CHEAPER = FiberReissner(smallest_element=0.0125, largest_element=0.1, time_step=1e-4, levels=1)
BARS = partial(RigidSuperelement, elements=1, rotational_stiffness=6.0)  # those of the thesis
MODELS = {
    "rigid superelement, one per member": BARS(),
    "rigid superelement": RigidSuperelement(),
    "flexible superelement": FlexibleSuperelement(),
    "fiber-reissner, converged mesh": FiberReissner(levels=1),
    "fiber-reissner, 12.5 mm to 0.1 m": CHEAPER,
}


def opensees(scenario: FrameImpact, hardening: float, steps: float) -> tuple[float, float]:
    """Peak displacement (m) of the hit node, and seconds of solving; the striker sticks to it."""
    import openseespy.opensees as ops

    frame, striker = scenario.frame, scenario.striker
    steel = frame.steel
    number = {node.name: i for i, node in enumerate(frame.nodes)}
    ops.wipe()
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    for node in frame.nodes:
        ops.node(number[node.name], node.x, node.y)
        if node.held:
            ops.fix(number[node.name], *(int(c in node.held) for c in ("u", "v", "rotation")))
    ops.uniaxialMaterial("Steel01", 1, steel.yield_stress, steel.elastic_modulus, hardening)
    y, area = frame.members[0].section.fibers(20)
    ops.section("Fiber", 1)
    for height, part in zip(y, area, strict=True):
        ops.fiber(float(height), 0.0, float(part), 1)
    ops.geomTransf("Corotational", 1)
    ops.beamIntegration("Lobatto", 1, 1, 5)
    attached = 0.0
    for tag, member in enumerate(frame.members):
        mass = frame.properties(member.name).mass_per_length
        ends = number[member.start], number[member.end]
        ops.element("forceBeamColumn", tag, *ends, 1, 1, "-iter", 50, 1e-8, "-mass", mass)
        if striker.node in (member.start, member.end):
            attached += 0.5 * mass * frame.length(member.name)
    hit = number[striker.node]
    ops.mass(hit, striker.mass, 0.0, 0.0)
    ops.setNodeVel(hit, 1, striker.mass * striker.velocity / (striker.mass + attached), "-commit")
    begun = perf_counter()
    return peak_of(hit, scenario.duration, steps, LOOSE), perf_counter() - begun


def bars(scenario: FrameImpact, option: str, setting: float) -> tuple[float, float]:
    """Peak (m) of one rigid superelement per member, and seconds of solving.

    The `option` is `accuracy`, or `time_step` for a number of equal steps.
    """
    value = scenario.duration / setting if option == "time_step" else setting
    answer = BARS(**{option: value}).simulate(scenario)
    return float(answer["peak_displacement"]), float(answer.attrs["solve_time"])


def timed(impact: FrameImpact, share: float) -> tuple[float, float]:
    """Seconds of solving one rigid superelement per member, and of all else, at that `share` of v.

    All else are findings, what is read and drawn, the response and its provenance.
    """
    striker = replace(impact.striker, velocity=share * impact.striker.velocity)
    other = replace(impact, striker=striker)
    begun = perf_counter()
    spent = float(BARS().simulate(other).attrs["solve_time"])
    return spent, perf_counter() - begun - spent


def solving(impact: FrameImpact) -> None:
    """Print what solving takes: the compiled march, OpenSeesPy."""
    compiled, rest = map(min, zip(*(timed(impact, 1.0 + 1e-6 * n) for n in range(60)), strict=True))
    print(f"\n{'rigid superelement, 0.1 %':<40}{1e3 * compiled:>11.3f} ms")
    print(f"{'on top of solving':<40}{1e3 * rest:>11.3f} ms")
    equal, by_error = partial(bars, impact, "time_step"), partial(bars, impact, "accuracy")
    base = min(
        cheapest("equal steps", equal, 5000, 20),
        cheapest("steps by error", by_error, 1e-5, 20, ACCURACIES),
    )
    for hardening in (1e-6, 1e-3):
        label = f"OpenSeesPy, {hardening:g} E, steps"
        try:
            spent = cheapest(label, partial(opensees, impact, hardening), 4000, 5)
        except (ImportError, RuntimeError) as failure:
            print(f"{label}: {failure}")
            continue
        print(f"{'':<32}{spent / base:>18.1f} times ours at 1 %, {spent / compiled:.1f} at 0.1 %")


def main() -> None:
    """Measure all in turn and print peaks, medians and ratios."""
    impact = load_scenario(data_directory() / "published" / "heng2017_frame.toml")
    assert isinstance(impact, FrameImpact)
    impact = replace(impact, duration=DURATION)
    short = replace(impact, duration=1e-3)
    for model in MODELS.values():
        model.simulate(short)  # compile
    answers: dict[str, Response] = {}
    times: dict[str, list[float]] = {}
    for turn in range(TURNS):  # interleaved, so that a drift of the machine meets all alike
        for label, model in MODELS.items():
            if isinstance(model, FiberReissner) and turn > 0:
                continue
            start = perf_counter()
            answers[label] = model.simulate(impact)
            times.setdefault(label, []).append(perf_counter() - start)
    peaks = {label: float(answer["peak_displacement"]) for label, answer in answers.items()}
    base = median(times["rigid superelement"])
    print(f"{'model':<42}{'peak':>10}{'median':>12}{'ratio':>10}")
    for label, values in times.items():
        spent = median(values)
        print(f"{label:<42}{peaks[label]:>8.4f} m{spent:>10.3f} s{spent / base:>10.1f}")
    solving(impact)


if __name__ == "__main__":
    main()
