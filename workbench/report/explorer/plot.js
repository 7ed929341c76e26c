"use strict";
// Drawing: SVG by elements (texts are never read as markup), scales, whole numbers back to values.
const TAG = "http://www.w3.org/2000/svg";
const put = (parent, name, attributes, text) => {
  const node = parent.appendChild(document.createElementNS(TAG, name));
  for (const key in attributes) node.setAttribute(key, attributes[key]);
  if (text !== undefined) node.textContent = text;
  return node;
};
const unpack = (kept, width = 1) => {
  const values = kept.n.slice();
  for (let i = width; i < values.length; i += 1) values[i] += values[i - width];
  return values.map((value) => value * kept.step);
};
const nearest = (values, at) => {
  let low = 0, high = values.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (values[middle] <= at) low = middle; else high = middle;
  }
  return Math.abs(values[low] - at) <= Math.abs(values[high] - at) ? low : high;
};
const digits = (value, many = 3) => {
  if (value === 0) return "0";
  const size = Math.floor(Math.log10(Math.abs(value)));
  return value.toFixed(Math.max(0, Math.min(many - 1 - size, 8))).replace("-", "\u2212");
};
const percent = (value) => `${value > 0 ? "+" : ""}${digits(100 * value, 3)} %`;
const ticks = (low, high, most) => {
  const rough = (high - low) / most, decade = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((k) => k * decade).find((size) => size >= rough * 0.999);
  const values = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i += 1) {
    values.push(i * step);
  }
  return values;
};
const short = (value) => String(Number(value.toPrecision(4))).replace("-", "\u2212");

// An empty panel with axes in `holder`: functions from values to pixels and back, the drawing.
// `x` and `y`: `range`, `title`, and for x `log` or `names` at whole numbers.
const panel = (holder, words, height, x, y) => {
  const width = Math.max(holder.clientWidth - 18, 240);
  const left = 60, right = width - 18, top = 10, bottom = height - 40;
  holder.replaceChildren();
  const svg = put(holder, "svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": words });
  const log = x.log ? Math.log : (value) => value, back = x.log ? Math.exp : (value) => value;
  const [x0, x1] = x.range.map(log), [y0, y1] = y.range;
  const plot = {
    svg, top, bottom, left, right,
    x: (value) => left + ((log(value) - x0) / (x1 - x0 || 1)) * (right - left),
    y: (value) => bottom - ((value - y0) / (y1 - y0 || 1)) * (bottom - top),
    value: (pixel) => back(x0 + ((pixel - left) / (right - left)) * (x1 - x0)),
    path: (xs, ys) => xs.map((value, i) => `${i ? "L" : "M"}${plot.x(value).toFixed(1)},${plot.y(ys[i]).toFixed(1)}`).join(""),
  };
  const line = (attributes) => put(svg, "line", { stroke: "#d9d9d9", "stroke-width": 1, ...attributes });
  ticks(y0, y1, 5).forEach((value) => {
    line({ x1: left, x2: right, y1: plot.y(value), y2: plot.y(value) });
    put(svg, "text", { x: left - 6, y: plot.y(value) + 4, "text-anchor": "end" }, short(value));
  });
  let marks = ticks(...x.range, width > 500 ? 8 : 4).map((value) => [value, short(value)]);
  if (x.log) {
    const fits = (value) => value >= x.range[0] * 0.999 && value <= x.range[1] * 1.001;
    const all = [];
    for (let p = Math.floor(x0 / Math.LN10); p <= x1 / Math.LN10; p += 1) {
      [1, 2, 5].forEach((k) => all.push(k * 10 ** p));
    }
    const few = x1 - x0 > Math.log(200) ? all.filter((value, i) => i % 3 === 0) : all;
    marks = few.filter(fits).map((value) => [value, short(value)]);
  }
  if (x.names) {
    const every = Math.ceil((x.names.length * (Math.max(...x.names.map((n) => n.length)) * 7.5 + 8)) / (right - left));
    marks = x.names.map((name, i) => [i, name]).filter((mark, i) => i % every === 0);
  }
  marks.forEach(([value, text]) => {
    line({ x1: plot.x(value), x2: plot.x(value), y1: bottom, y2: bottom + 4, stroke: "#6b6b6b" });
    put(svg, "text", { x: plot.x(value), y: bottom + 17, "text-anchor": "middle" }, text);
  });
  line({ x1: left, x2: right, y1: bottom, y2: bottom, stroke: "#6b6b6b" });
  put(svg, "text", { x: (left + right) / 2, y: height - 6, "text-anchor": "middle" }, x.title);
  put(svg, "text", { x: 12, y: (top + bottom) / 2, "text-anchor": "middle", transform: `rotate(-90 12 ${(top + bottom) / 2})` }, y.title);
  return plot;
};
// A polygon between two curves over the same places.
const between = (plot, xs, low, high, fill, opacity) => {
  const there = plot.path(xs, high), back = plot.path(xs.slice().reverse(), low.slice().reverse());
  put(plot.svg, "path", { d: `${there}${back.replace("M", "L")}Z`, fill, "fill-opacity": opacity });
};
const empty = (holder, words) => {
  holder.replaceChildren();
  const paragraph = holder.appendChild(document.createElement("p"));
  paragraph.className = "hint";
  paragraph.textContent = words;
};
