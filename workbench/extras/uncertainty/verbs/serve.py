"""`workbench serve`: a model over HTTP, for samplers of other packages."""

from __future__ import annotations

import sys

from workbench.base.errors import InputError, message_of
from workbench.cli.output import Answer, Options, ScenarioFile, Settings, option, pairs_of, verb


@verb
def serve(
    scenario: ScenarioFile,
    over: list[str] = option("Key of a number that is input, once for each.", ..., "KEY"),
    model: str | None = option("Name of a model.  [default: by the scenario]", None, "NAME"),
    quantity: list[str] = option("Scalar that is output.", ["peak_displacement"], "NAME"),
    host: str = option("Address to listen at.", "127.0.0.1"),
    port: int = option("Port to listen at; 0: any that is free.", 4242),
    settings: Settings = None,
    options: Options = None,
) -> Answer:
    """Let other programs ask a model over HTTP.

    By the protocol of UM-Bridge, until Ctrl-C: input are the numbers of the scenario under --over,
    output the scalars under --quantity, all in SI. Exit status 0, 2 for bad input.
    """
    from workbench.base.fields import Number
    from workbench.extras.uncertainty.service import Server, Service
    from workbench.extras.uncertainty.verbs.fragility import pair_of
    from workbench.models.base import make_model, on_one_mesh
    from workbench.report.page.markdown import paragraph
    from workbench.scenarios import load_scenario

    Number(0, 65535, integer=True).check("--port", port)
    base = load_scenario(scenario, settings or [])
    name = model or pair_of(base, None, "")[0]
    chosen = on_one_mesh(make_model(name, pairs_of("--option", options)))
    service = Service(chosen, base, over, quantity)
    try:
        server = Server(service, host, port)
    except (OSError, ValueError) as error:
        text = f"cannot be listened at: {getattr(error, 'strerror', '') or message_of(error)}"
        raise InputError("--port", f"{host}:{port}", text, "take another one") from error
    address = f"http://{host}:{server.effective_port}"
    print(f"workbench: {name} is served at {address} until Ctrl-C", file=sys.stderr, flush=True)
    server.run()
    server.close()
    text = f"{server.count} evaluations of {name}."
    return Answer({"model": name, "evaluations": server.count}, [paragraph(text)])
