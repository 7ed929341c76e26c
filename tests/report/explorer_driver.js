// Uses the explorer as a reader does and posts what it found; stands behind the page's own script.
(async () => {
  const found = { errors: window.noted };
  const at = (id) => document.getElementById(id), all = (which) => [...document.querySelectorAll(which)];
  const wait = (time) => new Promise((done) => setTimeout(done, time));
  const set = (control, value, kind) => { control.value = value; control.dispatchEvent(new Event(kind, { bubbles: true })); };
  const curves = () => [...new Set(all("#history [data-curve]").map((one) => one.dataset.curve))].sort();
  const checked = () => all("#models input:checked").map((box) => box.value).sort();
  const view = () => [at("which").textContent, at("clock").textContent, at("cell")?.textContent, checked().join("|"),
    ...["group", "x", "y", "times", "focus", "case"].map((id) => at(id)?.value)].join("\n");
  const shape = () => all("#shape [data-shape]").map((one) => one.getAttribute("d")).join();

  found.width = innerWidth;
  found.overflow = document.documentElement.scrollWidth - innerWidth;
  found.unnamed = all("main input, main select, main button").filter((one) => !one.textContent.trim() && !one.labels?.length && !one.ariaLabel).map((one) => one.outerHTML);
  found.start = { curves: curves(), checked: checked(), case: at("case").value, band: all("#history path[fill-opacity='0.35']").length, legend: at("history-words").textContent };

  found.sliders = [];
  for (const control of all("[data-axis]")) {
    const stops = control.type === "range" ? [...Array(Number(control.max) + 1).keys()] : [...control.options].map((one) => one.value);
    for (const stop of stops) {
      set(control, stop, "input");
      found.sliders.push([control.dataset.axis, String(stop), at("case").value, at("which").textContent, control.parentElement.querySelector("output")?.textContent ?? control.value]);
    }
  }
  found.cases = [...at("case").options].map((one) => one.value);
  found.chosen = found.cases.map((name) => { set(at("case"), name, "change"); return [at("which").textContent, at("against").textContent]; });
  found.ends = [at("previous").disabled, at("next").disabled];
  const walked = [];
  while (!at("previous").disabled) { at("previous").click(); walked.push(at("case").value); }
  while (!at("next").disabled) { at("next").click(); walked.push(at("case").value); }
  found.walked = walked;

  found.boxes = all("#models input").map((box) => {
    const steps = [0, 1].map(() => { box.click(); return [box.checked, curves().includes(box.value)]; });
    return [box.value, ...steps, box.closest("li").querySelector(".value").textContent];
  });
  at("all").click();
  found.all = [checked().length, curves(), at("history-words").textContent];
  found.rows = all("#numbers tbody tr").map((row) => [...row.cells].map((one) => one.textContent));
  found.says = all("#says li").map((one) => one.textContent);
  found.energies = [...at("focus").options].map((one) => {
    set(at("focus"), one.value, "change");
    return [one.value, all("#energy path").length, at("energy-words").textContent || at("energy").textContent];
  });
  at("none").click();
  found.none = checked();
  all("#models input:checked").forEach((box) => box.click());
  at("csv").click();
  found.nothing = ["history", "shape", "told", "says"].map((id) => at(id).textContent);
  at("all").click();

  found.matrix = all("#matrix button").map((button) => {
    button.click();
    return { ...button.dataset, text: button.textContent, pressed: all("#matrix [aria-pressed='true']").map((one) => one === button), told: at("cell").textContent, case: at("case").value, open: [...at("case").options].map((one) => one.value), group: at("group")?.value, focus: at("focus").value };
  });
  if (at("group")) set(at("group"), "", "change");
  set(at("case"), found.cases[0], "change");

  set(at("focus"), at("focus").options[0].value, "change");
  found.times = [0, 20, 400].map((place) => { set(at("time"), place, "input"); return [at("clock").textContent, shape(), at("shape-words").textContent, at("energy-words").textContent]; });
  found.drawn = [...at("times").options].map((one) => { set(at("times"), one.value, "change"); return [one.value, shape(), at("shape-words").textContent]; });
  found.circles = [...at("focus").options].map((one) => {
    set(at("focus"), one.value, "change");
    return all("#shape circle[visibility='visible']").length;
  });
  const plot = at("history").querySelector("svg"), box = plot.getBoundingClientRect();
  const touch = (kind, share) => plot.dispatchEvent(new PointerEvent(kind, { clientX: box.left + share * box.width, clientY: box.top + 50, buttons: 1, bubbles: true }));
  found.drag = [["pointerdown", 0.3], ["pointermove", 0.5], ["pointermove", 0.7]].map(([kind, share]) => { touch(kind, share); return parseFloat(at("clock").textContent); });
  touch("pointerup", 0.7);

  const clock = () => parseFloat(at("clock").textContent);
  set(at("time"), 0, "input");
  found.play = [at("play").textContent];
  at("play").click();
  found.play.push(at("play").textContent);
  const until = async (done) => { for (let i = 0; i < 400 && !done(); i += 1) await wait(50); };
  await until(() => clock() > 0);
  found.play.push(clock());
  at("play").click();
  found.play.push(at("play").textContent, clock());
  await wait(500);
  found.play.push(clock());
  at("play").click();
  await until(() => at("play").textContent === "Play");
  found.play.push(at("play").textContent, clock());

  found.sweeps = [...at("x").options].flatMap((x) => [...at("y").options].map((y) => {
    set(at("x"), x.value, "change");
    set(at("y"), y.value, "change");
    return [x.value, y.value, all("#sweep circle").length, all("#sweep path").length];
  }));
  const points = all("#sweep circle"), last = points.reduce((a, b) => (Number(b.getAttribute("cx")) > Number(a.getAttribute("cx")) ? b : a), points[0]);
  if (last) {
    const place = last.getBoundingClientRect();
    at("sweep").querySelector("svg").dispatchEvent(new MouseEvent("click", { clientX: place.left + place.width / 2, clientY: place.top + place.height / 2, bubbles: true }));
    found.clicked = at("case").value;
  }

  let blob = null;
  const make = URL.createObjectURL;
  URL.createObjectURL = (given) => { blob = given; return make.call(URL, given); };
  HTMLAnchorElement.prototype.click = function click() { found.download = this.download; };
  at("csv").click();
  found.csv = await blob.text();
  found.told = at("told").textContent;

  set(at("time"), 123, "input");
  at("link").click();
  await wait(100);
  found.link = at("told").textContent;
  const kept = location.hash, before = view();
  at("none").click();
  set(at("time"), 7, "input");
  set(at("case"), found.cases.at(-2) ?? found.cases[0], "change");
  set(at("y"), "main", "change");
  const between = view();
  location.hash = kept;
  await wait(100);
  found.restored = [before, between, view()];
  location.hash = "#case=nobody&m=nobody&f=nobody&g=constructor&c=x&t=nan&x=no&y=no&times=-3";
  await wait(100);
  found.nonsense = at("which").textContent;
  found.after = document.documentElement.scrollWidth - innerWidth;
  parent.postMessage(JSON.stringify(found), "*");
})().catch((error) => parent.postMessage(JSON.stringify({ errors: [String(error.stack)] }), "*"));
