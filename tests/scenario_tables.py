"""A good and complete table of every kind of scenario, and changes in any place of it."""

from __future__ import annotations

from typing import Any

COLUMN: dict[str, Any] = {
    "column": {
        "section": {"height": 0.3, "width": 0.2, "web": 0.01, "flange": 0.015, "fillet": 0.02},
        "length_below": 0.8, "length_above": 3.2, "fillets": False, "base": "pinned",
        "head": "fixed", "axial_load": 2e5, "restraint_stiffness": 1e7, "head_mass": 100.0,
        "area": 9e-3, "second_moment": 8e-5, "plastic_moment": 3e5, "squash_load": 3e6,
        "mass_per_length": 70.0, "impact_mass": 90.0,
    },
    "steel": {"elastic_modulus": 210e9, "yield_stress": 355e6, "density": 7850.0},
}  # fmt: skip
STRIKER = {"mass": 1500.0, "velocity": 15.0, "restitution": 0.2}
LOAD = {"node": "top", "x": 1e3, "y": -1e4, "moment": 5.0}
FRAME: dict[str, Any] = {
    "frame": {"fillets": True},
    "steel": COLUMN["steel"],
    "node": [
        {"name": "foot", "x": 0.0, "y": 0.0, "support": "clamped"},
        {"name": "top", "x": 1.0, "y": 4.0, "mass": 10.0, "rotary_inertia": 1.0, "spring_x": 1e5,
         "spring_y": 1e5, "spring_rotation": 1e5, "locked": "none"},
    ],
    "member": [
        {"name": "post", "start": "foot", "end": "top", "section": {"side": 0.2},
         "joint_start": "soft", "joint_end": "rigid",
         **{key: COLUMN["column"][key] for key in ("area", "second_moment", "plastic_moment")},
         **{key: COLUMN["column"][key] for key in ("squash_load", "mass_per_length")}},
    ],
    "joint": [
        {"name": "soft", "rotational_stiffness": 2e6, "axial_stiffness": 1e9,
         "plastic_moment": 1e5, "plastic_moment_negative": 1e5, "tension_resistance": 1e6,
         "compression_resistance": 1e6},
    ],
    "load": [LOAD],
    "split": [{"member": "post", "at": 1.0, "node": "hit"}],
}  # fmt: skip
REGULAR: dict[str, Any] = {
    "frame": {"bays": [6.0, 5.0], "storeys": [4.0], "column": "HEB 220", "beam": {"diameter": 0.3,
              "wall": 0.01}, "base": "pinned", "beam_joint": "soft", "fillets": False},
    "joint": [{"name": "soft", "rotational_stiffness": 2e6}],
    "split": [{"member": "A0-A1", "at": 0.8, "node": "hit"}],
}  # fmt: skip
GROUND = {"acceleration": [0.0, 1.0, -1.0], "time_step": 0.02, "node": "hit", "direction": "x",
          "load_as_mass": True}  # fmt: skip
TESTS = {"asked": "strength", "tables": ["stud-push-out"], "curves": ["stud-load-slip"],
         "calibrate": ["a"], "validate": ["b"], "confidence": 0.9, "digests": []}  # fmt: skip
PULSE = {"shape": "friedlander", "peak": 1e5, "length": 0.01, "decay": 1.5}
FLIGHT = {**STRIKER, "node": "hit", "direction": "-x"}
SCENARIOS: dict[str, dict[str, Any]] = {
    "pushover": {"kind": "column-pushover", **COLUMN, "pushover": {"displacement": 0.1}},
    "impact": {"kind": "column-impact", **COLUMN, "striker": STRIKER, "time": {"duration": 0.1}},
    "static": {"kind": "frame-static", **FRAME, "pattern": [LOAD],
               "push": {"node": "top", "direction": "-x", "path": [0.1, -0.1],
                        "control": "displacement"}},
    "frame": {"kind": "frame-impact", **FRAME, "striker": FLIGHT, "time": {"duration": 0.1}},
    "regular": {"kind": "frame-impact", **REGULAR, "striker": FLIGHT, "time": {"duration": 0.1}},
    "ground": {"kind": "frame-ground-motion", **FRAME, "ground": {**GROUND, "damping": 0.1},
               "time": {"duration": 1.0}},
    "pulse": {"kind": "member-pulse", **COLUMN, "pulse": {**PULSE, "load": "uniform"},
              "time": {"duration": 0.1}},
    "frame-pulse": {"kind": "frame-pulse", **FRAME, "pattern": [LOAD],
                    "pulse": {**PULSE, "node": "hit", "direction": "+x", "members": []},
                    "time": {"duration": 0.1}},
    "studs": {"kind": "stud-tests", "tests": TESTS},
}  # fmt: skip


def places(tables: Any, before: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Paths of all tables, entries and values in nested tables."""
    keys = tables if isinstance(tables, dict) else range(len(tables))
    values = []
    for key in keys:
        values.append((*before, key))
        if isinstance(tables[key], (dict, list)):
            values += places(tables[key], (*before, key))
    return values


def put(tables: Any, place: tuple[Any, ...], value: Any) -> Any:
    """The tables with another value in one place."""
    changed = dict(tables) if isinstance(tables, dict) else list(tables)
    key, *rest = place
    changed[key] = put(changed[key], tuple(rest), value) if rest else value
    return changed
