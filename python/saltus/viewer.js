// The program of the page: tables of runs, panels of curves, and the time that they share with the scene. The page
// defines view_data and scene_data (viewer.py); scene.js draws the scene, if there is one.
"use strict";

// ---- Tables -----------------------------------------------------------------------------------
const bytes = text => Uint8Array.from(atob(text), c => c.charCodeAt(0)).buffer;

// A column as numbers; missing ones are NaN.
function unpack(column) {
  if (column.f) return new Float32Array(bytes(column.f));
  return Float64Array.from(new Uint16Array(bytes(column.u)),
                           level => level === 65535 ? NaN : column.low + column.step * level);
}

class Table {
  constructor(packed) {
    Object.assign(this, packed);
    this.time = new Float64Array(bytes(packed.time));
    if (view_data.logarithmic && !(this.time[0] > 0)) this.time[0] = this.time[1] / 10;  // zero has no logarithm
    this.unpacked = {};
  }
  column(name) { return this.unpacked[name] ||= unpack(this.columns[name]); }
  // Row and fraction of the way to the next one.
  place(t) {
    if (t === this.asked) return this.found;
    let low = 0, high = this.time.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.time[middle] <= t) low = middle; else high = middle - 1;
    }
    const next = Math.min(low + 1, this.time.length - 1), step = this.time[next] - this.time[low];
    this.asked = t;
    return this.found = [low, next, step > 0 && !this.hold ? Math.min(Math.max((t - this.time[low]) / step, 0), 1) : 0];
  }
  at(name, t) {
    const [row, next, part] = this.place(t), values = this.column(name);
    return part === 0 ? values[row] : (1 - part) * values[row] + part * values[next];
  }
  text(name, t) { return this.columns[name].names[this.column(name)[this.place(t)[0]]]; }
}

let runs = [];
function take_in(data) {
  runs = data.runs.map(run => ({
    ...run, plans: run.plans && new Table(run.plans),
    tables: Object.fromEntries(Object.entries(run.tables).map(([name, packed]) => [name, new Table(packed)])),
  }));
}
const all_tables = () => runs.flatMap(run => Object.values(run.tables));
const span = () => [Math.min(...all_tables().map(t => t.time[0])), Math.max(...all_tables().map(t => t.time.at(-1)))];
const modes_of = run => (run.tables.trajectory || Object.values(run.tables).find(t => t.modes) || {}).modes || [];

const mode_names = run => [...new Set(Object.values(run.tables).flatMap(t => t.modes || []).map(m => m[2]))];

// ---- Panels -----------------------------------------------------------------------------------
const SHADES = ["#dbe9f6", "#fde6cf", "#dff0d8", "#f3dcef", "#fff3bf", "#e2e2e2", "#d5f0f0", "#f6d8d8"];
const COLORS = ["#1f77b4", "#d9661f", "#2e7d32", "#8e24aa", "#795548", "#d81b60", "#607d8b", "#9e9d24"];
const DASHES = [[], [8, 4], [2, 3], [10, 3, 2, 3]];  // by run
const plots = document.getElementById("plots");
let panels = [];
const element = (kind, parent, text, name) => {
  const made = document.createElement(kind);
  if (text) made.textContent = text;
  if (name) made.className = name;
  parent.append(made);
  return made;
};
// A thousandth of the range of the panel is the last digit.
function digits(v, { min, max }) {
  if (!Number.isFinite(v)) return "\u2013";
  const last = Math.floor(Math.log10(max - min || 1)) - 3;
  return last < -6 || last > 3 ? v.toExponential(2) : v.toFixed(Math.max(0, -last)).replace(/^-(?=[0.]+$)/, "");
}

// Labels of an axis: 250, 0.05, 2.5e6.
const ticks = (u, at) => at.map(v => v === null ? "" : v !== 0 && (Math.abs(v) >= 1e5 || Math.abs(v) < 1e-3)
  ? v.toExponential(2).replace(/\.?0+e/, "e").replace("e+", "e") : String(Number(v.toPrecision(6))));

