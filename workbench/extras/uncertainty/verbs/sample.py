"""Uncertain inputs: `workbench sample`, `gather`, `sensitivity`, `rare`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path
from shutil import rmtree
from tempfile import mkdtemp
from typing import TYPE_CHECKING, Annotated, Any

import typer

from workbench.base.errors import InputError
from workbench.cli.output import (
    ENDINGS,
    Answer,
    Jobs,
    Options,
    ScenarioFile,
    Settings,
    at_work,
    option,
    pairs_of,
    processes,
    verb,
    writable,
    write_answers,
)
from workbench.extras.uncertainty.verbs.fragility import pair_of, struck
from workbench.report.page.markdown import Block, Cell, Table, paragraph

if TYPE_CHECKING:
    from workbench.extras.uncertainty.chunks import Chunk
    from workbench.extras.uncertainty.inputs import UncertainScenario
    from workbench.extras.uncertainty.sensitivity import Index

MOST, MOST_ROWS = 10_000_000, 100_000  # samples; rows of a sensitivity: 0.7 GB
_CHUNKS = ".chunks"  # ending of a folder of chunks
_TABLE = "ANSWERS.csv|nc|parquet|xlsx"
_SHARES = (0.05, 0.5, 0.95)


@verb
def sample(
    scenario: ScenarioFile,
    model: str | None = option("Name of a model.  [default: by the scenario]", None, "NAME"),
    out: str | None = option(
        "Write the table, or keep a folder of chunks.  [default: quantiles alone]",
        None,
        f"{_TABLE}|chunks",
    ),
    samples: int = option("Samples of the inputs.", 1024),
    seed: int = option("Seed of the Sobol sequence.", 1),
    first: int = option("First sample of the sequence.", 0),
    part: str | None = option("Answer part i of n, to gather.", None, "i/n", "--slice"),
    jobs: Jobs = None,
    scheduler: str | None = option("Run on this Dask cluster.", None, "ADDRESS"),
    settings: Settings = None,
    options: Options = None,
) -> Answer:
    """Answer samples of uncertain inputs.

    One model, one table, a row a sample. Samples are points of a scrambled Sobol sequence: those
    from --first on are the same whatever the number of samples or processes. An interrupted run
    goes on where it was, if asked the same. With --slice, or where --out ends in .chunks, the
    answers stay a folder of chunks, which `workbench gather` joins to the same table. Exit status 0
    if all survive or collapse, 1 if one has no answer (the table says why), 2 for bad input.
    """
    from workbench.base.fields import Number
    from workbench.extras.uncertainty.chunks import SampleRequest, Span, answer_chunks
    from workbench.models.base import make_model
    from workbench.study.store import locked, own_directory

    kept = out is not None and Path(out).suffix == _CHUNKS
    if part is not None and not kept:
        text = f"must end in {_CHUNKS} with --slice"
        raise InputError("--out", out, text, "workbench gather makes the table")
    target = Path(out) if out and kept else writable("--out", out, *ENDINGS, inputs=[scenario])
    Number(1, MOST, integer=True).check("--samples", samples)
    Number(0, MOST, integer=True).check("--first", first)
    number, count = (1, 1) if part is None else _slice(part)
    uncertain, workers = _uncertain(scenario, settings, seed), processes(jobs)
    name = model or pair_of(uncertain.base, None, "")[0]
    question = SampleRequest(uncertain.text, make_model(name, pairs_of("--option", options)), seed)
    whole = Span(first, first + samples)
    spans = question.spans(whole)
    mine = spans[len(spans) * (number - 1) // count : len(spans) * number // count]
    if not mine:
        raise InputError("--slice", part, f"must divide the {len(spans)} chunks of these samples")
    if target is None:
        folder = Path(mkdtemp())
    else:
        folder = own_directory(target.parent, target.name if kept else f".{target.name}{_CHUNKS}")
    alone = nullcontext() if kept else locked(folder / ".lock")  # the folder of a table goes
    with alone, at_work(f"{name}, samples {mine[0].first} to {mine[-1].last - 1}, at work"):
        chunks = answer_chunks(question, folder, mine, whole, workers, scheduler)
        answer = _tabled(chunks, target)
        if not kept:
            rmtree(folder)
    return answer


@verb
def gather(
    parts: Annotated[list[str], typer.Argument(metavar="PARTS...", help="Folders and chunks.")],
    out: str = option("Write the table.", ..., _TABLE),
) -> Answer:
    """Join chunks of `workbench sample --slice` to one table.

    The table is the same as that of one run. Exit status 0 if all survive or collapse, 1 if one has
    no answer, 2 for bad input: gaps, overlaps, damaged chunks and those of other inputs.
    """
    from workbench.extras.uncertainty.chunks import gathered

    target = writable("--out", out, *ENDINGS, inputs=parts)
    return _tabled(gathered([Path(each) for each in parts]), target)


def _slice(text: str) -> tuple[int, int]:
    """Number and count of a text like 3/8."""
    number, _, count = text.partition("/")
    if not (number.isdecimal() and count.isdecimal() and 1 <= int(number) <= int(count)):
        raise InputError("--slice", text, "must look like 3/8: which part, of how many")
    return int(number), int(count)


def _tabled(chunks: list[Chunk], target: Path | None) -> Answer:
    """The table of chunks: summed up, and written where it has a file and is no folder."""
    from workbench.base.tables import plain_rows
    from workbench.extras.uncertainty.chunks import joined
    from workbench.extras.uncertainty.inputs import uncertain_from_text
    from workbench.models.batch import FAILURE, OUTCOME
    from workbench.report.page.formatting import title_of

    table = joined(chunk.table() for chunk in chunks)
    uncertain = uncertain_from_text(chunks[0].labels["scenario"])
    model, name = chunks[0].labels["model"], uncertain.base.name
    kept = target is not None and target.suffix == _CHUNKS
    if target is not None and not kept:
        write_answers(target, table, table.rename_axis("sample").to_xarray())
    outcomes = {str(name): int(n) for name, n in table[OUTCOME].value_counts().items()}
    numbers = [each for each in table.columns if each not in (*uncertain.names, OUTCOME, FAILURE)]
    quantiles = table[numbers].quantile(list(_SHARES)).T.add_prefix("q")
    quantiles.insert(0, "answers", table[numbers].count())
    rows = plain_rows(quantiles.rename_axis("quantity").reset_index())
    content = {"scenario": name, "model": model, "outcomes": outcomes, "quantiles": rows}
    texts = ", ".join(f"{n} {each}" for each, n in outcomes.items())
    columns = {str(each): each for each in quantiles}
    titled = {"quantity": lambda row: title_of(row["quantity"]), **columns}
    blocks = (
        paragraph(f"{name}, {len(table)} samples by {model}: {texts}."),
        Table.of("quantiles", "Quantiles of what was answered, in SI.", titled, rows),
    )
    answered = outcomes.get("ok", 0) + outcomes.get("collapse", 0) == len(table)
    files = {"folder of chunks" if kept else "table": target}
    return Answer(content, blocks, int(not answered), files)


@verb
def sensitivity(
    scenario: ScenarioFile,
    model: str | None = option("Name of a model.  [default: by the scenario]", None, "NAME"),
    samples: int = option("Rows; the model answers inputs + 2 times as many.", 1024),
    quantity: str = option("Scalar of the answer.", "peak_displacement", "NAME"),
    seed: int = option("Seed of the Sobol sequence.", 1),
    jobs: Jobs = None,
    settings: Settings = None,
    options: Options = None,
) -> Answer:
    """Sobol indices: on which inputs an answer depends.

    First and total indices of the uncertain inputs: of the answer given survival, and of having no
    such answer (collapse, refusal, failure), with intervals of 90 %. Exit status 0, 2 for bad
    input.
    """
    import numpy as np

    from workbench.base.fields import Number
    from workbench.extras.uncertainty.inputs import sobol_scores
    from workbench.extras.uncertainty.sample_runs import sample_answers
    from workbench.extras.uncertainty.sensitivity import (
        FEWEST_OF_A_KIND,
        FEWEST_ROWS,
        sobol_indices,
    )
    from workbench.models.base import make_model

    Number(FEWEST_ROWS, MOST_ROWS, integer=True).check("--samples", samples)
    uncertain = _uncertain(scenario, settings, seed)
    if not uncertain.independent:
        text = "makes indices of single inputs meaningless"
        raise InputError("correlation", "", text, "leave the table out")
    reduced = model or pair_of(uncertain.base, None, "")[0]
    chosen, count = make_model(reduced, pairs_of("--option", options)), processes(jobs)
    d = len(uncertain.inputs)
    scores = sobol_scores(2 * d, samples, (seed,))
    A, B = scores[:, :d], scores[:, d:]
    mixed = [np.where(np.arange(d) == i, B, A) for i in range(d)]
    with at_work(f"{reduced}, {samples * (d + 2)} samples, at work"):
        table = sample_answers(chosen, uncertain, np.vstack([A, B, *mixed]), count)
    if quantity not in table:
        scalars = [name for name in table.columns if table[name].dtype == float]
        text = f"is no scalar of these answers: {', '.join(scalars)}"
        raise InputError("--quantity", quantity, text)
    values = table[quantity].to_numpy(dtype=float).reshape(d + 2, samples)
    missing = np.isnan(values).astype(float)
    indices = sobol_indices(values[0], values[1], values[2:], seed)
    share = float(missing.mean())
    scarce = min(missing[:2].sum(axis=1).min(), (1.0 - missing[:2]).sum(axis=1).min())
    known = scarce >= FEWEST_OF_A_KIND  # else a resample may hold one kind alone
    fails = sobol_indices(missing[0], missing[1], missing[2:], seed) if known else None
    rows = []
    for i, name in enumerate(uncertain.names):
        row: dict[str, Any] = {"input": name}
        row |= {"first": indices.first[i], "total": indices.total[i]}
        if fails is not None:
            row |= {"first_missing": fails.first[i], "total_missing": fails.total[i]}
        rows.append(row)
    content = {
        "scenario": uncertain.base.name,
        "model": reduced,
        "quantity": quantity,
        "samples": samples,
        "missing_share": share,
        "indices": [
            {k: v if isinstance(v, str) else v._asdict() for k, v in row.items()} for row in rows
        ],
    }
    return Answer(content, _shown(uncertain, reduced, quantity, share, rows))


@verb
def rare(
    scenario: ScenarioFile,
    limit: str = option("What must not be exceeded.", ..., "displacement=METRES|collapse"),
    model: str | None = option("Name of a model.  [default: by the scenario]", None, "NAME"),
    cov: float = option("Coefficient of variation that is good enough.", 0.1),
    runs: int = option("Runs of the model, at most.", 5000),
    seed: int = option("Seed of the samples.", 1),
    jobs: Jobs = None,
    settings: Settings = None,
    options: Options = None,
) -> Answer:
    """Probability of a rare failure, by one model.

    That the impact exceeds a limit at its own velocity, which may be a distribution as may all
    other numbers; 1e-6 takes some 2000 runs. Exit status 0 if the coefficient of variation is as
    small as was asked, 1 if it is not or there is no probability, 2 for bad input.
    """
    import numpy as np

    from workbench.base.fields import Number
    from workbench.extras.uncertainty.critical_velocity import limit_of
    from workbench.extras.uncertainty.rare import Struck, rare_probability
    from workbench.models.base import make_model
    from workbench.study.batches import Processes

    Number(0.01, 1.0).check("--cov", cov)
    Number(2000, MOST, integer=True).check("--runs", runs)
    exceeded, uncertain = limit_of(limit), _uncertain(scenario, settings, seed)
    base = struck(uncertain.base)
    name = model or pair_of(base, None, "")[0]
    chosen, workers = make_model(name, pairs_of("--option", options)), processes(jobs)
    with at_work(f"{name} at work"), Processes(workers) as run:
        structure = Struck(uncertain, chosen, exceeded, run, workers)
        random = np.random.default_rng(seed)
        result = rare_probability(structure, len(uncertain.inputs), random, cov, runs)
    at = [values.tolist() for values in uncertain.values(result.points).values()]
    medians = (each.middle for each in uncertain.inputs.values())
    rows = [
        {"input": key, "median": median, "design_points": values}
        | ({"share": float(share)} if uncertain.independent else {})
        for key, median, values, share in zip(
            uncertain.names, medians, at, result.shares, strict=True
        )
    ]
    content = {
        "scenario": base.name,
        "model": name,
        "limit": str(exceeded),
        "probability": result.probability,
        "cov": result.cov,
        "band": list(result.band),
        "reliability_index": result.index,
        "without_answer": result.silent,
        "runs": result.runs,
        "inputs": rows,
    }
    event = "collapses" if exceeded.displacement == np.inf else f"exceeds {exceeded}"
    scatter = "90 %: {:.2g} to {:.2g}, coefficient of variation {:.2f}".format(
        *result.band, result.cov
    )
    text = f"{base.name}: {event} with probability {result.probability:.2g} ({scatter})"
    text += f", reliability index {result.index:.2f}; {name}, {sum(result.runs.values())} runs."
    columns: dict[str, Any] = {"input": "input", "median": lambda row: _number(row["median"])}
    for k in range(len(result.points)):
        columns[f"design point {k + 1}"] = lambda row, k=k: _number(row["design_points"][k])
    if uncertain.independent:
        columns["share"] = lambda row: Cell(f"{row['share']:.2f}", row["share"])
    caption = "Where failure is most likely, in SI; shares in the variance of the margin there."
    left_out = "The error of the model and that of the distributions is not in it."
    if result.silent > 0.0:
        left_out += f" Samples without an answer add {100.0 * result.silent:.2g} % at most."
    table = Table.of("design", caption, columns, rows)
    return Answer(content, (paragraph(text), paragraph(left_out), table), int(result.cov > cov))


def _number(value: Any) -> Cell | str:
    return Cell(f"{value:.4g}", value) if isinstance(value, float) else str(value)


def _uncertain(scenario: str, settings: list[str] | None, seed: int) -> UncertainScenario:
    from workbench.base.fields import Number
    from workbench.extras.uncertainty.inputs import load_uncertain

    Number(0, 2**32 - 1, integer=True).check("--seed", seed)
    uncertain = load_uncertain(scenario, settings or [])
    if not uncertain.inputs:
        advice = "write a distribution, such as velocity = { normal = [14.0, 2.0] }"
        raise InputError("scenario", uncertain.base.name, "has no uncertain input", advice)
    return uncertain


def _shown(
    uncertain: UncertainScenario, model: str, quantity: str, share: float, rows: list[Any]
) -> Iterator[Block]:
    text = f"{quantity.replace('_', ' ')} by {model}"
    yield paragraph(f"{uncertain.base.name}: {text}; {100.0 * share:.1f} % have no such answer.")

    columns = {"input": "input", "first": "first", "total": "total"}
    if "first_missing" in rows[0]:
        columns |= {"no answer: first": "first_missing", "no answer: total": "total_missing"}
    shown = [
        {key: value if key == "input" else _index(value) for key, value in row.items()}
        for row in rows
    ]
    caption = "Sobol indices, 90 % intervals; total is the share of the variance that is left "
    caption += "when all other inputs are known."
    yield Table.of("indices", caption, columns, shown)


def _index(index: Index) -> Cell:
    return Cell(f"{index.value:.2f} ({index.low:.2f} to {index.high:.2f})", index.value)
