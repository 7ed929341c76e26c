(() => {
const data = JSON.parse(document.getElementById("data").textContent);
const at = (id) => document.getElementById(id);
const models = new Map(data.models.map((model) => [model.label, model]));
const cases = new Map(data.cases.map((each) => [each.name, each]));
const axes = [...document.querySelectorAll("[data-axis]")].map((control) => ({
  control,
  name: control.dataset.axis,
  stops: control.dataset.stops ? JSON.parse(control.dataset.stops) : null,
  log: control.dataset.log === "1",
  output: control.parentElement.querySelector("output"),
}));
const boxes = [...document.querySelectorAll("#models input")];
const state = { case: "", group: "", focus: "", shown: new Set(), time: 0, cell: "" };
const views = {};  // what moves with the cursor, by plot
let timer = null;

// Curves are decoded once, when their case is shown.
const cell = (each, label) => each.cells.find((one) => one.model === label);
const curves = (one) => {
  if (!one.t || one.curves) return one.curves;
  const decoded = { t: unpack(one.t), d: unpack(one.d) };
  if (one.band) decoded.band = { t: unpack(one.band.t), low: unpack(one.band.low), high: unpack(one.band.high) };
  if (one.energy) {
    const parts = data.parts.filter(([name]) => name in one.energy.parts);
    decoded.energy = {
      t: unpack(one.energy.t), in: unpack(one.energy.in),
      parts: parts.map(([name, title, color]) => ({ title, color, values: unpack(one.energy.parts[name]) })),
    };
  }
  if (one.shape) {
    const width = 2 * one.shape.points.reduce((sum, n) => sum + n, 0);
    decoded.shape = { ...one.shape, t: unpack(one.shape.t), moved: unpack(one.shape.n, width), width };
  }
  one.curves = decoded;
  return decoded;
};
const shown = () => {
  const here = cases.get(state.case);
  const last = (one) => one.model === state.focus;
  const chosen = here.cells.filter((one) => state.shown.has(one.model)).sort((a, b) => last(a) - last(b));
  return chosen.map((one) => ({ one, model: models.get(one.model), ...curves(one) }));
};
const inGroup = () => data.cases.filter((each) => !state.group || data.groups[state.group].includes(each.name));
const plane = data.plane, quantities = Object.keys(plane.numbers), main = plane.numbers[quantities[0]], moves = Boolean(at("shape"));
const end = () => Math.max(...cases.get(state.case).cells.map((one) => (curves(one) ? curves(one).t.at(-1) : 0)), 1e-9);
const begin = () => (moves ? 0 : Math.min(...cases.get(state.case).cells.map((one) => (curves(one) ? curves(one).t[0] : end()))));
const worded = ([, unit, factor], many) => (value) => `${digits(factor * value, many)} ${unit}`.trim();
const titled = ([title, unit]) => (unit ? `${title} (${unit})` : title);
const ms = worded(plane.across, 3), mm = worded(plane.upward, moves ? 4 : 3), [, , acrossFactor] = plane.across, [, , upFactor] = plane.upward;
const outcome = (one) => ({
  ok: one.outside ? "answered, outside its domain" : "answered",
  collapse: "collapses", "out-of-domain": "refused", "not-converged": "not converged",
  "not run": "not run", "timed-out": "out of time", crashed: "crashed", "invalid-input": "input refused",
}[one.outcome] || one.outcome);
const stroke = (model, more = {}) => ({
  fill: "none", stroke: model.color, "stroke-width": model.width * (model.label === state.focus ? 2 : 1.3),
  "stroke-dasharray": model.dash, "stroke-linejoin": "round", ...more,
});
const cross = (svg, x, y, color, more = {}) => put(svg, "path", {
  d: `M${x - 5},${y - 5}l10,10m0,-10l-10,10`, stroke: color, "stroke-width": 2.4, fill: "none", ...more,
});

const drawHistory = () => {
  const here = cases.get(state.case), known = shown();
  const highs = [1e-6], lows = [0];
  known.forEach(({ one, d, band }) => {
    if (d) { highs.push(Math.max(...d)); lows.push(Math.min(...d)); }
    if (band) highs.push(0.5 * (Math.max(...band.high) + Math.max(...d)));
    if (moves && !d && one.main !== undefined) highs.push(one.main + (one.width || 0));
    if (one.collapse) highs.push(one.collapse[1]);
  });
  views.history = () => {};
  if (highs.length === 1) {
    empty(at("history"), `No model shown has a number in this case: ${known.map(({ one }) => `${one.model} ${outcome(one)}`).join(", ") || "none is shown"}.`);
    at("history-words").textContent = "";
    return;
  }
  const low = Math.min(...lows), high = Math.max(...highs);
  const range = [upFactor * (low < -0.02 * high ? low * 1.05 : 0), upFactor * high * 1.06];
  const words = `${plane.upward[0]} over ${plane.across[0]} of ${known.map(({ one }) => one.model).join(", ")} in ${here.name}`;
  const plot = panel(at("history"), words, 320, { range: [acrossFactor * begin(), acrossFactor * end()], title: titled(plane.across) }, { range, title: titled(plane.upward) });
  const notes = [];
  known.forEach(({ band, model }) => {
    if (!band) return;
    const inside = (value) => Math.min(Math.max(upFactor * value, range[0]), range[1]);
    between(plot, band.t.map((place) => acrossFactor * place), band.low.map(inside), band.high.map(inside), moves ? data.colors.band : model.color, moves ? 0.35 : 0.2);
    if (moves) notes.push(`Band: numerical uncertainty of ${here.reference}, the governing reference.`);
  });
  if (!moves) notes.push(plane.band);
  known.forEach(({ one, t }) => {
    if (!moves || t || !one.width || one.model !== here.reference) return;
    const [least, most] = [one.main - one.width, one.main + one.width].map((v) => Math.min(upFactor * v, range[1]));
    between(plot, [0, acrossFactor * end()], [least, least], [most, most], data.colors.band, 0.35);
    notes.push(`Band: uncertainty of the peak of ${one.model}, the governing reference.`);
  });
  known.forEach(({ one, model, t, d }) => {
    if (t) {
      put(plot.svg, "path", { d: plot.path(t.map((v) => acrossFactor * v), d.map((v) => upFactor * v)), ...stroke(model), "data-curve": one.model });
    } else if (one.collapse) {
      cross(plot.svg, plot.x(acrossFactor * (one.collapse[0] ?? end())), plot.y(upFactor * one.collapse[1]), model.color, { "data-curve": one.model });
      notes.push(`× ${one.model} collapses${one.collapse[0] === null ? " (time not known)" : ""}.`);
    } else if (moves && one.main !== undefined) {
      const height = plot.y(upFactor * one.main);
      put(plot.svg, "path", { d: `M${plot.left},${height}H${plot.right}`, ...stroke(model, { "stroke-dasharray": "1.5 4" }), "data-curve": one.model });
      notes.push(`Dotted level: ${one.model} knows its peak only.`);
    } else notes.push(`${one.model}: ${outcome(one)}, no curve.`);
  });
  at("history-words").textContent = notes.join(" ");
  const line = put(plot.svg, "line", { y1: plot.top, y2: plot.bottom, stroke: "#1a1a1a", "stroke-width": 1.4, "data-cursor": "" });
  const dots = known.filter(({ t }) => t).map(({ model, t, d }) => ({ t, d, dot: put(plot.svg, "circle", { r: 3.5, fill: model.color }) }));
  views.history = () => {
    const x = plot.x(acrossFactor * state.time);
    line.setAttribute("x1", x);
    line.setAttribute("x2", x);
    dots.forEach(({ t, d, dot }) => {
      const i = nearest(t, state.time);
      dot.setAttribute("cx", plot.x(acrossFactor * t[i]));
      dot.setAttribute("cy", plot.y(upFactor * d[i]));
    });
  };
  const seek = (event) => {
    const box = plot.svg.getBoundingClientRect();
    const pixel = ((event.clientX - box.left) / box.width) * plot.svg.viewBox.baseVal.width;
    stop();
    moveTo(plot.value(pixel) / acrossFactor);
  };
  plot.svg.addEventListener("pointerdown", (event) => {
    seek(event);
    if (plot.svg.setPointerCapture && event.isTrusted) plot.svg.setPointerCapture(event.pointerId);
  });
  plot.svg.addEventListener("pointermove", (event) => { if (event.buttons) seek(event); });
  plot.svg.addEventListener("pointerup", settle);
};

// Members of one answer at a snapshot; a column that stands upright is drawn lying, heights across.
const members = (shape, k, rest, times, lay) => {
  let n = k * shape.width;
  return rest.map(([ax, ay, bx, by], m) => {
    const many = shape.points[m], line = [];
    for (let p = 0; p < many; p += 1, n += 2) {
      const share = p / (many - 1);
      line.push(lay(ax + share * (bx - ax) + times * shape.moved[n], ay + share * (by - ay) + times * shape.moved[n + 1]));
    }
    return line;
  });
};
const drawShape = () => {
  const here = cases.get(state.case), known = shown().filter(({ shape }) => shape);
  const without = shown().filter(({ shape }) => !shape).map(({ one }) => one.model);
  views.shape = () => {};
  const missing = without.length ? `No shape stored: ${without.join(", ")}.` : "";
  at("shape-words").textContent = missing;
  if (!here.rest || !known.length) {
    empty(at("shape"), "None of the models shown states a deformed shape in this case.");
    return;
  }
  const holder = at("shape"), width = Math.max(holder.clientWidth - 18, 240);
  const upright = here.rest.every(([ax, , bx]) => ax === bx && ax === here.rest[0][0]);
  const foot = here.rest[0][0];
  const lay = upright ? (x, y) => [y, x - foot] : (x, y) => [x, y];
  const corners = here.rest.flatMap(([ax, ay, bx, by]) => [lay(ax, ay), lay(bx, by)]);
  const wide = Math.max(...corners.map((p) => p[0])) - Math.min(...corners.map((p) => p[0])) || 1;
  const largest = known.reduce((top, { shape }) => shape.moved.reduce((a, b) => Math.max(a, Math.abs(b)), top), 1e-9);
  const seen = [1, 2, 5, 10, 20, 50, 100].find((k) => (k * largest * width) / wide >= 16) || 200;
  const times = Number(at("times").value || seen);
  known.forEach(({ shape }) => shape.t.forEach((time, k) => corners.push(...members(shape, k, here.rest, times, lay).flat())));
  const xs = corners.map((p) => p[0]), ys = corners.map((p) => p[1]);
  let [x0, x1, y0, y1] = [xs, ys].flatMap((all) => [all.reduce((a, b) => Math.min(a, b)), all.reduce((a, b) => Math.max(a, b))]);
  const size = Math.max(x1 - x0, y1 - y0);
  [x0, x1, y0, y1] = [x0 - 0.05 * size, x1 + 0.05 * size, y0 - 0.06 * size, y1 + 0.06 * size];
  const scale = Math.min(width / (x1 - x0), 420 / (y1 - y0)), height = scale * (y1 - y0);
  const shift = 0.5 * (width - scale * (x1 - x0));
  const pixel = ([x, y]) => [shift + scale * (x - x0), height - scale * (y - y0)];
  const path = (line) => line.map((p, i) => `${i ? "L" : "M"}${pixel(p).map((v) => v.toFixed(1)).join(",")}`).join("");
  holder.replaceChildren();
  const svg = put(holder, "svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": `deformed shapes of ${known.map(({ one }) => one.model).join(", ")}` });
  here.rest.forEach(([ax, ay, bx, by]) => put(svg, "path", { d: path([lay(ax, ay), lay(bx, by)]), stroke: data.colors.rest, "stroke-width": 1.5, fill: "none" }));
  here.held.forEach(([x, y, support]) => {
    const [px, py] = pixel(lay(x, y));
    if (support === "clamped") put(svg, "rect", { x: px - 5, y: py - 5, width: 10, height: 10, fill: "#6b6b6b" });
    else put(svg, "circle", { cx: px, cy: py, r: 5, fill: "#fff", stroke: "#6b6b6b", "stroke-width": 1.5 });
  });
  if (here.hit) {
    const tip = pixel(lay(here.hit[0], here.hit[1])), tail = pixel(lay(here.hit[0] - here.hit[2], here.hit[1] - here.hit[3]));
    const long = Math.hypot(tail[0] - tip[0], tail[1] - tip[1]) || 1;
    const [ux, uy] = [(tail[0] - tip[0]) / long, (tail[1] - tip[1]) / long];
    const [px, py] = [tip[0] + 5 * ux, tip[1] + 5 * uy];
    put(svg, "path", { d: `M${px + 24 * ux},${py + 24 * uy}L${px},${py}M${px + 7 * ux - 4 * uy},${py + 7 * uy + 4 * ux}L${px},${py}L${px + 7 * ux + 4 * uy},${py + 7 * uy - 4 * ux}`, stroke: "#1a1a1a", "stroke-width": 2, fill: "none" });
  }
  const drawn = known.map(({ one, model, shape }) => ({
    shape,
    lines: here.rest.map(() => put(svg, "path", { ...stroke(model), "data-shape": one.model })),
    circles: one.model === state.focus && shape.yields ? here.rest.flatMap(() => [0, 1].map(() => put(svg, "circle", { r: 4, stroke: "#1a1a1a" }))) : [],
  }));
  const scaled = times === 1 ? "True to scale" : `Displacements drawn × ${times}`;
  const chords = known.filter(({ shape }) => shape.chords).map(({ one }) => one.model);
  views.shape = () => {
    const taken = drawn.map(({ shape, lines, circles }) => {
      const k = nearest(shape.t, state.time);
      const curves = members(shape, k, here.rest, times, lay);
      lines.forEach((line, m) => line.setAttribute("d", path(curves[m])));
      circles.forEach((circle, h) => {
        const line = curves[h >> 1], [x, y] = pixel(line[h % 2 ? line.length - 1 : 0]);
        circle.setAttribute("cx", x);
        circle.setAttribute("cy", y);
        const now = shape.yields[k].includes(h), once = shape.yields.slice(0, k).some((all) => all.includes(h));
        circle.setAttribute("fill", now ? data.colors.yields : "#fff");
        circle.setAttribute("visibility", now || once ? "visible" : "hidden");
      });
      return shape.t[k];
    });
    const [first, last] = [Math.min(...taken), Math.max(...taken)];
    const when = [...new Set([ms(first), ms(last)])].join(" to ");
    at("shape-words").textContent = [
      `${scaled}${upright ? ", the column lying, its base on the left" : ""}; stored snapshots nearest to the cursor: ${when}.`,
      chords.length ? `Straight lines: ${chords.join(", ")} (the shape between is not known).` : "",
      drawn.some(({ circles }) => circles.length) ? `Circles: where ${state.focus} yields (filled) or has yielded (open).` : "", missing,
    ].join(" ");
  };
};

const drawEnergy = () => {
  const one = cell(cases.get(state.case), state.focus), energy = one && curves(one) && curves(one).energy;
  views.energy = () => {};
  at("energy-words").textContent = "";
  if (!energy) {
    empty(at("energy"), one ? `${state.focus} keeps no energies of this case (${outcome(one)}).` : `${state.focus} was not asked this case.`);
    return;
  }
  const times = energy.t.map((v) => 1e3 * v), kilo = (values) => values.map((v) => v / 1e3);
  let low = energy.t.map(() => 0);
  const stack = energy.parts.map((part) => {
    const bottom = low;
    low = part.values.map((v, i) => bottom[i] + v / 1e3);
    return { ...part, bottom, top: low };
  });
  const high = Math.max(...kilo(energy.in), ...low);
  const plot = panel(at("energy"), `energies of ${state.focus}`, 300, { range: [0, 1e3 * end()], title: "time (ms)" }, { range: [0, 1.05 * high], title: "energy (kJ)" });
  stack.forEach((part) => between(plot, times, part.bottom, part.top, part.color, 1));
  put(plot.svg, "path", { d: plot.path(times, kilo(energy.in)), fill: "none", stroke: "#1a1a1a", "stroke-dasharray": "5 3", "stroke-width": 1.4 });
  const line = put(plot.svg, "line", { y1: plot.top, y2: plot.bottom, stroke: "#1a1a1a", "stroke-width": 1.4 });
  const words = at("energy-words");
  views.energy = () => {
    const i = nearest(energy.t, state.time), x = plot.x(1e3 * state.time);
    line.setAttribute("x1", x);
    line.setAttribute("x2", x);
    words.replaceChildren(`At ${ms(energy.t[i])}: `);
    stack.slice().reverse().forEach((part) => {
      const chip = words.appendChild(document.createElement("span"));
      chip.style.cssText = `display:inline-block;width:.8em;height:.8em;margin:0 .3em 0 .6em;background:${part.color}`;
      words.append(`${part.title} ${digits(part.values[i] / 1e3, 3)} kJ`);
    });
    words.append(`; dashed: brought in so far, ${digits(energy.in[i] / 1e3, 3)} kJ.`);
  };
};

const drawSweep = () => {
  const kind = at("y").value, name = at("x").value, parameter = axes.find((one) => one.name === name);
  const names = !parameter ? data.cases.map((each, i) => (data.cases.length > 12 ? String(i + 1) : each.name)) : parameter.stops ? null : [...parameter.control.options].map((option) => option.value);
  const place = (each, i) => (!parameter ? i : parameter.stops ? each.at[name] : names.indexOf(String(each.at[name])));
  const factor = kind === "error" ? 100 : main[2];
  const points = [], fallen = [];
  data.cases.forEach((each, i) => each.cells.forEach((one) => {
    const x = place(each, i), value = one[kind];
    if (!state.shown.has(one.model) || x === undefined || x < 0) return;
    if (value !== undefined) points.push({ each, one, x, y: factor * value });
    else if (one.outcome === "collapse") fallen.push({ each, one, x, y: 0 });
  }));
  if (!points.length && !fallen.length) {
    empty(at("sweep"), "No model shown has this number in any case.");
    at("sweep-words").textContent = "";
    return;
  }
  const xs = data.cases.map(place).filter((x) => x !== undefined && x >= 0);
  let range = [Math.min(...xs), Math.max(...xs)];
  const log = Boolean(parameter && parameter.log);
  const margin = names ? 0.5 : 0.04 * (range[1] - range[0]) || 1;
  range = log ? [range[0] / 1.15, range[1] * 1.15] : [range[0] - margin, range[1] + margin];
  const ys = points.map((point) => point.y).concat(0);
  let [low, high] = [Math.min(...ys), Math.max(...ys)];
  const room = 0.08 * (high - low) || 1;
  [low, high] = [low < 0 ? low - room : 0, high + room];
  const title = kind === "error" ? `error of the ${main[0]} (%)` : titled(main);
  const plot = panel(at("sweep"), `${title} over ${name || "the cases"}`, 300, { range, title: name || (data.cases.length > 12 ? "number of the case" : "case"), log, names }, { range: [low, high], title });
  if (kind === "error") {
    [0, ...data.bounds.flatMap((bound) => [100 * bound, -100 * bound])].filter((y) => y >= low && y <= high).forEach((y) => {
      put(plot.svg, "line", { x1: plot.left, x2: plot.right, y1: plot.y(y), y2: plot.y(y), stroke: "#6b6b6b", "stroke-width": y ? 0.8 : 1.2, "stroke-dasharray": y ? "4 3" : "" });
    });
  }
  const group = new Set(inGroup().map((each) => each.name)), focused = ({ one }) => one.model === state.focus;
  [...points, ...fallen].sort((a, b) => focused(a) - focused(b)).forEach((point) => {
    const { each, one } = point, model = models.get(one.model);
    point.px = plot.x(point.x);
    point.py = one.outcome === "collapse" ? plot.top + 6 : plot.y(point.y);
    const bold = focused(point), faded = group.has(each.name) ? (bold ? 1 : 0.6) : 0.12;
    if (one.outcome === "collapse") cross(plot.svg, point.px, point.py, model.color, { opacity: faded });
    else put(plot.svg, "circle", { cx: point.px, cy: point.py, r: bold ? 4.5 : 3, fill: one.outside ? "#fff" : model.color, stroke: model.color, "stroke-width": 1.3, opacity: faded });
    if (each.name === state.case) put(plot.svg, "circle", { cx: point.px, cy: point.py, r: 8, fill: "none", stroke: "#1a1a1a", "stroke-width": bold ? 2 : 0.8 });
  });
  at("sweep-words").textContent = `Each point is a stored case; click one to see it. Ringed: this case. Large: ${state.focus}. Open: outside the model's domain.${fallen.length ? " ×: collapses." : ""}${kind === "error" ? " Dashed: ±5 and ±10 %." : ""}`;
  plot.svg.addEventListener("click", (event) => {
    const box = plot.svg.getBoundingClientRect(), times = plot.svg.viewBox.baseVal.width / box.width;
    const [px, py] = [(event.clientX - box.left) * times, (event.clientY - box.top) * times];
    const far = (point) => Math.hypot(point.px - px, point.py - py);
    const best = [...points, ...fallen].reduce((a, b) => (far(b) < far(a) ? b : a));
    if (far(best) > 30) return;
    state.focus = best.one.model;
    choose(best.each.name);
  });
};

const row = (table, texts, tones = []) => {
  const line = table.insertRow();
  texts.forEach((text, i) => {
    const one = line.appendChild(document.createElement(i ? "td" : "th"));
    one.textContent = text || "–";
    if (i) one.dataset.head = table.parentElement.tHead.rows[0].cells[i].textContent;
    if (tones[i]) one.className = tones[i];
  });
  return line;
};
const tellCase = () => {
  const here = cases.get(state.case), body = at("numbers").tBodies[0];
  const known = here.reference ? `Errors against ${here.reference}${here.inside ? "" : ", which is outside its own domain"}.` : "No reference answered this case: there is nothing to compare with.";
  at("against").textContent = `${here.name}. ${known}${here.why ? ` Why this reference: ${here.why}.` : ""}`;
  body.replaceChildren();
  at("says").replaceChildren();
  here.cells.forEach((one) => {
    const text = one.text, best = one.model === here.reference;
    const line = row(body, [
      one.model, [outcome(one), one.message && `: ${one.message}`, one.apart && `; ${one.apart}`].filter(Boolean).join(""),
      ...quantities.flatMap((name, i) => [text[name], ...(i < 2 ? [best ? "the reference" : text[`${name} error`]] : [])]), text.cost,
    ], ["", one.apart ? "bad" : one.outcome === "ok" ? "" : "doubt", "", one.tone || ""]);
    if (!state.shown.has(one.model)) line.className = "off";
    if (!state.shown.has(one.model)) return;
    one.says.forEach(([sentence, remedy]) => {
      const item = at("says").appendChild(document.createElement("li"));
      item.appendChild(document.createElement("strong")).textContent = one.model;
      item.append(`: ${data.texts[sentence]}.${remedy ? ` Instead: ${data.texts[remedy]}.` : ""}`);
    });
  });
  if (!at("says").children.length) at("says").appendChild(document.createElement("li")).textContent = shown().some(({ one }) => one.outcome === "ok") ? "The models shown say nothing against their answers." : "No model shown has answered with numbers.";
};
const tellValues = () => {
  const here = cases.get(state.case);
  boxes.forEach((box) => {
    const one = cell(here, box.value), item = box.closest("li"), curve = one && curves(one);
    box.checked = state.shown.has(box.value);
    item.classList.toggle("focus", box.value === state.focus);
    item.classList.toggle("counts", box.value === here.reference);
    item.querySelector(".value").textContent = !one ? "not asked" : curve ? mm(curve.d[nearest(curve.t, state.time)]) : moves && one.main !== undefined ? `peak ${mm(one.main)}` : outcome(one);
  });
};
const tellMatrix = () => {
  document.querySelectorAll("#matrix button").forEach((button) => {
    button.setAttribute("aria-pressed", String(state.cell === `${button.dataset.model}\n${button.dataset.group}`));
  });
  const words = at("cell"), [model, group] = state.cell.split("\n");
  if (!words) return;
  words.hidden = !state.cell;
  const line = data.matrix.find((one) => one.label === model);
  if (line) words.textContent = `${model}, ${group}: ${line.cells[group]}. Shown below: ${state.case}.`;
};

const moveTo = (time) => {
  state.time = Math.min(Math.max(time, begin()), end());
  at("time").value = Math.round((400 * (state.time - begin())) / (end() - begin() || 1));
  at("time").setAttribute("aria-valuetext", ms(state.time));
  at("clock").textContent = ms(state.time);
  Object.values(views).forEach((view) => view());
  tellValues();
};
const stop = () => {
  clearInterval(timer);
  timer = null;
  at("play").textContent = "Play";
  at("play").setAttribute("aria-pressed", "false");
};
const play = () => {
  if (timer) { stop(); settle(); return; }
  const first = begin(), whole = end(), seconds = 6, pause = 40;
  if (state.time >= whole) moveTo(first);
  at("play").textContent = "Pause";
  at("play").setAttribute("aria-pressed", "true");
  let last = performance.now();
  timer = setInterval(() => {
    const now = performance.now(), passed = Math.min(now - last, 5 * pause);  // hidden pages sleep
    last = now;
    moveTo(state.time + ((whole - first) * passed) / 1000 / seconds);
    if (state.time >= whole) { stop(); settle(); }
  }, pause);
};

// The address holds the state, so that a link opens the same view.
const settle = () => {
  const link = new URLSearchParams({ case: state.case, f: state.focus, t: state.time.toPrecision(4) });
  if (state.group) link.set("g", state.group);
  if (state.cell) link.set("c", state.cell);
  ["x", "y", "times"].filter(at).forEach((id) => { if (at(id).selectedIndex > 0) link.set(id, at(id).value); });
  [...state.shown].forEach((label) => link.append("m", label));
  history.replaceState(null, "", `#${link}`);
};
const restore = () => {
  const link = new URLSearchParams(location.hash.slice(1)), known = link.getAll("m").filter((label) => models.has(label));
  state.group = at("group") && Object.hasOwn(data.groups, link.get("g")) ? link.get("g") : "";
  const open = inGroup(), answered = open.find((each) => each.cells.some((one) => one.t));
  const wanted = open.find((each) => each.name === link.get("case")) || answered || open[0] || data.cases[0];
  state.shown = new Set(known.length ? known : data.models.filter((model) => model.shown).map((model) => model.label));
  const plain = data.models.find((model) => model.shown && !model.rank) || data.models[0];
  state.focus = models.has(link.get("f")) ? link.get("f") : plain.label;
  state.cell = [...document.querySelectorAll("#matrix button")].map((b) => `${b.dataset.model}\n${b.dataset.group}`).find((key) => key === link.get("c")) || "";
  ["x", "y", "times"].filter(at).forEach((id) => {
    at(id).selectedIndex = Math.max(0, [...at(id).options].findIndex((option) => option.value === link.get(id)));
  });
  choose(wanted.name, { time: link.has("t") ? Number(link.get("t")) : NaN });
};
const refresh = () => {
  drawHistory();
  if (moves) { drawShape(); drawEnergy(); }
  drawSweep();
  tellCase();
  tellMatrix();
  moveTo(state.time);
};
// Show a case; `wanted`, what the sliders ask for (default: what the case has).
const choose = (name, { wanted = null, time = NaN } = {}) => {
  const here = cases.get(name), fresh = name !== state.case, open = inGroup();
  stop();
  state.case = name;
  const best = [cell(here, here.reference), ...here.cells].find((one) => one && one.begin !== undefined);
  if (Number.isFinite(time)) state.time = time;
  else if (fresh) state.time = (best && best.begin) || 0;
  if (at("group")) at("group").value = state.group;
  at("case").replaceChildren(...open.map((each) => new Option(each.name, each.name, false, each === here)));
  at("focus").value = state.focus;
  axes.forEach((axis) => {
    const given = here.at[axis.name];
    if (given === undefined) { if (axis.output) axis.output.textContent = "not given"; return; }
    if (!axis.stops) { axis.control.value = String(given); return; }
    if (!wanted) axis.control.value = axis.stops.reduce((k, stop, i) => (away(axis, stop, given) < away(axis, axis.stops[k], given) ? i : k), 0);
    const asked = axis.stops[axis.control.value], same = Math.abs(asked - given) <= 1e-4 * Math.abs(given);
    axis.output.textContent = wanted && !same ? `asked ${short(asked)}, has ${short(given)}` : short(given);
    axis.control.setAttribute("aria-valuetext", axis.output.textContent);
  });
  const index = open.indexOf(here);
  at("previous").disabled = index <= 0;
  at("next").disabled = index < 0 || index >= open.length - 1;
  at("which").textContent = `${wanted ? "Nearest stored case: " : "Stored case: "}${here.name} (${index + 1} of ${open.length}${state.group ? ` in ${state.group}` : ""}).`;
  refresh();
  settle();
};
const away = (axis, a, b) => {
  const f = axis.log ? Math.log : (value) => value;
  return Math.abs(f(a) - f(b)) / (f(axis.stops.at(-1)) - f(axis.stops[0]) || 1);
};
// The nearest case in shares of each range; what was just moved counts most.
const slide = (moved) => {
  const wanted = Object.fromEntries(axes.map((axis) => [axis.name, axis.stops ? axis.stops[axis.control.value] : axis.control.value]));
  const far = (each) => axes.reduce((sum, axis) => {
    const given = each.at[axis.name], weight = axis === moved ? 10 : 1;
    if (given === undefined) return sum + weight;
    return sum + weight * (axis.stops ? away(axis, wanted[axis.name], given) ** 2 : String(given) === wanted[axis.name] ? 0 : 4);
  }, 0);
  const open = inGroup();
  choose(open.reduce((a, b) => (far(b) < far(a) ? b : a)).name, { wanted });
};

axes.forEach((axis) => axis.control.addEventListener("input", () => slide(axis)));
at("case").addEventListener("change", () => choose(at("case").value));
const step = (by) => { const open = inGroup(); choose(open[open.indexOf(cases.get(state.case)) + by].name); };
at("previous").addEventListener("click", () => step(-1));
at("next").addEventListener("click", () => step(1));
const enter = (group) => {
  state.group = group;
  const open = inGroup();
  return open.includes(cases.get(state.case)) ? state.case : open[0].name;
};
if (at("group")) at("group").addEventListener("change", () => { state.cell = ""; choose(enter(at("group").value)); });
boxes.forEach((box) => box.addEventListener("change", () => {
  if (box.checked) state.shown.add(box.value); else state.shown.delete(box.value);
  refresh();
  settle();
}));
const showing = (wanted) => () => {
  state.shown = new Set(data.models.filter(wanted).map((model) => model.label));
  refresh();
  settle();
};
at("all").addEventListener("click", showing(() => true));
at("none").addEventListener("click", showing((model) => model.rank));
at("focus").addEventListener("change", () => { state.focus = at("focus").value; refresh(); settle(); });
["x", "y", "times"].filter(at).forEach((id) => at(id).addEventListener("change", () => { refresh(); settle(); }));
document.querySelectorAll("#matrix button").forEach((button) => button.addEventListener("click", () => {
  const { model, group } = button.dataset;
  state.cell = `${model}\n${group}`;
  state.focus = model;
  state.shown.add(model);
  enter(at("group") ? group : "");
  const worst = inGroup().map((each) => ({ each, one: cell(each, model) })).filter(({ one }) => one);
  const badness = ({ one }) => (one.apart || one.outcome === "collapse" ? 1e9 : Math.abs(one.error ?? -1));
  const top = worst.reduce((a, b) => (a === null || badness(b) > badness(a) ? b : a), null);
  choose(top ? top.each.name : state.case);
}));
at("time").addEventListener("input", () => { stop(); moveTo(begin() + (at("time").value / 400) * (end() - begin())); });
at("time").addEventListener("change", settle);
at("play").addEventListener("click", play);
at("csv").addEventListener("click", () => {
  const quoted = (text) => `"${text.replaceAll('"', '""')}"`, lines = [moves ? "case,label,time_s,displacement_m" : "case,label,velocity_m_s,probability"];
  shown().filter(({ t }) => t).forEach(({ one, t, d }) => t.forEach((time, i) => {
    lines.push(`${quoted(state.case)},${quoted(one.model)},${Number(time.toPrecision(6))},${Number(d[i].toPrecision(6))}`);
  }));
  if (lines.length === 1) { at("told").textContent = "No curve is shown: there is nothing to download."; return; }
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([`${lines.join("\n")}\n`], { type: "text/csv" }));
  link.download = `${data.study} ${state.case}`.replace(/[^A-Za-z0-9._-]+/g, "-") + ".csv";
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  at("told").textContent = `${lines.length - 1} points of ${shown().filter(({ t }) => t).length} curves.`;
});
at("link").addEventListener("click", () => {
  settle();
  const tell = (words) => { at("told").textContent = words; };
  const failed = () => tell("The address of this page is the link: copy it from the address bar.");
  if (navigator.clipboard) navigator.clipboard.writeText(location.href).then(() => tell("Link copied."), failed);
  else failed();
});
addEventListener("hashchange", restore);
let wide = innerWidth;
addEventListener("resize", () => { if (innerWidth !== wide) { wide = innerWidth; refresh(); } });
restore();
})();
