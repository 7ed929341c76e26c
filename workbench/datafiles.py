"""Where the data files of the workbench are, in a source tree and in an installed package."""

from pathlib import Path

from workbench.errors import WorkbenchError


def data_directory() -> Path:
    """Find the directory of the published data that come with the workbench.

    Inside an installed package it is ``workbench/_data``, in a source tree ``data`` beside the
    package. Raises `WorkbenchError` when neither exists.
    """
    package = Path(__file__).resolve().parent
    for directory in (package / "_data", package.parent / "data"):
        if directory.is_dir():
            return directory
    raise WorkbenchError(f"the data files of the workbench are missing beside {package}")
