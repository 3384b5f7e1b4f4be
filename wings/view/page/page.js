const data = JSON.parse(document.getElementById("data").textContent);
const main = document.querySelector("main");
const followers = []; // functions of the time [s] that the page shows

function element(tag, parent, attributes = {}, text = "") {
  const made = document.createElement(tag);
  Object.assign(made, attributes);
  if (text) made.textContent = text;
  if (parent) parent.append(made);
  return made;
}

// Plots beside each other, where there is room.
function plots(section, names) {
  const row = element("div", section, { className: "plots" });
  return names.map((className) => element("div", row, { className }));
}

function panel(title, note = "", wide = false) {
  const section = element("section", main, { className: wide ? "wide" : "" });
  const row = element("div", section, { className: "row" });
  element("h2", row, {}, title);
  if (note) element("span", row, { className: "soft" }, note);
  return [section, row];
}

// Cards that need half the width stand in two columns, each below the shorter one; one alone takes the whole width.
function arrange() {
  const runs = [[]];
  for (const section of [...main.children]) {
    if (section.className === "wide") runs.push([]); else runs.at(-1).push(section);
  }
  for (const run of runs) {
    if (run.length < 2) continue;
    const columns = element("div", null, { className: "columns" });
    run[0].before(columns);
    const sides = [0, 1].map(() => element("div", columns, { className: "column" }));
    const length = (side) => [...side.children].reduce((sum, one) => sum + one.offsetHeight, 0);
    for (const [place, section] of run.entries()) {
      section.style.order = place;
      sides[length(sides[0]) <= length(sides[1]) ? 0 : 1].append(section);
    }
    columns.classList.add("filled"); // the last card of the shorter column takes what is left
  }
  for (const node of main.querySelectorAll(".js-plotly-plot")) Plotly.Plots.resize(node);
}
addEventListener("load", arrange);

function choice(row, title, names) {
  const select = element("select", row, { title });
  for (const name of names) element("option", select, {}, name);
  return select;
}

function bytes(text) {
  const raw = atob(text), found = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) found[i] = raw.charCodeAt(i);
  return found;
}

// The number of the last of these times at or before a time; before the first, 0.
function before(count, at, time) {
  let low = 0, high = count - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (at(middle) <= time + 1e-9) low = middle; else high = middle - 1;
  }
  return low;
}
const frameAt = (frames, time) => frames[before(frames.length, (one) => frames[one].t, time)];

const seconds = (t) => t.toFixed(3) + " s";
const short = (value) => String(Number(value.toPrecision(3)));
// Plotly reads its texts as a kind of HTML.
const plain = (text) => text.replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;");
const narrow = () => innerWidth < 600;

// -- plots, in the colours of the page --------------------------------------------------------------------------------

const dark = matchMedia("(prefers-color-scheme: dark)"), turbo = data.palette;
// On a dark page without the darkest ends of the palette.
const palette = () => (dark.matches ? turbo.slice(1, -1).map(([, shade], place, all) => [place / (all.length - 1), shade]) : turbo);
const sensors = ["#2f7ed8", "#e0852b", "#36a86a", "#c05fc0", "#c9a227", "#2ba8a8", "#d05050", "#8a77d8"];
const config = { responsive: true, displaylogo: false };
const equal = { scaleanchor: "x", scaleratio: 1 };
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();

function axis(title, more = {}) {
  const line = colour("line");
  return { title: { text: title, font: { size: 12 } }, gridcolor: line, zerolinecolor: colour("faint"), linecolor: line, exponentformat: "power", ...more };
}
function spatial(title, range) {
  return { ...axis(title), range, backgroundcolor: colour("panel"), showbackground: false };
}
const colourBar = (title) => ({ thickness: 10, len: 0.7, outlinewidth: 0, title: { text: plain(title), side: "right", font: { size: 12 } } });

function plot(node, traces, layout) {
  const page = { paper_bgcolor: colour("panel"), plot_bgcolor: colour("panel"), font: { color: colour("ink"), size: 11 },
    legend: { orientation: "h", y: -0.3, bgcolor: "rgba(0,0,0,0)", itemsizing: "constant" },
    hovermode: "closest", showlegend: false, modebar: { bgcolor: "rgba(0,0,0,0)", color: colour("faint"), activecolor: colour("mark") },
    margin: { l: 56, r: 12, t: 26, b: 40 }, uirevision: 1 };
  Plotly.react(node, traces, { ...page, ...layout }, { ...config, displayModeBar: narrow() ? false : "hover" });
}

// A line at the time that the page shows.
const cursor = (time) => ({ type: "line", x0: time, x1: time, yref: "paper", y0: 0, y1: 1, line: { width: 1, color: colour("soft") } });

// Draws when the panel comes into sight, then at every change of the time or of the page's colours.
function draws(node, draw) {
  let seen = false, shown = null;
  new IntersectionObserver((entries) => {
    seen = entries.at(-1).isIntersecting;
    if (seen && shown !== clock.time) { shown = clock.time; draw(shown); }
  }, { rootMargin: "200px" }).observe(node);
  followers.push((time, again) => {
    if (again) shown = null;
    if (seen && shown !== time) { shown = time; draw(time); }
  });
}

// A bar of the palette; returns a function that says its ends.
function bar(parent, unit) {
  const row = element("div", parent, { className: "colours" });
  const low = element("span", row), strip = element("i", row), high = element("span", row);
  strip.style.background = `linear-gradient(to right, ${turbo.filter((_, place) => place % 2 === 0).map((one) => one[1]).join(", ")})`;
  return (frame) => { low.textContent = `${short(frame.low)} ${unit}`; high.textContent = `${short(frame.high)} ${unit}`; };
}

function table(title, columns, rows, note = "", folded = false) {
  const [section] = panel(title, note, true);
  let parent = section;
  if (folded) {
    parent = element("details", section);
    element("summary", parent, {}, `${rows.length} lines`);
  }
  const made = element("table", element("div", parent, { className: "scroll" }));
  const head = element("tr", element("thead", made)), body = element("tbody", made);
  for (const column of columns) element("th", head, {}, column);
  for (const row of rows) {
    const line = element("tr", body);
    for (const [place, cell] of row.entries()) element("td", line, { className: columns[place] === "code" ? "code" : "" }, cell);
  }
}

// -- the time ---------------------------------------------------------------------------------------------------------

const clock = { start: data.start, end: data.end, time: data.start };
const slider = document.getElementById("time"), now = document.getElementById("now"), play = document.getElementById("play");

function show(time, again = false) {
  clock.time = time;
  now.textContent = seconds(time);
  for (const follow of followers) follow(time, again);
}

let playing = 0;
play.onclick = () => {
  if (playing) { clearInterval(playing); playing = 0; play.textContent = "Play"; return; }
  play.textContent = "Pause";
  playing = setInterval(() => {
    const next = clock.time + 0.1 > clock.end ? clock.start : clock.time + 0.1;
    slider.value = next;
    show(next);
  }, 200);
};
Object.assign(slider, { min: clock.start, max: clock.end, step: 0.01, value: clock.start });
slider.oninput = () => show(Number(slider.value));
dark.addEventListener("change", () => show(clock.time, true));
