"""What every verb has in common: ``--json``, the text on a terminal, the exit status."""

import functools
import inspect
import json
import sys
from collections.abc import Callable, Iterable, Mapping
from typing import Annotated, Any, NamedTuple

import typer

from workbench.content.tree import Block

Json = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]


class InterruptedByUserError(Exception):
    """The user ended a verb; the message says what is left behind."""


class Answer(NamedTuple):
    """What a verb found: the `content` of its JSON object, the same as `blocks`, its exit status.

    `blocks` may be a generator: it does no work where JSON is asked for.
    """

    content: Mapping[str, Any]
    blocks: Iterable[Block] = ()
    status: int = 0


def verb(function: Callable[..., Answer]) -> Callable[..., int]:
    """A function as a verb: it gets the option ``--json``, prints its answer, returns the status.

    A function that has a parameter `as_json` itself is told.
    """
    signature = inspect.signature(function, eval_str=True)
    told = "as_json" in signature.parameters

    @functools.wraps(function)
    def answered(*arguments: Any, as_json: bool = False, **options: Any) -> int:
        if told:
            options["as_json"] = as_json
        answer = function(*arguments, **options)
        if as_json:
            json.dump(answer.content, sys.stdout, indent=2, ensure_ascii=False, allow_nan=False)
            sys.stdout.write("\n")
        else:
            from workbench.content.terminal import show

            show(*answer.blocks)
        return answer.status

    if not told:
        kind = inspect.Parameter.KEYWORD_ONLY
        option = inspect.Parameter("as_json", kind, default=False, annotation=Json)
        signature = signature.replace(parameters=[*signature.parameters.values(), option])
    answered.__signature__ = signature  # type: ignore[attr-defined]
    return answered