// Series of all runs in one panel, each with its own times.
function series_of(spec) {
  return runs.flatMap((run, index) => {
    const table = run.tables[spec.table];
    return !table ? [] : spec.series.filter(s => table.columns[s.column]).map((s, i) => {
      const components = new Set(spec.series.map(x => x.label.replace(/ ?planned/, ""))), alone = components.size === 1;
      const color = COLORS[(alone ? index : [...components].indexOf(s.label.replace(/ ?planned/, ""))) % COLORS.length];
      return { run, table, column: s.column, color, names: table.columns[s.column].names, planned: s.dash,
               dash: s.dash ? [4, 4] : alone ? [] : DASHES[index % DASHES.length],
               label: [s.label, runs.length > 1 ? run.name : ""].filter(Boolean).join(" ") };
    });
  });
}
const to_plot = s => [s.table.time, Array.from(s.table.column(s.column), v => Number.isNaN(v) ? null : v)];
const join = series => uPlot.join(series.map(to_plot));

// A constant up to rounding gets a range around it.
function range(u, low, high) {
  if (low === null || high === null || !Number.isFinite(low)) return [-1, 1];
  if (high - low <= 1e-9 * Math.max(1, Math.abs(low))) return [low - 1, high + 1];
  const room = 0.06 * (high - low);
  return [low - room, high + room];
}

// Modes are those of the table of the panel, if it has any; events belong to the first table.
function shade(u, spec) {
  const { ctx, bbox } = u, run = runs[0], own = (run.tables[spec.table] || {}).modes || modes_of(run);
  const names = mode_names(run), modes = own.some(m => m[2] !== own[0][2]) ? own : [];
  const events = spec.table.startsWith("trajectory_") && spec.table !== view_data.main ? [] : run.events;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  const visible = (from, to) => to >= u.scales.x.min && from <= u.scales.x.max;
  const few = list => list.length * 6 * devicePixelRatio < bbox.width ? list : [];  // others would cover the curves
  for (const [begin, end, name] of few(modes.filter(([from, to]) => visible(from, to)))) {
    const left = u.valToPos(begin, "x", true), right = u.valToPos(end, "x", true);
    ctx.fillStyle = SHADES[names.indexOf(name) % SHADES.length];
    ctx.fillRect(left, bbox.top, right - left, bbox.height);
  }
  ctx.strokeStyle = "#555";
  ctx.lineWidth = devicePixelRatio;
  ctx.setLineDash([5, 4]);
  for (const [t] of few(events.filter(([at]) => visible(at, at)))) {
    const x = u.valToPos(t, "x", true);
    ctx.beginPath();
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
  }
  ctx.restore();
}

// The plans of a closed loop: all thin, the one in force at the time of the scene thick.
function draw_plans(u, panel) {
  const { ctx, bbox } = u;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  for (const run of runs) {
    if (!run.plans || panel.spec.table !== "trajectory" || !plans_wanted) continue;
    const now = plan_at(run, time);
    panel.spec.series.filter(s => run.plans.columns[s.column]).forEach(s => {
      const values = run.plans.column(s.column);
      run.plans.plans.forEach(([, first, count], index) => {
        ctx.strokeStyle = index === now ? "#000" : "rgba(90, 90, 90, .45)";
        ctx.lineWidth = (index === now ? 1.8 : 0.7) * devicePixelRatio;
        ctx.setLineDash(index === now ? [6, 3] : []);
        ctx.beginPath();
        for (let i = first; i < first + count; ++i)
          if (!Number.isNaN(values[i]))
            ctx.lineTo(u.valToPos(run.plans.time[i], "x", true), u.valToPos(values[i], "y", true));
        ctx.stroke();
      });
    });
  }
  ctx.restore();
}
let plans_wanted = true;
const plan_at = (run, t) => run.plans ? run.plans.plans.findLastIndex(([made]) => made <= t + 1e-9) : -1;

let zooming = false;
function zoom(u, key) {
  if (key !== "x" || zooming) return;
  zooming = true;
  for (const other of panels) if (other.plot !== u) other.plot.setScale("x", { min: u.scales.x.min, max: u.scales.x.max });
  zooming = false;
  panels.forEach(move_line);
}

