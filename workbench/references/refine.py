"""Numerical uncertainty of a reference: coarser meshes behind every answer.

The mesh asked for is the finest. Space and time are halved together, as the discretisation errors
of both are of first order; more fibers and shorter steps alone are tried on the coarsest mesh.
See docs/theory/numerical-uncertainty.md.
"""

import json
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from typing import Any

from workbench.errors import InputError
from workbench.fields import Number
from workbench.models.base import on_one_mesh, options_of
from workbench.references.localisation import by_run, drift_text, localisation_of, told
from workbench.references.quantities import check_quantities, default_quantities, read
from workbench.responses import (
    Finding,
    Outcome,
    Response,
    findings_of,
    outcome_of,
    scalars_of,
    set_findings,
    warnings_of,
)
from workbench.responses.convergence import CAUTIOUS
from workbench.responses.uncertainty import (
    BASIS,
    FINEST,
    SPACE_AND_STEPS,
    WIDTHS,
    Direction,
    Estimate,
    attach_curves,
    estimate,
    fiber_direction,
    level_names,
    step_direction,
)
from workbench.scenarios import Scenario

COARSEST, MOST_LEVELS = -6, 6
REFINEMENT = Number(COARSEST, 6, integer=True)  # rules of the options of that name
LEVELS = Number(1, MOST_LEVELS, integer=True)
MORE_FIBERS, MOST_FIBERS = 4, 1000
LEAST_COARSENING = 1.5  # of the smallest element from one mesh to the next
# the yield ratio of a coarse run is an error of its discretisation, which the ladder measures
DOUBTS = ("time-step", "damping", "no-peak", "energy-balance")
WELL_KNOWN = 0.015  # relative half-width up to which a sequence may oscillate without a warning


def check_levels(refinement: int, levels: int, coarsest: int = COARSEST) -> None:
    """Refuse meshes below the refinement of the `coarsest` there is. Raises `InputError`."""
    if refinement - levels + 1 < coarsest:
        allowed = f"with refinement = {refinement} need meshes below refinement = {coarsest}"
        raise InputError("option.levels", levels, allowed, "take fewer levels")


def refined(model: Any, scenario: Any, solve: Callable[[Any], Response]) -> Response:
    """The answer of `solve`, with the uncertainty that the option `levels` of the model buys.

    For use inside a model's `simulate`. Failures of `solve` are raised. Coarser meshes that fail,
    or that warn of their own accuracy where the answer does not, are left out with all that are
    coarser still; without any the uncertainty is unknown.
    """
    response = solve(scenario)
    _Refinement(model, scenario, response, model.levels).attach()
    return response


def refine(
    model: Any,
    scenario: Scenario,
    quantities: Sequence[str] | None = None,
    levels: int = 3,
    localisation: bool = True,
) -> Response:
    """The response of a model with its numerical uncertainty, from any model with refinement.

    Arguments: `model` with the option `refinement`, the finest mesh; `quantities`, scalars of a
    response, ``"force at 0.05 m"`` or ``"displacement at load factor 0.5"`` (None: all scalars,
    and in statics points of the curve; warnings speak of peak, its time and residual displacement
    in time, and of input energy and the curve in statics); `levels`, meshes in all, each at half
    the element size and steps of the one before; `localisation`, whether the sensitivity to the
    hardening is found too, and a sequence that does not converge is repeated with hardening that
    regularises it.
    The result carries two attributes in JSON: `numerical_uncertainty`, quantity to absolute
    half-width in SI (null: unknown, the reason stands in the other), and `refinement` with the
    levels, all directions and the statements; and the main curve of every run. Coarser meshes
    count as far as they can be relied on, see `refined`. If the finest mesh fails, its outcome is
    the answer. Raises `InputError` for a model without refinement,
    fewer than two levels, or quantities that are not known.
    """
    options = {field.name for field in fields(model)}
    if "refinement" not in options:
        raise InputError("model", model.name, "has no option refinement", "use a reference")
    if not 2 <= levels <= MOST_LEVELS:
        raise InputError("levels", levels, f"must be from 2 to {MOST_LEVELS}")
    asked = None if quantities is None else check_quantities(quantities)
    started = time.perf_counter()
    response: Response = on_one_mesh(model).simulate(scenario)
    if outcome_of(response) is Outcome.OK:
        _Refinement(model, scenario, response, levels, asked).attach(localisation)
        response.attrs["options"] = json.dumps(options_of(model), sort_keys=True)
        response.attrs["wall_time"] = time.perf_counter() - started
    return response


