"""Questions to tables of tests on studs: their options, declared once.

The fields of a question are its options: for Python, where `fit_question` of the module
`workbench.studs.laboratory` answers it with tables, and for `workbench fit`, whose flags are made
of them. Words of long lists (formulas, laws, trends) are checked by the fit itself: nothing heavy
is imported to ask.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, ClassVar

from workbench.base.errors import InputError
from workbench.base.fields import Choice, Declared, Flag, Many, Number, Text, checked

if TYPE_CHECKING:
    import pandas as pd

_LOSS = Choice(("linear", "huber", "bisquare"))
_NAMES = Many(Text())
_SIZE = Number(0.0, 1e4)  # of a stud, in the unit of its column, whose rule is the narrower one
_BETWEEN: Any = {
    "optional": True,
    "help": "Scatter between campaigns (of logarithms, of shares left) that is known.",
}


def _size(words: str) -> Any:
    return checked(_SIZE, optional=True, help=words)


@dataclass(frozen=True)
class Question(Declared):
    """A question to tests: which campaigns are fitted, which judge the fit, how sure bands are.

    `name` of the verb; `on_curves`, asked of load-slip points instead of tests.
    """

    calibrate: tuple[str, ...] | None = checked(
        _NAMES, optional=True, help="A campaign to fit.  [default: all not validating]"
    )
    validate: tuple[str, ...] | None = checked(
        _NAMES, optional=True, help="A campaign to judge the fit by, kept out of it."
    )
    confidence: float = checked(Number(0.5, 0.999), 0.9, help="Confidence of intervals and bands.")

    name: ClassVar[str]
    on_curves: ClassVar[bool] = False

    def split(self, table: pd.DataFrame) -> tuple[pd.DataFrame, pd.DataFrame]:
        """The rows to fit, and those held out to judge the fit. Raises `InputError`."""
        from workbench.studs.tables import check_campaigns, split_table

        calibrate, validate = self.calibrate or (), self.validate or ()
        check_campaigns((*calibrate, *validate), table)
        return split_table(table, calibrate, validate)

    def head(
        self, table: pd.DataFrame, held: pd.DataFrame, how: Mapping[str, Any], **told: Any
    ) -> dict[str, Any]:
        """Head of an answer and its report: what was asked of a `table` with rows `held` out.

        `how`: options beside its own; `told`: its `tables`, `digest`, `rows_left_out`, `notes`.
        """
        from workbench.studs.tables import campaigns_of

        defaults = {each.name: each.default for each in fields(self) if each.name != "points"}
        options = {name: getattr(self, name) for name in defaults} | dict(how)
        named = {
            name: list(value) if isinstance(value, tuple) else value
            for name, value in options.items()
            if value != defaults.get(name) and (value or name in defaults)
        }
        return {
            "fit": self.name,
            "calibrate": list(self.calibrate or ()),
            "validate": campaigns_of(held),
            "confidence": self.confidence,
            "options": named,
            "roles": table["role"].value_counts().to_dict() if "role" in table else {},
            "known_variation": getattr(self, "known_variation", None),
            **told,
        }


@dataclass(frozen=True)
class StrengthQuestion(Question):
    """Judge and fit formulas of strength.

    Undamaged headed studs in solid slabs with use_for_fit = 1; with EN 1990 D.8 and, under shear,
    EN 1994-1-1 Annex B.2. Campaigns that validate are kept out of the fit.
    """

    model: tuple[str, ...] | None = checked(
        _NAMES,
        optional=True,
        help="A formula; of pull-outs en1992-, aci318-, aisc360-tension.  [default: all of shear]",
    )
    trend: tuple[str, ...] | None = checked(
        _NAMES, optional=True, help="A variable whose missing exponent is fitted."
    )
    factor: tuple[str, ...] | None = checked(
        _NAMES, optional=True, help="Fit this factor of the formula: steel or concrete."
    )
    loss: str = checked(_LOSS, "linear")
    known_between: float | None = checked(Number(0.001, 1.0), **_BETWEEN)
    slab: str = checked(
        Choice(("solid", "deck", "any")), "solid", help="In decks reduced by the rules of the codes"
    )
    variation: tuple[str, ...] | None = checked(
        _NAMES, optional=True, help="NAME=V, scatter of a variable in structures, for D.8."
    )
    points: str | None = checked(
        Text(1000), optional=True, help="Load-slip curves, for slip capacities."
    )
    specified: float | None = checked(
        Number(200.0, 1500.0, "MPa"),
        optional=True,
        path="--specified-fu",
        help="Specified stud strength, MPa.  [default: 450 in Annex B, as tested in D.8]",
    )

    name: ClassVar[str] = "stud-strength"


@dataclass(frozen=True)
class LoadSlipQuestion(Question):
    """Fit load-slip laws to push-out curves.

    Curves are the observations, not points: a curve of many points counts once.
    """

    law: tuple[str, ...] | None = checked(
        _NAMES, optional=True, help="A law of `workbench.studs.LAWS`.  [default: all]"
    )
    loss: str = checked(Choice(("linear", "huber", "soft_l1")), "linear")
    least_points: int = checked(
        Number(2, 10_000, integer=True), 3, help="Points that a curve needs to count."
    )

    name: ClassVar[str] = "load-slip"
    on_curves: ClassVar[bool] = True


@dataclass(frozen=True)
class ResidualQuestion(Question):
    """Fit what is left after pre-damage.

    The answer carries the grade of its evidence. Without tests after pre-damage the mechanical
    model predicts, and nothing validates it.
    """

    quantity: str = checked(Choice(("strength", "stiffness", "both")), "both")
    predamage: str | None = checked(Text(), optional=True, help="Tests after this damage only.")
    measure: str | None = checked(
        Text(), optional=True, help="Tests with this measure of damage only."
    )
    loss: str = checked(_LOSS, "linear")
    known_between: float | None = checked(Number(0.001, 1.0), **_BETWEEN)
    predicted_reference: bool = checked(
        Flag(), False, help="Predict undamaged strengths that no test gave."
    )
    mechanical: bool = checked(Flag(), True, help="Let the mechanical model predict, or compete.")
    diameter_mm: float | None = _size("Stud to predict for.  [default: those of FILE, else 19]")
    height_mm: float | None = _size("Height of that stud.  [default: as in FILE, else 100]")
    fcm_mpa: float | None = _size("Mean strength of its slab.  [default: as in FILE, else 30]")
    fu_mpa: float | None = _size("Its tensile strength.  [default: as in FILE, else 450]")

    name: ClassVar[str] = "residual"


@dataclass(frozen=True)
class InteractionQuestion(Question):
    """Fit the exponent of tension with shear.

    Combined tests (test = combined) over the pull-outs and push-outs of their campaign and
    diameter; t^p + v^p = 1, with the laws of the codes on the same tests.
    """

    loss: str = checked(_LOSS, "linear")

    name: ClassVar[str] = "interaction"


@dataclass(frozen=True)
class FewTestsQuestion(Question):
    """Characteristic value of one to three tests, EN 1990 D.8.4.

    Strength of undamaged studs, and share of strength and stiffness left after damage, for a
    scatter that earlier tests with the same resistance have shown (--known-variation).
    """

    known_variation: float | None = checked(
        Number(0.01, 0.5), optional=True, help="V_r that earlier tests have shown; needed."
    )

    name: ClassVar[str] = "few-tests"

    def check(self) -> None:
        """Refuse to go on without the scatter."""
        if self.known_variation is None:
            advice, reason = "--known-variation 0.11 for example", "must be given: few tests do not"
            raise InputError("known_variation", "", f"{reason} tell it", advice)


QUESTIONS: tuple[type[Question], ...] = (
    StrengthQuestion,
    LoadSlipQuestion,
    ResidualQuestion,
    InteractionQuestion,
    FewTestsQuestion,
)
