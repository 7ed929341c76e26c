"""The seal of the impact bench: ``python data/bench/rotate.py OLD.json NEW.json``.

Opens the sealed half of the references with its key, holds it to the commitments, and seals the
other half under a new salt. A key holds the salt and the sealed answers. It is the organiser's and
never lies in the repository.
"""

import json
import secrets
import sys
import tomllib
from collections.abc import Collection, Mapping
from pathlib import Path

import tomli_w

from workbench.extras.bench.cases import (
    CASE,
    ReferenceAnswer,
    commitment,
    key_of,
    load_bench,
    opened,
)
from workbench.study.store import write_atomically

HERE = Path(__file__).resolve().parent


def seal(
    folder: Path,
    answers: Mapping[str, ReferenceAnswer],
    sealed: Collection[str],
    key: Path,
    before: str = "",
) -> None:
    """Write the key, then every answer into its case: of those to be sealed the commitment.

    What is opened keeps its commitment, and the salt `before`, so that anyone can check it.
    """
    salt = secrets.token_hex(32)
    held = {"salt": salt, "sealed": {name: answers[name].text for name in sorted(sealed)}}
    with key.open("x", encoding="utf-8") as stream:  # no key that opens something is overwritten
        json.dump(held, stream, indent=1)
    texts = {}  # all of them, before the first is written
    for name, answer in answers.items():
        file = folder / name / CASE
        content = tomllib.loads(file.read_text(encoding="utf-8"))
        old = content.get("reference", {}).get("commitment", "")
        if old and before:
            content["opened"] = {"commitment": old, "salt": before}
        secret = {"commitment": commitment(salt, name, answer.text)}
        content["reference"] = secret if name in sealed else answer.table
        texts[file] = tomli_w.dumps(content).encode()
    for file, text in texts.items():
        write_atomically(file, text)


def rotate(folder: Path, old: Path, new: Path) -> None:
    """Open the sealed references of a folder with the `old` key, seal the others with a `new`."""
    cases = load_bench(folder)
    known, (salt, _) = opened(cases, old), key_of(old)
    seal(folder, known, {case.name for case in cases if not case.seal}, new, salt)


if __name__ == "__main__":
    rotate(HERE, Path(sys.argv[1]), Path(sys.argv[2]))
