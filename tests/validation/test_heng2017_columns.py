"""Columns of P. Heng, doctoral thesis, KTH 2017: published numbers and independent solutions.

Figure 5.9(b) prints the peaks. The static forces and the finer digits of the peaks are those of
an independent implementation of the same equations (five digits).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import THESIS_SPRINGS

from workbench.models.four_dof import FourDof
from workbench.models.published import Published
from workbench.scenarios import ColumnPushover

FINE = 1e-5  # s; steps by error leave some 0.1 % of the peak open
AT = [0.001, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]
STATIC_KN = {
    (1.0, 1.0): [263.81, 623.41, 702.42, 735.84, 770.81, 846.44, 860.36, 866.19, 971.08, 1261.2,
                 1852.1, 2836.5],
    (1.0, 1.3): [263.81, 647.06, 754.28, 783.95, 807.41, 837.16, 896.27, 959.11, 1134.0, 1485.2,
                 2097.0, 2848.3],
    (1.0, 2.0): [263.81, 670.19, 805.01, 830.31, 841.37, 833.18, 887.54, 1043.8, 1325.7, 1746.4,
                 2313.7, 2867.4],
    (2.0, 2.0): [263.81, 674.53, 814.55, 838.84, 846.89, 830.41, 871.89, 1052.6, 1425.4, 2010.3,
                 2650.9, 2905.4],
}  # fmt: skip


@pytest.mark.claim("model:four-dof", "static force off fig. 5.8", "independent code", 0, 5e-4)
@pytest.mark.parametrize("exponents", STATIC_KN)
def test_figure_5_8_static_curve(thesis_impact, exponents, claim) -> None:
    push = ColumnPushover("figure 5.8", thesis_impact.column, 0.7)
    response = FourDof(alpha=exponents[0], beta=exponents[1], **THESIS_SPRINGS).simulate(push)
    force = np.interp(AT, response["displacement"], response["force"]) / 1e3
    claim(np.abs(force / STATIC_KN[exponents] - 1.0).max())


@pytest.mark.parametrize(
    ("options", "peaks"),
    [
        ({"beta": 1.3}, (0.09026, 0.19143, 0.32364)),
        ({"beta": 1.2762}, (0.09046, 0.19154, 0.32416)),
        ({"alpha": 1.0, "beta": 1.0}, (0.09363, 0.19419, 0.33438)),
        ({"alpha": 1.0, "beta": 2.0}, (0.08693, 0.19111, 0.31891)),
        ({"alpha": 2.0, "beta": 2.0}, (0.08639, 0.19162, 0.31980)),
        ({"beta": 1.3, "rotational_stiffness": 3.0}, (0.0938, 0.1951, 0.3269)),
    ],
)
def test_figure_5_9_peaks_of_the_four_dof_column(thesis_impact, options, peaks) -> None:
    tolerance = 1e-4 if "rotational_stiffness" not in options else 2e-3
    for velocity, expected in zip((10.0, 15.0, 20.0), peaks, strict=True):
        impact = thesis_impact.at_velocity(velocity)
        peak = float(
            FourDof(**{**THESIS_SPRINGS, **options}, time_step=FINE).simulate(impact)[
                "peak_displacement"
            ]
        )
        assert peak == pytest.approx(expected, rel=tolerance)
        by_error = float(
            FourDof(**{**THESIS_SPRINGS, **options}).simulate(impact)["peak_displacement"]
        )
        assert by_error == pytest.approx(peak, rel=1e-3)


@pytest.mark.parametrize(
    ("restitution", "peaks"),
    # 2026-11: gaps are forecast for a whole step; before 0.20125, with steps of 1e-6 s 0.20120
    [(0.5, (0.08971, 0.19070, 0.32280)), (1.0, (0.09413, 0.20123, 0.33876))],
)
def test_restitution(thesis_impact, restitution, peaks) -> None:
    for velocity, expected in zip((10.0, 15.0, 20.0), peaks, strict=True):
        impact = thesis_impact.at_velocity(velocity)
        impact = replace(impact, striker=replace(impact.striker, restitution=restitution))
        peak = float(
            FourDof(time_step=5e-6, **THESIS_SPRINGS).simulate(impact)["peak_displacement"]
        )
        assert peak == pytest.approx(expected, rel=1e-4)  # measured 3.4e-5
        by_error = float(FourDof(**THESIS_SPRINGS).simulate(impact)["peak_displacement"])
        assert by_error == pytest.approx(peak, rel=2e-3)


def test_first_impact_loses_the_share_of_the_impact_mass(thesis_impact) -> None:
    response = FourDof(**THESIS_SPRINGS).simulate(thesis_impact)
    # m_1 / (m_1 + m_c); the rest of the contact is lossless (eps = 0: the masses stay together)
    share = 95.2467 / (95.2467 + 1500.0)
    loss = float(response["contact_loss"][-1]) / thesis_impact.input_energy
    assert loss == pytest.approx(share, rel=1.7e-3)  # measured 8.3e-4


@pytest.mark.parametrize(
    ("exponents", "peak"), [((1.0, 1.3), 0.4975), ((1.0, 1.0), 0.5056), ((2.0, 2.0), 0.4583)]
)
def test_figure_5_4_clamped_column(clamped_impact, exponents, peak) -> None:
    model = FourDof(alpha=exponents[0], beta=exponents[1], time_step=FINE, **THESIS_SPRINGS)
    response = model.simulate(clamped_impact)
    assert float(response["peak_displacement"]) == pytest.approx(peak, rel=2e-4)  # measured 9.1e-5


@pytest.mark.claim("model:four-dof model:published", "peak over figure 5.9", "heng2017", 1, 2e-3)
@pytest.mark.parametrize("velocity", [10.0, 15.0, 20.0])
def test_four_dof_reproduces_the_published_peaks(thesis_impact, velocity, claim) -> None:
    impact = thesis_impact.at_velocity(velocity)
    published = float(
        Published("heng2017-figure-5-9", "4-DOF nonlinear yield surface").simulate(impact)[
            "peak_displacement"
        ]
    )
    computed = float(FourDof(**THESIS_SPRINGS).simulate(impact)["peak_displacement"])
    claim(computed / published)
