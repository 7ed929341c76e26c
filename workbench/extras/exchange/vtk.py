"""Deformed shapes of a response for ParaView: VTU for each snapshot, PVD for their times."""

from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from workbench.base.arrays import Array
from workbench.base.errors import InputError
from workbench.report.drawing.shapes import Shapes, shapes_of
from workbench.responses import Finding, Response, warnings_of
from workbench.scenarios import Scenario
from workbench.study.store import write_atomically

_POLYLINE = 4  # the type of a cell of VTK
_TYPES = {"i": "Int64", "f": "Float64"}


def write_shapes(path: Path, scenario: Scenario, response: Response) -> None:
    """Write ``<name>.pvd`` and, in the folder ``<name>``, one ``.vtu`` for each snapshot.

    Points are those of the members at rest, in m; `displacement` (points, 3) moves them ("Warp By
    Vector"); `utilisation` of the N-M strength stands at the ends of members, NaN elsewhere;
    `member` numbers the members. Times are in s, of static answers steps.
    Raises `InputError` for an answer without deformed shapes or a folder that cannot be written.
    """
    shapes = shapes_of(scenario, response)
    if shapes is None:
        reason = f"the answer of {response.attrs['model']} knows no deformed shape"
        raise InputError("--out", path.name, reason, "take a model that has one, or end in .nc")
    folder = path.with_suffix("")
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise InputError("--out", str(path), f"needs the folder {folder.name} beside it") from error
    root, collection = _file("Collection")
    for snapshot, at in enumerate(shapes.at):
        name = f"{snapshot:04d}.vtu"
        write_atomically(folder / name, _vtu(shapes, snapshot))
        place = {"timestep": repr(float(at)), "part": "0", "file": f"{folder.name}/{name}"}
        ElementTree.SubElement(collection, "DataSet", place)
    write_atomically(path, _bytes(root))


def write_answer(scenario: Scenario, target: Path, **options: Any) -> tuple[str, list[Finding]]:
    """Answer a scenario, by the model that `workbench advise` names, and write its shapes.

    Gives a sentence on what was written, and the warnings of the answer. Raises `InputError`.
    """
    from workbench.api.answers import simulate

    response = simulate(scenario, **options)
    write_shapes(target, scenario, response)
    then = f"answer of {response.attrs['model']}; open it in ParaView, Warp By Vector moves it"
    return then, warnings_of(response)


def _vtu(shapes: Shapes, snapshot: int) -> bytes:
    """The members in one snapshot, each a polyline."""
    rest = shapes.rest_places
    _, members, points = rest.shape
    root, grid = _file("UnstructuredGrid")
    sizes = {"NumberOfPoints": str(members * points), "NumberOfCells": str(members)}
    piece = ElementTree.SubElement(grid, "Piece", sizes)
    _arrays(piece, "Points", {"": _rows(rest)})
    cells = {
        "connectivity": np.arange(members * points),
        "offsets": points * np.arange(1, members + 1),
        "types": np.full(members, _POLYLINE),
    }
    _arrays(piece, "Cells", cells)
    states = {"displacement": _rows(shapes.places[..., snapshot] - rest)}
    if shapes.hinges:
        states["utilisation"] = _at_ends(shapes, snapshot)
    _arrays(piece, "PointData", states)
    _arrays(piece, "CellData", {"member": np.arange(members)})
    return _bytes(root)


def _rows(places: Array) -> Array:
    """Points (members * points, 3) of places (3, members, points)."""
    return places.reshape(3, -1).T


def _at_ends(shapes: Shapes, snapshot: int) -> np.ndarray:
    """Utilisation at the points (members * points,), of hinges "member:start" and "member:end"."""
    used = dict(zip(shapes.hinges, shapes.used[:, snapshot], strict=True))
    values = np.full(shapes.rest.shape, np.nan)
    for row, member in zip(values, shapes.frame.members, strict=True):
        row[0], row[-1] = (used.get(f"{member.name}:{end}", np.nan) for end in ("start", "end"))
    return values.ravel()


def _file(kind: str) -> tuple[ElementTree.Element, ElementTree.Element]:
    """The root of a file of VTK and its content."""
    words = {"type": kind, "version": "1.0", "byte_order": "LittleEndian"}
    root = ElementTree.Element("VTKFile", words)
    return root, ElementTree.SubElement(root, kind)


def _arrays(piece: ElementTree.Element, name: str, arrays: dict[str, np.ndarray]) -> None:
    """Add arrays by name, as text."""
    parent = ElementTree.SubElement(piece, name)
    for key, array in arrays.items():
        head = {"type": _TYPES[array.dtype.kind], "format": "ascii"}
        if key:
            head["Name"] = key
        if array.ndim > 1:
            head["NumberOfComponents"] = str(array.shape[1])
        element = ElementTree.SubElement(parent, "DataArray", head)
        element.text = " ".join(map(repr, array.ravel().tolist()))


def _bytes(root: ElementTree.Element) -> bytes:
    ElementTree.indent(root)
    return bytes(ElementTree.tostring(root, encoding="utf-8", xml_declaration=True))
