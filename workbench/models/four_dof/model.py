"""The impacted column as two rigid bars and four generalized hinges, with four unknowns.

Heng 2017, section 5.1: hinges at the base (1), on both sides of the hit point (2, 3) and at the
head (4). Large rotations are exact. Each hinge of a bar of length l has the rotational stiffness
6 EI / l and shares the axial stiffness EA / l of the bar with the other one; a bar with one
pinned end has the single stiffness 3 EI / l at the other. The impact mass m1 (a third of the
column) sits at the hit point, the head mass at the head.
"""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from workbench.errors import OutOfDomainError, SolverError
from workbench.fields import Choice, Flag, Number, check_fields, checked
from workbench.hinges import YieldSurface
from workbench.models.base import respond
from workbench.models.domain import member_findings
from workbench.models.four_dof import _impact_kernels, _kernels
from workbench.responses import Finding, Response, build_response
from workbench.scenarios import Column, ColumnImpact, ColumnPushover, ColumnScenario, Scenario

Array = NDArray[np.float64]
HINGES = ("base", "hit-below", "hit-above", "head")
SEGMENTS = ("below", "above")
_SCHEMES = {
    "midpoint": _impact_kernels.MIDPOINT,
    "moreau": _impact_kernels.MOREAU,
    "gear-gupta-leimkuhler": _impact_kernels.GEAR_GUPTA_LEIMKUHLER,
}
_BALANCE = 1e-7  # of the input energy; the midpoint step is refined until its ledger closes
_PUSH_STEP = 5e-4  # m, changes the static force by less than 0.02 %
_SHORTEST_STEP = 1e-8  # s


