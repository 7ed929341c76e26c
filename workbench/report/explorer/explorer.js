(async () => {
const at = (id) => document.getElementById(id), json = (id) => JSON.parse(at(id).textContent);
const data = json("data"), { plane, models, cases, axes, colors } = data;
await Bokeh.embed.embed_items(...json("plots"));
const of = (name) => Bokeh.documents[0].get_model_by_name(name);
const fill = (name, rows, columns) => {
  of(name).data = Object.fromEntries(columns.map((key, i) => [key, rows.map((row) => row[i])]));
};
const [across, upward] = [plane.across[2], plane.upward[2]], moves = plane.moves;
const boxes = [...document.querySelectorAll("#models input")], buttons = [...document.querySelectorAll("#matrix button")];
const state = { case: null, group: "", focus: "", shown: new Set(), time: 0, cell: null };
let timer = null, quiet = false;

const unpack = ({ step, n }) => Array.from(new Int16Array(Uint8Array.from(atob(n), (c) => c.charCodeAt(0)).buffer), (v) => v * step);
const decoded = (part) => part && Object.fromEntries(Object.entries(part).map(([key, value]) => [key, value?.step ? unpack(value) : value]));
const curves = (one) => {  // decoded once, when their case is shown
  if (one.t?.step) Object.assign(one, decoded(one), { band: decoded(one.band), shape: decoded(one.shape), energy: one.energy && { ...decoded(one.energy), parts: decoded(one.energy.parts) } });
  return one;
};
const model = (one) => models.find((each) => each.label === one.model);
const shown = () => state.case.cells.filter((one) => state.shown.has(one.model)).map(curves).sort((a, b) => (a.model === state.focus) - (b.model === state.focus));
const look = (one) => [one.model, model(one).color, model(one).width * (one.model === state.focus ? 2 : 1.3)];
const nearest = (places, place) => places.reduce((k, value, i) => (Math.abs(value - place) < Math.abs(places[k] - place) ? i : k), 0);
const scaled = (values, factor) => values.map((value) => factor * value);
const inGroup = () => (state.group ? cases.filter((each) => data.groups[state.group].includes(each.name)) : cases);
const ends = () => {
  const known = state.case.cells.map(curves).filter((one) => one.t);
  return [moves || !known.length ? 0 : Math.min(...known.map((one) => one.t[0])), Math.max(1e-9, ...known.map((one) => one.t.at(-1)))];
};
const digits = (value, unit) => `${Number(value.toPrecision(3))} ${unit}`.trim();

const drawHistory = () => {
  const rows = [], crosses = [], bands = [], notes = [], [begin, end] = ends();
  shown().forEach((one) => {
    const { t, d, band, collapse, main, width } = one, [label, color, wide] = look(one), edge = (low, high, places) => bands.push([scaled([...places, ...places.toReversed()], across), scaled([...low, ...high.toReversed()], upward), moves ? colors.band : color]);
    if (t) rows.push([scaled(t, across), scaled(d, upward), label, color, wide, model(one).dash]);
    else if (collapse) { crosses.push([across * (collapse[0] ?? end), upward * collapse[1], color]); notes.push(`× ${label} collapses${collapse[0] === null ? " (time not known)" : ""}.`); }
    else if (moves && main !== undefined) { rows.push([[across * begin, across * end], [upward * main, upward * main], label, color, wide, "2 4"]); notes.push(`Dotted level: ${label} knows its peak only.`); }
    else notes.push(`${label}: ${one.ends}, no curve.`);
    if (band) edge(band.low, band.high, band.t);
    else if (moves && !t && width && label === state.case.reference) edge([main - width, main - width], [main + width, main + width], [begin, end]);
    if (moves && bands.length && label === state.case.reference) notes.push(`Band: uncertainty of ${label}, the governing reference.`);
  });
  fill("lines", rows, ["x", "y", "label", "color", "width", "dash"]);
  fill("ends", crosses, ["x", "y", "color"]);
  fill("band", bands, ["x", "y", "color"]);
  at("history-words").textContent = [...notes, plane.band].join(" ").trim() || (rows.length ? "" : "No model shown has a number in this case: none is shown.");
};

// Members of one answer at a snapshot.
const members = (shape, k, times) => {
  let n = 2 * k * shape.points.reduce((sum, many) => sum + many, 0);
  return state.case.rest.map(([ax, ay, bx, by], m) => [...Array(shape.points[m]).keys()].map((p) => {
    const share = p / (shape.points[m] - 1);
    n += 2;
    return [ax + share * (bx - ax) + times * shape.moved[n - 2], ay + share * (by - ay) + times * shape.moved[n - 1]];
  }));
};
const column = (points, i) => points.map((point) => point[i]);
const magnified = () => Number(of("times").value || state.case.times);
const drawShape = () => {
  const { rest = [], held = [], hit } = state.case, known = shown().filter(({ shape }) => shape);
  fill("rest", rest.map(([ax, ay, bx, by]) => [[ax, bx], [ay, by]]), ["x", "y"]);
  fill("held", held, ["x", "y", "marker"]);
  fill("hit", hit ? [hit] : [], ["x_start", "y_start", "x_end", "y_end"]);
  const corners = [...rest, ...rest.map((line) => line.slice(2)), ...(hit ? [hit] : [])].map(([x, y]) => [x, y]);
  known.forEach(({ shape }) => shape.t.forEach((time, k) => corners.push(...members(shape, k, magnified()).flat())));
  const [xs, ys] = [0, 1].map((i) => column(corners, i)), edges = (all) => [all.reduce((a, b) => Math.min(a, b), Infinity), all.reduce((a, b) => Math.max(a, b), -Infinity)];
  fill("box", corners.length ? [0, 1].map((i) => [edges(xs)[i], edges(ys)[i]]) : [], ["x", "y"]);
};
const moveShape = () => {
  const rows = [], circles = [], known = shown(), times = magnified(), taken = [];
  known.filter(({ shape }) => shape).forEach((one) => {
    const { shape } = one, k = nearest(shape.t, state.time), lines = members(shape, k, times);
    taken.push(across * shape.t[k]);
    lines.forEach((line) => rows.push([column(line, 0), column(line, 1), ...look(one), model(one).dash]));
    if (one.model === state.focus && shape.yields) lines.flatMap((line) => [line[0], line.at(-1)]).forEach((place, h) => {
      if (shape.yields.slice(0, k + 1).some((all) => all.includes(h))) circles.push([...place, shape.yields[k].includes(h) ? colors.yields : "white"]);
    });
  });
  fill("shapes", rows, ["x", "y", "label", "color", "width", "dash"]);
  fill("hinges", circles, ["x", "y", "color"]);
  const without = known.filter(({ shape }) => !shape).map((one) => one.model), chords = known.filter(({ shape }) => shape?.chords).map((one) => one.model);
  at("shape-words").textContent = [
    taken.length ? `${times === 1 ? "True to scale" : `Displacements drawn × ${times}`}${state.case.upright ? ", the column lying, its base on the left" : ""}${state.case.aside ? "; above seen across the hit, below along it" : ""}; stored snapshots nearest to the cursor: ${[...new Set([Math.min(...taken), Math.max(...taken)])].map((v) => digits(v, "ms")).join(" to ")}.` : "None of the models shown states a deformed shape in this case.",
    chords.length && `Straight lines: ${chords.join(", ")} (the shape between is not known).`,
    known.some((one) => one.model === state.focus && one.shape?.yields) && `Circles: where ${state.focus} yields (filled) or has yielded (open).`,
    without.length && `No shape stored: ${without.join(", ")}.`,
  ].filter(Boolean).join(" ");
};

const focused = () => state.case.cells.map(curves).find((one) => one.model === state.focus);
const drawEnergy = () => {
  const { energy } = focused() ?? {}, source = of("energy"), names = Object.keys(source.data).slice(2);
  const part = (name) => (energy ? (energy.parts[name] ? scaled(energy.parts[name], 1e-3) : energy.t.map(() => 0)) : []);
  source.data = { t: scaled(energy?.t ?? [], 1e3), brought: scaled(energy?.in ?? [], 1e-3), ...Object.fromEntries(names.map((name) => [name, part(name)])) };
};
const moveEnergy = () => {
  const one = focused(), energy = one?.energy, k = energy && nearest(energy.t, state.time), source = of("energy").data;
  at("energy-words").textContent = energy ? `${state.focus} at ${digits(1e3 * energy.t[k], "ms")}: ${data.parts.filter(([name]) => name in energy.parts).map(([name, title]) => `${title} ${digits(source[name][k], "kJ")}`).join(", ")}; brought in so far ${digits(source.brought[k], "kJ")}.` : `${state.focus} ${one ? `keeps no energies of this case (${one.ends})` : "was not asked this case"}.`;
};

const drawSweep = () => {
  const kind = of("y").value, axis = axes.find((one) => one.name === of("x").value), group = new Set(inGroup());
  const factor = kind === "error" ? 100 : plane.main[2], rows = [], rings = [];
  cases.forEach((each, i) => each.cells.forEach((one) => {
    const fallen = one.ends === "collapses", value = fallen ? 0 : one[kind], bold = one.model === state.focus, x = axis.place[i];
    if (!state.shown.has(one.model) || value === undefined || x === null) return;
    const { color } = model(one);
    rows.push([x, factor * value, one.model, each.name, color, one.outside ? "white" : color, bold ? 10 : 6, fallen ? "x" : "circle", group.has(each) ? (bold ? 1 : 0.6) : 0.12, fallen ? 2.4 : 1.3]);
    if (each === state.case) rings.push([x, factor * value]);
  }));
  fill("points", rows.sort((a, b) => a[6] - b[6]), ["x", "y", "label", "case", "color", "fill", "size", "marker", "alpha", "width"]);
  fill("ring", rings, ["x", "y"]);
  fill("bounds", kind === "error" ? data.bounds.map((y) => [y, y ? "dashed" : "solid"]) : [], ["y", "dash"]);
  const [x, y] = [of("sweep-across"), of("sweep-upward")];
  x.ticker.ticks = axis.ticks.map(([place]) => place);
  x.major_label_overrides = new Map(axis.ticks);
  [x.axis_label, y.axis_label] = [axis.name, kind === "error" ? `error of the ${plane.main[0]} (%)` : data.titles[1]];
};

const tellCase = () => {
  at("about").textContent = state.case.about;
  at("says").replaceChildren();
  const say = (label, words) => { at("says").appendChild(document.createElement("li")).textContent = `${label}${words}`; };
  boxes.forEach((box) => {
    const one = state.case.cells.find((each) => each.model === box.value), row = box.closest("tr"), seen = box.checked = state.shown.has(box.value);
    row.className = `${box.value === state.focus ? "focus" : ""} ${seen ? "" : "off"}`;
    [...row.cells].slice(2).forEach((cell, i) => {
      cell.textContent = (i === 2 && box.value === state.case.reference ? "the reference" : one?.row[i]) || (i || one ? "–" : "not asked");
      cell.className = !one ? "" : i === 2 ? one.tone ?? "" : i === 0 && one.apart ? "bad" : "";
    });
    if (one && seen) one.says.forEach((words) => say(box.value, `: ${words}`));
  });
  if (!at("says").children.length) say("", shown().some(({ ends }) => ends?.startsWith("answered")) ? "The models shown say nothing against their answers." : "No model shown has answered with numbers.");
};
const tellMatrix = () => {
  buttons.forEach((button) => button.setAttribute("aria-pressed", String(button === state.cell)));
  if (!at("cell")) return;
  at("cell").hidden = !state.cell;
  if (state.cell) at("cell").textContent = `${state.cell.dataset.model}, ${state.cell.dataset.group}: ${state.cell.dataset.words}. Shown below: ${state.case.name}.`;
};
const moveTo = (time) => {
  const [begin, end] = ends();
  state.time = Math.min(Math.max(time, begin), end);
  const silent = quiet;
  quiet = true;
  of("time").setv({ start: across * begin, end: across * end, step: (across * (end - begin)) / 400 || 1, value: across * state.time });
  quiet = silent;
  of("cursor").location = across * state.time;
  const dots = shown().filter(({ t }) => t).map((one) => [one, nearest(one.t, state.time)]);
  fill("dots", dots.map(([one, k]) => [across * one.t[k], upward * one.d[k], model(one).color]), ["x", "y", "color"]);
  boxes.forEach((box) => {
    const one = state.case.cells.find((each) => each.model === box.value), words = box.closest("tr").cells[1];
    words.textContent = one?.t ? digits(upward * one.d[nearest(one.t, state.time)], plane.upward[1]) : "–";
  });
  if (moves) { of("energy-cursor").location = across * state.time; moveShape(); moveEnergy(); }
};
const refresh = () => {
  shown();
  drawHistory();
  if (moves) { drawShape(); drawEnergy(); }
  drawSweep();
  tellCase();
  tellMatrix();
  moveTo(state.time);
};
// The address holds the state, so that a link opens the same view.
const settle = () => {
  const link = new URLSearchParams({ case: state.case.name, f: state.focus, t: state.time.toPrecision(4), g: state.group, c: buttons.indexOf(state.cell) });
  ["x", "y", "times"].filter(of).forEach((name) => link.set(name, of(name).value));
  state.shown.forEach((label) => link.append("m", label));
  history.replaceState(null, "", `#${link}`);
};
const choose = (here, time = NaN) => {
  const fresh = here !== state.case, open = inGroup(), index = open.indexOf(here), i = cases.indexOf(here);
  state.case = here;
  const best = [here.cells.find((one) => one.model === here.reference), ...here.cells].find((one) => one?.begin !== undefined);
  if (Number.isFinite(time)) state.time = time;
  else if (fresh) state.time = best?.begin ?? 0;
  quiet = true;
  if (of("group")) of("group").value = state.group;
  of("case").setv({ options: open.map((each) => each.name), value: here.name });
  of("focus").value = state.focus;
  axes.forEach((axis, k) => { if (of(`axis-${k}`) && axis.at[i] !== null) of(`axis-${k}`).value = axis.stops[axis.at[i]]; });
  of("previous").disabled = index <= 0;
  of("next").disabled = index < 0 || index >= open.length - 1;
  quiet = false;
  at("which").textContent = `Stored case: ${here.name} (${index + 1} of ${open.length}${state.group ? ` in ${state.group}` : ""}).`;
  refresh();
  settle();
};
// The nearest case in shares of each range; the control that moved counts most.
const slide = (moved) => {
  const far = (each) => axes.reduce((sum, axis, k) => {
    const wanted = of(`axis-${k}`) && cases.findIndex((one, j) => axis.stops[axis.at[j]] === of(`axis-${k}`).value);
    if (wanted === null || wanted === undefined) return sum;
    const [a, b] = [axis.place[cases.indexOf(each)], axis.place[wanted]], places = axis.place.filter((v) => v !== null);
    const share = a === null ? 1 : axis.words ? 2 * (a !== b) : (a - b) / (Math.max(...places) - Math.min(...places));
    return sum + (k === moved ? 10 : 1) * share ** 2;
  }, 0);
  choose(inGroup().map((each) => [far(each), each]).reduce((a, b) => (b[0] < a[0] ? b : a))[1]);
};
const enter = (group) => {
  state.group = group;
  return inGroup().includes(state.case) ? state.case : inGroup()[0];
};
const show = (labels) => { state.shown = new Set(labels); refresh(); settle(); };
const stop = () => { clearInterval(timer); timer = null; quiet = true; of("play").setv({ active: false, label: "Play" }); quiet = false; };
const on = (name, property, act) => of(name)?.properties[property].change.connect(() => { if (!quiet) act(of(name)[property]); });
const press = (name, act) => of(name).on_event("button_click", act);

on("group", "value", (group) => { state.cell = null; choose(enter(group)); });
axes.forEach((axis, k) => on(`axis-${k}`, "value", () => slide(k)));
on("case", "value", (name) => choose(cases.find((each) => each.name === name)));
[["previous", -1], ["next", 1]].forEach(([name, by]) => press(name, () => { const open = inGroup(); choose(open[open.indexOf(state.case) + by]); }));
on("focus", "value", (label) => { state.focus = label; refresh(); settle(); });
["x", "y", "times"].forEach((name) => on(name, "value", () => { refresh(); settle(); }));
boxes.forEach((box) => box.addEventListener("change", () => { state.shown[box.checked ? "add" : "delete"](box.value); show(state.shown); }));
press("all", () => show(models.map((each) => each.label)));
press("none", () => show(models.filter((each) => each.rank).map((each) => each.label)));
on("time", "value", (value) => { if (timer) stop(); moveTo(value / across); });
on("time", "value_throttled", settle);
["tap", "pan"].forEach((kind) => of("history-plot").on_event(kind, (event) => { stop(); moveTo(event.x / across); settle(); }));
on("play", "active", (active) => {
  if (!active) { stop(); settle(); return; }
  const [begin, end] = ends(), pause = 40, seconds = 6;
  if (state.time >= end) moveTo(begin);
  of("play").label = "Pause";
  let last = performance.now();
  timer = setInterval(() => {
    const now = performance.now(), passed = Math.min(now - last, 5 * pause);  // hidden pages sleep
    last = now;
    moveTo(state.time + ((end - begin) * passed) / 1000 / seconds);
    if (state.time >= end) { stop(); settle(); }
  }, pause);
});
of("points").selected.properties.indices.change.connect(() => {
  const { selected, data: points } = of("points"), k = selected.indices.at(-1);
  if (k === undefined) return;
  state.focus = points.label[k];
  const here = cases.find((each) => each.name === points.case[k]);
  selected.indices = [];
  choose(here);
});
buttons.forEach((button) => button.addEventListener("click", () => {
  const label = button.dataset.model, badness = (one) => (one.apart || one.ends === "collapses" ? 1e9 : Math.abs(one.error ?? -1));
  Object.assign(state, { cell: button, focus: label });
  state.shown.add(label);
  enter(of("group") ? button.dataset.group : "");
  const asked = inGroup().flatMap((each) => each.cells.filter((one) => one.model === label).map((one) => [badness(one), each]));
  choose(asked.length ? asked.reduce((a, b) => (b[0] > a[0] ? b : a))[1] : state.case);
}));
const tell = (words) => { at("told").textContent = words; };
press("csv", () => {
  const quoted = (text) => `"${text.replaceAll('"', '""')}"`, known = shown().filter(({ t }) => t);
  const lines = known.flatMap((one) => one.t.map((time, i) => `${quoted(state.case.name)},${quoted(one.model)},${Number(time.toPrecision(6))},${Number(one.d[i].toPrecision(6))}`));
  if (!lines.length) { tell("No curve is shown: there is nothing to download."); return; }
  const link = document.createElement("a"), head = moves ? "case,label,time_s,displacement_m" : "case,label,velocity_m_s,probability";
  link.href = URL.createObjectURL(new Blob([`${[head, ...lines].join("\n")}\n`], { type: "text/csv" }));
  link.download = `${data.study} ${state.case.name}`.replace(/[^A-Za-z0-9._-]+/g, "-") + ".csv";
  link.click();
  tell(`${lines.length} points of ${known.length} curves.`);
});
press("link", () => {
  settle();
  const failed = () => tell("The address of this page is the link: copy it from the address bar.");
  if (navigator.clipboard) navigator.clipboard.writeText(location.href).then(() => tell("Link copied."), failed);
  else failed();
});
const restore = () => {
  const link = new URLSearchParams(location.hash.slice(1)), labels = models.map((each) => each.label), chosen = link.getAll("m").filter((label) => labels.includes(label));
  const started = models.filter((each) => each.shown);
  stop();
  state.group = of("group") && Object.hasOwn(data.groups, link.get("g")) ? link.get("g") : "";
  state.shown = new Set(chosen.length ? chosen : started.map((each) => each.label));
  state.focus = labels.includes(link.get("f")) ? link.get("f") : (started.find((each) => !each.rank) ?? models[0]).label;
  state.cell = buttons[link.get("c")] ?? null;
  quiet = true;
  ["x", "y", "times"].filter(of).forEach((name) => { const [[first], ...more] = of(name).options; of(name).value = more.map(([value]) => value).includes(link.get(name)) ? link.get(name) : first; });
  const open = inGroup();
  choose(open.find((each) => each.name === link.get("case")) ?? open.find((each) => each.cells.some((one) => one.t)) ?? open[0], link.has("t") ? Number(link.get("t")) : NaN);
};
addEventListener("hashchange", restore);
restore();
document.body.dataset.ready = "1";
})();
