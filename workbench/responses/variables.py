"""The standard variables of a response: names, dimensions, units, meaning, in one table."""

from typing import NamedTuple


class Variable(NamedTuple):
    """Dimensions, SI unit and plain name of a response variable."""

    dims: tuple[str, ...]
    units: str
    long_name: str


# By which models of studs are judged: pure numbers over the judged tests.
STUD_TESTS: dict[str, str] = {
    "tests_fitted": "tests that a fit has used",
    "fitted_test_over_prediction": "median of test over prediction in the tests fitted",
    "test_over_prediction": "median of test over prediction in tests not used by a fit",
    "least_test_over_prediction": "smallest test over prediction in tests not used by a fit",
    "stiffness_test_over_prediction": "median of stiffness, test over prediction, in tests not "
    "used by a fit",
    "coverage": "share of the tests not used by a fit that lie inside the band",
}

COORDINATES: dict[str, Variable] = {
    "time": Variable(("time",), "s", "time after first contact"),
    "step": Variable(("step",), "1", "load step"),
    "hinge": Variable(("hinge",), "1", "plastic hinge (or section watched for plasticity)"),
    "segment": Variable(("segment",), "1", "member segment"),
    "member": Variable(("member",), "1", "member of the frame"),
    "point": Variable(("point",), "1", "place along the member, 0 at its start, 1 at its end"),
    "snapshot": Variable(("snapshot",), "1", "number of the snapshot"),
    "run": Variable(("run",), "1", "run that the numerical uncertainty rests on"),
}

# Histories stand over `time` in an impact and over `step` in a pushover.
HISTORY = "history"

VARIABLES: dict[str, Variable] = {
    "displacement": Variable((HISTORY,), "m", "displacement of the hit point along the strike"),
    "velocity": Variable((HISTORY,), "m/s", "velocity of the hit point along the strike"),
    "run_displacement": Variable(("run", HISTORY), "m", "displacement in each further run"),
    "run_force": Variable(("run", HISTORY), "N", "force in each further run"),
    "force": Variable((HISTORY,), "N", "force on the hit point along the strike"),
    "load_factor": Variable((HISTORY,), "1", "factor on the pattern of loads"),
    "percussion": Variable((HISTORY,), "N s", "contact impulse of the time step"),
    "striker_velocity": Variable((HISTORY,), "m/s", "velocity of the striker"),
    "shortening": Variable((HISTORY,), "m", "shortening of the column at its head"),
    "axial_force": Variable(("hinge", HISTORY), "N", "axial force, tension positive"),
    "moment": Variable(("hinge", HISTORY), "N m", "bending moment"),
    "plastic_rotation": Variable(("hinge", HISTORY), "rad", "plastic rotation"),
    "kinetic": Variable((HISTORY,), "J", "kinetic energy of column and striker"),
    "elastic": Variable((HISTORY,), "J", "stored elastic energy"),
    "dissipated": Variable((HISTORY,), "J", "plastic (and algorithmic) dissipation so far"),
    "external_work": Variable((HISTORY,), "J", "work of dead loads and imposed forces so far"),
    "contact_loss": Variable((HISTORY,), "J", "energy lost in contact so far"),
    "balance_error": Variable((HISTORY,), "J", "energy input less stored, lost and dissipated"),
    "shear_utilisation": Variable(("segment",), "1", "largest shear force over V_pl"),
    "snapshot_at": Variable(("snapshot",), "1", "time (s) or step of the snapshot"),
    "shape_x": Variable(("member", "point", "snapshot"), "m", "place of the deformed axis along x"),
    "shape_y": Variable(("member", "point", "snapshot"), "m", "place of the deformed axis along y"),
    "utilisation": Variable(("hinge", "snapshot"), "1", "utilisation of the hinge in N and M"),
    "peak_displacement": Variable((), "m", "largest displacement of the hit or pushed point"),
    "time_of_peak": Variable((), "s", "time of the largest displacement"),
    "residual_displacement": Variable((), "m", "permanent displacement of the hit point"),
    "peak_force": Variable((), "N", "largest contact force, mean over 1 ms"),
    "resistance": Variable((), "N", "largest force of a static loading, either way"),
    "impulse": Variable((), "N s", "total impulse of the contact"),
    "input_energy": Variable((), "J", "energy brought in: striker, or work of the push"),
    **{name: Variable((), "1", meaning) for name, meaning in STUD_TESTS.items()},
}

# Attributes that differ from run to run; all others repeat exactly.
TIMES = ("wall_time", "solve_time")  # s: the whole answer, and solving the equations alone
VOLATILE = ("provenance", *TIMES)

SCALARS = tuple(name for name, variable in VARIABLES.items() if not variable.dims)
ENERGIES = (
    "kinetic",
    "elastic",
    "dissipated",
    "external_work",
    "contact_loss",
    "balance_error",
)
