"""A small study whose models answer from closed forms: every figure kind has something to show."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest
from builders import made_once

from workbench.base.errors import SolverError
from workbench.base.fields import Declared, Flag, Number, Text, checked
from workbench.models.base import respond
from workbench.responses import Finding, Response, build_response
from workbench.scenarios import Column, ColumnImpact, ColumnPushover, Scenario, Striker
from workbench.steel.sections import find
from workbench.study import Case, Figure, Study, run_study
from workbench.study.assessment import Gate
from workbench.study.assessor import Assessment, assess, read_assessment

HINGES = ("base", "impact point", "head")


@dataclass(frozen=True)
class Synthetic(Declared, table="option"):
    """Answers from closed forms. Options: see the fields; `extent` is full, scalars or curve."""

    gain: float = checked(Number(0.1, 10.0), 1.0)
    size: float = checked(Number(0.0, 10.0), 0.0)
    extent: str = checked(Text(), "full")
    fails_above: float = checked(Number(0.0, 1e3), 1e3)
    warns: bool = checked(Flag(), True)

    name: ClassVar[str] = "synthetic"
    version: ClassVar[int] = 1
    judged: ClassVar[bool] = False
    answers: ClassVar[tuple[str, ...]] = (ColumnImpact.KIND, ColumnPushover.KIND)
    assumptions: ClassVar[tuple[str, ...]] = ("A half sine & a cubic <curve>; no mechanics.",)
    sources: ClassVar[tuple[str, ...]] = ("heng2017", "a <strange> source")

    def domain(self, scenario: Scenario) -> list[Finding]:
        """A warning about short segments."""
        ratio = 1.44 / scenario.column.length_below
        if self.warns and ratio > 1.0:
            text = f"the segment below the impact point needs V/Vpl = {ratio:.2f}; no shear model"
            return [Finding("shear", text)]
        return []

    def simulate(self, scenario: Scenario) -> Response:
        """Answer by closed forms."""
        return respond(self, scenario, self._solve)

    def _solve(self, scenario: Scenario) -> Response:
        if isinstance(scenario, ColumnPushover):
            return self._push(scenario)
        velocity, column = scenario.striker.velocity, scenario.column
        if velocity > self.fails_above:
            raise SolverError("t = 0.0123 s", 3.2e-4, "halving the step 12 times")
        peak = self.gain * (1.0 + 0.05 * self.size) * 1.6e-3 * velocity**1.75
        top = 0.02 * (velocity / 10.0) ** 0.7
        if self.extent == "scalars":
            return build_response({"peak_displacement": peak})
        time = np.linspace(0.0, scenario.duration, 1501)
        rise = np.sin(0.5 * np.pi * np.minimum(time / top, 1.0))
        ring = np.where(time > top, 0.02 * (np.cos(250.0 * (time - top)) - 1.0), 0.0)
        moved = peak * (rise + ring)
        speed = np.gradient(moved, time)
        energy = scenario.input_energy
        share = rise**2
        lost = np.where(time > 0.0, 0.06, 0.0) * energy
        kinetic = np.maximum(0.94 * (1.0 - share), 0.0) * energy
        elastic = 0.05 * share * energy
        dissipated = energy - kinetic - elastic - lost
        properties = column.properties
        n = -column.axial_load / properties.squash_load + 0.6 * rise**2 * peak
        m = np.maximum(1.0 - np.abs(n) ** 1.3, 0.0) * np.minimum(time / (0.1 * top), 1.0)
        signs = np.array([1.0, -1.0, 1.0])[:, None]
        percussion = np.where(time < 0.5 * top, scenario.striker.mass * velocity, 0.0)
        percussion *= np.diff(time)[0] / (0.5 * top)
        return build_response(
            {
                "displacement": moved,
                "velocity": speed,
                "percussion": percussion,
                "shortening": moved**2 / column.length_below,
                "axial_force": np.tile(n, (3, 1)) * properties.squash_load,
                "moment": signs * m * properties.plastic_moment,
                "kinetic": kinetic,
                "elastic": elastic,
                "dissipated": dissipated,
                "contact_loss": lost,
                "external_work": np.zeros_like(time),
                "balance_error": np.full_like(time, 1e-9 * energy),
                "shear_utilisation": [1.44 / column.length_below, 0.45],
                "peak_displacement": peak,
                "time_of_peak": top,
                "residual_displacement": 0.96 * peak,
                "input_energy": energy,
            },
            time=time,
            hinges=HINGES,
            segments=("below", "above"),
        )

    def _push(self, scenario: ColumnPushover) -> Response:
        if self.extent == "scalars":
            raise SolverError("v = 0.1 m", 1.0, "nothing")
        moved = np.linspace(0.0, scenario.displacement, 241)
        force = 8e5 * np.tanh(moved / 0.006) + self.gain * 6e6 * moved**3
        return build_response(
            {
                "displacement": moved,
                "force": force,
                "shortening": moved**2 / scenario.column.length_below,
            },
            steps=len(moved),
        )


def columns() -> dict[str, Column]:
    """Columns that differ in support, section and load."""
    long = Column(
        find("HEB 220"),
        0.8,
        3.2,
        fillets=False,
        axial_load=0.5e6,
        restraint_stiffness=1e7,
    )
    pinned = replace(
        long,
        section=find("IPE 300"),
        base="pinned",
        head="pinned",
        restraint_stiffness=0.0,
        head_mass=120.0,
        length_below=1.5,
        length_above=1.5,
        axial_load=0.0,
    )
    return {"thesis": long, "pinned": pinned}


def small_study(name: str = "small") -> Study:
    """Impacts at three velocities and a pushover; a ladder, failures, estimates, gates."""
    column = columns()["thesis"]
    impacts = tuple(
        Case(
            f"{v} metres per second",
            ColumnImpact(f"impact at {v}", column, Striker(1500.0, float(v)), 0.06),
            figure="impacts",
        )
        for v in (10, 15, 20)
    )
    push = Case("push", ColumnPushover("push", column, 0.5), figure="pushes")
    models = {
        "four-dof": Synthetic(gain=1.01),
        "<i>single & dof": Synthetic(gain=0.95, extent="full", warns=False),
        "estimate": Synthetic(gain=1.03, extent="scalars"),
        "breaks": Synthetic(gain=1.2, fails_above=12.0),
        "reference over 4": Synthetic(size=4.0),
        "reference over 2": Synthetic(size=2.0),
        "reference": Synthetic(size=1.0),
    }
    gates = (
        _gate("four-dof", "peak_displacement", "relative_error", 0.2),
        _gate("estimate", "peak_displacement", "relative_error", 0.01),
        _gate("breaks", "peak_displacement", "relative_error", 0.5),
        _gate("four-dof", "displacement", "sprague_geers_comprehensive", 0.2),
        _gate("four-dof", "impulse", "relative_error", 0.2),
    )
    return Study(
        name,
        "Small <study> of an impacted column",
        "How far do the <b>closed forms</b> & their estimates agree? See [@heng2017].",
        (*impacts, push),
        models,
        "reference",
        ladder=("reference over 4", "reference over 2", "reference"),
        gates=gates,
        figures=(
            _figure("shape", "structure", group="impacts"),
            _figure("histories", "history", group="impacts"),
            _figure("impulses", "history", group="impacts", quantity="impulse"),
            _figure("peaks", "peaks", group="impacts"),
            _figure("bent", "deformed", group="impacts"),
            _figure("curves", "force-displacement", group="pushes"),
            _figure("paths", "interaction", group="impacts", surfaces=((1.0, 1.3),)),
            _figure("ledger", "energy", group="impacts"),
        ),
        notes=("The closed forms are no mechanics.", "The curve is `tanh` plus a cubic."),
    )


def sweep_study() -> Study:
    """A sweep over section, position, velocity and load, with warnings and failures."""
    cases = []
    for section in ("HEB 160", "HEB 300"):
        for position in (0.1, 0.2, 0.35, 0.5):
            for velocity in (5.0, 10.0, 20.0, 25.0):
                column = Column(find(section), 4.0 * position, 4.0 * (1.0 - position))
                name = f"{section}, {position:g} L, {velocity:g} mps"
                cases.append(
                    Case(
                        name,
                        ColumnImpact(name, column, Striker(1000.0, velocity), 0.05),
                        parameters={
                            "position (L)": position,
                            "velocity (m/s)": velocity,
                            "section": section,
                        },
                    )
                )
    return Study(
        "sweep",
        "Sweep of closed forms",
        "Where does each of them stop being trustworthy?",
        tuple(cases),
        {
            "four-dof": Synthetic(gain=1.05, fails_above=22.0),
            "single-dof": Synthetic(gain=0.87),
            "reference": Synthetic(),
        },
        "reference",
        quantities=("peak_displacement",),
        figures=(_figure("map", "sweep"),),
    )


def _gate(model: str, quantity: str, metric: str, bound: float) -> Gate:
    return Gate(
        model,
        "reference",
        quantity,
        metric,
        bound,
        "a tenth is what design can absorb",
        "heng2017",
    )


def _figure(key: str, kind: str, **options: object) -> Figure:
    title = f"{kind.replace('-', ' ').capitalize()} of the cases"
    return Figure(key, kind, title, f"What {kind} shows, after [@heng2017].", options=options)


def store_of(study: Study, root: Path) -> Assessment:
    """Run and assess a study in this process; return what a report reads."""
    directory = run_study(study, root, jobs=0).directory
    assess(study, root)
    return read_assessment(directory, study)


def shared_store_of(study: Study, factory: pytest.TempPathFactory) -> Assessment:
    """The same, run by one of the processes that test."""
    root = made_once(factory, study.name, lambda directory: store_of(study, directory))
    return read_assessment(root / study.name, study)
