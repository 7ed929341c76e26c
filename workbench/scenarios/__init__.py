"""What happens, independent of any model: frozen value objects, TOML in and out."""

from workbench.scenarios.column import (
    Column,
    ColumnImpact,
    ColumnPushover,
    MemberProperties,
    Striker,
)
from workbench.scenarios.files import (
    Scenario,
    apply_override,
    canonical,
    load_scenario,
    parse_value,
    scenario_from,
    scenario_hash,
    to_tables,
    to_toml,
)

__all__ = [
    "Column",
    "ColumnImpact",
    "ColumnPushover",
    "MemberProperties",
    "Scenario",
    "Striker",
    "apply_override",
    "canonical",
    "load_scenario",
    "parse_value",
    "scenario_from",
    "scenario_hash",
    "to_tables",
    "to_toml",
]
