"""A stored study as one data tree."""

import json
from pathlib import Path

import xarray as xr

from workbench.study.cells import cells_of
from workbench.study.definition import Study
from workbench.study.manifest import read_manifest
from workbench.study.store import Presence, Store


def gather(study: Study, root: Path) -> xr.DataTree:
    """The stored responses of a study as ``tree["case/label"]``.

    A slash within a case or label, as in "10 m/s", becomes an underscore there.
    Arguments: `study`; `root`, the directory of all stores. The attributes of the tree hold the
    `study` name, the `manifest` (JSON) and the `missing` cells (JSON list), which are absent;
    every cell has the attributes `wall_time` (s) and `provenance` (JSON) of its record.
    Raises `WorkbenchError` if a stored cell cannot be read.
    """
    store = Store(Path(root) / study.name)
    tree = xr.DataTree(name=study.name)
    missing = []
    for cell in cells_of(study):
        if store.presence(cell.key) is not Presence.FINISHED:
            missing.append(cell.name)
            continue
        response, record = store.response(cell.key), store.record(cell.key)
        response.attrs["wall_time"] = record["wall_time"]
        response.attrs["provenance"] = json.dumps(record["provenance"], sort_keys=True)
        path = "/".join(name.replace("/", "_") for name in (cell.case, cell.label))
        tree[path] = xr.DataTree(response)
    tree.attrs["study"] = study.name
    tree.attrs["manifest"] = json.dumps(read_manifest(store), sort_keys=True)
    tree.attrs["missing"] = json.dumps(missing)
    return tree
