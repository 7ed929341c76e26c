"""Page in a browser: a structure at the left, its answers at the right; tests on studs below."""

from importlib.util import find_spec

from workbench.base.errors import InputError


def check_panel(field: str) -> None:
    """Refuse what needs Panel where that is not installed. Raises `InputError`."""
    if find_spec("panel") is None:
        advice = "pip install 'steel-impact-workbench[app]'"
        raise InputError(field, None, "needs panel, which is not installed", advice)
