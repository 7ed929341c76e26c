"""Small models for the tests of the runner; worker processes import them from this file."""

from __future__ import annotations

import os
import signal
import time
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from workbench.base.errors import Collapse, CollapseError, InputError, Mechanism, SolverError
from workbench.models.base import respond
from workbench.responses import Finding, Response, build_response
from workbench.scenarios import ColumnImpact, ColumnPushover, Scenario


@dataclass(frozen=True)
class Spring:
    """The striker on a linear spring; `error` is a relative error of first order in the step.

    Impacts faster than `above` m/s end in the `trouble` of `Troubled`.
    """

    stiffness: float = 5e6
    level: int = 0
    error: float = 0.0
    delay: float = 0.0
    trouble: str = ""
    above: float = 18.0

    name: ClassVar[str] = "toy-spring"
    version: ClassVar[int] = 1
    judged: ClassVar[bool] = False
    answers: ClassVar[tuple[str, ...]] = (ColumnImpact.KIND, ColumnPushover.KIND)
    assumptions: ClassVar[tuple[str, ...]] = ("Linear spring, no mass but the striker's.",)
    sources: ClassVar[tuple[str, ...]] = ()

    def domain(self, scenario: Scenario) -> list[Finding]:
        return [Finding("stiffness", "very soft")] if self.stiffness < 1e5 else []

    def simulate(self, scenario: Scenario) -> Response:
        return respond(self, scenario, self._solve)

    def _solve(self, scenario: Scenario) -> Response:
        if self.delay:
            time.sleep(self.delay)
        if self.trouble:
            Troubled(self.trouble, self.above)._solve(scenario)
        k = self.stiffness
        scale = 1.0 + self.error * 0.5**self.level
        if isinstance(scenario, ColumnPushover):
            d = np.linspace(0.0, scenario.displacement, 300)
            return build_response({"displacement": d, "force": scale * k * d}, steps=300)
        m, v0 = scenario.striker.mass, scenario.striker.velocity
        omega = float(np.sqrt(k / m))
        t = np.linspace(0.0, 0.9 * np.pi / omega, 400)
        d, v = scale * v0 / omega * np.sin(omega * t), v0 * np.cos(omega * t)
        kinetic, elastic = 0.5 * m * v**2, 0.5 * k * (d / scale) ** 2
        return build_response(
            {
                "displacement": d,
                "velocity": v,
                "kinetic": kinetic,
                "elastic": elastic,
                "dissipated": 0.0 * t,
                "external_work": 0.0 * t,
                "contact_loss": 0.0 * t,
                "balance_error": scenario.input_energy - kinetic - elastic,
                "peak_displacement": scale * v0 / omega,
                "time_of_peak": 0.5 * np.pi / omega,
                "input_energy": scenario.input_energy,
            },
            time=t,
        )


@dataclass(frozen=True)
class Troubled:
    """Ends in the way that `trouble` names, for impacts faster than `above` m/s."""

    trouble: str = "solver"
    above: float = 0.0
    seconds: float = 30.0

    name: ClassVar[str] = "toy-troubled"
    version: ClassVar[int] = 1
    judged: ClassVar[bool] = False
    answers: ClassVar[tuple[str, ...]] = (ColumnImpact.KIND,)
    assumptions: ClassVar[tuple[str, ...]] = ("None.",)
    sources: ClassVar[tuple[str, ...]] = ()

    def domain(self, scenario: Scenario) -> list[Finding]:
        return [Finding("toy", "refuses everything", True)] if self.trouble == "refuse" else []

    def simulate(self, scenario: Scenario) -> Response:
        if self.trouble == "raise":
            return self._solve(scenario)
        return respond(self, scenario, self._solve)

    def _solve(self, scenario: ColumnImpact) -> Response:
        if scenario.striker.velocity > self.above:
            if self.trouble == "kill":
                os.kill(os.getpid(), signal.SIGKILL)
            if self.trouble == "exit":
                os._exit(3)
            if self.trouble == "hang":
                time.sleep(self.seconds)
            if self.trouble == "solver":
                raise SolverError("t = 0.01 s", 0.5, "everything")
            if self.trouble == "collapse":
                parts = ("below",)
                collapse = Collapse(Mechanism.GEOMETRY, parts, 0.5, 0.02)
                raise CollapseError(collapse, "nothing holds it")
            if self.trouble == "no peak":
                growing = {"displacement": [0.0, 0.1], "percussion": [0.0, 1.0]}
                return build_response(growing, time=[0.0, 0.01])
            if self.trouble == "input":
                raise InputError("toy.option", 1, "must be 2")
            if self.trouble == "raise":
                raise ZeroDivisionError("division by zero")
            if self.trouble == "nan":
                return build_response({"peak_displacement": float("nan")})
        return build_response({"peak_displacement": 0.1})
