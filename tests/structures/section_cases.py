"""Fibers and sections led along strains, by the kernel that all beams with fibers share."""

from __future__ import annotations

import numpy as np

from workbench.mechanics.structures.fibers import BeamSection, kernels
from workbench.mechanics.structures.fibers.section import section_tables


def response(section: BeamSection, strain: float, curvature: float, old: np.ndarray):
    """Forces and tangent of a section (see `section_response`), and its new states (states, f)."""
    tables = section_tables(np.zeros(1, dtype=np.int64), [section])
    new = np.zeros_like(old)
    strains = strain, 0.0, curvature
    return kernels.section_response(tables, 0, 1.0, np.inf, strains, old, new), new


def stress_path(law, strains, duration: float = np.inf) -> np.ndarray:
    """Stresses and tangents (n, 2) of a fiber that is led along `strains` (n,) from rest."""
    fiber = BeamSection(np.zeros(1), np.ones(1), law, 0.0)
    tables = section_tables(np.zeros(1, dtype=np.int64), [fiber])
    old, new = np.zeros((2, law.states, 1))
    result = []
    for strain in np.asarray(strains, dtype=float):
        outcome = kernels.section_response(tables, 0, 1.0, duration, (strain, 0.0, 0.0), old, new)
        result.append((outcome[0], outcome[3]))
        old, new = new, old
    return np.array(result)
