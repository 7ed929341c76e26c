"""What one factor for the strain rate adds to the error of the anchor, on drawn columns.

Columns and strikes are those of `which_model` with another seed. The steel feels the strain rate:
the law of the grade with the nearest yield stress, its reference rate drawn between the ends of
90 % of such steels. The beam whose webs yield answers twice: with the law in every fiber, and with
one factor on the yield stress, as models have it that know no rate. What is between the two is
data of the error model.
"""

import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import exp, log
from typing import ClassVar

import numpy as np
from which_model import stratified

from workbench.cli import main
from workbench.models.references.fiber_beams import FiberShear
from workbench.models.strain_rate import rate_factor, with_rate
from workbench.models.superelements import FlexibleSuperelement
from workbench.scenarios import ColumnImpact
from workbench.study import Case, Figure, Study
from workbench.study.assessment.variations import rate_law
from workbench.study.error_model.error_table import FACTOR_BEAM

SEED, QUOTAS, QUICK = 31, np.full((3, 3), 20), 6


@dataclass(frozen=True)
class FactorBeam(FiberShear):
    """The beam whose webs yield, with one factor on the yield stress: that of the anchor."""

    name: ClassVar[str] = FACTOR_BEAM
    version: ClassVar[int] = 100 * FlexibleSuperelement.version + FiberShear.version
    material: ClassVar[tuple[str, ...]] = ("hardening",)


REFERENCE = "web-yielding beam"
models = {
    REFERENCE: FiberShear(levels=1),
    "web-yielding beam, one factor": FactorBeam(levels=1),
}


def drawn_columns(seed: int, quotas: np.ndarray) -> Iterator[ColumnImpact]:
    """Struck columns whose steel has a drawn rate law, so many in each cell."""
    rng = np.random.default_rng(seed)
    for impact, number in stratified(seed, quotas):
        law = rate_law(impact)
        rate = exp(rng.uniform(log(law.slow), log(law.fast)))
        law = replace(law, reference_rate=float(f"{rate:.3g}"), slow=None, fast=None)
        column, striker = impact.column, impact.striker
        name = f"{number:03d} {column.section.name.replace(' without fillets', ', plates')}, "
        name += f"{column.length_below:.2f} + {column.length_above:.2f} m, "
        name += f"{striker.velocity:.1f} m/s, {striker.mass:.0f} kg, D {law.reference_rate:g} 1/s"
        yield replace(with_rate(impact, law), name=name)


cases = tuple(
    Case(
        impact.name,
        impact,
        parameters={"factor on the yield stress": rate_factor(impact, shear_yields=True)},
        quick=number < QUICK,
    )
    for number, impact in enumerate(drawn_columns(SEED, QUOTAS))
)
study = Study(
    name="drawn_rates",
    title="Columns whose steel feels the strain rate: one factor on drawn ones",
    question="How far is one factor on the yield stress from fibers that follow the law?",
    cases=cases,
    models=models,
    reference=REFERENCE,
    quantities=("peak_displacement", "residual_displacement"),
    figures=(Figure("peaks", "peaks", "Peaks against fibers that follow the law", "By case."),),
    decisive="peaks",
)

if __name__ == "__main__":
    main(["run", __file__, *sys.argv[1:]])
