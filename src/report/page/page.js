"use strict";
(() => {
  const figure = document.getElementById("view");
  const data = JSON.parse(document.getElementById("data").textContent);
  const [nx, ny] = data.shape, [h, v] = data.spacing, [x0, y0] = data.origin;
  const FULL = 65535;
  const decoded = (text) => {
    const bytes = atob(text), values = new Uint16Array(bytes.length / 2);
    for (let k = 0; k < values.length; k++) values[k] = bytes.charCodeAt(2 * k) | bytes.charCodeAt(2 * k + 1) << 8;
    return values;
  };
  const pressures = decoded(data.pressure), gaps = data.gap ? decoded(data.gap) : null;
  const pressureIn = (i, j) => i < 0 || j < 0 || i >= nx || j >= ny ? 0 : pressures[j * nx + i] / (FULL - 1) * data.most;

  // Bilinear between the centres of cells.
  const pressureAt = (x, y) => {
    const u = (x - x0) / h - 0.5, w = (y - y0) / v - 0.5, i = Math.floor(u), j = Math.floor(w), s = u - i, t = w - j;
    return (1 - t) * ((1 - s) * pressureIn(i, j) + s * pressureIn(i + 1, j))
      + t * ((1 - s) * pressureIn(i, j + 1) + s * pressureIn(i + 1, j + 1));
  };
  const gapAt = (x, y) => {
    const i = Math.floor((x - x0) / h), j = Math.floor((y - y0) / v);
    if (!gaps || i < 0 || j < 0 || i >= nx || j >= ny) return null;
    const whole = gaps[j * nx + i];
    return whole === FULL ? Infinity : whole / (FULL - 1) * data.widest;
  };

  // Numbers with four digits, in units with prefixes where those have them.
  const PREFIXES = {p: -12, n: -9, "µ": -6, m: -3, "": 0, k: 3, M: 6, G: 9, T: 12};
  const split = (unit) => {
    for (const base of ["Pa", "N", "m"]) {
      if (!unit.endsWith(base)) continue;
      const own = unit.slice(0, -base.length).replace(/^[u\u03bc]$/, "µ");
      if (own in PREFIXES) return [PREFIXES[own], base];
    }
    return null;
  };
  const said = (value, unit) => {
    if (!isFinite(value)) return "none";
    const known = split(unit);
    if (!known || value === 0) {
      const small = value !== 0 && (Math.abs(value) < 1e-3 || Math.abs(value) >= 1e5);
      return (small ? value.toExponential(3) : String(+value.toPrecision(4))) + (known ? " " + unit : "");
    }
    const [power, base] = known;
    let wanted = 3 * Math.floor((Math.log10(Math.abs(value)) + power) / 3);
    wanted = Math.min(Math.max(wanted, -12), base === "m" ? 0 : 12);
    const prefix = Object.keys(PREFIXES).find((p) => PREFIXES[p] === wanted);
    return String(+(value * 10 ** (power - wanted)).toPrecision(4)) + " " + prefix + base;
  };
  const {length, pressure: ofPressure} = data.units;
  const point = (x, y) => {
    const gap = gapAt(x, y), p = pressureAt(x, y);
    return `x ${said(x, length)}, y ${said(y, length)}: pressure ${said(p, ofPressure)}`
      + (gap === null ? "" : gap === Infinity ? ", no material" : `, gap ${said(p > 0 && gap < 1e-4 * data.widest ? 0 : gap, length)}`);
  };

  const line = figure.querySelector(".said"), map = figure.querySelector(".map"), canvas = figure.querySelector("canvas");
  const cut = figure.querySelector(".cut"), tabs = figure.querySelector(".tabs");
  const IDLE = {map: "Move over the map to read pressure and gap; drag a line for a section.", surface: "Drag to turn, or use the arrow keys.",
    section: "Drag a line over the map for another section."};
  let view = "map";
  const say = (text) => { line.textContent = text || IDLE[view]; };

  // The point of the plane under a pointer, on whichever of the two maps is shown.
  const under = (event) => {
    for (const kind of ["page", "phone"]) {
      const svg = map.querySelector("svg." + kind), box = svg.getBoundingClientRect();
      if (!box.width) continue;
      const {area: [left, top, width, height], min, max} = data.placed[kind];
      const s = ((event.clientX - box.left) / box.width - left) / width, t = ((event.clientY - box.top) / box.height - top) / height;
      return {x: min[0] + s * (max[0] - min[0]), y: max[1] - t * (max[1] - min[1]), inside: s >= 0 && s <= 1 && t >= 0 && t <= 1};
    }
    return null;
  };

  // Sections: a line from end to end over the patch, pressure and gap along it.
  const NS = "http://www.w3.org/2000/svg";
  const element = (name, attributes, text) => {
    const made = document.createElementNS(NS, name);
    for (const key in attributes) made.setAttribute(key, attributes[key]);
    if (text !== undefined) made.textContent = text;
    return made;
  };
  const section = (from, to) => {
    const n = 240, along = Math.hypot(to.x - from.x, to.y - from.y);
    const width = Math.max(280, Math.min(cut.clientWidth || 352, 540)), height = 230, left = 12, right = 12, top = 40, bottom = 30;
    const svg = element("svg", {width, height, viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": "Pressure and gap along a line"});
    let most = 0, widest = 0;
    const points = [];
    for (let k = 0; k <= n; k++) {
      const x = from.x + k / n * (to.x - from.x), y = from.y + k / n * (to.y - from.y);
      const p = pressureAt(x, y), gap = gapAt(x, y);
      most = Math.max(most, p);
      if (gap !== null && isFinite(gap)) widest = Math.max(widest, gap);
      points.push([k / n, p, gap]);
    }
    const place = (s, share) => [left + s * (width - left - right), height - bottom - share * (height - top - bottom)];
    const path = (of, whole) => {
      let text = "", pen = "M";
      for (const p of points) {
        const value = of(p);
        if (value === null || !isFinite(value)) { pen = "M"; continue; }
        const [x, y] = place(p[0], whole > 0 ? value / whole : 0);
        text += `${pen}${x.toFixed(1)} ${y.toFixed(1)}`;
        pen = "L";
      }
      return text;
    };
    const [ax, ay] = place(0, 0), [bx] = place(1, 0);
    svg.append(element("path", {d: `M${ax} ${ay}H${bx}`, class: "axis"}));
    svg.append(element("path", {d: path((p) => p[2], widest), class: "gap"}), element("path", {d: path((p) => p[1], most), class: "pressure"}));
    svg.append(element("text", {x: left, y: 14, class: "pressure"}, `pressure, to ${said(most, ofPressure)}`));
    if (gaps) svg.append(element("text", {x: left, y: 31, class: "gap"}, `gap left, to ${said(widest, length)}`));
    svg.append(element("text", {x: left, y: height - 9}, "0"), element("text", {x: width - right, y: height - 9, "text-anchor": "end"}, said(along, length)));
    cut.replaceChildren(svg);
    const mark = element("path", {class: "mark axis"});
    svg.append(mark);
    svg.addEventListener("pointermove", (event) => {
      const box = svg.getBoundingClientRect();
      const s = Math.min(1, Math.max(0, ((event.clientX - box.left) / box.width * width - left) / (width - left - right)));
      mark.setAttribute("d", `M${place(s, 0).join(" ")}V${top}`);
      say(point(from.x + s * (to.x - from.x), from.y + s * (to.y - from.y)));
    });
  };
  const whole = {x: [x0, x0 + nx * h], y: [y0, y0 + ny * v]};
  const strongest = pressures.reduce((best, p, k) => p > pressures[best] ? k : best, 0);
  const peak = {x: x0 + (strongest % nx + 0.5) * h, y: y0 + (Math.floor(strongest / nx) + 0.5) * v};
  let ends = [{x: whole.x[0], y: peak.y}, {x: whole.x[1], y: peak.y}];
  const shown = (from, to) => {
    for (const kind of ["page", "phone"]) {
      const svg = map.querySelector("svg." + kind), {area: [left, top, width, height], min, max} = data.placed[kind];
      const [, , w, t] = svg.getAttribute("viewBox").split(" ").map(Number);
      const place = ({x, y}) => [w * (left + width * (x - min[0]) / (max[0] - min[0])), t * (top + height * (max[1] - y) / (max[1] - min[1]))];
      let stroke = svg.querySelector(".drawn");
      if (!stroke) svg.append(stroke = element("path", {class: "drawn"}));
      stroke.setAttribute("d", from ? `M${place(from).join(" ")}L${place(to).join(" ")}` : "");
    }
  };
  let start = null;
  map.addEventListener("pointerdown", (event) => {
    const at = under(event);
    if (at && at.inside) start = at;
  });
  map.addEventListener("pointermove", (event) => {
    const at = under(event);
    if (!at) return;
    if (start && (event.buttons & 1)) shown(start, at);
    say(at.inside ? point(at.x, at.y) : "");
  });
  map.addEventListener("pointerleave", () => say(""));
  map.addEventListener("pointerup", (event) => {
    const at = under(event), from = start;
    start = null;
    if (!from || !at || Math.hypot(at.x - from.x, at.y - from.y) < 2 * Math.max(h, v)) return;
    ends = [from, at];
    show("section");
  });

  // The surface: parallel projection, the farthest cells first.
  const VIRIDIS = [[68, 1, 84], [71, 44, 122], [59, 81, 139], [44, 113, 142], [33, 144, 141], [39, 173, 129], [92, 200, 99], [170, 220, 50], [253, 231, 37]];
  const shade = (share) => {
    const at = (1 - Math.min(1, Math.max(0, share))) * 8, k = Math.min(7, Math.floor(at));
    return VIRIDIS[k].map((c, m) => Math.round(c + (at - k) * (VIRIDIS[k + 1][m] - c)));
  };
  let turn = -0.6, down = 0.6;
  const step = Math.max(1, Math.ceil(Math.max(nx, ny) / 72));
  const nodes = (n) => { const all = []; for (let k = 0; k < n; k += step) all.push(k); if (all[all.length - 1] !== n - 1) all.push(n - 1); return all; };
  const columns = nodes(nx), rows = nodes(ny);
  const surface = () => {
    const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
    canvas.width = width * ratio;
    canvas.height = height * ratio;
    const to = canvas.getContext("2d");
    to.scale(ratio, ratio);
    const wide = nx * h, deep = ny * v, longest = Math.max(wide, deep), unit = 0.6 * Math.min(width, 1.3 * height);
    const place = (i, j, share) => {
      const u = ((i + 0.5) * h - wide / 2) / longest, w = ((j + 0.5) * v - deep / 2) / longest;
      const right = u * Math.cos(turn) - w * Math.sin(turn), away = u * Math.sin(turn) + w * Math.cos(turn);
      return [width / 2 + unit * right, 0.62 * height - unit * (away * Math.sin(down) + 0.55 * share * Math.cos(down)), away];
    };
    const shares = (i, j) => Math.min(1, pressureIn(i, j) / data.scale);
    const quads = [];
    for (let b = 0; b + 1 < rows.length; b++) {
      for (let a = 0; a + 1 < columns.length; a++) {
        const corners = [[columns[a], rows[b]], [columns[a + 1], rows[b]], [columns[a + 1], rows[b + 1]], [columns[a], rows[b + 1]]];
        const heights = corners.map(([i, j]) => shares(i, j));
        if (heights.every((s) => s === 0)) continue;
        const seen = corners.map(([i, j], k) => place(i, j, heights[k]));
        quads.push([seen[0][2] + seen[1][2] + seen[2][2] + seen[3][2], seen, (heights[0] + heights[1] + heights[2] + heights[3]) / 4]);
      }
    }
    quads.sort((p, q) => q[0] - p[0]);
    const ink = getComputedStyle(canvas).color;
    to.strokeStyle = ink;
    to.globalAlpha = 0.3;
    to.beginPath();
    for (const [i, j] of [[-0.5, -0.5], [nx - 0.5, -0.5], [nx - 0.5, ny - 0.5], [-0.5, ny - 0.5], [-0.5, -0.5]]) to.lineTo(...place(i, j, 0).slice(0, 2));
    to.stroke();
    to.globalAlpha = 1;
    to.lineWidth = 0.5;
    for (const [, seen, share] of quads) {
      to.fillStyle = to.strokeStyle = `rgb(${shade(share)})`;
      to.beginPath();
      for (const p of seen) to.lineTo(p[0], p[1]);
      to.closePath();
      to.fill();
      to.stroke();
    }
    to.fillStyle = ink;
    to.font = "13px sans-serif";
    to.textAlign = "center";
    to.fillText("x", ...place(nx + 0.06 * longest / h, ny / 2, 0).slice(0, 2));
    to.fillText("y", ...place(nx / 2, ny + 0.06 * longest / v, 0).slice(0, 2));
  };
  let held = null;
  canvas.addEventListener("pointerdown", (event) => { held = [event.clientX, event.clientY]; canvas.setPointerCapture(event.pointerId); });
  canvas.addEventListener("pointerup", () => { held = null; });
  const turned = (by, tip) => {
    turn += by;
    down = Math.min(1.5, Math.max(0.05, down + tip));
    surface();
  };
  canvas.addEventListener("pointermove", (event) => {
    if (!held) return;
    turned((event.clientX - held[0]) / 120, (event.clientY - held[1]) / 160);
    held = [event.clientX, event.clientY];
  });
  canvas.addEventListener("keydown", (event) => {
    const by = {ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.08], ArrowDown: [0, 0.08]}[event.key];
    if (by) { event.preventDefault(); turned(...by); }
  });

  const show = (name) => {
    view = name;
    for (const button of tabs.children) button.setAttribute("aria-pressed", String(button.dataset.view === name));
    map.hidden = name === "surface";
    canvas.hidden = name !== "surface";
    cut.hidden = name !== "section";
    shown(...(name === "section" ? ends : []));
    if (name === "surface") surface();
    if (name === "section") section(...ends);
    say("");
  };
  tabs.addEventListener("click", (event) => { if (event.target.dataset.view) show(event.target.dataset.view); });
  window.addEventListener("resize", () => { if (view !== "map") show(view); });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { if (view === "surface") surface(); });
  // Paper has the map and the scene in full.
  let folded = [];
  window.addEventListener("beforeprint", () => {
    show("map");
    folded = [...document.querySelectorAll("details:not([open])")];
    folded.forEach((one) => { one.open = true; });
  });
  window.addEventListener("afterprint", () => folded.forEach((one) => { one.open = false; }));
  tabs.hidden = false;
  say("");
})();
