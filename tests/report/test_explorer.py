"""The explorer: what it holds is what was stored, and every control works in a browser."""

from __future__ import annotations

import csv
import io
import json
import re
import subprocess
from base64 import b64decode
from dataclasses import dataclass, replace
from html import unescape
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from builders import made_once
from chromium import browser_program
from hypothesis import given
from hypothesis import strategies as st
from synthetic_study import Synthetic, columns, shared_store_of
from toy_models import Troubled

from workbench.extras.uncertainty.scenario import UncertainImpact
from workbench.models.base import Answering, respond
from workbench.models.references.refine import refined
from workbench.report.chapters.answer import matrix_rows
from workbench.report.explorer import LARGEST, bokeh_script, explorer
from workbench.report.explorer.cells import packed
from workbench.responses import Finding, build_response
from workbench.responses.uncertainty import uncertainty_of
from workbench.scenarios import ColumnImpact, ColumnPushover, Striker
from workbench.steel.sections import find
from workbench.study import Case, Study
from workbench.study.assessor import Assessment, read_assessment

pytestmark = pytest.mark.thorough


def unpacked(kept, width=1):
    """The values (n, width) that `packed` kept, as a page sees them."""
    whole = np.frombuffer(b64decode(kept["n"]), dtype="<i2")
    return whole.reshape(-1, width) * kept["step"]


WICKED = "</script><script>noted.push('run')</script> <b>&quot;model"
ENDS = ("hard", "soft & <i>slow</i>")


@dataclass(frozen=True)
class Refining(Synthetic):
    """The closed form on three meshes, with an error of first order."""

    refinement: int = 2
    levels: int = 3

    name: ClassVar[str] = "synthetic-refining"

    def domain(self, scenario):
        text = "the striker is <fast>"
        return [Finding("speed", text, remedy="a <slower> one")] if self.gain > 1.1 else []

    def simulate(self, scenario):
        return respond(self, scenario, lambda asked: refined(self, asked, self.mesh))

    def mesh(self, scenario):
        response = replace(self, size=0.5**self.refinement)._solve(scenario)
        response.attrs["yield_ratio"] = 0.999
        return response


def a_study() -> Study:
    """Two sections at two velocities, answers of every kind, and a push that has no time."""
    base = columns()["thesis"]
    cases = [
        Case(
            f"{section}, {v:g} m/s",
            ColumnImpact(
                f"{section} {v}", replace(base, section=find(section)), Striker(1500.0, v)
            ),
            parameters={"section": section, "velocity in m/s": v, "energy in kJ": 0.75 * v**2},
        )
        for section in ("HEB 220", "HEA 240")
        for v in (10.0, 20.0)
    ]
    names = [case.name for case in cases]
    return Study(
        "explored",
        "Answers of <every> kind",
        "What does a reader see?",
        (*cases, Case("push", ColumnPushover("push", base, 0.3), models=("reference",))),
        {
            "reference": Refining(),
            "fast": Refining(gain=1.2, levels=1),
            WICKED: Synthetic(gain=0.97),
            "estimate": Synthetic(gain=1.03, extent="scalars", warns=False),
            "breaks": Synthetic(fails_above=12.0),
            "falls": Troubled("collapse", above=12.0),
            "refuses": Troubled("refuse"),
        },
        "reference",
        groups={ENDS[0]: tuple(names[:2]), ENDS[1]: tuple(names[2:])},
    )


@pytest.fixture(scope="module")
def stored(tmp_path_factory) -> Assessment:
    return shared_store_of(a_study(), tmp_path_factory)


@pytest.fixture(scope="module")
def page(stored) -> str:
    text = explorer(stored.study, stored)
    assert text is not None
    return text


@pytest.fixture(scope="module")
def frame_page(frames) -> str:
    text = explorer(frames.study, frames)
    assert text is not None
    return text


def data_of(page: str) -> dict[str, Any]:
    (inside,) = re.findall(r'<script type="application/json" id="data">(.*?)</script>', page, re.S)
    return json.loads(inside)


def cell_of(data: dict[str, Any], case: str, label: str) -> dict[str, Any]:
    (result,) = (each for each in data["cases"] if each["name"] == case)
    return next(cell for cell in result["cells"] if cell["model"] == label)