@dataclass(frozen=True)
class FourDof:
    """Four-degree-of-freedom column.

    Options: `alpha`, `beta`: exponents of the yield surface (None: fitted to the exact N-M
    envelope of the section and stated to one decimal, as the thesis does);
    `rotational_stiffness`: factor c of c EI / l of a hinge (the thesis: 6); `integrator`;
    `time_step` in s (None: a fifth of the inverse of the highest axial frequency, finer with
    restitution, refined until the energy balance closes to 1e-7); `small_rotations`: the
    kinematics of the SDOF model; `spring_shares_load`: the restraint spring is there before the
    axial load comes on.
    """

    alpha: float | None = checked(Number(1.0, 20.0), optional=True)
    beta: float | None = checked(Number(1.0, 20.0), optional=True)
    rotational_stiffness: float = checked(Number(0.1, 1e6), 6.0)
    integrator: str = checked(Choice(tuple(_SCHEMES)), "midpoint")
    time_step: float | None = checked(Number(_SHORTEST_STEP, 1.0, "s"), optional=True)
    small_rotations: bool = checked(Flag(), False)
    spring_shares_load: bool = checked(Flag(), False)

    name: ClassVar[str] = "four-dof"
    version: ClassVar[int] = 1
    answers: ClassVar[tuple[str, ...]] = (ColumnImpact.KIND, ColumnPushover.KIND)
    assumptions: ClassVar[tuple[str, ...]] = (
        "Two rigid bars; all flexibility and plasticity in four generalized hinges.",
        "Hinge stiffness 6EI/l: the elastic lateral stiffness is exact for a hit at mid-height "
        "and too stiff for an eccentric hit (36 % for the thesis column).",
        "Elastic-perfectly plastic hinges with associated flow on a super-elliptic N-M surface; "
        "the thesis does not print its exponents, (1, 1.3) are inferred from its section.",
        "One third of the column's mass acts at the hit point; bending waves are left out.",
        "No shear deformation, no shear yielding, no local buckling, no strain-rate effect.",
    )
    sources: ClassVar[tuple[str, ...]] = ("heng2017",)

    def __post_init__(self) -> None:
        check_fields(self, "option")

    def surface(self, column: Column) -> YieldSurface:
        """The yield surface of all hinges of the column."""
        properties = column.properties
        fitted = YieldSurface.fit(column.strength_section, column.steel, decimals=1)
        return YieldSurface(
            properties.squash_load,
            properties.plastic_moment,
            fitted.alpha if self.alpha is None else self.alpha,
            fitted.beta if self.beta is None else self.beta,
        )

    def domain(self, scenario: ColumnScenario) -> list[Finding]:
        """Findings common to all member models, and the step limit of the explicit scheme."""
        findings = member_findings(scenario)
        if isinstance(scenario, ColumnImpact) and self.integrator == "moreau" and self.time_step:
            limit = 0.3 * 2.0 / self._highest_frequency(scenario.column)
            if self.time_step > limit:
                text = (
                    f"option.time_step = {self.time_step:g} s is above 0.3 of the stability "
                    f"limit of the explicit scheme, {limit:.3g} s: reduce it"
                )
                findings.append(Finding("time-step", text, refusal=True))
        return findings

    def simulate(self, scenario: Scenario) -> Response:
        """Answer a column pushover or a column impact."""
        return respond(self, scenario, self._solve)

    def _solve(self, scenario: ColumnScenario) -> Response:
        if isinstance(scenario, ColumnPushover):
            return self._pushover(scenario)
        return self._impact(scenario)

    def _assembly(self, column: Column) -> tuple[dict[str, Any], Array]:
        """Arrays of the kernels and the preloaded state q (straight column under its load)."""
        properties, surface = column.properties, self.surface(column)
        lengths = np.array([column.length_below, column.length_above])
        pinned = (column.base == "pinned", column.head == "pinned")
        axial = column.steel.elastic_modulus * properties.area / lengths
        bending = column.steel.elastic_modulus * properties.second_moment / lengths
        factor = self.rotational_stiffness
        stiffness = np.array(
            [
                [axial[i], 0.0 if pinned[i] else factor * bending[i], factor * bending[i]]
                for i in range(2)
            ]
        )
        for i in range(2):
            if pinned[i]:
                stiffness[i, 2] *= 0.5  # 3 EI / l: the far end turns freely
        flexibility = float(np.sum(1.0 / axial))
        spring = column.restraint_stiffness if column.head != "fixed" else 0.0
        load = column.axial_load
        if self.spring_shares_load:
            force = load / (1.0 + spring * flexibility)
            unstressed = 0.0
        else:
            force = load
            unstressed = -load * flexibility
        q = np.array([0.0, -force / axial[0], 0.0, -force * flexibility])
        kernel = {
            "lengths": lengths,
            "stiffness": stiffness,
            "bounds": np.array([surface.axial_bounds] + [surface.moment_bounds] * 2),
            "exponents": np.array([surface.alpha, surface.beta]),
            "small": self.small_rotations,
            "free_u2": column.head != "fixed",
            "head": np.array([load, spring, unstressed]),
        }
        return kernel, q

    def _highest_frequency(self, column: Column) -> float:
        """Bound of the highest (axial) circular frequency, in rad/s."""
        kernel, _ = self._assembly(column)
        axial = kernel["stiffness"][:, 0]
        square = float(np.sum(axial)) / column.properties.impact_mass
        if column.head_mass > 0.0 and column.head != "fixed":
            head = (axial[1] + column.restraint_stiffness) / column.head_mass
            square = max(square, head)
        return float(np.sqrt(square))

    def _pushover(self, scenario: ColumnPushover) -> Response:
        column = scenario.column
        kernel, q = self._assembly(column)
        steps = max(200, int(np.ceil(scenario.displacement / _PUSH_STEP)))
        path = np.linspace(0.0, scenario.displacement, steps + 1)[1:]
        records = np.zeros((steps + 1, 12))
        records[0, :4] = q
        records[0, [5, 8]] = -column.axial_load if not self.spring_shares_load else (
            q[_kernels.U1] * kernel["stiffness"][0, 0]
        )  # fmt: skip
        status, last, residual = _kernels.pushover(
            path, **kernel, q=q, plastic=np.zeros((2, 3)), records=records[1:]
        )
        if status != _kernels.OK:
            raise SolverError(
                f"displacement {path[last]:.5g} m", residual, "increments down to 1/1024"
            )
        state, stress = records[:, :4], records[:, 5:11].reshape(-1, 2, 3)
        external = np.concatenate(
            [[0.0], np.cumsum(0.5 * (records[1:, 4] + records[:-1, 4]) * np.diff(state[:, 0]))]
        )
        dead = -column.axial_load * (state[:, 3] - state[0, 3])
        elastic = np.array(
            [
                _kernels.elastic_energy(forces, kernel["stiffness"], kernel["head"], u2)
                for forces, u2 in zip(stress, state[:, 3], strict=True)
            ]
        )
        values: dict[str, Any] = {
            "displacement": state[:, 0],
            "force": records[:, 4],
            "shortening": -state[:, 3],
            "elastic": elastic,
            "dissipated": records[:, 11],
            "external_work": external + dead,
            "input_energy": external[-1],
            **self._hinge_values(column, kernel, state, stress, None),
        }
        return build_response(values, steps=steps + 1, hinges=HINGES, segments=SEGMENTS)

    def _impact(self, scenario: ColumnImpact) -> Response:
        started = perf_counter()
        frequency = self._highest_frequency(scenario.column)
        share = 0.2 if scenario.striker.restitution == 0.0 else 0.05
        step = min(self.time_step or share / frequency, scenario.duration / 20)
        error = np.inf
        for _ in range(5):
            records, time = self._march(scenario, step)
            total = records[:, 19] + records[:, 20] + records[:, 21] + records[:, 22]
            dead = -scenario.column.axial_load * (records[:, 3] - records[0, 3])
            balance = total[0] + dead - total
            error = float(np.max(np.abs(balance))) / scenario.input_energy
            exact = self.integrator == "midpoint" and self.time_step is None
            if not exact or error < _BALANCE:
                solved = perf_counter() - started
                response = self._impact_response(scenario, time, records, balance, dead)
                response.attrs["solve_time"] = solved
                return response
            step *= 0.5
        raise SolverError("the energy balance", error, f"steps down to {2 * step:.2g} s")

    def _march(self, scenario: ColumnImpact, step: float) -> tuple[Array, Array]:
        """Records (steps + 1, columns of the kernel) and times of one run."""
        column, striker = scenario.column, scenario.striker
        kernel, q = self._assembly(column)
        steps = int(np.ceil(scenario.duration / step))
        step = scenario.duration / steps
        records = np.zeros((steps + 1, _impact_kernels.COLUMNS))
        masses = np.array([column.properties.impact_mass, column.head_mass, striker.mass])
        status, last, residual, cuts = _impact_kernels.impact(
            _SCHEMES[self.integrator], steps, step, striker.velocity, masses,
            striker.restitution, q=q, records=records, **kernel,
        )  # fmt: skip
        if status == _kernels.NO_CONVERGENCE:
            raise SolverError(
                f"time {last * step:.6g} s (step {last} of {step:.3g} s)",
                residual,
                f"nested rotation balance, line search and 64 substeps ({cuts} cuts in all)",
            )
        if status == _kernels.COLLAPSE:
            raise OutOfDomainError(
                f"collapse at {last * step:.4g} s and {records[last, 0]:.4g} m: a bar reaches its "
                "squash load or the displacement nine tenths of the shorter segment; the model "
                "means nothing beyond"
            )
        return records, np.linspace(0.0, scenario.duration, steps + 1)

    def _impact_response(
        self,
        scenario: ColumnImpact,
        time: Array,
        records: Array,
        balance: Array,
        dead_work: Array,
    ) -> Response:
        column = scenario.column
        kernel, _ = self._assembly(column)
        state, stress = records[:, :4], records[:, 7:13].reshape(-1, 2, 3)
        plastic = records[:, 13:19].reshape(-1, 2, 3)
        values: dict[str, Any] = {
            "displacement": state[:, 0],
            "velocity": records[:, 4],
            "striker_velocity": records[:, 5],
            "percussion": records[:, 6],
            "force": records[:, 23],
            "shortening": -state[:, 3],
            "kinetic": records[:, 19],
            "elastic": records[:, 20],
            "dissipated": records[:, 21],
            "contact_loss": records[:, 22],
            "external_work": dead_work,
            "balance_error": balance,
            "input_energy": scenario.input_energy,
            **self._hinge_values(column, kernel, state, stress, plastic),
        }
        return build_response(values, time=time, hinges=HINGES, segments=SEGMENTS)

    @staticmethod
    def _hinge_values(
        column: Column, kernel: dict[str, Any], state: Array, stress: Array, plastic: Array | None
    ) -> dict[str, Any]:
        """Forces of the four hinges and the shear of the two bars from a record."""
        v, u1, u2 = state[:, 0], state[:, 1], state[:, 3]
        chords = np.hypot(
            np.stack([column.length_below + u1, column.length_above + u2 - u1]), v[None, :]
        )
        shear = np.abs(stress[:, :, 1] - stress[:, :, 2]).T / chords
        values = {
            "axial_force": stress[:, [0, 0, 1, 1], 0].T,
            "moment": np.stack(
                [stress[:, 0, 1], stress[:, 0, 2], stress[:, 1, 2], stress[:, 1, 1]]
            ),
            "shear_utilisation": shear.max(axis=1) / column.properties.shear_resistance,
        }
        if plastic is not None:
            values["plastic_rotation"] = np.stack(
                [plastic[:, 0, 1], plastic[:, 0, 2], plastic[:, 1, 2], plastic[:, 1, 1]]
            )
        return values