function show_panel(spec) {
  const series = series_of(spec);
  if (series.length === 0) return;
  const box = element("div", plots, "", "panel"), head = element("div", box, "", "head");
  const prefix = spec.table === view_data.main ? "" : spec.table + ": ";
  element("b", head, prefix + spec.title + (spec.unit ? ` [${spec.unit}]` : ""));
  const labels = series.map(s => Object.assign(element("span", head), { style: `color: ${s.color}` }));
  const panel = { spec, series, box, labels };
  const names = series[0].names;
  const stepped = spec.stepped || names;
  panel.plot = new uPlot({
    width: box.clientWidth - 14, height: 150,
    legend: { show: false }, padding: [8, 10, 0, 0], pxAlign: 0,
    cursor: { sync: { key: "time", setSeries: false, scales: ["x", null],
                      filters: { pub: kind => kind === "mousemove" || kind === "mouseleave", sub: () => true } },
              drag: { x: true, y: false }, points: { show: false } },
    scales: { x: { time: false, distr: view_data.logarithmic ? 3 : 1 }, y: { range } },
    axes: [{ size: 26, font: "11px system-ui", values: ticks, grid: { stroke: "#0001" } },
           { size: names ? 76 : 58, space: 24, font: "11px system-ui", grid: { stroke: "#0001" },
             ...(names ? { splits: names.map((_, i) => i), values: (u, at) => at.map(i => names[i]) }  : { values: ticks }) }],
    series: [{}, ...series.map(s => ({ stroke: s.color, width: 1.5, dash: s.dash, points: { show: false },
                                       paths: stepped ? uPlot.paths.stepped({ align: 1 }) : undefined }))],
    hooks: { drawClear: [u => shade(u, spec)], draw: [u => draw_plans(u, panel)], setScale: [zoom],
             setCursor: [u => show_values(panel, u.cursor.left >= 0 ? u.posToVal(u.cursor.left, "x") : time)] },
  }, join(series), box);
  panel.line = element("div", panel.plot.over, "", "now");
  let pressed = 0;
  panel.plot.over.addEventListener("mousedown", e => { pressed = e.clientX; });
  panel.plot.over.addEventListener("mouseup", e => {  // a click without a drag
    if (Math.abs(e.clientX - pressed) < 3) {
      playing = false;
      go(panel.plot.posToVal(e.clientX - panel.plot.over.getBoundingClientRect().left, "x"));
    }
  });
  panels.push(panel);
  move_line(panel);
  show_values(panel, time);
}
function show_values(panel, t) {
  panel.series.forEach((s, i) => {
    const inside = t >= s.table.time[0] - 1e-9 && t <= s.table.time.at(-1) + 1e-9;
    const value = !inside ? "\u2013" : s.names ? s.table.text(s.column, t) : digits(s.table.at(s.column, t), panel.plot.scales.y);
    panel.labels[i].textContent = s.planned ? `(${value})` : (s.label ? s.label + " " : "") + value;
  });
}
function move_line(panel) {
  const x = panel.plot.valToPos(time, "x");
  panel.line.style.display = x >= 0 && x <= panel.plot.bbox.width / devicePixelRatio ? "" : "none";
  panel.line.style.transform = `translateX(${x - 0.75}px)`;
}
function build_panels() {
  for (const panel of panels) { panel.plot.destroy(); panel.box.remove(); }
  panels = [];
  view_data.panels.filter(spec => spec.shown).forEach(show_panel);
  fit_panels();
}
// Few panels are taller, so that they fill the page.
function fit_panels() {
  const columns = getComputedStyle(plots).gridTemplateColumns.split(" ").length, rows = Math.ceil(panels.length / columns);
  const height = Math.min(Math.max(Math.floor(plots.clientHeight / rows) - 44, 130), 320);
  for (const panel of panels) panel.plot.setSize({ width: panel.box.clientWidth - 14, height });
  panels.forEach(move_line);
}

