"""Steel-impact validation workbench: how far each reduced model can be trusted, at what cost.

``import workbench as wb`` imports nothing heavy; the names below come in with their first use.
They and the attributes of their results are public: within a minor version they keep their
arguments and their meaning. Everything else may move; docs/guide/python.md.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from workbench.api.answers import *  # noqa: F403
    from workbench.api.sweeps import *  # noqa: F403
    from workbench.base.errors import *  # noqa: F403
    from workbench.models.base import *  # noqa: F403
    from workbench.scenarios import *  # noqa: F403
    from workbench.steel.materials import *  # noqa: F403
    from workbench.study import *  # noqa: F403

__version__ = "1.0.0"

_PUBLIC = {  # room: names that it gives
    "base.errors": ("InputError", "WorkbenchError"),
    "steel.materials": ("Steel",),
    "scenarios": (
        *("Column", "ColumnImpact", "ColumnPushover", "Striker", "Pulse", "MemberPulse"),
        *("Frame", "Node", "Member", "Joint", "Load", "FrameStriker", "regular_frame"),
        *("FrameImpact", "FrameStatic", "FramePulse", "FrameGroundMotion", "StudTests"),
    ),
    "models.base": ("make_model", "model_names"),
    "study": ("Study", "Case", "Figure", "Gate", "Budget", "load_study", "run_study"),
    "api.sweeps": ("simulate_many", "sweep"),
    "api.answers": (
        *("Comparison", "compare", "fit_residual", "impact", "load", "simulate", "study_of"),
    ),
}
_ROOMS = {name: room for room, names in _PUBLIC.items() for name in names}
__all__ = ["__version__", *_ROOMS]


def __getattr__(name: str) -> Any:
    """A public name, from its room, which is imported now."""
    if name in _ROOMS:
        value = getattr(import_module(f"workbench.{_ROOMS[name]}"), name)
    elif name in (offers := _offers()):
        value = offers[name].load()
    else:
        raise AttributeError(f"module 'workbench' has no attribute {name!r}")
    globals()[name] = value
    return value


def _offers() -> dict[str, Any]:
    """Names that companions add, by entry points."""
    return {each.name: each for each in import_module("workbench.base.offered").offered("names")}


def __dir__() -> list[str]:
    """All public names, for completion."""
    return sorted({*globals(), *_ROOMS, *_offers()})
