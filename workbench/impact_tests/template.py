"""The template of a table of impact tests."""

from workbench.impact_tests.schema import IMPACTS
from workbench.studs.templates import Template

_COLUMNS = {  # with the unit that the template has; it may be changed
    **dict.fromkeys(("campaign", "specimen", "section"), ""),
    **{"span_m": "m", "hit_at_m": "m", "base": "", "head": "", "axial_load_N": "kN"},
    **{"yield_stress_Pa": "MPa", "mass_kg": "kg", "velocity_m_per_s": "m/s"},
    **{"peak_m": "mm", "peak_uncertainty_m": "mm"},
    **{"residual_m": "mm", "residual_uncertainty_m": "mm"},
    **dict.fromkeys(("source", "licence", "year", "role"), ""),
}
TEMPLATE = Template(
    "Impact tests on steel columns and beams, one row per test",
    IMPACTS,
    tuple(_COLUMNS),
    (
        *("height_m", "width_m", "web_m", "flange_m", "side_m", "wall_m", "diameter_m"),
        *("restraint_N_per_m", "head_mass_kg", "elastic_modulus_Pa", "restitution", "duration_s"),
        "collapse",
        *("source_locator", "flag"),
    ),
    "data add FILE.csv",
    (
        "our lab,B1,IPE 200,3.0,1.5,pinned,pinned,0,371,500,4.0,45,2,33,2,Report 12,CC BY 4.0,2026,"
        "validate",
        "our lab,C1,HEB 160,3.0,1.5,clamped,guided,150,382,1000,5.0,47,2,36,2,Report 12,CC BY 4.0,"
        "2026,validate",
    ),
    (
        "The second line holds units, which may be changed; ranges above are in SI.",
        "Numbers without source and licence are not taken.",
    ),
    tuple(_COLUMNS.values()),
)
