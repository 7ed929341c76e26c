// Fields of the page as elements of the browser: label, control, unit, slider, message.
const made = (name, attributes = {}, ...inside) => {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (value === false || value === undefined) continue;
    if (key in element && key !== "list") element[key] = value;
    else element.setAttribute(key, value === true ? "" : value);
  }
  element.append(...inside);
  return element;
};

export function render({ model, el }) {
  const tell = (message) => model.send_msg(message);
  const box = made("div", { className: "form" });
  let busy = null, waiting = null;  // one change on its way at a time: the newest follows
  const follow = (message) => {
    if (busy) { waiting = message; return; }
    busy = setTimeout(() => { busy = null; if (waiting) { const next = waiting; waiting = null; follow(next); } }, 40);
    tell(message);
  };

  const control = (field, id) => {
    const described = `${id}-hint ${id}-error`;
    const common = { id, name: field.key, "aria-describedby": described, "data-key": field.key };
    if (field.kind === "choice") {
      const select = made("select", common, ...field.choices.map(([value, text]) =>
        made("option", { value, selected: value === field.value }, text)));
      select.addEventListener("change", () => tell({ key: field.key, value: select.value }));
      return [select];
    }
    if (field.kind === "check") {
      const input = made("input", { ...common, type: "checkbox", checked: field.value });
      input.addEventListener("change", () => tell({ key: field.key, value: input.checked }));
      return [input];
    }
    if (field.kind === "file") {
      const input = made("input", { ...common, type: "file", accept: field.accept });
      input.addEventListener("change", () => {
        const [file] = input.files;
        if (!file) return;
        if (file.size > field.largest) { tell({ key: field.key, name: file.name, size: file.size }); return; }
        const reader = new FileReader();
        reader.onload = () => tell({ key: field.key, name: file.name, value: reader.result.split(",")[1] || "" });
        reader.readAsDataURL(file);
      });
      return [input];
    }
    if (field.kind === "button") {
      const button = made("button", { ...common, type: "button", disabled: field.disabled }, field.label);
      button.addEventListener("click", () => tell({ key: field.key, value: true }));
      return [button];
    }
    const text = made("input", { ...common, type: "text", value: field.value, autocomplete: "off",
      placeholder: field.usual || "", spellcheck: false });
    if (field.kind === "number") text.setAttribute("inputmode", "text");
    if (field.kind === "range") text.hidden = true;
    const parts = [text];
    if (field.list && field.list.length) {
      text.setAttribute("list", `${id}-list`);
      parts.push(made("datalist", { id: `${id}-list` }, ...field.list.map((value) => made("option", { value }))));
    }
    const unit = () => (choice ? choice.value : field.unit || "");
    let choice = null;
    if (field.units && field.units.length) {
      choice = made("select", { "aria-label": `Unit of ${field.label}`, className: "unit", "data-unit": field.key },
        ...field.units.map((value) => made("option", { value, selected: value === field.unit }, value)));
      choice.addEventListener("change", () => tell({ key: field.key, measure: choice.value }));
      parts.push(choice);
    } else if (field.unit) parts.push(made("span", { className: "unit" }, field.unit));
    let slider = null;
    text.addEventListener("input", () => {
      if (slider) slider.value = text.value.replace(",", ".");
      follow({ key: field.key, value: text.value, unit: unit() });
    });
    text.addEventListener("change", () => tell({ key: field.key, value: text.value, unit: unit(), ended: true }));
    if (field.slider) {
      const [low, high] = field.slider;
      slider = made("input", { type: "range", min: low, max: high, step: field.step || (high - low) / 200,
        value: Number(field.value) || low, "aria-label": `${field.label}, slider`, "data-slider": field.key });
      slider.addEventListener("input", () => {
        text.value = String(Number(Number(slider.value).toPrecision(4)));
        if (field.kind === "range") slider.setAttribute("aria-valuetext", field.said?.[slider.value] || slider.value);
        follow({ key: field.key, value: text.value, unit: unit() });
      });
      parts.push(slider);
    }
    return parts;
  };

  const draw = () => {
    const active = box.getRootNode().activeElement;
    const opened = new Set([...box.querySelectorAll("details[open] > summary")].map((each) => each.textContent));
    const kept = ["key", "unit", "slider"].find((name) => active?.dataset?.[name]);
    const [key, at] = kept ? [`[data-${kept}="${active.dataset[kept]}"]`, active.selectionStart] : [];
    box.replaceChildren(...model.groups.map((group, i) => {
      const fields = group.fields.map((field, j) => {
        const id = `${model.id || "f"}-${i}-${j}`;
        const label = field.kind === "button" ? "" : made("label", { htmlFor: id }, field.label);
        const hint = made("span", { id: `${id}-hint`, className: "hint" },
          [field.hint, field.range].filter(Boolean).join("; "));
        const error = made("span", { id: `${id}-error`, className: "wrong", role: "alert", "data-error": field.key });
        return made("div", { className: `field ${field.kind}` }, label,
          made("div", { className: "control" }, ...control(field, id)), hint, error);
      });
      const legend = group.title ? [made("legend", {}, group.title)] : [];
      const fieldset = made("fieldset", { className: group.many ? "many" : "" }, ...legend, ...fields);
      if (!group.folded) return fieldset;
      return made("details", { open: opened.has(group.folded) || !!group.open }, made("summary", {}, group.folded), fieldset);
    }));
    mark();
    const again = key && box.querySelector(key);
    if (again) { again.focus(); if (at !== null && again.setSelectionRange && again.type === "text") again.setSelectionRange(at, at); }
  };
  const mark = () => {
    for (const place of box.querySelectorAll("[data-error]")) {
      const text = model.errors[place.dataset.error] || "";
      if (place.textContent !== text) place.textContent = text;
      const field = box.querySelector(`[data-key="${place.dataset.error}"]`);
      if (field) field.setAttribute("aria-invalid", text ? "true" : "false");
    }
  };
  model.on("sent", () => {  // a file that was made for this person
    const { name, data, kind } = model.sent;
    const bytes = Uint8Array.from(atob(data), (each) => each.charCodeAt(0));
    const link = made("a", { href: URL.createObjectURL(new Blob([bytes], { type: kind })), download: name });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60000);
  });
  model.on("groups", draw);
  model.on("errors", mark);
  draw();
  el.append(box);
}
