"""How long the events of a frame take, and the time steps that follow from that."""

from functools import lru_cache
from math import inf, pi, sqrt

import numpy as np

from workbench.frames.chains import chains
from workbench.frames.elastic import ElasticFrame
from workbench.frames.findings import HALVES, dead_load_state
from workbench.frames.shear import shear_stiffness
from workbench.scenarios import Frame, FrameImpact, Load

FIRST_SPAN, LATER = 6.0, 4.0  # beyond so many times to the peak, so many times longer steps

_FELT = 0.05  # of the largest swing of a mode after a blow

Spans = list[tuple[float, float]]  # end times and time steps of the parts of a record, in s


def spans_to(peak: float, duration: float, first: float, coarsest: float, share: float) -> Spans:
    """Parts of a record around and after a peak, at the time `peak` in s.

    Arguments: `duration` of the record, step at `first` and the `coarsest` one allowed, all in s;
    `share` of these steps that is taken.
    """
    first = min(coarsest, first)
    later = min(coarsest, LATER * first)
    return [(min(FIRST_SPAN * peak, duration), share * first), (duration, share * later)]


def time_to_peak(scenario: FrameImpact, shear_flexible: bool = False) -> float:
    """Estimate (s) of the time of the peak: of an elastic spring, or of hinges if longer.

    Both from the members at the struck node alone, held at their far ends; the plastic estimate
    is that of a mechanism with hinges at both ends of them. Elastic shear strain counts if
    `shear_flexible`.
    """
    frame, striker = scenario.frame, scenario.striker
    along = np.array([1.0, 0.0] if striker.direction.endswith("x") else [0.0, 1.0])
    stiffness = np.zeros((3, 3))
    resistance = 0.0
    inertia = striker.mass + frame.node(striker.node).mass
    for member in frame.members:
        if striker.node not in (member.start, member.end):
            continue
        far = frame.node(member.end if striker.node == member.start else member.start)
        near = frame.node(striker.node)
        length = frame.length(member)
        properties = frame.properties(member)
        c, s = (far.x - near.x) / length, (far.y - near.y) / length
        modulus = frame.steel.elastic_modulus
        axial = modulus * properties.area / length
        bending = modulus * properties.second_moment / length
        softer = 0.0  # Timoshenko's ratio of bending to shear stiffness
        if shear_flexible:
            shear = shear_stiffness(frame.strength_section(member), frame.steel)
            softer = 12.0 * bending / (length * shear)
            bending /= 1.0 + softer
        e, n = np.array([c, s, 0.0]), np.array([-s, c, 0.0])
        turned = 6.0 * bending / length * n
        stiffness += axial * np.outer(e, e) + 12.0 * bending / length**2 * np.outer(n, n)
        stiffness[2, :2] += turned[:2]
        stiffness[:2, 2] += turned[:2]
        stiffness[2, 2] += (4.0 + softer) * bending
        across, lengthwise = abs(float(n[:2] @ along)), abs(float(e[:2] @ along))
        resistance += 2.0 * properties.plastic_moment / length * across
        resistance += properties.squash_load * lengthwise
        inertia += properties.mass_per_length * length / 3.0
    flexibility = float(np.append(along, 0.0) @ np.linalg.pinv(stiffness) @ np.append(along, 0.0))
    elastic = 0.5 * pi * sqrt(inertia * flexibility)
    return max(elastic, striker.mass * striker.velocity / resistance)


@lru_cache(maxsize=64)
def slowest_period(frame: Frame, node: str, direction: str) -> float:
    """Longest period (s) of those that a blow on a node along a direction makes felt.

    Of the elastic frame; dead loads lengthen it by no more than they soften the mode in which it
    buckles.
    """
    elastic = ElasticFrame(frame, parts=HALVES)
    blow = elastic.load([Load(node, **{direction[-1]: 1.0})])
    periods, swings = elastic.vibrations(blow)
    factor = dead_load_state(frame).factor if frame.loads else inf
    softer = 1.0 if factor is None else sqrt(1.0 - 1.0 / factor)
    return float(periods[swings >= _FELT * swings.max(initial=0.0)].max(initial=0.0)) / softer


@lru_cache(maxsize=64)
def wave_times(frame: Frame) -> tuple[float, ...]:
    """Times (s) of an axial wave along every member."""
    modulus = frame.steel.elastic_modulus
    owns = [(frame.length(member), frame.properties(member)) for member in frame.members]
    return tuple(length / sqrt(modulus * own.area / own.mass_per_length) for length, own in owns)


def line_wave_times(frame: Frame) -> list[float]:
    """Times (s) of an axial wave along every line of members that continue each other."""
    names = [member.name for member in frame.members]
    times = dict(zip(names, wave_times(frame), strict=True))
    return [sum(times[name] for name in line.members) for line in chains(frame)]
