"use strict";
document.querySelectorAll("table.sortable").forEach((table) => {
  const body = table.tBodies[0];
  table.querySelectorAll("thead th").forEach((head, index) => {
    head.querySelector("button").addEventListener("click", () => {
      const rising = head.getAttribute("aria-sort") !== "ascending";
      table.querySelectorAll("thead th").forEach((th) => th.setAttribute("aria-sort", "none"));
      head.setAttribute("aria-sort", rising ? "ascending" : "descending");
      const numeric = head.classList.contains("number");
      const value = (row) => {
        const cell = row.cells[index];
        const text = cell.dataset.sort;
        if (numeric) return text === undefined ? null : Number(text);
        return cell.textContent.trim();
      };
      const order = (a, b) => {
        const x = value(a), y = value(b);
        if (numeric) {
          if (x === null || Number.isNaN(x)) return y === null || Number.isNaN(y) ? 0 : 1;
          if (y === null || Number.isNaN(y)) return -1;
          return rising ? x - y : y - x;
        }
        return (rising ? 1 : -1) * x.localeCompare(y, "en", { numeric: true });
      };
      [...body.rows].sort(order).forEach((row) => body.append(row));
    });
  });
});
// Films: a snapshot is shown as it was stored; nothing moves before somebody asks for it.
document.querySelectorAll(".film").forEach((film) => {
  const data = JSON.parse(film.querySelector("script").textContent);
  const frames = data.at.length, yields = data.colours.length - 1;
  const whole = (text) => {
    const sum = [];
    return text.split(";").map((frame) => frame.split(" ").map((step, i) => {
      sum[i] = (sum[i] || 0) + Number(step);
      return sum[i] / data.fine;
    }));
  };
  const panels = [...film.querySelectorAll("g")].map((group, i) => ({
    ...data.panels[i],
    paths: data.panels[i].paths.map(whole),
    circles: data.panels[i].circles ? whole(data.panels[i].circles) : [],
    members: group.querySelectorAll(".film-member"),
    hinges: group.querySelectorAll(".film-hinge"),
    reading: group.querySelector(".film-words"),
  }));
  const edge = (circle, yielding) => {
    circle.setAttribute("r", yielding ? 5 : 3.5);
    circle.setAttribute("stroke", yielding ? "#1a1a1a" : "#6b6b6b");
    circle.setAttribute("stroke-width", yielding ? 1.2 : 0.6);
  };
  const show = (k) => panels.forEach((panel) => {
    panel.members.forEach((member, i) => {
      member.setAttribute("d", `M${panel.paths[i][k].join(" ")}`);
    });
    panel.hinges.forEach((circle, i) => {
      const level = panel.used[k].charCodeAt(i) - 97;
      circle.setAttribute("cx", panel.circles[k][2 * i]);
      circle.setAttribute("cy", panel.circles[k][2 * i + 1]);
      circle.setAttribute("fill", data.colours[level]);
      edge(circle, level === yields);
    });
    panel.reading.textContent = panel.words[k];
  });
  const [button, slider] = film.querySelectorAll("button, input");
  const seconds = 6;
  let playing = false;
  const stop = () => { playing = false; button.textContent = "Play"; };
  slider.addEventListener("input", () => { stop(); show(Number(slider.value)); });
  button.addEventListener("click", () => {
    if (playing) { stop(); return; }
    const from = Number(slider.value) === frames - 1 ? 0 : data.at[Number(slider.value)];
    let started = null;
    playing = true;
    button.textContent = "Pause";
    const tick = (now) => {
      if (!playing) return;
      started = started ?? now;
      const at = from + (now - started) / 1000 / seconds;
      let k = 0;
      while (k + 1 < frames && data.at[k + 1] <= at) k += 1;
      slider.value = k;
      show(k);
      if (at >= 1) stop(); else requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  });
  film.querySelector(".film-controls").hidden = false;
});
addEventListener("beforeprint", () => {
  document.querySelectorAll("details:not(.screen-only)").forEach((d) => { d.open = true; });
});
// Tables that are wider than the page say so.
const hint = () => document.querySelectorAll(".table").forEach((table) => {
  table.classList.toggle("scrolls", table.scrollWidth > table.clientWidth + 1);
});
hint();
addEventListener("resize", hint);
