"""Commented templates of tables of tests: what to fill in, what it means, and an example that runs.

A template is CSV whose comments stand above the header; the reader passes over them.
"""

from collections.abc import Iterator
from typing import NamedTuple

from workbench.fields import Choice, Text
from workbench.studs.reading import COMMENT
from workbench.studs.schema import POINTS, TESTS, Table

_TEST = ("campaign", "specimen", "test")
_STUD = ("diameter_mm", "height_mm", "fcm_MPa", "fu_MPa")
_DAMAGE = ("predamage", "predamage_measure", "predamage_level")
_DECK = ("deck_depth_mm", "deck_width_mm", "deck_thickness_mm", "studs_per_rib", "deck_fixing")
_CYCLES = (
    *("predamage", "predamage_cycles", "predamage_range_kN", "predamage_peak_kN"),
    *("predamage_frequency_Hz", "predamage_life_cycles"),
)


class Template(NamedTuple):
    """What a table is for: its `title`, columns and example `rows`; `verb` that takes it.

    `more`, columns that help and may be added; `notes`, what columns alone do not tell; `units`, a
    second line for names without units (empty: the names hold them).
    """

    title: str
    schema: Table
    columns: tuple[str, ...]
    more: tuple[str, ...]
    verb: str
    rows: tuple[str, ...]
    notes: tuple[str, ...] = ()
    units: tuple[str, ...] = ()

    @property
    def text(self) -> str:
        """The whole template: comments, the header, and the line of units if there is one."""
        lines = (f"{COMMENT} {line}".rstrip() for line in _comments(self))
        header = ",".join(_shown(self, name) for name in self.columns)
        return "\n".join([*lines, header, *([",".join(self.units)] if self.units else [])]) + "\n"


