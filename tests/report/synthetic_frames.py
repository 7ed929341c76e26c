"""A small study of frames whose models answer from closed forms, with snapshots and cycles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from builders import thesis_frame

from workbench.base.fields import Declared, Number, Text, checked
from workbench.models.base import respond
from workbench.responses import Finding, Response, build_response
from workbench.scenarios import (
    Frame,
    FrameGroundMotion,
    FrameImpact,
    FrameStatic,
    FrameStriker,
    Joint,
    Load,
    Member,
    Node,
    Scenario,
    cyclic_path,
)
from workbench.steel.hinges import YieldSurface
from workbench.steel.sections import find
from workbench.study import Case, Figure, Study

SNAPSHOTS, POINTS = 61, 9


@dataclass(frozen=True)
class SyntheticFrame(Declared, table="option"):
    """Answers from closed forms; `extent` is full, or bare: without snapshots and hinges."""

    gain: float = checked(Number(0.001, 10.0), 1.0)
    extent: str = checked(Text(), "full")

    name: ClassVar[str] = "synthetic-frame"
    version: ClassVar[int] = 1
    judged: ClassVar[bool] = False
    answers: ClassVar[tuple[str, ...]] = (
        FrameStatic.KIND,
        FrameImpact.KIND,
        FrameGroundMotion.KIND,
    )
    assumptions: ClassVar[tuple[str, ...]] = ("A swaying frame; no mechanics.",)
    sources: ClassVar[tuple[str, ...]] = ("heng2017",)

    def domain(self, scenario: Scenario) -> list[Finding]:
        """No findings."""
        return []

    def member_surface(self, frame: Frame, member: Member) -> YieldSurface:
        """The yield surface of a member's hinges."""
        properties = frame.properties(member)
        return YieldSurface(properties.squash_load, properties.plastic_moment, 1.0, 1.7)

    def simulate(self, scenario: Scenario) -> Response:
        """Answer by closed forms."""
        return respond(self, scenario, self._solve)

    def _solve(self, scenario) -> Response:
        if isinstance(scenario, FrameStatic):
            return self._push(scenario)
        time = np.linspace(0.0, scenario.duration, 901)
        if isinstance(scenario, FrameImpact):
            energy, top = scenario.input_energy, 0.4 * scenario.duration
            peak = self.gain * 0.2 * np.sqrt(energy / 1e6)
            moved = peak * np.sin(0.5 * np.pi * np.minimum(time / top, 1.0))
            moved += np.where(time > top, 0.03 * peak * (np.cos(400.0 * (time - top)) - 1.0), 0.0)
            scalars = {"peak_displacement": peak, "time_of_peak": top}
        else:
            moved = self.gain * 0.05 * np.sin(20.0 * time) * np.exp(-time)
            energy, scalars = 1e4, {"peak_displacement": None, "time_of_peak": None}
        share = np.minimum(np.abs(moved) / np.abs(moved).max(), 1.0) ** 2
        start = energy if isinstance(scenario, FrameImpact) else 0.0
        values = {
            "displacement": moved,
            "kinetic": start * 0.9 * (1.0 - share),
            "elastic": 1e3 + 0.1 * energy * share,
            "dissipated": 0.8 * energy * share,
            "contact_loss": np.full_like(time, 0.1 * start),
            "external_work": np.zeros_like(time) if start else 0.9 * energy * share,
            "balance_error": np.full_like(time, 1e-9 * energy),
            "input_energy": energy,
            **scalars,
        }
        return self._respond(scenario, values, time, moved, {"time": time})

    def _push(self, scenario: FrameStatic) -> Response:
        corners = np.concatenate([[0.0], scenario.path])
        moved = np.interp(
            np.linspace(0.0, len(corners) - 1.0, 60 * len(corners)),
            np.arange(len(corners)),
            corners,
        )
        strength = self.gain * 8e4
        force, stiffness = [0.0], strength / 0.01
        for step in np.diff(moved):  # elastic, perfectly plastic
            force.append(float(np.clip(force[-1] + stiffness * step, -strength, strength)))
        values = {
            "displacement": moved,
            "force": force,
            "load_factor": np.array(force) / scenario.magnitude,
            "elastic": np.array(force) ** 2 / (2.0 * stiffness),
            "dissipated": np.zeros_like(moved),
            "external_work": np.zeros_like(moved),
            "input_energy": 1.0,
        }
        steps = np.arange(len(moved))
        return self._respond(scenario, values, steps, moved, {"steps": len(moved)})

    def _respond(self, scenario, values, along, moved, history) -> Response:
        if self.extent == "bare":
            return build_response(values, **history)
        frame: Frame = scenario.frame
        at = np.unique(np.linspace(0, len(along) - 1, SNAPSHOTS - 1).round().astype(int))
        at = np.unique([*at, int(np.argmax(np.abs(moved)))])
        x, y = shapes(frame, target_of(scenario), moved[at])
        hinges = [f"{m.name}:{end}" for m in frame.members for end in ("start", "end")]
        reach = np.linspace(0.1, 1.4, len(hinges))[:, None]
        share = np.abs(moved) / np.abs(moved).max()
        strengths = [frame.properties(m) for m in frame.members for _ in range(2)]
        plastic = np.array([p.plastic_moment for p in strengths])[:, None]
        squash = np.array([p.squash_load for p in strengths])[:, None]
        m = np.clip(reach * np.sign(moved) * share, -0.97, 0.97)
        values |= {
            "shape_x": x,
            "shape_y": y,
            "snapshot_at": along[at],
            "utilisation": np.minimum(reach * share[at], 1.0),
            "moment": m * plastic,
            "axial_force": -0.15 * share * squash,
            "plastic_rotation": np.maximum(reach * share - 1.0, 0.0) * 0.05,
            "shear_utilisation": np.linspace(0.2, 0.7, len(frame.members)),
        }
        names = [member.name for member in frame.members]
        return build_response(values, hinges=hinges, segments=names, members=names, **history)