@dataclass
class _Refinement:
    """The runs behind one answer."""

    model: Any
    scenario: Any
    response: Response
    levels: int
    asked: tuple[str, ...] | None = None
    statements: list[str] = field(default_factory=list)
    runs: dict[str, Response] = field(default_factory=dict)

    def attach(self, localisation: bool = False) -> None:
        """Make the runs, and let the response carry what they say."""
        response = self.response
        main = self.asked or default_quantities(self.scenario, response)
        others = () if self.asked else scalars_of(response)
        quantities = tuple(dict.fromkeys([*main, *others]))
        directions = self._run()
        values = {name: read(run, quantities) for name, run in self.runs.items()}
        values[FINEST] = read(response, quantities)
        found = {q: estimate(directions, by_run(values, q)) for q in quantities}
        if self.levels == 1:
            self.statements.append("one mesh only (levels = 1): numerical uncertainty unknown")
        unknown = [q for q in main if found[q].width is None]
        drifting = [q for q in main if _drifts(found[q])]
        warned: list[str] = []
        if unknown and self.levels > 1:
            reasons = dict.fromkeys(self.statements or [found[q].note for q in unknown])
            without = f"numerical uncertainty of {', '.join(unknown)} is unknown"
            warned.extend(f"{without}: {reason}" for reason in reasons)
        if drifting:
            warned.append(drift_text(drifting, response))
        extra: dict[str, Any] = {}
        if localisation:
            meshes = self._meshes()
            extra, said = localisation_of(meshes, self.scenario, values, main, drifting)
            warned.extend(said)
        response.attrs[WIDTHS] = json.dumps({q: found[q].width for q in quantities}, sort_keys=True)
        response.attrs[BASIS] = json.dumps(
            {
                "levels": [mesh.refinement for mesh in self._meshes()],
                "directions": [asdict(direction) for direction in directions],
                "quantities": {q: told(found[q], by_run(values, q)) for q in quantities},
                "quadrature": "fixed by the element, no option: part of space",
                "statements": list(dict.fromkeys([*self.statements, *warned])),
                **extra,
            },
            sort_keys=True,
        )
        attach_curves(response, self.runs)
        own = [Finding("refinement", text) for text in warned]
        set_findings(response, [*own, *findings_of(response)])

    def _run(self) -> tuple[Direction, ...]:
        """Answer on coarser meshes as far as they can be relied on; the directions they make."""
        model, names = on_one_mesh(self.model), level_names(self.levels)
        together = SPACE_AND_STEPS
        if self.scenario.STATIC:
            together = getattr(model, "refines_in_statics", together)
        coarsest, used = model, [FINEST]
        for name, mesh in zip(reversed(names[:-1]), reversed(self._meshes()[:-1]), strict=True):
            if not self._answer(name, mesh, self.runs.get(used[0], self.response)):
                break
            coarsest, used = mesh, [name, *used]
        if len(used) == 1:
            return ()
        directions = [Direction(together, tuple(used))]
        options = {field.name for field in fields(model)}
        if "layers" in options:
            more = MORE_FIBERS * model.layers
            layers = more if more <= MOST_FIBERS else 2 * (model.layers // (2 * MORE_FIBERS))
            name = f"{used[0]}, {'more' if layers > model.layers else 'fewer'} fibers"
            directions.append(fiber_direction(used[0], name, layers / model.layers))
            self._answer(name, replace(coarsest, layers=layers))
        if "step_refinement" in options:
            name = f"{used[0]}, half steps"
            longer = 2.0 ** (len(used) - 1) if together == SPACE_AND_STEPS else 1.0
            directions.append(step_direction(used[0], name, longer, CAUTIOUS))
            self._answer(name, replace(coarsest, step_refinement=model.step_refinement + 1))
        return tuple(directions)

    def _meshes(self) -> list[Any]:
        """The model on each mesh, from coarse to fine, alone."""
        model = on_one_mesh(self.model)
        return [
            replace(model, refinement=model.refinement - k) for k in reversed(range(self.levels))
        ]

    def _answer(self, name: str, variant: Any, finer: Response | None = None) -> bool:
        """Answer with a variant; False, with a statement, if that cannot be relied on.

        `finer` is the answer on the next finer mesh, if the variant is a coarser one.
        """
        run: Response = variant.simulate(self.scenario)
        if outcome_of(run) is not Outcome.OK:
            self.statements.append(f"{name}: {outcome_of(run)}, {run.attrs['message']}")
            return False
        known = {finding.subject for finding in warnings_of(self.response)}
        doubts = [f for f in warnings_of(run) if f.subject in DOUBTS and f.subject not in known]
        if doubts:
            self.statements += [f"{name} cannot be relied on, {f.subject}: {f}" for f in doubts]
            return False
        if finer is not None and not _coarser(run, finer):
            self.statements.append(f"{name} has no larger elements: there is no coarser mesh")
            return False
        self.runs[name] = run
        return True


def _coarser(run: Response, finer: Response) -> bool:
    """Whether the elements of a run are larger, as far as it tells."""
    own, other = (response.attrs.get("smallest_element") for response in (run, finer))
    return own is None or other is None or own >= LEAST_COARSENING * other


def _drifts(found: Estimate) -> bool:
    """Whether the meshes do not converge, by more than what is small anyway."""
    if found.found is None or found.found.converging:
        return False
    return found.found.relative is None or found.found.relative > WELL_KNOWN
