"""The push of a solid column, from the loaded state to the response."""

import numpy as np
from scipy.integrate import cumulative_trapezoid

from workbench.arrays import Array
from workbench.references.solid.assembly import SolidAssembly
from workbench.references.solid.material import SQUEEZED
from workbench.references.solid.push import push
from workbench.responses import Finding, Response, build_response, findings_of, set_findings
from workbench.scenarios import Column

SEGMENTS = ("below", "above")
KINKED = 0.05  # nominal strain beyond which forces fall by several per cent with each refinement
REGULAR = 0.005  # hardening ratio from which on they do not
LOCALISED = 0.8  # nominal strain at which kinks fold up
LARGEST_IMBALANCE = 1e-3  # of the work of the push


def run_pushover(column: Column, assembly: SolidAssembly, path: Array) -> Response:
    """Lead the hit section along `path` (steps,) in m, from zero, and record the response.

    Arguments: `assembly` under its axial load. The restraint spring is unstressed, and a fixed
    head locked, from here on. External work is the trapezoidal sum over the steps, plastic work
    likewise. Raises `SolverError`.
    """
    supports = assembly.supports
    fixed = column.head == "fixed"
    held = np.array([supports.head] if fixed else [], dtype=np.int64)
    if not fixed:
        assembly.spring = (column.restraint_stiffness, float(assembly.q[supports.head]))
    plastic_before = assembly.dissipated

    def seen(force: float) -> tuple[float, ...]:
        return (
            force,
            float(assembly.q[supports.head]),
            assembly.stored(),
            assembly.dissipated - plastic_before,
            *segment_shear(assembly),
            assembly.largest_strain(),
            float(np.min(assembly.area_ratio())),
        )

    rows = [seen(0.0)]
    evaluations = cuts = 0
    for step in push(assembly, path[1:], held):
        rows.append(seen(step.force))
        evaluations += step.evaluations
        cuts += step.cuts
    force, head, stored, dissipated, below, above, strains, areas = np.array(rows).T
    pushed = cumulative_trapezoid(force, path, initial=0.0)
    work = pushed - column.axial_load * (head - head[0])
    shear = np.max(np.abs([below, above]), axis=1)
    response = build_response(
        {
            "displacement": path,
            "force": force,
            "shortening": -head,
            "elastic": stored,
            "dissipated": dissipated,
            "external_work": work,
            "input_energy": pushed[-1],
            "shear_utilisation": shear / column.properties.shear_resistance,
        },
        steps=len(path),
        segments=SEGMENTS,
        warnings=_localisation(path, strains, areas, assembly.hardening_ratio),
    )
    open_by = float(np.max(np.abs(response["balance_error"])) / np.max(np.abs(pushed)))
    if open_by > LARGEST_IMBALANCE:
        text = f"the energy ledger is open by {open_by:.2g} of the work of the push"
        finding = Finding("energy-balance", text, remedy="take a smaller step", number=open_by)
        set_findings(response, [*findings_of(response), finding])
    response.attrs.update(
        elements=len(assembly.mesh.dofs),
        dofs=assembly.mesh.size,
        smallest_element=assembly.mesh.smallest,
        newton_iterations=evaluations,
        cut_steps=cuts,
        largest_strain=float(strains.max()),
        least_area_ratio=float(areas.min()),
    )
    return response


def segment_shear(assembly: SolidAssembly) -> tuple[float, float]:
    """Shear force of the segments below and above the hit section in the committed state, in N.

    No load acts between the sections, so that the reaction of an end is the force in all sections
    of its segment; shear is its part across the chord of the deformed segment.
    """
    mesh, force = assembly.mesh, assembly.force
    u = assembly.supports.expand(assembly.q)
    shears = []
    for end, length in ((mesh.base, mesh.lengths[0]), (mesh.head, -mesh.lengths[1])):
        across, along = force[end[0]].sum(), force[end[1]].sum()
        dx = u[mesh.hit[0]].mean() - u[end[0]].mean()
        dy = length + u[mesh.hit[1]].mean() - u[end[1]].mean()
        shears.append(float((across * dy - along * dx) / np.hypot(dx, dy)))
    return shears[0], shears[1]


def _localisation(
    path: Array, strains: Array, areas: Array, hardening_ratio: float
) -> list[Finding]:
    """What the mesh decides about: forces once kinks form, everything once they fold up."""
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
