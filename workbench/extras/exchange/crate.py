"""A report as an RO-Crate: one archive with report, figures, tables, cells, and what made what.

Source: RO-Crate Metadata Specification 1.1 (Sefton et al. 2021), which describes files in JSON-LD.
"""

import hashlib
import io
import json
import re
import zipfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from workbench.report.gallery import cases_of, figures_of
from workbench.study.assessor import Assessment
from workbench.study.store import Store, canonical_json, write_atomically

METADATA = "ro-crate-metadata.json"
_FORMATS = {
    "csv": "text/csv",
    "html": "text/html",
    "json": "application/json",
    "nc": "application/x-netcdf",
    "parquet": "application/vnd.apache.parquet",
    "pdf": "application/pdf",
    "png": "image/png",
    "svg": "image/svg+xml",
    "xlsx": "application/vnd.openxmlformats-officedocument.spreadsheetml.sheet",
}
_EPOCH = (1980, 1, 1, 0, 0, 0)  # of every entry: equal stores give equal archives


def write_crate(stored: Assessment, report: Path, target: Path, commands: tuple[str, ...]) -> None:
    """Write an archive of a built report and of all that it was made of.

    Arguments: the `stored` study; the folder of its built `report`; the `target`, a zip; the
    `commands` that make it again. Every figure names the cells that it was drawn from, every cell
    the versions and the commit that answered it. Raises `InputError` if it cannot be written.
    """
    files = dict(_files(stored, report))
    content = canonical_json({"@context": _CONTEXT, "@graph": _graph(stored, files, commands)})
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in {METADATA: content, **files}.items():
            archive.writestr(zipfile.ZipInfo(name, _EPOCH), text, zipfile.ZIP_DEFLATED)
    write_atomically(target, buffer.getvalue())


_CONTEXT = "https://w3id.org/ro/crate/1.1/context"


def _files(stored: Assessment, report: Path) -> Iterator[tuple[str, bytes]]:
    """Contents of all files by their names in the crate."""
    store = Store(stored.directory)
    yield "manifest.json", store.manifest.read_bytes()
    for folder, root in (("report", report), ("tables", store.tables)):
        for path in sorted(root.rglob("*")):
            if path.is_file() and path.suffix[1:] in _FORMATS:
                yield f"{folder}/{path.relative_to(root).as_posix()}", path.read_bytes()
    for key in sorted({cell.key for cell in stored.cells.values() if cell.key}):
        for ending in ("json", "nc"):
            path = store.cells / f"{key}.{ending}"
            if path.is_file():
                yield f"cells/{path.name}", path.read_bytes()


def _graph(
    stored: Assessment, files: Mapping[str, bytes], commands: tuple[str, ...]
) -> list[dict[str, Any]]:
    """The entities of the crate: itself, its files, the programs, and the act that made it."""
    study, programs = stored.study, list(_programs(stored))
    named = {each["@id"] for each in programs}
    entities = {name: _file(name, content) for name, content in files.items()}
    for (case, label), cell in stored.cells.items():
        if f"cells/{cell.key}.nc" in entities:
            words = {"name": f"{label}: {case}", "description": cell.outcome}
            entities[f"cells/{cell.key}.nc"] |= words
    for figure in figures_of(study):
        labels = figure.models or tuple(study.models)
        keys = {stored.cells[c.name, n].key for c in cases_of(study, figure)
                for n in labels if (c.name, n) in stored.cells}  # fmt: skip
        cells = sorted({f"cells/{key}.nc" for key in keys} & set(entities))
        for name in (f"report/figures/{figure.key}.{end}" for end in ("svg", "png", "csv")):
            if name in entities:
                entities[name] |= {
                    "name": figure.title,
                    "description": figure.caption,
                    "isBasedOn": _links(cells),
                }
    made = [name for name in entities if name.startswith(("report/", "tables/"))]
    given = [name for name in entities if name.startswith("cells/") and name.endswith(".nc")]
    root = {
        "@id": "./",
        "@type": "Dataset",
        "name": study.title,
        "description": study.question,
        "datePublished": _newest(files),
        "hasPart": _links(sorted(entities)),
        "mentions": [{"@id": "#report"}],
    }
    about: dict[str, Any] = {"@id": METADATA, "@type": "CreativeWork", "about": {"@id": "./"},
             "conformsTo": {"@id": "https://w3id.org/ro/crate/1.1"}}  # fmt: skip
    act = {
        "@id": "#report",
        "@type": "CreateAction",
        "name": "; ".join(commands),
        "instrument": _links(sorted(named)),
        "object": _links(given),
        "result": _links(made),
    }
    return [about, root, *entities.values(), *programs, act]


def _file(name: str, content: bytes) -> dict[str, Any]:
    """One file, with what it is and the digest of its content."""
    return {
        "@id": name,
        "@type": "File",
        "name": name.rpartition("/")[2],
        "encodingFormat": _FORMATS[name.rpartition(".")[2]],
        "contentSize": str(len(content)),
        "sha256": hashlib.sha256(content).hexdigest(),
    }


def _programs(stored: Assessment) -> Iterator[dict[str, Any]]:
    """The programs that answered the cells, each with its version and what it ran with."""
    for number, record in enumerate(stored.provenance, 1):
        known = {name: value for name, value in record.items() if name != "machine"}
        version, commit = known.pop("workbench", ""), known.pop("commit", "")
        yield {
            "@id": f"#workbench-{number}",
            "@type": "SoftwareApplication",
            "name": "Steel-impact validation workbench",
            "version": version,
            "identifier": f"commit {commit}",
            "softwareRequirements": ", ".join(f"{n} {v}" for n, v in sorted(known.items())),
        }


def _newest(files: Mapping[str, bytes]) -> str:
    """The day on which the last cell was answered."""
    records = (json.loads(files[n]) for n in files if re.fullmatch(r"cells/.*\.json", n))
    return str(max((record.get("finished", "") for record in records), default=""))[:10]


def _links(names: list[str]) -> list[dict[str, str]]:
    return [{"@id": name} for name in names]
