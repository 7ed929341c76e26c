"""Numerical uncertainty of a reference: coarser meshes behind every answer.

The mesh asked for is the finest. Space and time are halved together, as the discretisation errors
of both are of first order; more fibers and shorter steps alone are tried on the coarsest mesh,
a bow of what may leave its plane on the finest.
See docs/theory/numerical-uncertainty.md.
"""

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from typing import Any, NamedTuple

import numpy as np

from workbench.base.errors import InputError
from workbench.base.fields import Number
from workbench.models.base import on_one_mesh
from workbench.responses import (
    Finding,
    Outcome,
    Response,
    finding,
    findings_of,
    outcome_of,
    scalars_of,
    set_attributes,
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
    NumericalEstimate,
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
HALVED_STEPS = "how often the steps alone are halved further"  # meanings of options
MESHES = (
    "meshes behind an answer, each with twice the elements and steps of the next finer one (1: "
    "that of refinement alone, the numerical uncertainty is then unknown)"
)
MORE_FIBERS, MOST_FIBERS = 4, 1000
IMPERFECTION, USUAL_BOW = "imperfection", 1.0 / 750.0  # of the length, out of the plane
LEAST_COARSENING = 1.5  # of the smallest element from one mesh to the next
# the yield ratio of a coarse run is an error of its discretisation, which the ladder measures
DOUBTS = ("time-step", "damping", "no-peak", "energy-balance")
WELL_KNOWN = 0.015  # relative half-width up to which a sequence may oscillate without a warning
IN_TIME = ("peak_displacement", "time_of_peak", "residual_displacement")
SHARES = (0.25, 0.5, 0.75, 1.0)  # of the largest displacement (or load factor) of a static path


class CurvePoint(NamedTuple):
    """A `variable` of a static curve where `abscissa` first reaches the value `at`."""

    variable: str
    abscissa: str
    at: float


Quantities = Mapping[str, CurvePoint | None]  # by name; None: a scalar of that name


def check_levels(refinement: int, levels: int, coarsest: int = COARSEST) -> None:
    """Refuse meshes below the refinement of the `coarsest` there is. Raises `InputError`."""
    if refinement - levels + 1 < coarsest:
        allowed = f"with refinement = {refinement} need meshes below refinement = {coarsest}"
        raise InputError("option.levels", levels, allowed, "take fewer levels")


def default_quantities(scenario: Scenario, response: Response) -> Quantities:
    """Quantities whose numerical uncertainty matters most.

    In time: peak displacement, its time, residual displacement. Static: input energy, resistance
    (of a frame), and forces at quarters of the displacement, or displacements at quarters of the
    load factor where the scenario imposes that.
    """
    if "time" in response.coords:
        return dict.fromkeys(name for name in IN_TIME if name in response)
    scalars: Quantities = dict.fromkeys(n for n in ("input_energy", "resistance") if n in response)
    if getattr(scenario, "control", "") == "load":
        curve, name = ("displacement", "load_factor"), "displacement at load factor {:.12g}"
    elif "force" in response:
        unit = "rad" if str(getattr(scenario, "direction", "")).endswith("rotation") else "m"
        curve, name = ("force", "displacement"), f"force at {{:.12g}} {unit}"
    else:
        return scalars
    values = response[curve[1]].values
    top = float(values[np.argmax(np.abs(values))])
    points = {name.format(share * top): CurvePoint(*curve, share * top) for share in SHARES}
    return {**scalars, **points}


def read(response: Response, quantities: Quantities) -> dict[str, float]:
    """Values of scalars and of points of the curve; those that are absent are left out."""
    values = {}
    for name, point in quantities.items():
        if point is None:
            if name in response:
                values[name] = float(response[name])
        elif point.variable in response and point.abscissa in response:
            # where the abscissa first gets as far, linear between the steps
            sign, at = (1.0 if point.at >= 0.0 else -1.0), abs(point.at)
            way, curve = sign * response[point.abscissa].values, response[point.variable].values
            reached = np.flatnonzero(way >= at * (1.0 - 1e-9))
            if reached.size:
                pair = [max(reached[0] - 1, 0), reached[0]]
                values[name] = float(np.interp(at, way[pair], curve[pair]))
    return values


def refined(model: Any, scenario: Any, solve: Callable[[Any], Response]) -> Response:
    """The answer of `solve`, with the uncertainty that the option `levels` of the model buys.

    For use inside a model's `simulate`. Failures of `solve` are raised. Coarser meshes that fail,
    or that warn of their own accuracy where the answer does not, are left out with all that are
    coarser still; without any the uncertainty is unknown.
    The response carries two attributes in JSON: `numerical_uncertainty`, quantity to absolute
    half-width in SI (null: unknown, the reason stands in the other), and `refinement` with the
    levels, all directions and the statements; and the main curve of every run.
    """
    response = solve(scenario)
    _Refinement(model, scenario, response, model.levels).attach()
    return response


@dataclass
class _Refinement:
    """The runs behind one answer."""

    model: Any
    scenario: Any
    response: Response
    levels: int
    statements: list[str] = field(default_factory=list)
    runs: dict[str, Response] = field(default_factory=dict)

    def attach(self) -> None:
        """Make the runs, and let the response carry what they say."""
        response = self.response
        main = default_quantities(self.scenario, response)
        quantities = {**main, **dict.fromkeys(scalars_of(response))}
        directions = self._run()
        runs = self.runs | {FINEST: response}
        values = {name: read(run, quantities) for name, run in runs.items()}
        by_run = {q: {run: of[q] for run, of in values.items() if q in of} for q in quantities}
        estimates = {q: estimate(directions, by_run[q]) for q in quantities}
        if self.levels == 1:
            self._state("one-mesh")
        unknown = [q for q in main if estimates[q].width is None]
        drifting = [q for q in main if _drifts(estimates[q])]
        doubts: list[Finding] = []
        if unknown and self.levels > 1:
            reasons = dict.fromkeys(self.statements or [estimates[q].note for q in unknown])
            names = ", ".join(unknown)
            doubts += [finding("refinement-unknown", names=names, reason=each) for each in reasons]
        if drifting:
            elastic = "dissipated" in response and float(response["dissipated"].max()) == 0.0
            more = () if elastic else ("localises",)
            doubts.append(finding("refinement-drifts", parts=more, names=", ".join(drifting)))
        widths = {q: estimates[q].width for q in quantities}
        basis: dict[str, Any] = {
            "levels": [mesh.refinement for mesh in self._meshes()],
            "directions": [asdict(direction) for direction in directions],
            "quantities": {
                q: _table(estimates[q], by_run[q]) | {"variable": point.variable if point else q}
                for q, point in quantities.items()
            },
            "quadrature": "fixed by the element, no option: part of space",
            "statements": list(dict.fromkeys([*self.statements, *(f.text for f in doubts)])),
        }
        set_attributes(response, **{WIDTHS: widths, BASIS: basis})
        attach_curves(response, self.runs)
        set_findings(response, [*doubts, *findings_of(response)])

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
        if "bow" in options and not model.upright:
            name = f"{FINEST}, bowed"  # coarse plates do not buckle
            directions.append(Direction(IMPERFECTION, (FINEST, name), 1.0))
            self._answer(name, replace(model, bow=model.bow + USUAL_BOW))
        return tuple(directions)

    def _meshes(self) -> list[Any]:
        """The model on each mesh, from coarse to fine, alone."""
        model = on_one_mesh(self.model)
        coarser = reversed(range(self.levels))
        return [replace(model, refinement=model.refinement - k) for k in coarser]

    def _answer(self, name: str, variant: Any, finer: Response | None = None) -> bool:
        """Answer with a variant; False, with a statement, if that cannot be relied on.

        `finer` is the answer on the next finer mesh, if the variant is a coarser one.
        """
        run: Response = variant.simulate(self.scenario)
        if outcome_of(run) is not Outcome.OK:
            outcome, message = outcome_of(run), run.attrs["message"]
            return self._state("run-failed", run=name, outcome=outcome, message=message)
        known = {finding.subject for finding in warnings_of(self.response)}
        doubts = [f for f in warnings_of(run) if f.subject in DOUBTS and f.subject not in known]
        for each in doubts:
            self._state("run-doubtful", run=name, doubt=each.subject, text=each)
        if doubts:
            return False
        fine = 0.0 if finer is None else finer.attrs.get("smallest_element", 0.0)
        if run.attrs.get("smallest_element", np.inf) < LEAST_COARSENING * fine:
            return self._state("no-coarser-mesh", run=name)
        self.runs[name] = run
        return True

    def _state(self, key: str, **values: Any) -> bool:
        """Keep the sentence of a finding on a run that is left out: False."""
        self.statements.append(finding(key, **values).text)
        return False


def _drifts(known: NumericalEstimate) -> bool:
    """Whether the meshes do not converge, by more than what is small anyway."""
    ladder = known.ladder
    if ladder is None or ladder.converging:
        return False
    return ladder.relative is None or ladder.relative > WELL_KNOWN


def _table(known: NumericalEstimate, values: Mapping[str, float]) -> dict[str, Any]:
    """An estimate and its values, as the attributes of a response hold them."""
    table: dict[str, Any] = {"values": values, "parts": dict(known.parts), "note": known.note}
    if known.ladder is not None:
        for name in ("order", "extrapolated", "converging", "accepted"):
            table[name] = getattr(known.ladder, name)
    return table
