"""Answers to samples in chunks: one file each, made by any process anywhere, joined to one table.

Samples are taken by index, so that a chunk follows from a few lines of text and its rows. The rows
of chunks do not depend on who answers them, nor on how many samples are asked for: tables of one
process, of many, of a cluster and of slices are the same byte for byte.

``<key>-<first>-<last>-<digest>.nc`` holds rows `first` to below `last`: numbers as they are; of
texts, a code per row and the different ones as compressed JSON. The key says what is answered,
the digest what the file must hold, which is read when its rows are needed.
"""

import hashlib
import json
import sys
import zlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, islice, pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from workbench import __version__
from workbench.base.errors import InputError, WorkbenchError, message_of
from workbench.extras.uncertainty.inputs import UncertainScenario, uncertain_from_text
from workbench.extras.uncertainty.sample_runs import sample_answers
from workbench.models.batch import FAILURE, OUTCOME, can_stack
from workbench.responses import SCALARS
from workbench.study.batches import Processes
from workbench.study.cells import ingredients_of, key_of
from workbench.study.runner import DaskCluster
from workbench.study.store import UNREADABLE, read_netcdf, to_netcdf_bytes, write_atomically

STACKED, ALONE, BLOCK = 8192, 1000, 100  # rows of a chunk; of what a process answers at a time
_TEXTS = "texts of "


class Span(NamedTuple):
    """Samples `first` to below `last`."""

    first: int
    last: int


