"""Where the data files of the workbench are, and how files that a user names are opened."""

import hashlib
import os
import stat
from contextlib import suppress
from functools import cache
from getpass import getuser
from importlib.util import find_spec
from io import BufferedReader
from pathlib import Path
from tempfile import TemporaryFile, gettempdir, mkdtemp

from workbench.base.errors import InputError, WorkbenchError

OWN_DATA, OWN_DATA_VARIABLE = "lab_data", "WORKBENCH_DATA"
LARGEST_FILE = 20_000_000  # bytes; a row of tests has some 500, so this holds some 40 000


def data_directory(name: str = "data") -> Path:
    """Find the directory of the published data, or ``studies``, that come with the workbench.

    Inside an installed package it is ``workbench/_data``, in a source tree ``data`` beside the
    package. Raises `WorkbenchError` when neither exists.
    """
    package = Path(__file__).resolve().parents[1]
    for directory in (package / f"_{name}", package.parent / name):
        if directory.is_dir():
            return directory
    raise WorkbenchError(f"the {name} of the workbench are missing beside {package}")


def own_data_directory() -> Path:
    """The directory of the user's own data, which need not exist.

    What the variable `OWN_DATA_VARIABLE` of the environment names, else ``lab_data`` in the working
    directory.
    """
    return Path(os.environ.get(OWN_DATA_VARIABLE) or OWN_DATA)


def open_input(path: Path, field: str, largest: int = LARGEST_FILE) -> BufferedReader:
    """A file that a user names, opened to be read: regular, and of at most `largest` bytes.

    Refused before anything is read. Raises `InputError` naming `field`.
    """

    def opener(name: str, flags: int) -> int:  # without waiting for the writer of a pipe
        return os.open(name, flags | getattr(os, "O_NONBLOCK", 0))

    try:
        stream = open(path, "rb", opener=opener)  # noqa: SIM115  (handed out)
    except IsADirectoryError as error:
        raise InputError(field, str(path), "is a directory, not a file") from error
    except (OSError, ValueError) as error:  # ValueError: a zero byte in the name
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(field, str(path), f"cannot be read: {reason}") from error
    status = os.fstat(stream.fileno())
    if stat.S_ISREG(status.st_mode) and status.st_size <= largest:
        return stream
    stream.close()
    if not stat.S_ISREG(status.st_mode):
        text, advice = "is a pipe or a device, which may never end", "save it as a file"
        raise InputError(field, str(path), text, advice)
    limit = f"must not exceed {largest / 1e6:g} MB"
    raise InputError(field, f"{status.st_size / 1e6:.0f} MB", limit, "is this the right file?")


def digest(path: Path) -> str:
    """First digits of the SHA-256 of a file that a user names: the same table, the same digits."""
    with open_input(path, path.name) as stream:
        return hashlib.sha256(stream.read()).hexdigest()[:16]


def can_write(directory: Path) -> bool:
    """Whether files can be made in a directory, which is made if need be."""
    try:
        directory.mkdir(parents=True, exist_ok=True)
        with TemporaryFile(dir=directory):
            return True
    except OSError:
        return False


@cache
def private_folder() -> Path:
    """Temporary folder of this user alone, for who has no home or may not write there.

    One of its name that others made or may change is left alone: code from it would run.
    """
    folder = Path(gettempdir()) / f"workbench-{os.getuid() if hasattr(os, 'getuid') else getuser()}"
    with suppress(OSError):
        folder.mkdir(mode=0o700, exist_ok=True)
        status = folder.lstat()
        ours = status.st_uid == getattr(os, "getuid", int)()
        if stat.S_ISDIR(status.st_mode) and ours and (os.name == "nt" or not status.st_mode & 0o22):
            return folder
    return Path(mkdtemp(prefix="workbench-"))


def check_library(ending: str, field: str) -> None:
    """Refuse an ending whose library is not installed. Raises `InputError`."""
    if ending == "parquet" and find_spec("pyarrow") is None:
        reason = "needs pyarrow, which is not installed"
        raise InputError(field, ending, reason, "pip install 'steel-impact-workbench[tables]'")
