"""Answers of the page while a hand moves the velocity, against the bare calls, in one run.

Prints the median time from a change of the field to the answers on the page, over the median of
`workbench.simulate` for the same models in this process: with the four-DOF column, with the anchor,
with both. The browser and its connection are not in it. Nothing here passes or fails.
"""

from __future__ import annotations

from statistics import median
from time import perf_counter, sleep

from workbench.api.answers import simulate
from workbench.extras.app.desk import Desk
from workbench.extras.app.page import ExplorerPage
from workbench.study.error_model.error_table import ANCHOR

MODELS = (("four-dof",), (ANCHOR,), ("four-dof", ANCHOR))
MOVES = 25
REST = 3.0  # s until what follows an answer is done


def main() -> None:
    """Move the hand, and print medians and ratios."""
    desk = Desk()
    page = ExplorerPage(None, desk)
    while page.busy or not page.responses:
        sleep(0.01)
    sleep(REST)
    print(f"{'models':42} {'page':>9} {'bare call':>10} {'ratio':>6}")
    for names in MODELS:
        page.alone(page.ask, list(names))
        sleep(1.0)
        shown, bare = [], []
        for move in range(MOVES):
            before, begun = page.responses, perf_counter()
            hand = {"key": "striker.velocity", "value": f"{20 + 0.37 * move}", "unit": "km/h"}
            page.alone(page.change, hand)
            while page.busy or page.responses is before:
                sleep(0.0002)
            shown.append(perf_counter() - begun)
            page.alone(page.stop)
            scenario = page.form.scenario.at_velocity((20 + 0.37 * move) / 3.6 + 1e-6)
            begun = perf_counter()
            for name in names:
                simulate(scenario, name)
            bare.append(perf_counter() - begun)
        of, alone = (1e3 * median(each[2:]) for each in (shown, bare))
        print(f"{', '.join(names):42} {of:6.1f} ms {alone:7.1f} ms {of / alone:6.2f}")
    desk.close()


if __name__ == "__main__":
    main()
