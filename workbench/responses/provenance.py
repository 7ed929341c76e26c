"""Where a number came from: versions, lock file, source state, kind of machine (no names)."""

import hashlib
import platform
import subprocess
from contextlib import suppress
from functools import cache
from importlib import metadata
from pathlib import Path

DISTRIBUTION = "steel-impact-workbench"  # its name where packages are installed from
_LIBRARIES = ("numpy", "scipy", "xarray", "numba")
_ROOT = Path(__file__).resolve().parents[2]


@cache
def provenance() -> dict[str, str]:
    """Versions, hash of the lock file, git commit, processor; never a host name or a path."""
    record = {"workbench": metadata.version(DISTRIBUTION), "python": platform.python_version()}
    for library in _LIBRARIES:
        record[library] = metadata.version(library)
    record["machine"] = f"{platform.system()} {platform.machine()}, {_processor()}"
    lock = _ROOT / "requirements.lock"
    if lock.is_file():
        record["requirements_lock"] = hashlib.sha256(lock.read_bytes()).hexdigest()[:16]
    commit = _git("rev-parse", "HEAD")
    if commit and (_ROOT / ".git").exists():
        dirty = bool(_git("status", "--porcelain", "--", "workbench", "data", "studies"))
        record["commit"] = commit[:12] + ("+changes" if dirty else "")
    return record


def _processor() -> str:
    with suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or "unknown processor"


def _git(*arguments: str) -> str:
    command = ["git", "-C", str(_ROOT), *arguments]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=10)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""
