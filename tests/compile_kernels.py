"""Answer a short case by each of the named models, which compiles their kernels into the cache."""

from __future__ import annotations

import sys
from dataclasses import fields, replace

from workbench.base.datafiles import data_directory
from workbench.models.base import make_model, model_kind
from workbench.scenarios import ColumnPushover, frame_scenario, load_scenario

hit = load_scenario(data_directory() / "published" / "heng2017_impact_column.toml")
hit = replace(hit, duration=1e-3)
push = ColumnPushover("push", hit.column, 1e-3)
for name in sys.argv[1:]:
    one_mesh = "levels" in {field.name for field in fields(model_kind(name))}
    model = make_model(name, {"levels": 1} if one_mesh else {})
    for scenario in (hit, push, frame_scenario(hit)):
        if scenario.KIND in model.answers:
            model.simulate(scenario)
