"""Writing files so that a reader sees the old content or the new one, never a half."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

TEMPORARY = ".partial"


def write_atomically(path: Path, content: bytes) -> None:
    """Write, flush to the disk, then rename into place.

    A process killed in between leaves a file ending in `TEMPORARY`, which nobody reads.
    """
    temporary = path.with_name(f"{path.name}.{os.getpid()}{TEMPORARY}")
    try:
        with temporary.open("wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        temporary.replace(path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def canonical_json(content: Any) -> bytes:
    """JSON with sorted keys, two-space indents and a final newline; refuses NaN."""
    text = json.dumps(
        content, sort_keys=True, indent=2, ensure_ascii=False, allow_nan=False, default=_plain
    )
    return (text + "\n").encode()


def _plain(value: Any) -> Any:
    if hasattr(value, "item"):
        return value.item()  # a NumPy scalar, as sweeps often carry
    raise TypeError(f"{type(value).__name__} cannot be stored as JSON")