// ---- Menus ------------------------------------------------------------------------------------
function menu(title) {
  const details = element("details", document.querySelector("header"), "", "menu");
  element("summary", details, title);
  return element("div", details);
}
function make_menus() {
  const curves = menu("Curves");
  const box = (text, checked, act) => {
    const label = element("label", curves);
    const input = element("input", label);
    input.type = "checkbox";
    input.checked = checked;
    input.onchange = () => act(input.checked);
    label.append(" " + text);
    return label;
  };
  if (runs.some(run => run.plans))
    box("plans of the controller", true, on => { plans_wanted = on; panels.forEach(p => p.plot.redraw(false)); });
  const search = element("input", curves);
  search.placeholder = "search";
  const labels = [];
  for (const table of new Set(view_data.panels.map(spec => spec.table))) {
    const every = Math.max(...runs.map(run => run.tables[table]?.every || 1));
    element("h4", curves, table + (every > 1 ? ` (every ${every}th row)` : ""));
    for (const spec of view_data.panels.filter(s => s.table === table)) {
      const label = box(spec.title + (spec.unit ? ` [${spec.unit}]` : ""), spec.shown,
                        on => { spec.shown = on; build_panels(); });
      labels.push([label, [spec.title, ...spec.series.map(s => s.column)].join(" ").toLowerCase()]);
    }
  }
  search.oninput = () => {
    for (const [label, text] of labels) label.style.display = text.includes(search.value.toLowerCase()) ? "" : "none";
  };
  for (const note of view_data.notes) {
    const table = element("table", menu(note.title));
    if (runs.length > 1) for (const text of ["", ...runs.map(run => run.name)]) element("td", table, text);
    for (const row of note.rows) {
      const line = element("tr", table);
      for (const text of row) element("td", line, text);
    }
  }
  addEventListener("pointerdown", e => {
    for (const open of document.querySelectorAll("details.menu[open]")) if (!open.contains(e.target)) open.open = false;
  });
}
// Modes, events and, if there are several, runs.
function make_keys() {
  const keys = document.getElementById("keys"), most = 8;
  keys.textContent = "";
  const key = (color, text) => {
    const span = element("span", keys);
    element("i", span).style.background = color;
    span.append(text);
  };
  const names = mode_names(runs[0]);
  if (names.length > 1) names.slice(0, most).forEach((name, i) => key(SHADES[i % SHADES.length], name));
  if (names.length > most) element("span", keys, `and ${names.length - most} more`);
  const texts = [...new Set(runs[0].events.map(e => e[1]))];
  if (texts.length) element("span", keys, "\u2506 " + texts.slice(0, most).join(", ") + (texts.length > most ? ", ..." : ""));
  if (runs.some(run => run.plans)) element("span", keys, "grey: plans of the controller, black: the plan in force");
  if (view_data.panels.some(spec => spec.series.some(s => s.dash))) element("span", keys, "dashed, in brackets: planned");
  element("span", keys, "horizontal: t [s]");
  if (runs.length > 1) runs.forEach((run, i) => key(COLORS[i % COLORS.length], run.name));
}

// ---- Time -------------------------------------------------------------------------------------
const play = document.getElementById("play"), scrub = document.getElementById("scrub");
const clock = document.getElementById("clock"), speed = document.getElementById("speed");
let begin = 0, end = 1, time = 0, playing = false, last = null, drawn = 0, world_of_scene = null, plans_shown = [];

const curve = t => view_data.logarithmic ? Math.log(t) : t;  // along the slider

