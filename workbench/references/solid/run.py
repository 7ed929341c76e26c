"""What a run of a solid column records, and its push from the loaded state to the response."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import cumulative_trapezoid

from workbench.arrays import Array, Indices
from workbench.frames.runs import OPEN_LEDGER
from workbench.references.solid.assembly import SolidAssembly
from workbench.references.solid.material import SQUEEZED
from workbench.references.solid.push import push
from workbench.responses import (
    Finding,
    Response,
    build_response,
    energy_error,
    findings_of,
    set_findings,
)
from workbench.scenarios import Column

SEGMENTS = ("below", "above")
KINKED = 0.05  # nominal strain beyond which forces fall by several per cent with each refinement
REGULAR = 0.005  # hardening ratio from which on they do not
LOCALISED = 0.8  # nominal strain at which kinks fold up
LARGEST_IMBALANCE = 1e-3  # of the work of the push


class Measures(NamedTuple):
    """What is read off a committed state: energies in J, forces in N, lengths in m.

    Elastic energy, plastic work since the start, shear force below and above the hit section,
    displacement of the head, largest strain, smallest share of its area that a point keeps.
    """

    elastic: float
    dissipated: float
    shear_below: float
    shear_above: float
    head: float
    strain: float
    area: float


def measures(solid: SolidAssembly, plastic_before: float) -> Measures:
    """Read the committed state; plastic work counts from `plastic_before` (J) on."""
    return Measures(
        solid.stored(),
        solid.dissipated - plastic_before,
        *segment_shear(solid),
        float(solid.q[solid.supports.head]),
        solid.largest_strain(),
        float(np.min(solid.area_ratio())),
    )


def held_unknowns(solid: SolidAssembly, column: Column) -> Indices:
    """Unknowns that do not move once the axial load is on."""
    return np.array([solid.supports.head] if column.head == "fixed" else [], dtype=np.int64)


def release(solid: SolidAssembly, column: Column) -> float:
    """Put on the restraint spring, unstressed; the plastic work so far, in J."""
    if column.head != "fixed":
        solid.spring = (column.restraint_stiffness, float(solid.q[solid.supports.head]))
    return solid.dissipated


def run_pushover(column: Column, solid: SolidAssembly, path: Array) -> Response:
    """Lead the hit section along `path` (steps,) in m, from zero, and record the response.

    Arguments: `solid` under its axial load. The restraint spring is unstressed, and a fixed
    head locked, from here on. External work is the trapezoidal sum over the steps, plastic work
    likewise. Raises `SolverError`.
    """
    plastic_before = release(solid, column)
    forces, states = [0.0], [measures(solid, plastic_before)]
    evaluations = cuts = 0
    for step in push(solid, path[1:], held_unknowns(solid, column)):
        forces.append(step.force)
        states.append(measures(solid, plastic_before))
        evaluations += step.evaluations
        cuts += step.cuts
    pushed = cumulative_trapezoid(forces, path, initial=0.0)
    lowered = np.array([state.head for state in states]) - states[0].head
    values = {
        "displacement": path,
        "force": forces,
        "external_work": pushed - column.axial_load * lowered,
        "input_energy": pushed[-1],
    }
    response = finished(column, solid, values, states)
    response.attrs.update(newton_iterations=evaluations, cut_steps=cuts)
    return response


def finished(
    column: Column,
    solid: SolidAssembly,
    values: Mapping[str, ArrayLike],
    states: Sequence[Measures],
    time: Array | None = None,
) -> Response:
    """The response of a finished run with these `values` and committed `states`.

    Of an impact at `time` (steps,) in s.
    """
    columns = Measures(*np.array(states).T)
    shear = np.max(np.abs([columns.shear_below, columns.shear_above]), axis=1)
    path = np.asarray(values["displacement"])
    response = build_response(
        {
            **values,
            "shortening": -np.asarray(columns.head),
            "elastic": columns.elastic,
            "dissipated": columns.dissipated,
            "shear_utilisation": shear / column.properties.shear_resistance,
        },
        time=time,
        steps=None if time is not None else len(path),
        segments=SEGMENTS,
        warnings=localisation(path, columns, solid.hardening_ratio),
    )
    open_by = energy_error(response) or 0.0
    largest = LARGEST_IMBALANCE if time is None else OPEN_LEDGER
    if open_by > largest:
        text = f"the energy ledger is open by {open_by:.2g} of the energy brought in"
        finding = Finding("energy-balance", text, remedy="take a smaller step", number=open_by)
        set_findings(response, [*findings_of(response), finding])
    response.attrs.update(
        elements=len(solid.mesh.dofs),
        dofs=solid.mesh.size,
        smallest_element=solid.mesh.smallest,
        largest_strain=float(np.max(columns.strain)),
        least_area_ratio=float(np.min(columns.area)),
    )
    return response


def segment_shear(solid: SolidAssembly) -> tuple[float, float]:
    """Shear force of the segments below and above the hit section in the committed state, in N.

    The part of the reaction of its end across the chord of the deformed segment: at rest that is
    the force in all of its sections, in motion that of its end.
    """
    mesh, force = solid.mesh, solid.force
    u = solid.supports.expand(solid.q)
    shears = []
    for end, length in ((mesh.base, mesh.lengths[0]), (mesh.head, -mesh.lengths[1])):
        across, along = force[end[0]].sum(), force[end[1]].sum()
        dx = u[mesh.hit[0]].mean() - u[end[0]].mean()
        dy = length + u[mesh.hit[1]].mean() - u[end[1]].mean()
        shears.append(float((across * dy - along * dx) / np.hypot(dx, dy)))
    return shears[0], shears[1]


def localisation(path: Array, states: Measures, hardening_ratio: float) -> list[Finding]:
    """What the mesh decides about: forces once kinks form, everything once they fold up.

    Arguments: displacements `path` (steps,) in m; columns of the `states` there.
    """
    strains, areas = np.asarray(states.strain), np.asarray(states.area)
    findings = []
    kinked = np.flatnonzero(strains > KINKED)
    if kinked.size and hardening_ratio < REGULAR:
        text = (
            f"plastic kinks of the length of an element from {path[kinked[0]]:.4g} m on (nominal "
            f"strain {strains.max():.3g} at the end): where bending governs, force falls by "
            "several per cent with each halving of the mesh; compare refinements, or set "
            "hardening_ratio to 0.01"
        )
        findings.append(Finding("mesh", text))
    folded = np.flatnonzero((strains > LOCALISED) | (areas < SQUEEZED))
    if folded.size:
        text = (
            f"kinks fold up from {path[folded[0]]:.4g} m on: a point reaches the nominal strain "
            f"{strains.max():.3g} or keeps {areas.min():.2g} of its area; steel would tear or "
            "buckle locally, and forces beyond are an indication only"
        )
        findings.append(Finding("localisation", text))
    return findings
