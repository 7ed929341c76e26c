"""A scenario's column as geometrically exact beams: sections, crookedness, assembly by forms."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from workbench.references.column_beams import (
    ColumnBeams,
    shear_modulus,
    shear_stiffness,
    stand_column,
)
from workbench.scenarios import Column
from workbench.structures.reissner_beams import BeamSection, ReissnerBeams
from workbench.structures.reissner_beams.fibers import section_fibers
from workbench.structures.shear_beams import ShearYielding
from workbench.structures.uniaxial import UniaxialLaw

Array = NDArray[np.float64]


def reissner_section(
    column: Column, law: UniaxialLaw, layers: int, pattern: str = "none", peak: float | None = None
) -> BeamSection:
    """Fibers of the column's strength section with elastic shear strain of the shear area.

    Arguments: `law` of the steel; `layers` over the depth; `pattern` and `peak` of residual
    stresses, see `section_fibers`. Raises `InputError`.
    """
    fibers = section_fibers(column.strength_section, layers, pattern, peak)
    return BeamSection(
        fibers.y,
        fibers.area,
        law,
        column.properties.mass_per_length,
        shear_stiffness=shear_stiffness(column),
        initial_stress=column.steel.yield_stress * fibers.residual,
    )


def shear_section(
    column: Column,
    layers: int,
    hardening_ratio: float,
    pattern: str = "none",
    peak: float | None = None,
) -> BeamSection:
    """Fibers of which those along the shear force yield under sigma^2 + 3 tau^2.

    Arguments: as of `reissner_section`; `hardening_ratio` of the regularising hardening modulus
    to the elastic one. Raises `InputError`.
    """
    steel = column.steel
    fibers = section_fibers(column.strength_section, layers, pattern, peak)
    return BeamSection(
        fibers.y,
        fibers.area,
        ShearYielding(
            steel.elastic_modulus,
            shear_modulus(steel),
            steel.yield_stress,
            hardening_ratio * steel.elastic_modulus,
        ),
        column.properties.mass_per_length,
        shear_share=fibers.share,
        initial_stress=steel.yield_stress * fibers.residual,
    )


def reissner_column(
    column: Column,
    section: BeamSection,
    below: Array,
    above: Array,
    *,
    crookedness: float = 0.0,
    forms: bool = False,
    lumped: bool = False,
) -> ColumnBeams:
    """The column as geometrically exact beams under its axial load.

    Arguments: `section` of all elements; element lengths (m) `below` and `above` the hit point;
    `crookedness`, amplitude of a half sine along the strike over the length; assembly by
    scikit-fem `forms` instead of the compiled kernel; `lumped` mass. Raises `SolverError`.
    """
    lengths = np.concatenate([below, above])
    count = len(lengths)
    nodes = np.stack([np.arange(count), np.arange(1, count + 1)], axis=1)
    heights = np.concatenate([[0.0], np.cumsum(lengths)])
    beams = ReissnerBeams(nodes, np.zeros(count, dtype=np.int64), [section])
    group = None
    if forms:
        from workbench.references.reissner_forms import ReissnerForms

        group = ReissnerForms(beams)
    return stand_column(
        column,
        beams,
        heights,
        len(below),
        group=group,
        offsets=crookedness * column.length * np.sin(np.pi * heights / column.length),
        lumped=lumped,
        shear_yields=isinstance(section.law, ShearYielding),
    )