def target_of(scenario) -> str:
    """The node whose displacement is followed."""
    return scenario.striker.node if isinstance(scenario, FrameImpact) else scenario.node


def shapes(frame: Frame, target: str, moved: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A sway with a bump at the target: x and y (members, points, snapshots)."""
    node, share = frame.node(target), np.linspace(0.0, 1.0, POINTS)
    ends = [(frame.node(m.start), frame.node(m.end)) for m in frame.members]
    x = np.array([a.x + share * (b.x - a.x) for a, b in ends])[:, :, None]
    y = np.array([a.y + share * (b.y - a.y) for a, b in ends])[:, :, None]
    height = max(n.y for n in frame.nodes)
    sway = 0.15 * np.sin(0.5 * np.pi * y / height)
    bump = np.exp(-((x - node.x) ** 2) / 0.3 - (y - node.y) ** 2 / 1.5)
    here = 0.15 * np.sin(0.5 * np.pi * node.y / height)
    return x + (sway + (1.0 - here) * bump) * moved, y - 0.05 * bump * np.abs(moved)


def portal() -> Frame:
    """A portal with everything that a picture can show."""
    column, beam = find("HEB 220"), find("IPE 300")
    return Frame(
        (
            Node("A", 0.0, 0.0, "clamped"),
            Node("B", 0.0, 4.0, mass=500.0),
            Node("C", 3.0, 4.0),
            Node("D", 6.0, 4.0, spring_x=2e7, spring_rotation=1e6),
            Node("E", 6.0, 0.0, "pinned"),
        ),
        (
            Member("A-B", "A", "B", column),
            Member("B-C", "B", "C", beam, joint_start="semi"),
            Member("C-D", "C", "D", beam, joint_end="pinned"),
            Member("E-D", "E", "D", column),
        ),
        (Load("B", y=-1.2e5), Load("C", y=-4e4, moment=5e3), Load("D", y=-1.2e5)),
        (Joint("semi", rotational_stiffness=2e7, plastic_moment=1.2e5),),
    )


def storeys() -> Frame:
    """The frame of Heng 2017, figures 5.13 and 5.14: four bays, two storeys."""
    return thesis_frame().split("C0-C1", 0.8, "hit")


def frame_study(name: str = "frames") -> Study:
    """An impact on two storeys, a portal that is hit, cycled and shaken."""
    gate = portal()
    swing = tuple(0.3 * 9.81 * np.sin(np.linspace(0.0, 12.0, 40)))
    cases = (
        Case("storeys", FrameImpact("s", storeys(), FrameStriker(1500.0, 50.0, node="hit"), 0.05)),
        Case(
            "from above",
            FrameImpact("a", gate, FrameStriker(800.0, 6.0, node="C", direction="-y"), 0.05),
        ),
        Case(
            "cycles",
            FrameStatic(
                "c",
                gate,
                (Load("B", x=1e4), Load("C", y=-2e4)),
                "B",
                "x",
                cyclic_path((0.02, 0.04, 0.08), 3),
            ),
        ),
        Case("shaken", FrameGroundMotion("g", gate, swing, 0.02, "B")),
    )
    models = {
        "rigid": SyntheticFrame(gain=1.05),
        "flexible <b>": SyntheticFrame(gain=0.93),
        "bare": SyntheticFrame(gain=1.2, extent="bare"),
        "reference": SyntheticFrame(),
    }

    def figure(key: str, kind: str, shown: tuple[str, ...] = (), **options: object) -> Figure:
        return Figure(key, kind, f"{kind} of {key}", "A synthetic frame.", shown, options)

    figures = (
        figure("structure", "structure"),
        figure("deformed", "deformed", cases=("storeys",)),
        figure("stills", "deformed", ("rigid", "reference"), cases=("storeys",), layout="instants"),
        figure("loops", "force-displacement", cases=("cycles",)),
    )
    return Study(
        name,
        "Frames",
        "What do pictures of frames look like?",
        cases,
        models,
        "reference",
        quantities=("peak_displacement",),
        figures=figures,
    )
