"use strict";
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

function panel(title, note = "", wide = false) {
  const section = element("section", main, { className: wide ? "wide" : "" });
  const row = element("div", section, { className: "row" });
  element("h2", row, {}, title);
  if (note) element("span", row, { className: "soft" }, note);
  return [section, row];
}

function bytes(text) {
  const raw = atob(text), found = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) found[i] = raw.charCodeAt(i);
  return found;
}

// The last frame at or before a time; before the first, the first.
function frameAt(frames, time) {
  let low = 0, high = frames.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (frames[middle].t <= time + 1e-9) low = middle; else high = middle - 1;
  }
  return frames[low];
}

const seconds = (t) => t.toFixed(3) + " s";
const config = { responsive: true, displaylogo: false };
const turbo = data.palette;
const flat = { margin: { l: 56, r: 12, t: 26, b: 40 }, hovermode: "closest", showlegend: false };
const equal = { scaleanchor: "x", scaleratio: 1 };

// Draws when the panel comes into sight, then at every change of the time.
function draws(node, draw) {
  let seen = false, shown = null;
  new IntersectionObserver((entries) => {
    seen = entries.some((entry) => entry.isIntersecting);
    if (seen && shown !== clock.time) { shown = clock.time; draw(shown); }
  }).observe(node);
  followers.push((time) => { if (seen && shown !== time) { shown = time; draw(time); } });
}

function decoded(cloud, frame) {
  if (!frame.x) {
    const raw = bytes(frame.places), all = new Uint16Array(raw.buffer, 0, raw.length >> 1), n = all.length / 3;
    for (const [axis, name] of ["x", "y", "z"].entries()) {
      frame[name] = new Float32Array(n);
      for (let i = 0; i < n; i++) frame[name][i] = cloud.low[axis] + cloud.steps[axis] * all[3 * i + axis];
    }
    frame.values = frame.colours.map((text, number) => {
      const { low, high } = cloud.fields[number];
      return Float32Array.from(bytes(text), (one) => (one ? low + ((one - 1) / 254) * (high - low) : NaN));
    });
    frame.places = frame.colours = null;
  }
  return frame;
}

function drawCloud(cloud) {
  const shown = cloud.frames.length, of = cloud.count > shown ? `${shown} of ${cloud.count} clouds` : `${shown} clouds`;
  const [section, row] = panel(cloud.topic, `${of}, in ${cloud.frame || "its frame"}`);
  const select = element("select", row, { title: "what colours the points" });
  for (const field of cloud.fields) element("option", select, {}, field.name);
  const said = element("span", row, { className: "soft" });
  const node = element("div", section, { className: "cloud" });
  const end = cloud.steps.map((step, axis) => cloud.low[axis] + 65535 * step);
  const extent = Math.max(...end.map((one, axis) => one - cloud.low[axis]));
  const axes = Object.fromEntries(["x", "y", "z"].map((name, axis) => [
    `${name}axis`, { title: { text: name }, range: [cloud.low[axis], end[axis]], backgroundcolor: "#f5f7f9" }]));
  const ratio = Object.fromEntries(["x", "y", "z"].map((name, axis) => [
    name, Math.max(0.03, 1.15 * (end[axis] - cloud.low[axis]) / extent)]));
  const view = { eye: { x: -1.1, y: -1.1, z: 0.9 }, up: { x: 0, y: 0, z: 1 } };
  const layout = { margin: { l: 0, r: 0, t: 0, b: 0 }, uirevision: 1,
    scene: { ...axes, aspectmode: "manual", aspectratio: ratio, camera: view } };
  const draw = (time) => {
    const frame = decoded(cloud, frameAt(cloud.frames, time)), number = Math.max(0, select.selectedIndex);
    const field = cloud.fields[number] || { low: 0, high: 1 }, n = frame.x.length;
    said.textContent = `at ${seconds(frame.t)}, ` + (n < frame.total ? `${n} of ${frame.total}` : `${n}`) + " points";
    const marker = { size: n > 5000 ? 1.3 : n > 500 ? 2 : 4, color: frame.values[number], colorscale: turbo,
      cmin: field.low, cmax: field.high, colorbar: { thickness: 10, len: 0.7, title: { text: field.name } } };
    Plotly.react(node, [{ type: "scatter3d", mode: "markers", x: frame.x, y: frame.y, z: frame.z, marker }],
      layout, config);
  };
  select.onchange = () => draw(clock.time);
  if (cloud.ranges) {
    const image = element("img", section, { title: "range image: ahead in the middle, colours from near to far" });
    followers.push((time) => { image.src = frameAt(cloud.ranges, time).src; });
  }
  draws(node, draw);
}

function drawRadar(radar) {
  const [section, row] = panel(radar.topic, "detections: range over velocity, and from above; grey: all frames");
  const said = element("span", row, { className: "soft" });
  const sides = [
    ["v", "r", "radial velocity [m/s]", "range [m]", {}],
    ["y", "x", "left [m]", "ahead [m]", { autorange: "reversed" }],
  ].map(([across, up, first, second, more]) => [element("div", section, { className: "plot" }), across, up,
    { ...flat, xaxis: { title: { text: first }, ...more }, yaxis: { title: { text: second }, ...(up === "x" ? equal : {}) } }]);
  const grey = { size: 3, color: "#cfd6de" };
  const all = (name) => radar.frames.flatMap((frame) => frame[name]);
  for (const [node, across, up, layout] of sides) {
    const back = { mode: "markers", type: "scattergl", x: all(across), y: all(up), marker: grey, hoverinfo: "skip" };
    draws(node, (time) => {
      const frame = frameAt(radar.frames, time);
      said.textContent = `at ${seconds(frame.t)}, ${frame.r.length} detections`;
      const marker = { size: 8, color: frame.c, colorscale: turbo, cmin: radar.low, cmax: radar.high, showscale: true,
        colorbar: { thickness: 10, title: { text: radar.colour } } };
      Plotly.react(node, [back, { mode: "markers", type: "scattergl", x: frame[across], y: frame[up], marker }],
        layout, config);
    });
  }
}

