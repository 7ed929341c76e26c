"""The standard variables of a response; ``variables.csv`` holds them all.

Names, dimensions, SI units, meanings, and what each belongs to: ``coordinate``, ``structure``, what
only strikers that crush have, ``crushing``, or ``stud-tests`` and ``integrators``, the pure numbers
by which models of studs and schemes of time integration are judged. Dimension ``history`` is `time`
in an impact and `step` in a pushover.
"""

import hashlib
from pathlib import Path
from typing import NamedTuple

from workbench.base.tables import records

HISTORY = "history"


class Variable(NamedTuple):
    """Dimensions, SI unit and plain name of a response variable."""

    dims: tuple[str, ...]
    units: str
    long_name: str

    @property
    def attributes(self) -> dict[str, str]:
        """Attributes of a stored variable."""
        return {"units": self.units, "long_name": self.long_name}


_TABLE = Path(__file__).with_suffix(".csv").read_text(encoding="utf-8")
# answers of other tables are old; no answer to a rigid striker lacks what is of those that crush
_OF_ALL = "".join(row for row in _TABLE.splitlines(True) if not row.startswith("crushing,"))
TABLE_DIGEST = hashlib.sha256(_OF_ALL.encode()).hexdigest()[:16]


def _read(*of: str) -> dict[str, Variable]:
    return {
        row["name"]: Variable(tuple(row["dimensions"].split()), row["units"], row["meaning"])
        for row in records(_TABLE)
        if row["of"] in of
    }


COORDINATES = _read("coordinate")
VARIABLES = _read("structure", "crushing", "stud-tests", "integrators")
STUD_TESTS, INTEGRATORS = tuple(_read("stud-tests")), tuple(_read("integrators"))
SCALARS = tuple(name for name, variable in VARIABLES.items() if not variable.dims)
ENERGIES = tuple(n for n, v in VARIABLES.items() if v.units == "J" and v.dims == (HISTORY,))

# Attributes that differ from run to run; all others repeat exactly.
TIMES = ("wall_time", "solve_time")  # s: the whole answer, and solving the equations alone
VOLATILE = ("provenance", *TIMES)
