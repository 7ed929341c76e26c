"""Shared fixtures: the shipped tables, and synthetic campaigns."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pandas as pd
import pytest

from workbench.studs import shipped
from workbench.studs.schema import TESTS, read_text


@pytest.fixture(scope="session")
def push_outs() -> pd.DataFrame:
    """The shipped push-out tests."""
    return shipped("stud-push-out")


@pytest.fixture(scope="session")
def curves() -> pd.DataFrame:
    """The shipped load-slip points."""
    return shipped("stud-load-slip")


@pytest.fixture
def damaged() -> Callable[..., pd.DataFrame]:
    """Synthetic tests after pre-damage: strength left 1 - c D^p, campaign effects and scatter."""

    def make(
        campaigns: int = 5,
        tests: int = 8,
        c: float = 0.5,
        p: float = 1.0,
        tau: float = 0.04,
        sigma: float = 0.03,
        *,
        kind: str = "fatigue",
        measure: str = "life fraction",
        origin: str = "synthetic",
        seed: int = 1,
    ) -> pd.DataFrame:
        generator = np.random.default_rng(seed)
        rows = []
        for j in range(campaigns):
            effect = tau * generator.normal()
            for i in range(tests):
                level = round(generator.uniform(0.0, 1.0), 4)
                left = 1.0 - c * level**p + effect + sigma * generator.normal()
                shear = f"{100 * left:.4f}"
                rows.append(
                    f"lab {j},s{i},push-out,{origin},19,{shear},100,{kind},{measure},{level}"
                )
        header = (
            "campaign,specimen,test,origin,diameter_mm,shear_kN,undamaged_shear_kN,predamage,"
            "predamage_measure,predamage_level"
        )
        return read_text("\n".join([header, *rows]), TESTS).accept()

    return make