function drawPictures(pictures) {
  const shown = pictures.frames.length;
  const [section, row] = panel(pictures.topic, pictures.count > shown ? `${shown} of ${pictures.count} images` : `${shown} images`);
  const said = element("span", row, { className: "soft" });
  const image = element("img", section, { className: "picture", alt: pictures.topic });
  followers.push((time) => {
    const frame = frameAt(pictures.frames, time);
    if (said.textContent !== (said.textContent = `at ${seconds(frame.t)}`)) image.src = frame.src;
  });
}

function drawPaths(paths) {
  const [section] = panel("Where the frames went", `from above, in ${paths[0].root}`);
  const node = element("div", section, { className: "plot" });
  const layout = { ...flat, showlegend: true, xaxis: { title: { text: "x [m]" } }, yaxis: { title: { text: "y [m]" }, ...equal } };
  draws(node, (time) => {
    const lines = paths.map((path) => ({ name: path.name, mode: "lines", x: path.places[0], y: path.places[1] }));
    const dots = paths.map((path) => {
      const place = Math.max(0, path.t.findLastIndex((one) => one <= time + 1e-9));
      return { mode: "markers", showlegend: false, x: [path.places[0][place]], y: [path.places[1][place]],
        marker: { size: 7, color: "#1c2430" }, hoverinfo: "skip" };
    });
    Plotly.react(node, [...lines, ...dots], layout, config);
  });
}

function drawValues(values) {
  const [section] = panel(values.topic, "numbers over time");
  const node = element("div", section, { className: "plot" });
  draws(node, (time) => {
    const line = { type: "line", x0: time, x1: time, yref: "paper", y0: 0, y1: 1, line: { width: 1, color: "#9aa4b0" } };
    Plotly.react(node, values.lines.map((one) => ({ name: one.name, mode: "lines", x: values.t, y: one.y })),
      { ...flat, showlegend: true, xaxis: { title: { text: "time [s]" } }, shapes: [line], uirevision: 1 }, config);
  });
}

function drawTimeline(rows) {
  const [section] = panel("When everything came", "clocks, and each topic by its stamps; red: ticks without a message; drag to look closer", true);
  const node = element("div", section);
  node.style.height = 90 + 24 * rows.length + "px";
  const names = rows.map((row) => row.name + (row.more ? ` (${row.more} more)` : ""));
  const marks = (row, times, colour, size) => ({ type: "scattergl", mode: "markers", x: times, y: times.map(() => names[row]),
    marker: { symbol: "line-ns-open", size, color: colour, line: { width: 1.5 } }, hovertemplate: "%{x:.9f} s" });
  const traces = rows.flatMap((row, number) => [
    marks(number, row.t, row.sensor ? "#0b6bcb" : row.clock ? "#1c2430" : "#5b8a5b", 13),
    ...(row.missing && row.missing.length ? [marks(number, row.missing, "#d03030", 17)] : []),
  ]);
  draws(node, (time) => {
    const line = { type: "line", x0: time, x1: time, yref: "paper", y0: 0, y1: 1, line: { width: 1, color: "#9aa4b0" } };
    const end = Math.min(1, clock.end - clock.start) + clock.start;
    Plotly.react(node, traces, { ...flat, margin: { l: 240, r: 12, t: 8, b: 40 }, shapes: [line], uirevision: 1,
      xaxis: { title: { text: "simulation time [s]" }, range: [clock.start, end] },
      yaxis: { type: "category", categoryorder: "array", categoryarray: [...names].reverse(), automargin: true } }, config);
  });
}

function drawTable(title, columns, rows, note = "") {
  const [section] = panel(title, note, true);
  const table = element("table", section), head = element("tr", element("thead", table)), body = element("tbody", table);
  for (const column of columns) element("th", head, {}, column);
  for (const row of rows) {
    const line = element("tr", body);
    for (const [place, cell] of row.entries()) element("td", line, { className: columns[place] === "code" ? "code" : "" }, cell);
  }
}

const clock = { start: data.start, end: data.end, time: data.start };
const slider = document.getElementById("time"), now = document.getElementById("now"), play = document.getElementById("play");

function show(time) {
  clock.time = time;
  now.textContent = seconds(time);
  for (const follow of followers) follow(time);
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

drawTable("Topics", ["topic", "type", "what came"], data.topics);
if (data.warnings.length) drawTable("Warnings", ["code", "where", "message"], data.warnings);
data.clouds.forEach(drawCloud);
data.pictures.forEach(drawPictures);
data.radars.forEach(drawRadar);
if (data.paths.length) drawPaths(data.paths);
data.values.forEach(drawValues);
if (data.rows.length) drawTimeline(data.rows);
show(clock.start);
