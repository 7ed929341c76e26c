// Uses the explorer as a reader does and posts what it found; stands behind the page's own script.
(async () => {
  const found = { errors: window.noted };
  const at = (id) => document.getElementById(id), all = (which) => [...document.querySelectorAll(which)];
  const wait = (time) => new Promise((done) => setTimeout(done, time));
  const until = async (done) => { for (let i = 0; i < 400 && !done(); i += 1) await wait(50); };
  await until(() => document.body.dataset.ready);
  const of = (name) => Bokeh.documents[0].get_model_by_name(name), columns = (name) => of(name)?.data ?? {};
  const deep = (root) => [...root.querySelectorAll("*")].flatMap((one) => [one, ...(one.shadowRoot ? deep(one.shadowRoot) : [])]);
  const click = (label) => deep(document.body).find((one) => one.tagName === "BUTTON" && one.textContent.trim() === label).click();
  const set = (name, value) => { of(name).value = value; };
  const options = (name) => of(name).options.map((one) => (Array.isArray(one) ? one[0] : one));
  const curves = () => [...columns("lines").label].sort();
  const checked = () => all("#models input:checked").map((box) => box.value).sort();
  const rows = () => all("#models tbody tr").map((row) => [row.querySelector("input").value, ...[...row.cells].slice(1).map((one) => one.textContent)]);
  const view = () => [at("which").textContent, of("time").value, at("cell")?.textContent, checked().join("|"),
    ...["group", "x", "y", "times", "focus", "case"].map((name) => of(name)?.value)].join("\n");
  const shape = () => JSON.stringify([columns("shapes").x, columns("shapes").y]);

  found.width = innerWidth;
  found.overflow = document.documentElement.scrollWidth - innerWidth;
  found.start = { curves: curves(), checked: checked(), case: of("case").value, band: columns("band").x.length, ends: columns("ends").x.length, legend: at("history-words").textContent, time: of("time").value, values: rows().map((row) => row[1]) };

  found.sliders = [];
  for (let k = 0; of(`axis-${k}`); k += 1) {
    for (const stop of of(`axis-${k}`).categories ?? options(`axis-${k}`)) {
      set(`axis-${k}`, stop);
      found.sliders.push([of(`axis-${k}`).title, stop, of("case").value, at("which").textContent, of("time").value, rows().map((row) => row[1])]);
    }
  }
  found.velocities = [0, 0.5, 1].map((share) => {
    const { start, end } = of("time");
    set("time", start + share * (end - start));
    return [of("time").value, rows().map((row) => row[1])];
  });
  found.cases = options("case");
  found.chosen = found.cases.map((name) => { set("case", name); return [at("which").textContent, at("about").textContent]; });
  found.ends = [of("previous").disabled, of("next").disabled];
  found.walked = [];
  for (const [name, label] of [["previous", "◂ Previous"], ["next", "Next ▸"]]) {
    while (!of(name).disabled) { click(label); found.walked.push(of("case").value); await wait(0); }
  }
  found.boxes = all("#models input").map((box) => {
    const steps = [0, 1].map(() => { box.click(); return [box.checked, curves().includes(box.value)]; });
    return [box.value, ...steps];
  });
  click("All models");
  found.all = [checked().length, curves(), columns("ends").x.length, at("history-words").textContent];
  found.rows = rows();
  found.says = all("#says li").map((one) => one.textContent);
  if (of("energy")) {
    found.energies = options("focus").map((label) => { set("focus", label); return [label, columns("energy").t.length, at("energy-words").textContent]; });
    click("References only");
    found.none = checked();
    all("#models input:checked").forEach((box) => box.click());
    click("Download these curves (CSV)");
    found.nothing = ["history-words", "shape-words", "told", "says"].map((id) => at(id).textContent);
    click("All models");
    found.matrix = all("#matrix button").map((button) => {
      button.click();
      return { ...button.dataset, text: button.textContent, pressed: all("#matrix [aria-pressed='true']").map((one) => one === button), told: at("cell").textContent, case: of("case").value, open: options("case"), focus: of("focus").value };
    });
    if (of("group")) set("group", "");
    set("case", found.cases[0]);
    set("focus", options("focus")[0]);
    found.times = [0, 5, 100].map((share) => { set("time", (share * of("time").end) / 100); return [of("time").value, shape(), at("shape-words").textContent, at("energy-words").textContent]; });
    found.drawn = options("times").map((value) => { set("times", value); return [value, shape(), at("shape-words").textContent]; });
    set("times", "");
    found.circles = options("focus").map((label) => { set("focus", label); return columns("hinges").x.length; });

    set("time", 0);
    found.play = [of("play").label];
    click("Play");
    found.play.push(of("play").label);
    await until(() => of("time").value > 0);
    found.play.push(of("time").value);
    click("Pause");
    found.play.push(of("play").label, of("time").value);
    await wait(500);
    found.play.push(of("time").value);
    click("Play");
    await until(() => of("play").label === "Play");
    found.play.push(of("play").label, of("time").value);

    found.sweeps = options("x").flatMap((x) => options("y").map((y) => {
      set("x", x);
      set("y", y);
      const kinds = columns("points").marker;
      return [x, y, kinds.filter((one) => one === "circle").length, kinds.filter((one) => one === "x").length, columns("bounds").y.length];
    }));
    const point = columns("points").case.indexOf(found.cases.at(-1));
    if (point >= 0) of("points").selected.indices = [point];
    found.clicked = of("case").value;

    let blob = null;
    const make = URL.createObjectURL;
    URL.createObjectURL = (given) => { blob = given; return make.call(URL, given); };
    HTMLAnchorElement.prototype.click = function press() { found.download = this.download; };
    click("Download these curves (CSV)");
    found.csv = await blob.text();
    found.told = at("told").textContent;

    set("time", 30 * of("time").step);
    click("Copy a link to this view");
    await wait(100);
    found.link = at("told").textContent;
    const kept = location.hash, before = view();
    click("References only");
    set("time", 0);
    set("case", found.cases.at(-2) ?? found.cases[0]);
    set("y", "main");
    const between = view();
    location.hash = kept;
    await wait(100);
    found.restored = [before, between, view()];
    location.hash = "#case=nobody&m=nobody&f=nobody&g=constructor&c=x&t=nan&x=no&y=no&times=-3";
    await wait(100);
    found.nonsense = at("which").textContent;
  }
  found.after = document.documentElement.scrollWidth - innerWidth;
  parent.postMessage(JSON.stringify(found), "*");
})().catch((error) => parent.postMessage(JSON.stringify({ errors: [String(error.stack)] }), "*"));
