"""Desk of the page: worker processes that answer, and end where a model takes too long.

The process of the page computes nothing, so a model that hangs, or crashes, costs its own answer.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from importlib import import_module
from multiprocessing import get_context
from typing import Any, NamedTuple

from pebble import ProcessExpired, ProcessPool

from workbench.base.errors import message_of
from workbench.study.runner import deaf_to_interrupts, end_with_parent

LIMIT = 300.0  # s that a model may take
# lanes: what follows the hand, what follows that, slow models, files
LIVE, FOLLOWING, ASKED, FILES = "live", "following", "asked", "files"
_LIVE_LIMIT = 90.0  # s; the first answer of a model compiles it
NEAR = (0.5, 1.5)  # ends of a small curve, times the value given


class SmallCurve(NamedTuple):
    """Peaks (m) of a model over values (SI) of a key; infinite at a collapse, NaN unknown."""

    key: str
    unit: str
    values: Any
    peaks: Any


class Desk:
    """A worker process for each lane, so that slow work never holds up what follows the hand.

    Argument: `limit`, s that one answer may take.
    """

    def __init__(self, limit: float = LIMIT) -> None:
        self.limit = limit
        self._pools: dict[str, Any] = {}
        self.ask(_begin, lane=LIVE)

    def ask(
        self, function: Callable[..., Any] | str, *arguments: Any, lane: str = ASKED
    ) -> Future[Any]:
        """A function of a module at work in the worker of a lane, within the time limit.

        One of this room by its name, ``work.answers``: the page then need not import it.
        """
        if isinstance(function, str):
            function, arguments = _named, (function, *arguments)
        pool = self._pools.get(lane)
        if pool is None or not pool.active:
            context = get_context("spawn")
            pool = self._pools[lane] = ProcessPool(1, initializer=end_with_parent, context=context)
        with deaf_to_interrupts():
            limit = min(_LIVE_LIMIT, self.limit) if lane == LIVE else self.limit
            future: Future[Any] = pool.schedule(function, arguments, timeout=limit)
        return future

    def close(self) -> None:
        """End the workers, with what they are at."""
        for pool in self._pools.values():
            pool.stop()
            pool.join()


def _named(name: str, *arguments: Any) -> Any:
    """Result of a function of this room, by its module and name."""
    module, _, function = name.partition(".")
    return getattr(import_module(f"workbench.extras.app.{module}"), function)(*arguments)


def _begin() -> None:
    """Have the worker answer once, so that its libraries and kernels are there."""
    scenarios, new = (import_module(f"workbench.{name}") for name in ("scenarios", "cli.new"))
    _named("work.answers", scenarios.load_scenario(new.TEMPLATES / "column.toml.txt"))


def trouble(error: BaseException) -> str:
    """Sentence on why a worker gave no result."""
    if isinstance(error, TimeoutError):
        return "no answer within the time limit: the model was stopped; take another one"
    if isinstance(error, ProcessExpired):
        return "the process of the model ended without an answer: it crashed; take another one"
    return message_of(error)