@given(
    st.lists(st.floats(-1e9, 1e9, allow_subnormal=False), min_size=1, max_size=12),
    st.sampled_from([1, 2, 3]),
)
def test_packed_numbers_come_back(values, width):
    table = np.array(values[: len(values) // width * width] or [0.0] * width).reshape(-1, width)
    kept = packed(table)
    back = unpacked(kept, width)
    largest = np.abs(table).max()
    assert np.abs(back - table).max() <= 0.51 * max(kept["step"], 1e-300) or largest < 1e-290
    assert kept["step"] <= largest / 32_000 or largest < 1e-290


def test_curves_are_those_that_were_stored(stored, page):
    data, case = data_of(page), "HEB 220, 10 m/s"
    response, cell = stored.response(case, "reference"), cell_of(data, case, "reference")
    time, moved = unpacked(cell["t"])[:, 0], unpacked(cell["d"])[:, 0]
    assert len(time) <= 502
    real = np.interp(time, response["time"].values, response["displacement"].values)
    assert np.abs(moved - real).max() < 2e-3 * real.max()
    assert moved.max() == pytest.approx(response["displacement"].values.max(), rel=1e-4)
    band = {name: unpacked(kept)[:, 0] for name, kept in cell["band"].items()}
    top = int(np.argmin(np.abs(band["t"] - float(response["time_of_peak"]))))
    half = (band["high"][top] - band["low"][top]) / 2.0
    assert half == pytest.approx(uncertainty_of(response, "peak_displacement"), rel=0.05)
    spent = unpacked(cell["energy"]["parts"]["dissipated"])[-1, 0]
    assert spent == pytest.approx(response["dissipated"].values[-1], rel=1e-4)
    shape = cell["shape"]
    assert shape["points"] == [2, 2]
    assert shape["chords"]
    moved_there = unpacked(shape["moved"], 8)[
        :, 3
    ]  # of the impact point, across the column that lies
    assert moved_there.max() == pytest.approx(moved.max(), rel=2e-3)
    assert "band" not in cell_of(data, case, "fast")
    assert "t" not in cell_of(data, case, "estimate")


def test_frames_bend_and_yield_as_stored(frames, frame_page):
    data = data_of(frame_page)
    assert [case["name"] for case in data["cases"]] == ["storeys", "from above", "shaken"]
    response, cell = frames.response("storeys", "rigid"), cell_of(data, "storeys", "rigid")
    points, members = cell["shape"]["points"], [str(name) for name in response["member"].values]
    assert set(points) == {2, 9}  # those that stay straight are sent by their ends
    first = 2 * sum(points[: members.index("C0-C1/1")])
    kept = unpacked(cell["shape"]["moved"], 2 * sum(points))
    moved = response["shape_x"].sel(member="C0-C1/1").values[-1]
    assert kept[:, first + 2 * points[members.index("C0-C1/1")] - 2] == pytest.approx(
        moved - moved[0], abs=2e-4
    )
    yields = (response["utilisation"].values.T >= 0.995).sum(axis=1)
    assert [len(result) for result in cell["shape"]["yields"]] == yields.tolist()
    assert data["cases"][0]["hit"][2:] == [6.0, 0.8]


def test_pages_are_bounded_and_say_what_they_leave_out(stored, page):
    assert len(page.encode()) < LARGEST
    bound = len(page.encode()) - 30_000  # most of so small a page is the library
    small = explorer(stored.study, stored, largest=bound)
    assert len(small.encode()) <= bound
    statements = "histories hold about {} of up to 1501 stored points"
    assert statements.format(500) in page
    assert statements.format(500) not in small
    peaks = [
        unpacked(cell_of(data_of(text), "HEB 220, 10 m/s", "reference")["d"]).max()
        for text in (page, small)
    ]
    assert peaks[0] == pytest.approx(peaks[1], rel=1e-4)
    assert "1 of the study's cases, which are pushed" in unescape(page)


def test_nothing_is_loaded_and_names_stay_names(page):
    """The library names addresses in its texts; the policy of the page lets it load none."""
    own = page.replace(bokeh_script(), "")
    assert len(own) < len(page) - 1_000_000
    assert not re.search(r"https?://(?!www\.w3\.org/2000/svg\")", own)
    assert not re.search(r"<(link|img|iframe|object|embed)\b|\bsrc=|@import|url\(|\beval\(", own)
    policy = (
        "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:"
    )
    assert f'"Content-Security-Policy" content="{policy}"' in page
    assert page.count("</script>") == 4
    assert WICKED not in page
    assert WICKED in [model["label"] for model in data_of(page)["models"]]


def test_equal_stores_give_equal_pages(stored, page):
    """Though the library numbers its models through the process."""
    assert explorer(stored.study, stored) == page


def test_a_study_without_motion_has_no_page(stored):
    study = replace(stored.study, cases=stored.study.cases[-1:], groups={})
    assert explorer(study, read_assessment(stored.directory, study)) is None


UNCERTAIN = """kind = "column-impact"
[column]
section = "HEB 220"
length_below = 1.0
length_above = 2.0
[striker]
mass = 1500.0
velocity = { normal = [10.0, 1.0] }
"""


@dataclass(frozen=True)
class Curves(Answering):
    """A fragility curve that rises from the limit in m times `at`."""

    at: float = 100.0

    name: ClassVar[str] = "synthetic-curves"
    version: ClassVar[int] = 1
    answers: ClassVar[tuple[str, ...]] = (UncertainImpact.KIND,)
    assumptions: ClassVar[tuple[str, ...]] = ("A straight line.",)
    sources: ClassVar[tuple[str, ...]] = ()

    def domain(self, scenario: Any) -> list[Finding]:
        return []

    def _solve(self, scenario: Any) -> Any:
        response, first = build_response({}), self.at * scenario.displacement
        edges = {"median": 0.0, "low": -0.05, "high": 0.05}
        response["curve.velocity"] = ("curve", np.linspace(first, first + 10.0, 101))
        for name, shift in edges.items():
            response[f"curve.{name}"] = ("curve", np.clip(np.linspace(0, 1, 101) + shift, 0, 1))
        for share in (10, 50, 90):
            response[f"velocity.at_{share}"] = ((), first + share / 10.0)
        for values in response.data_vars.values():
            values.attrs = {"units": "1", "long_name": "synthetic"}
        response.attrs["sampling_uncertainty"] = json.dumps({"velocity.at_50": 0.5})
        return response


@pytest.fixture(scope="module")
def curves_page(tmp_path_factory) -> str:
    def case(limit: float) -> Case:
        impact = UncertainImpact(f"{limit:g} m", tuple(UNCERTAIN.splitlines()), 1.0, 50.0, limit)
        return Case(f"limit {limit:g} m", impact, parameters={"limit in m": limit})

    study = Study(
        "fragile",
        "Curves",
        "How probable?",
        (case(0.1), case(0.2)),
        {"best": Curves(), "late": Curves(110.0)},
        "best",
        quantities=("velocity.at_50",),
    )
    text = explorer(study, shared_store_of(study, tmp_path_factory))
    assert text is not None
    return text


def test_curves_of_probability_are_explored_by_velocity_and_limit(curves_page):
    data = data_of(curves_page)
    assert data["plane"]["across"][:2] == ["impact velocity", "m/s"]
    (limits, _) = data["axes"]
    assert (limits["name"], limits["stops"], limits["at"]) == ("limit in m", ["0.1", "0.2"], [0, 1])
    cell = cell_of(data, "limit 0.2 m", "late")
    assert (cell["main"], cell["begin"]) == (27.0, 27.0)
    assert cell["row"][1] == "27.00 ± 0.50\u00a0m/s (sampling)"
    assert cell["error"] == pytest.approx(2.0 / 25.0)
    velocity, probability = (unpacked(cell[name])[:, 0] for name in ("t", "d"))
    assert np.interp(25.0, velocity, probability) == pytest.approx(0.3, abs=1e-3)
    low, high = (unpacked(cell["band"][name])[:, 0] for name in ("low", "high"))
    assert high[50] - low[50] == pytest.approx(0.1, abs=1e-3)
    assert "Deformed shape" not in curves_page
    assert "Where the energy is" not in curves_page


# What follows needs a browser: the pages drive themselves in frames of two widths.


FIRST = """<script>window.noted = [];
addEventListener("error", (event) => noted.push(String(event.message)));
addEventListener("unhandledrejection", (event) => noted.push(String(event.reason)));
addEventListener("securitypolicyviolation", (event) => noted.push(event.blockedURI));
const note = (...said) => {
  if (!said.join(" ").includes("initial ranges")) noted.push(said.join(" "));  // of empty plots
};
console.error = console.warn = note;
</script>"""
AROUND = """<!DOCTYPE html><pre>[]</pre>{frames}<script>
const found = [];
addEventListener("message", (event) => {{
  const which = [...document.querySelectorAll("iframe")].findIndex(
    (frame) => frame.contentWindow === event.source);
  found[which] = JSON.parse(event.data);
  document.querySelector("pre").textContent = JSON.stringify(found);
}});</script>"""


@pytest.fixture(scope="module")
def driven(page, frame_page, curves_page, tmp_path_factory) -> list[dict[str, Any]]:
    """What the driver found on the columns at 1400 and at 390 px, on the frames, on the curves."""
    program = browser_program()

    def drive(directory: Path) -> None:
        directory.mkdir(parents=True)
        script = Path(__file__).with_name("explorer_driver.js").read_text(encoding="utf-8")
        pages = {"columns": page, "frames": frame_page, "curves": curves_page}
        for name, text in pages.items():
            text = text.replace("<style>", f"{FIRST}<style>", 1)
            text = f"{text.rpartition('</body>')[0]}<script>{script}</script></body></html>"
            (directory / f"{name}.html").write_text(text, encoding="utf-8")
        shown = "".join(
            f'<iframe src="{name}.html" width="{width}" height="900"></iframe>'
            for name, width in (
                ("columns", 1400),
                ("columns", 390),
                ("frames", 1400),
                ("curves", 390),
            )
        )
        (directory / "around.html").write_text(AROUND.format(frames=shown), encoding="utf-8")
        command = [program, "--headless", "--no-sandbox", "--disable-gpu", "--dump-dom"]
        command += ["--virtual-time-budget=60000", "--window-size=1500,1000"]
        command += [f"--user-data-dir={directory / 'profile'}"]
        command.append((directory / "around.html").as_uri())
        ran = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
        (directory / "found.html").write_text(ran.stdout, encoding="utf-8")

    directory = made_once(tmp_path_factory, "explorer", drive)
    dumped = (directory / "found.html").read_text(encoding="utf-8")
    answer = json.loads(unescape(re.search(r"<pre>(.*?)</pre>", dumped, re.S).group(1)))
    assert len(answer) == 4
    for each in answer:
        assert each["errors"] == []
    return answer


@pytest.fixture
def driven_curves(driven) -> dict[str, Any]:
    return driven[3]


@pytest.fixture(params=[0, 1], ids=["1400 px", "390 px"])
def seen(request, driven) -> dict[str, Any]:
    return driven[request.param]


def test_a_page_fits_its_screen(driven):
    for result, width in zip(driven, (1400, 390, 1400, 390), strict=True):
        assert result["width"] == width
        assert result["overflow"] <= 0
        assert result["after"] <= 0


def test_sliders_over_limit_and_velocity_give_probabilities(driven_curves):
    assert driven_curves["start"]["case"] == "limit 0.1 m"
    assert driven_curves["start"]["values"] == ["0.5", "0.4"]
    assert [each[2] for each in driven_curves["sliders"]] == ["limit 0.1 m", "limit 0.2 m"]
    clocks, values = zip(*driven_curves["velocities"], strict=True)
    assert clocks == pytest.approx((20.0, 26.0, 32.0), abs=0.01)
    assert values == (["0", "0"], ["0.6", "0.4"], ["1", "1"])
    assert driven_curves["start"]["band"] == 2


def test_it_opens_with_a_case_and_its_models(seen):
    start = seen["start"]
    assert start["case"] == "HEB 220, 10 m/s"
    assert set(start["curves"]) <= set(start["checked"])
    assert {"reference", "fast", WICKED, "estimate"} <= set(start["curves"])
    assert start["band"] == 1
    assert start["time"] == pytest.approx(20.0)
    assert "estimate knows its peak only" in start["legend"]


def test_sliders_choose_the_nearest_stored_case(seen):
    moves = seen["sliders"]
    assert len(moves) == 2 + 2 + 2
    for axis, stop, case, which, *_ in moves:
        assert which.startswith(f"Stored case: {case} (")
        if axis == "velocity in m/s":
            assert case.endswith(f", {stop} m/s")
        elif axis == "section":
            assert case.startswith(stop)


def test_cases_can_be_walked(seen):
    names = [case.name for case in a_study().cases[:-1]]
    assert seen["cases"] == names
    assert [which for which, _ in seen["chosen"]] == [
        f"Stored case: {name} ({number} of 4)." for number, name in enumerate(names, 1)
    ]
    assert all("Errors against reference." in against for _, against in seen["chosen"])
    assert seen["ends"] == [False, True]
    assert seen["walked"] == names[-2::-1] + names[1:]


def test_boxes_show_and_hide_models(seen):
    """In the last case, where one fails, one collapses and one refuses."""
    assert [box[0] for box in seen["boxes"]] == list(a_study().models)
    for label, off, on in seen["boxes"]:
        drawn = label not in ("breaks", "falls", "refuses")
        assert off == [False, False] or on == [False, False], label
        assert [True, drawn] in (off, on), label
    count, curves, crosses, words = seen["all"]
    assert count == len(a_study().models)
    assert "falls" not in curves
    assert crosses == 1
    assert "× falls collapses" in words
    assert "breaks: not converged, no curve" in words
    assert seen["none"] == ["reference"]
    history, shape, download, says = seen["nothing"]
    assert "none is shown" in history
    assert "None of the models shown states a deformed shape" in shape
    assert download == "No curve is shown: there is nothing to download."
    assert says == "No model shown has answered with numbers."


def test_outcomes_and_warnings_stand_in_words(seen):
    rows = {row[0]: row for row in seen["rows"]}
    assert "collapse at 0.02 s and 0.5 m" in rows["falls"][2]
    assert rows["falls"][2].endswith("; reference survives")
    assert rows["refuses"][2].startswith("refused: ")
    assert "residual 0.00032" in rows["breaks"][2]
    assert rows["reference"][4] == "the reference"
    assert "±" in rows["reference"][3]
    assert rows["fast"][4].startswith("+")
    assert rows["fast"][2] == "answered, outside its domain"
    assert "fast: the striker is <fast>. Instead: a <slower> one." in seen["says"]


def test_energies_are_told(seen):
    values = {label: (points, words) for label, points, words in seen["energies"]}
    assert values["reference"][0] > 60
    assert "dissipated (plastic, algorithmic)" in values["reference"][1]
    assert values["estimate"] == (0, "estimate keeps no energies of this case (answered).")
    assert "collapses" in values["falls"][1]


def test_the_matrix_says_the_times(page, stored):
    rows = re.findall(
        r'<tr><th scope="row">(.*?)</tr>', page.partition('id="models"')[0], re.DOTALL
    )
    times = {
        unescape(row.partition("<")[0]): re.findall(r"<td[^>]*>(.*?)</td>", row)[-1] for row in rows
    }
    assert times == {row.label: row.time for row in matrix_rows(stored)}
    assert any(times.values())


def test_cells_of_the_matrix_lead_to_their_worst_case(seen, stored):
    assert len(seen["matrix"]) == 2 * len(a_study().models)
    for each in seen["matrix"]:
        assert each["pressed"] == [True]
        assert each["group"] in ENDS
        assert each["focus"] == each["model"]
        assert each["told"].startswith(f"{each['model']}, {each['group']}: ")
        assert tuple(each["open"]) == stored.study.groups[each["group"]]
        assert each["case"] in each["open"]
        if each["model"] == "falls":
            assert "1 collapsed" in each["text"]
            assert each["case"].endswith(" 20 m/s")


def test_time_moves_shapes_and_energies(driven):
    for result in driven[:3]:
        clocks = [each[0] for each in result["times"]]
        assert clocks[0] == 0.0
        assert len(set(clocks)) == 3
        for kind in (1, 2, 3):
            assert len({each[kind] for each in result["times"]}) == 3
        scales = {value: words for value, _, words in result["drawn"]}
        assert "Displacements drawn × 10" in scales["10"]
        assert "True to scale" in scales["1"]
        assert len({path for _, path, _ in result["drawn"]}) >= 5


def test_it_plays_and_pauses(driven):
    for result in driven[:3]:
        idle, running, during, paused, stopped, still, ended, last = result["play"]
        assert (idle, running, paused, ended) == ("Play", "Pause", "Play", "Play")
        assert 0.0 < during <= stopped == still < last


def test_points_of_the_sweep_lead_to_their_case(seen):
    kinds = {(x, y): counts for x, y, *counts in seen["sweeps"]}
    assert len(kinds) == 4 * 2
    assert all(circles >= 12 for circles, *_ in kinds.values())
    assert all(crosses == 2 for _, crosses, _ in kinds.values())
    assert all(lines == 5 * (y == "error") for (_, y), (*_, lines) in kinds.items())
    assert seen["clicked"] == "HEA 240, 20 m/s"


def test_histories_are_downloaded(seen, stored):
    table = list(csv.DictReader(io.StringIO(seen["csv"])))
    assert list(table[0]) == ["case", "label", "time_s", "displacement_m"]
    case = table[0]["case"]
    assert {row["case"] for row in table} == {case}
    assert {row["label"] for row in table} == {"reference", "fast", WICKED}
    top = max(float(row["displacement_m"]) for row in table if row["label"] == "reference")
    peak = stored.number(case, "reference", "peak_displacement")
    assert top == pytest.approx(peak, rel=1e-3)
    assert seen["download"] == "explored-HEA-240-20-m-s.csv"
    assert seen["told"] == f"{len(table)} points of 3 curves."


def test_a_link_restores_the_view(driven):
    for result in driven[:3]:
        before, between, after = result["restored"]
        assert before == after
        assert before != between
        assert result["link"]
        assert result["nonsense"].startswith("Stored case: ")


def test_hinges_of_frames_are_marked(driven):
    assert driven[2]["circles"][0] > 0  # rigid
    assert driven[2]["circles"][2] == 0  # bare: without hinges


STACKED = """(() => {
  const rows = [...document.querySelectorAll("table.stacks tbody tr")].filter(
    (row) => row.getBoundingClientRect().width);
  const cells = rows.flatMap((row) => [...row.cells]);
  parent.postMessage(JSON.stringify({
    rows: rows.length,
    beyond: cells.filter((cell) => cell.getBoundingClientRect().right > innerWidth).length,
    beside: rows.filter((row) => row.cells[1].getBoundingClientRect().top <
      row.cells[0].getBoundingClientRect().bottom - 2).length,
    heads: cells.filter((cell) => cell.dataset.head).map((cell) => cell.dataset.head),
  }), "*");
})()"""


def test_a_phone_shows_all_columns_of_the_matrix_and_of_the_verdicts(page, built, tmp_path) -> None:
    """Rows are blocks at 390 px, a line for each cell with the head of its column; not at 1400."""
    frames, pages = "", {"explorer": page, "report": built["html"].read_text(encoding="utf-8")}
    for name, text in pages.items():
        text = re.sub(r"<meta http-equiv[^>]*>", "", text).rpartition("</body>")[0]
        text = f"{text}<script>{STACKED}</script></body></html>"
        (tmp_path / f"{name}.html").write_text(text, encoding="utf-8")
        for width in (390, 1400):
            style = f"width: {width}px; height: 900px"
            frames += f'<iframe src="{name}.html" style="{style}"></iframe>'
    around = tmp_path / "around.html"
    around.write_text(AROUND.format(frames=frames), encoding="utf-8")
    flags = ["--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=20000"]
    found = subprocess.run(
        [browser_program(), *flags, "--dump-dom", around.as_uri()],
        check=True,
        capture_output=True,
        text=True,
        timeout=120,
    ).stdout
    listed = json.loads(unescape(re.search(r"<pre>(.*?)</pre>", found, re.DOTALL)[1]))
    for phone, wide in (listed[:2], listed[2:]):
        assert phone["rows"] > 0
        assert (phone["beyond"], phone["beside"]) == (0, 0)
        assert wide["beside"] == wide["rows"]
    assert "solving took" in listed[0]["heads"]
    assert {"verdict", "bound", "cases passed"} <= set(listed[2]["heads"])