@dataclass(frozen=True)
class SampleRequest:
    """A model is asked for samples of an uncertain scenario: its `text` as TOML, the `seed`."""

    text: str
    model: Any
    seed: int
    version: str = __version__

    @cached_property
    def uncertain(self) -> UncertainScenario:
        """The scenario with its distributions."""
        return uncertain_from_text(self.text)

    @cached_property
    def labels(self) -> dict[str, Any]:
        """Everything that an answer depends on but its row."""
        median = ingredients_of(self.uncertain.base, self.model)
        return {**median, "scenario": self.text, "seed": self.seed}

    @cached_property
    def key(self) -> str:
        """Digits that stand for the labels."""
        return key_of(self.labels)

    @cached_property
    def stacked(self) -> bool:
        """Whether the model answers many samples in one compiled loop."""
        return can_stack(self.model, self.uncertain.base)

    def spans(self, whole: Span) -> list[Span]:
        """Rows of the chunks that hold these samples."""
        size = STACKED if self.stacked else ALONE
        ends = [whole.first, *range((whole.first // size + 1) * size, whole.last, size), whole.last]
        return [Span(*each) for each in pairwise(ends)]

    def table(self, span: Span) -> pd.DataFrame:
        """Inputs and answers of some samples. Raises `WorkbenchError` in another version."""
        if self.version != __version__:
            text = f"this worker has workbench {__version__}, the run {self.version}"
            raise WorkbenchError(f"{text}: install the same everywhere")
        count = span.last - span.first
        scores = self.uncertain.normal_scores(count, (self.seed,), span.first)
        return sample_answers(self.model, self.uncertain, scores)


class Chunk(NamedTuple):
    """A file of answers: its `span`, what it answers, the samples of the run that made it."""

    file: Path
    span: Span
    labels: dict[str, Any]
    whole: Span

    @classmethod
    def open(cls, file: Path) -> "Chunk":
        """The chunk in a file. Raises `InputError` if it is none, or not what was written."""
        try:
            attributes = read_netcdf(file).attrs
            span, whole = (Span(*json.loads(attributes[name])) for name in ("span", "whole"))
            labels = json.loads(attributes["labels"])
            if file.name != _name(key_of(labels), span, file.read_bytes()):
                raise ValueError("its name does not go with its content")
        except UNREADABLE as error:
            text = f"is no sound chunk of answers: {message_of(error)}"
            advice = "remove it and run its slice again"
            raise InputError("chunk", str(file), text, advice) from error
        return cls(file, span, labels, whole)

    def table(self) -> pd.DataFrame:
        """The rows, read now."""
        stored = read_netcdf(self.file)
        columns = {}
        for name in filter(lambda name: not str(name).startswith(_TEXTS), stored.variables):
            values = stored[name].to_numpy()
            if f"{_TEXTS}{name}" in stored:
                packed = stored[f"{_TEXTS}{name}"].to_numpy().tobytes()
                texts = json.loads(zlib.decompress(packed))
                values = np.array([*texts, None], object)[:-1][values]
            columns[str(name)] = pd.Series(values).infer_objects()
        return pd.DataFrame(columns)


def answer_chunks(
    question: SampleRequest,
    folder: Path,
    spans: Sequence[Span],
    whole: Span,
    jobs: int = 1,
    scheduler: str | None = None,
) -> list[Chunk]:
    """Chunks of a `whole` in a folder; what it lacks is answered in processes or on a cluster.

    Raises `WorkbenchError` if a process or worker is lost for good: what is finished is kept.
    """
    stored = _finished(question, folder)
    left = [span for span in spans if span not in stored]
    if len(left) < len(spans):
        text = f"workbench: {len(spans) - len(left)} of {len(spans)} chunks are there already"
        print(text, file=sys.stderr, flush=True)
    for span, table in _answered(question, left, jobs, scheduler):
        content = _encoded(question, span, whole, table)
        write_atomically(folder / _name(question.key, span, content), content)
    finished = _finished(question, folder)
    return [finished[span] for span in spans]


def _finished(question: SampleRequest, folder: Path) -> dict[Span, Chunk]:
    """Chunks of a question by their rows; damaged ones go."""
    finished = {}
    for file in folder.glob(f"{question.key}-*.nc"):
        try:
            chunk = Chunk.open(file)
            finished[chunk.span] = chunk
        except InputError:
            file.unlink()
    return finished


def _answered(
    question: SampleRequest, spans: Sequence[Span], jobs: int, scheduler: str | None
) -> Iterator[tuple[Span, pd.DataFrame]]:
    """Rows of chunks with their answers, as they get ready."""
    if scheduler is not None:
        for span, table, lost in DaskCluster(scheduler).results(question.table, spans):
            if lost is not None:
                text = f"the cluster lost samples {span.first} to {span.last - 1}"
                raise WorkbenchError(f"{text}: {message_of(lost)}; other chunks are kept")
            yield span, table
        return
    size = STACKED if question.stacked else BLOCK
    blocks = {
        span: [Span(k, min(k + size, span.last)) for k in range(span.first, span.last, size)]
        for span in spans
    }
    with Processes(jobs, threads=question.stacked) as run:  # compiled loops share one process
        tables = run(question.table, chain.from_iterable(blocks.values()))
        yield from ((span, joined(islice(tables, len(some)))) for span, some in blocks.items())


def _encoded(question: SampleRequest, span: Span, whole: Span, table: pd.DataFrame) -> bytes:
    """The content of a chunk."""
    variables: dict[str, Any] = {}
    for name, column in table.items():
        values: Any = column.to_numpy()
        if column.dtype != float:
            codes, different = pd.factorize(column.astype(object))
            packed = zlib.compress(json.dumps(different.tolist()).encode())
            variables[f"{_TEXTS}{name}"] = f"byte of {name}", np.frombuffer(packed, np.int8)
            values = codes.astype(np.int32)
        variables[str(name)] = "sample", values
    about = {"labels": question.labels, "span": span, "whole": whole}
    attributes = {name: json.dumps(each) for name, each in about.items()}
    return to_netcdf_bytes(xr.Dataset(variables, attrs=attributes))


def gathered(paths: Iterable[Path]) -> list[Chunk]:
    """The chunks in some folders and files: all of one question, without a gap.

    Raises `InputError` for gaps, overlaps, damaged files and parts of other inputs.
    """
    files = [each for path in paths for each in (path.glob("*.nc") if path.is_dir() else [path])]
    chunks = [Chunk.open(file) for file in {file.name: file for file in files}.values()]
    if not chunks:
        raise InputError("PARTS", ", ".join(map(str, paths)), "hold no chunk of answers")
    chunks.sort(key=lambda chunk: chunk.span)
    labels = chunks[0].labels
    for chunk in chunks:
        others = ", ".join(name for name in labels if chunk.labels.get(name) != labels[name])
        if others:
            text = f"answers another {others} than {chunks[0].file.name}"
            raise InputError("chunk", str(chunk.file), text, "gather each apart")
    first = min(chunk.whole.first for chunk in chunks)
    last = max(chunk.whole.last for chunk in chunks)
    ends = Span(first, first), *(chunk.span for chunk in chunks), Span(last, last)
    for before, after in pairwise(ends):
        text = f"samples {before.last} to {after.first - 1} are missing"
        if before.last < after.first:
            raise InputError("PARTS", None, text, "run their slice again")
        if before.last > after.first:
            text = f"samples {after.first} to {min(before.last, after.last) - 1} stand in two files"
            raise InputError("PARTS", None, text, "leave one of them out")
    return chunks


def joined(tables: Iterable[pd.DataFrame]) -> pd.DataFrame:
    """Tables of chunks as one: inputs, scalars, outcome and failure by sample."""
    whole: pd.DataFrame = pd.concat(list(tables), ignore_index=True)
    inputs = [name for name in whole if name not in (*SCALARS, OUTCOME, FAILURE)]
    return whole[[*inputs, *(name for name in SCALARS if name in whole), OUTCOME, FAILURE]]


def _name(key: str, span: Span, content: bytes) -> str:
    """The name of the file of a chunk."""
    return f"{key}-{span.first}-{span.last}-{hashlib.sha256(content).hexdigest()[:20]}.nc"