function refresh() {
  scrub.value = Math.round((curve(time) - curve(begin)) / (curve(end) - curve(begin) || 1) * scrub.max);
  clock.textContent = `${view_data.logarithmic ? time.toExponential(2) : time.toFixed(end - begin < 100 ? 2 : 1)} s`;
  play.textContent = playing ? "Pause" : "Play";
  const plans = runs.map(run => plan_at(run, time));
  if (plans.some((plan, i) => plan !== plans_shown[i])) {
    plans_shown = plans;
    panels.forEach(panel => panel.plot.redraw(false));
  }
  for (const panel of panels) {
    move_line(panel);
    if (!(panel.plot.cursor.left >= 0)) show_values(panel, time);
  }
  if (world_of_scene) world_of_scene.show(time);
}
function go(t) {
  time = Math.min(Math.max(t, begin), end);
  refresh();
}
function set_playing(on) {
  if (on && time >= end) time = begin;
  playing = on;
  last = null;
  refresh();
}
// The first frames are slow on slow machines; a running clock would not start at zero.
const longest_gap = 250;  // ms
function tick(now) {
  if (playing) {
    if (last !== null && drawn > 2) time += Math.min(now - last, longest_gap) / 1000 * Number(speed.value);
    last = now;
    ++drawn;
    if (time >= end) { time = end; playing = false; }
    refresh();
  }
  requestAnimationFrame(tick);
}
// #t=1.0 pauses at this time; #t=1.0&view=front also selects the view.
function from_address() {
  const wish = new URLSearchParams(location.hash.slice(1));
  if (world_of_scene && wish.has("view")) world_of_scene.look_from(wish.get("view"));
  const t = parseFloat(wish.get("t"));
  if (!Number.isFinite(t)) return false;
  playing = false;
  go(t);
  return true;
}
function resize() {
  if (world_of_scene) world_of_scene.resize();
  fit_panels();
  refresh();
}

// ---- A run that continues -----------------------------------------------------------------------
let is_live = view_data.live;
function saltus_live(data, is_over) {
  if (document.body.dataset.rows === data.runs[0].tables.trajectory.time && !is_over) return;
  document.body.dataset.rows = data.runs[0].tables.trajectory.time;
  const at_end = time >= end;
  take_in(data);
  view_data.notes = data.notes;
  [begin, end] = span();
  for (const panel of panels) {
    panel.series = series_of(panel.spec);
    panel.plot.setData(join(panel.series));
  }
  make_keys();
  if (world_of_scene) world_of_scene.trace();
  go(at_end ? end : time);
  is_live = !is_over;
}
function ask_again() {
  if (!is_live) return;
  const script = document.createElement("script");
  script.src = `view_live.js?${Date.now()}`;
  script.onload = script.onerror = () => { script.remove(); setTimeout(ask_again, 500); };
  document.body.append(script);
}

// #movie=20&from=2&to=5 draws 20 pictures per second of the scene into the page; saltus movie reads them.
function film(rate, from, to) {
  const pictures = [];
  world_of_scene.sun.castShadow = false;  // saves half of the time without a graphics card
  for (let t = Math.max(from, begin); t <= Math.min(to, end); t += 1 / rate) {
    go(t);
    pictures.push(world_of_scene.picture());
  }
  Object.assign(element("pre", document.body, pictures.join("\n")), { id: "film" });
}

function start_viewer() {
  take_in(view_data);
  [begin, end] = span();
  time = begin;
  const asked = new URLSearchParams(location.hash.slice(1));
  const number = (key, otherwise) => asked.has(key) ? parseFloat(asked.get(key)) : otherwise;
  if (asked.has("movie")) document.body.classList.add("movie");
  if (scene_data.items) world_of_scene = make_world();
  else document.body.classList.add("flat");
  make_menus();
  make_keys();
  if (!asked.has("movie")) build_panels();
  play.onclick = () => set_playing(!playing);
  scrub.oninput = () => {
    const at = curve(begin) + scrub.value / scrub.max * (curve(end) - curve(begin));
    playing = false;
    go(view_data.logarithmic ? Math.exp(at) : at);
  };
  onhashchange = from_address;
  onkeydown = e => {
    if (["SELECT", "INPUT"].includes(e.target.tagName) && e.target !== scrub) return;
    const step = (end - begin) / 500;
    if (e.key === " ") set_playing(!playing);
    else if (e.key === "ArrowLeft") { playing = false; go(time - step); }
    else if (e.key === "ArrowRight") { playing = false; go(time + step); }
    else return;
    e.preventDefault();
  };
  onresize = resize;
  resize();
  if (asked.has("movie")) {
    from_address();
    film(number("movie"), number("from", begin), number("to", end));
    return;
  }
  if (is_live) { go(end); ask_again(); }
  else if (!from_address() && world_of_scene) set_playing(true);
  requestAnimationFrame(tick);
}