TEMPLATES = {
    "strength": Template(
        "Push-out tests of undamaged headed studs, one row per specimen",
        TESTS,
        (*_TEST, *_STUD, "slab", "shear_kN", "slip_at_max_mm"),
        ("Ecm_MPa", "n_studs", "total_load_kN", "shear_uncertainty_kN", "failure_mode", "role"),
        "fit stud-strength FILE.csv --report FILE.html",
        (
            "our lab,A1,push-out,19,100,31.2,472,solid,104.5,7.1",
            "our lab,A2,push-out,19,100,31.2,472,solid,109.8,8.0",
            "our lab,A3,push-out,19,100,31.2,472,solid,101.9,6.4",
            "our lab,B1,push-out,22,125,31.2,468,solid,137.0,7.4",
        ),
        ("Three nominally equal specimens or more make a series of EN 1994-1-1 Annex B.",),
    ),
    "load-slip": Template(
        "Points of load-slip curves, one row per point",
        POINTS,
        ("campaign", "specimen", "slip_mm", "load_kN"),
        ("branch", "use_for_fit"),
        "fit load-slip FILE.csv --report FILE.html",
        (
            *(
                "our lab,A1,0.3,45",
                "our lab,A1,1.0,78",
                "our lab,A1,3.0,98",
                "our lab,A1,7.1,104.5",
            ),
            *("our lab,A2,0.3,50", "our lab,A2,1.0,80", "our lab,A2,3.0,101", "our lab,A2,8,109.8"),
        ),
        ("A curve goes on to its largest load; the points of a specimen make one curve.",),
    ),
    "residual": Template(
        "Tests after static pre-damage, one row per specimen",
        TESTS,
        (*_TEST, *_STUD, "shear_kN", *_DAMAGE, "undamaged_shear_kN"),
        ("stiffness_10_40_kN_per_mm", "undamaged_stiffness_kN_per_mm", "undamaged_basis"),
        "fit residual FILE.csv --report FILE.html",
        (
            "our lab,A1,push-out,19,100,31.2,472,104.5,none,,,",
            "our lab,D1,push-out,19,100,31.2,472,99.0,push-out,displacement ratio,0.3,",
            "our lab,D2,push-out,19,100,31.2,472,91.0,push-out,displacement ratio,0.6,",
            "our lab,D3,push-out,19,100,31.2,472,84.0,push-out,displacement ratio,0.9,",
            "our lab,D4,push-out,19,100,31.2,472,70.0,push-out,displacement ratio,1.3,104.5",
        ),
        (
            "Level 1 is what an undamaged stud bears; above 1 the stud was driven beyond it.",
            "The reference is undamaged_shear_kN, or undamaged specimens (predamage none) of the",
            "same campaign and diameter. Without either, --predicted-reference takes a formula.",
        ),
    ),
    "fatigue": Template(
        "Tests after cyclic pre-damage, one row per specimen",
        TESTS,
        (*_TEST, *_STUD, "shear_kN", *_CYCLES, "undamaged_shear_kN"),
        ("predamage_level", "predamage_measure", "stiffness_10_40_kN_per_mm"),
        "fit residual FILE.csv --report FILE.html",
        (
            "our lab,F1,push-out,19,100,31.2,472,101.0,fatigue,200000,30,60,5,2000000,104.5",
            "our lab,F2,push-out,19,100,31.2,472,96.0,fatigue,600000,30,60,5,2000000,104.5",
            "our lab,F3,push-out,19,100,31.2,472,88.0,fatigue,1000000,30,60,5,2000000,104.5",
            "our lab,F4,push-out,19,100,31.2,472,79.0,fatigue,1500000,30,60,5,2000000,104.5",
        ),
        (
            "Damage is predamage_cycles over predamage_life_cycles. Where no equal stud was cycled",
            "to failure leave the latter empty in all rows: the life is then that of EN 1994-1-1,",
            "6.8.3 for the range of the load. Or give predamage_level and predamage_measure.",
        ),
    ),
    "combined": Template(
        "Tests under tension and shear together, with those under one of them alone",
        TESTS,
        (*_TEST, *_STUD, "shear_kN", "tension_kN"),
        ("embedment_mm", "head_diameter_mm", "shear_uncertainty_kN", "tension_uncertainty_kN"),
        "fit interaction FILE.csv --report FILE.html",
        (
            "our lab,V1,push-out,19,100,31.2,472,104.5,",
            "our lab,T1,pull-out,19,100,31.2,472,,72.0",
            "our lab,C1,combined,19,100,31.2,472,88.0,28.0",
            "our lab,C2,combined,19,100,31.2,472,70.0,48.0",
            "our lab,C3,combined,19,100,31.2,472,45.0,61.0",
        ),
        ("Each combined test needs push-outs and pull-outs of its campaign and diameter.",),
    ),
    "deck": Template(
        "Push-out tests of headed studs in profiled deck, one row per specimen",
        TESTS,
        (*_TEST, *_STUD, "slab", *_DECK, "shear_kN"),
        ("deck_stud_position_mm", "slip_at_max_mm", "failure_mode"),
        "fit stud-strength FILE.csv --slab deck --report FILE.html",
        (
            "our lab,E1,push-out,19,125,31.2,472,deck transverse,60,120,1.0,1,welded through,71",
            "our lab,E2,push-out,19,125,31.2,472,deck transverse,60,120,1.0,1,welded through,76",
            "our lab,E3,push-out,19,125,31.2,472,deck transverse,60,120,1.0,2,welded through,58",
            "our lab,E4,push-out,19,125,31.2,472,deck transverse,60,120,1.0,2,welded through,55",
        ),
    ),
}


def template(kind: str) -> str:
    """The text of a template. Raises `InputError` for an unknown kind."""
    Choice(tuple(TEMPLATES)).check("--kind", kind)
    return TEMPLATES[kind].text


def _shown(told: Template, name: str) -> str:
    return told.schema.column(name).base if told.units else name


def _comments(told: Template) -> Iterator[str]:
    yield f"{told.title}. Then"
    yield "    workbench data check FILE.csv"
    yield f"    workbench {told.verb}"
    yield "Lines above the header that begin with # are not read; an empty cell: not reported."
    for title, names in (("Columns:", told.columns), ("Columns that help:", told.more)):
        yield ""
        yield title
        wide = max(len(_shown(told, name)) for name in names)
        for name in names:
            column = told.schema.column(name)
            rule = column.rule.allowed().removeprefix("must be ")
            words = "" if isinstance(column.rule, Text) else f"; {rule}"
            yield f"    {_shown(told, name):{wide}}  {column.meaning}{words}"
    yield ""
    yield from told.notes
    yield ""
    yield "Example:"
    yield from (f"    {row}" for row in told.rows)
