"""Rules that all column references share: time steps, meshes, and what fibers cannot follow."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
from numpy.typing import NDArray

from workbench.errors import InputError
from workbench.references.column_beams import shear_stiffness
from workbench.responses import Finding
from workbench.scenarios import Column, ColumnImpact, ColumnPushover, ColumnScenario
from workbench.structures.meshing import graded_lengths, halved

Array = NDArray[np.float64]
LARGEST_SHARE = 1.0 / 40.0  # of the length; travelling hinges pass through inner elements
CUBIC_STATIC_SHARE = 1.0 / 8.0  # of the length, for elements that bend: no hinge travels in statics
LARGEST_EXCESS = 0.025  # of the resistance, by sampling plasticity inside the member
LARGEST_IN_IMPACT = 0.06  # of the length
PEAK_STEPS = 200.0  # time steps up to the expected peak, at least
WAVE_STEPS = 15.0  # time steps while an axial wave passes the column, at least
LEAST_STEPS = 200.0  # time steps of a record, at least
FIRST_SPAN, LATER = 6.0, 4.0  # beyond so many times to the peak, so many times longer steps


def check_layers(layers: int) -> None:
    """Refuse an odd number of layers. Raises `InputError`."""
    if layers % 2:
        raise InputError("option.layers", layers, "must be even", "an odd number loses moment")


def column_mesh(
    scenario: ColumnScenario,
    smallest: float | None,
    largest: float | None,
    refinement: int,
    share: float,
    depth: float,
    growth: float = 1.5,
    static_share: float = LARGEST_SHARE,
) -> tuple[Array, Array]:
    """Element lengths (m) below and above the hit point.

    Arguments: lengths of the `smallest` and `largest` element in m (None: a `share` of the shorter
    segment, but not below `depth` times the depth of the section; 1/40 of the length under
    impact, `static_share` of it in statics); how often all are halved (negative: doubled);
    `growth`, ratio of neighbouring elements between both.
    """
    column = scenario.column
    shorter = min(column.length_below, column.length_above)
    bound = static_share if isinstance(scenario, ColumnPushover) else LARGEST_SHARE
    largest = largest or bound * column.length
    smallest = smallest or max(min(share * shorter, largest), depth * column.section.height)
    coarser = 2.0 ** max(-refinement, 0)
    smallest, largest = coarser * smallest, coarser * max(largest, smallest)
    below, above = (
        halved(graded_lengths(length, smallest, largest, growth), max(refinement, 0))
        for length in (column.length_below, column.length_above)
    )
    return below, above


def mesh_findings(
    scenario: ColumnScenario, below: Array, above: Array, sampled: float = 0.5
) -> list[Finding]:
    """Element lengths (m) for which the result is known to be off by several percent.

    Arguments: element lengths `below` and `above` the hit point; `sampled`, where an element
    samples plasticity, from its end next to a hinge and over its length.
    """
    findings = []
    shorter = min((below, above), key=np.sum)
    excess = sampled * (shorter[0] + shorter[-1]) / np.sum(shorter)
    if excess > LARGEST_EXCESS:
        text = (
            f"elements of {shorter[0]:.3g} m next to the hinges overestimate the resistance of a "
            f"segment of {np.sum(shorter):.3g} m by about {100 * excess:.0f} %: refine"
        )
        findings.append(Finding("mesh", text))
    largest = max(below.max(), above.max())
    if isinstance(scenario, ColumnImpact) and largest > LARGEST_IN_IMPACT * scenario.column.length:
        text = (
            f"elements of {largest:.3g} m inside the segments are too long for travelling plastic "
            "hinges, peaks may be several percent off: reduce largest_element"
        )
        findings.append(Finding("mesh", text))
    return findings


def time_spans(
    scenario: ColumnImpact, time_step: float | None, refinement: int, shear_flexible: bool = True
) -> list[tuple[float, float]]:
    """End times and time steps (s) of the parts of the record, refinement applied.

    Arguments: `time_step` in s (None: from the time of an axial wave and the time to the peak);
    `shear_flexible`, whether elastic shear strain counts in the time to the peak.
    """
    duration, halvings = scenario.duration, 2.0**refinement
    if time_step is not None:
        return [(duration, time_step / halvings)]
    column = scenario.column
    properties = column.properties
    wave_speed = sqrt(column.steel.elastic_modulus * properties.area / properties.mass_per_length)
    coarsest = min(column.length / wave_speed / WAVE_STEPS, duration / LEAST_STEPS)
    peak = time_to_peak(scenario, shear_flexible)
    first = min(coarsest, peak / PEAK_STEPS)
    later = min(coarsest, LATER * first)
    return [
        (min(FIRST_SPAN * peak, duration), first / halvings),
        (duration, later / halvings),
    ]


def time_to_peak(scenario: ColumnImpact, shear_flexible: bool = True) -> float:
    """Estimate (s): of an elastic spring, or of a mechanism of plastic hinges if longer."""
    column, striker = scenario.column, scenario.striker
    properties, modulus = column.properties, column.steel.elastic_modulus
    slopes = 1.0 / column.length_below + 1.0 / column.length_above
    flexibility = 1.0 / (3.0 * modulus * properties.second_moment * slopes**3)
    if shear_flexible:
        flexibility += 1.0 / (shear_stiffness(column) * slopes)
    inertia = striker.mass + properties.mass_per_length * column.length / 3.0
    elastic = 0.5 * pi * sqrt(inertia * flexibility)
    plastic = striker.mass * striker.velocity / (2.0 * properties.plastic_moment * slopes)
    return max(elastic, plastic)


def section_findings(column: Column, y: Array, area: Array) -> list[Finding]:
    """Overrides of section values that differ from those of the fibers by over 1 %.

    Arguments: fiber heights `y` (f,) in m and areas (f,) in m2.
    """
    stress = column.steel.yield_stress
    values = {
        "area": np.sum(area),
        "second_moment": np.sum(y**2 * area),
        "plastic_moment": stress * np.sum(np.abs(y) * area),
        "squash_load": stress * np.sum(area),
    }
    differing = [
        f"column.{key} = {getattr(column, key):.5g} against {value:.5g}"
        for key, value in values.items()
        if getattr(column, key) is not None and abs(getattr(column, key) / value - 1.0) > 0.01
    ]
    if not differing:
        return []
    text = "fibers come from the section alone and leave overrides out: "
    return [Finding("section", text + ", ".join(differing))]
