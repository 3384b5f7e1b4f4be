// A panel for each sensor, camera, radar and topic with numbers, and one of when everything came.

function drawClouds(group) {
  const clouds = group.clouds.map((number) => data.clouds[number]);
  const [section, row] = panel(clouds.length > 1 ? group.name : clouds[0].topic, group.flat ? "a planar lidar, from above" : "");
  const topics = clouds.length > 1 ? choice(row, "topic", clouds.map((one) => one.topic)) : { selectedIndex: 0 };
  const fields = choice(row, "what colours the points", []);
  const said = element("span", row, { className: "soft" });
  const node = element("div", section, { className: group.flat ? "above" : "cloud" });
  const fill = () => {
    const kept = fields.value;
    fields.replaceChildren();
    for (const field of clouds[topics.selectedIndex].fields) element("option", fields, {}, field.name);
    fields.value = clouds[topics.selectedIndex].fields.some((one) => one.name === kept) ? kept : fields.options[0]?.value;
  };
  const draw = (time) => {
    const cloud = clouds[topics.selectedIndex];
    if (!cloud.frames.length) { said.textContent = "no points"; return; }
    const frame = decoded(cloud, frameAt(cloud.frames, time)), number = Math.max(0, fields.selectedIndex), n = frame.x.length;
    const field = cloud.fields[number] || { name: "", low: 0, high: 1 }, shown = cloud.frames.length;
    said.textContent = `at ${seconds(frame.t)}, ` + (n < frame.total ? `${n} of ${frame.total}` : `${n}`) + " points" +
      (cloud.count > shown ? `; ${shown} of ${cloud.count} clouds` : "");
    const marker = { colorscale: palette(), cmin: field.low, cmax: field.high, colorbar: colourBar(field.name) };
    if (group.flat) drawAbove(node, frame, { ...marker, color: frame.values[number], size: 3.5 });
    else drawSpace(node, cloud, frame, { ...marker, color: frame.values[number], size: n > 5000 ? 1.3 : n > 500 ? 2 : 4 });
  };
  if (topics.onchange !== undefined) topics.onchange = () => { fill(); draw(clock.time); };
  fields.onchange = () => draw(clock.time);
  fill();
  const seen = clouds.find((one) => one.ranges);
  if (seen) drawRanges(section, seen.ranges);
  draws(node, draw);
}

function drawSpace(node, cloud, frame, marker) {
  const end = cloud.steps.map((step, axis) => cloud.low[axis] + 65535 * step);
  const extent = Math.max(...end.map((one, axis) => one - cloud.low[axis]));
  const axes = Object.fromEntries(["x", "y", "z"].map((name, axis) => [`${name}axis`, spatial(`${name} [m]`, [cloud.low[axis], end[axis]])]));
  const ratio = Object.fromEntries(["x", "y", "z"].map((name, axis) => [
    name, Math.max(0.03, 1.15 * (end[axis] - cloud.low[axis]) / extent)]));
  plot(node, [{ type: "scatter3d", mode: "markers", x: frame.x, y: frame.y, z: frame.z, marker,
    hovertemplate: "%{x:.2f}, %{y:.2f}, %{z:.2f} m<extra></extra>" }],
  { margin: { l: 0, r: 0, t: 0, b: 0 }, scene: { ...axes, aspectmode: "manual", aspectratio: ratio,
    camera: { eye: { x: -1.1, y: -1.1, z: 0.9 }, up: { x: 0, y: 0, z: 1 } } } });
}

function drawRanges(section, ranges) {
  const image = element("img", section, { className: "across", alt: "range image", title: "ranges: ahead in the middle" });
  const ends = element("div", section, { className: "ends" });
  for (const angle of [180, 90, 0, -90, -180]) element("span", ends, {}, angle ? `${angle}°` : "azimuth 0°, ahead");
  const say = bar(section, "m");
  followers.push((time) => { const frame = frameAt(ranges, time); image.src = frame.src; say(frame); });
}

// Places in the sensor's frame [m] from above: ahead is up, with rings of equal range and the sensor's mark.
function drawAbove(node, frame, marker, grey = null) {
  if (frame.local) {
    const flat = new Float32Array(bytes(frame.local).buffer);
    frame.ahead = flat.filter((_, place) => place % 2 === 0);
    frame.left = flat.filter((_, place) => place % 2);
    frame.local = null;
  }
  const all = grey || [frame], far = Math.max(0.1, ...all.map((one) => one.ahead.reduce((most, x, i) => Math.max(most, Math.hypot(x, one.left[i])), 0)));
  const power = 10 ** Math.floor(Math.log10(far / 4)), step = power * [1, 2, 5, 10].find((one) => one * power >= far / 5);
  const rings = Array.from({ length: Math.floor(far / step + 1e-9) }, (_, number) => (number + 1) * step);
  const ends = (name) => {
    const [low, high] = all.reduce(([l, h], one) => one[name].reduce(([a, b], v) => [Math.min(a, v), Math.max(b, v)], [l, h]), [0, 0]);
    return [low - 0.06 * far, high + 0.06 * far];
  };
  const stride = Math.ceil(frame.ahead.length / 3000), thin = (list) => (stride > 1 ? list.filter((_, place) => place % stride === 0) : list);
  const back = grey ? [{ mode: "markers", x: all.flatMap((one) => one.left), y: all.flatMap((one) => one.ahead), hoverinfo: "skip",
    marker: { size: 3, color: colour("faint") } }] : [];
  const points = { mode: "markers", x: thin(frame.left), y: thin(frame.ahead), marker: { ...marker, color: thin(marker.color), showscale: true },
    hovertemplate: "left %{x:.2f}, ahead %{y:.2f} m<extra></extra>" };
  const sensor = { mode: "markers", x: [0], y: [0], marker: { symbol: "triangle-up", size: 13, color: colour("ink") }, hovertemplate: "the sensor<extra></extra>" };
  plot(node, [...back, points, sensor], {
    xaxis: axis("left [m]", { range: ends("left").reverse(), zeroline: false }), yaxis: axis("ahead [m]", { range: ends("ahead"), ...equal, zeroline: false }),
    shapes: rings.map((r) => ({ type: "circle", layer: "below", x0: -r, x1: r, y0: -r, y1: r, line: { width: 1, color: colour("faint"), dash: "dot" } })),
    annotations: rings.map((r) => ({ x: 0, y: r, text: `${short(r)} m`, showarrow: false, bgcolor: colour("panel"), font: { size: 10, color: colour("soft") } })) });
}

function drawRadar(radar) {
  const [section, row] = panel(radar.topic, "detections of a radar; grey: all frames", true);
  const said = element("span", row, { className: "soft" });
  const [velocity, above] = plots(section, ["above", "above"]);
  for (const frame of radar.frames) Object.assign(frame, { ahead: frame.x, left: frame.y });
  const marker = { size: 8, colorscale: palette(), cmin: radar.low, cmax: radar.high, colorbar: colourBar(radar.colour), line: { width: 0.5, color: "#888" } };
  const all = (name) => radar.frames.flatMap((frame) => frame[name]);
  draws(velocity, (time) => {
    const frame = frameAt(radar.frames, time);
    said.textContent = `at ${seconds(frame.t)}, ${frame.r.length} detections`;
    plot(velocity, [
      { mode: "markers", x: all("v"), y: all("r"), marker: { size: 3, color: colour("faint") }, hoverinfo: "skip" },
      { mode: "markers", x: frame.v, y: frame.r, marker: { ...marker, color: frame.c, showscale: true }, hovertemplate: "%{x:.2f} m/s, %{y:.2f} m<extra></extra>" },
    ], { xaxis: axis("radial velocity [m/s]"), yaxis: axis("range [m]", { rangemode: "tozero" }) });
  });
  draws(above, (time) => { const frame = frameAt(radar.frames, time); drawAbove(above, frame, { ...marker, color: frame.c }, radar.frames); });
}

function drawPictures(pictures) {
  const shown = pictures.frames.length;
  const [section, row] = panel(pictures.topic, pictures.count > shown ? `${shown} of ${pictures.count} images` : `${shown} images`);
  const said = element("span", row, { className: "soft" });
  const image = element("img", section, { className: "picture", alt: pictures.topic });
  const say = pictures.frames.some((one) => "low" in one) ? bar(section, "m") : () => {};
  followers.push((time) => {
    const frame = frameAt(pictures.frames, time);
    if (said.textContent === (said.textContent = `at ${seconds(frame.t)}`) && image.src) return;
    image.src = frame.src;
    if ("low" in frame) say(frame);
  });
}

function drawPaths(paths) {
  const [section] = panel("Where the frames went", `from above, in ${paths[0].root}`);
  const node = element("div", section, { className: "plot" });
  node.style.height = `${300 + (narrow() ? 20 : 10) * Math.max(0, paths.length - 6)}px`; // for the rows of names below
  draws(node, (time) => {
    const lines = paths.map((path, number) => ({ name: plain(path.name), mode: "lines", line: { color: sensors[number % sensors.length] },
      x: path.places.map((one) => one[0]), y: path.places.map((one) => one[1]) }));
    const places = paths.map((path) => poseAt(path, time).place);
    const dots = { mode: "markers", showlegend: false, x: places.map((one) => one[0]), y: places.map((one) => one[1]),
      marker: { size: 6, color: colour("ink") }, hoverinfo: "skip" };
    plot(node, [...lines, dots], { showlegend: true, xaxis: axis("x [m]"), yaxis: axis("y [m]", equal) });
  });
}

// One plot a quantity. A value that holds is a step until the next message, and until the end.
function drawValues(values) {
  const [section] = panel(values.topic, values.holds ? "values hold until the next message" : "", true);
  const end = values.holds ? [clock.end] : [], t = [...values.t, ...end];
  const parts = plots(section, values.quantities.map(() => ""));
  for (const [place, quantity] of values.quantities.entries()) {
    const more = quantity.more ? `, the first ${quantity.lines.length} of ${quantity.lines.length + quantity.more}` : "";
    const unit = quantity.unit ? ` [${quantity.unit}]` : "", last = quantity.name.split(":")[0].split(".").at(-1);
    element("h3", parts[place], {}, quantity.name + unit + more);
    const node = element("div", parts[place], { className: "curves" });
    const lines = quantity.lines.map((one, number) => ({ name: plain(one.name), mode: t.length < 40 && !values.holds ? "lines+markers" : "lines",
      x: t, y: [...one.y, ...end.map(() => one.y.at(-1))], line: { width: 1.6, color: sensors[number % sensors.length], shape: values.holds ? "hv" : "linear" } }));
    draws(node, (time) => plot(node, lines, { showlegend: true, margin: { l: 56, r: 12, t: 8, b: 40 }, shapes: [cursor(time)],
      xaxis: axis("time [s]", { range: [clock.start, clock.end] }), yaxis: axis(plain(last + unit)) }));
  }
}

// A row of marks as one line with gaps.
function marks(row, times, shade, size) {
  return { mode: "lines", x: times.flatMap((t) => [t, t, null]), y: times.flatMap(() => [row - size, row + size, null]),
    line: { width: 1.5, color: shade }, hovertemplate: "%{x:.9f} s<extra></extra>" };
}

function drawTimeline(rows) {
  const [section] = panel("When everything came", "clocks, and each topic by its stamps; red: ticks without a message; drag to look closer", true);
  const node = element("div", section);
  node.style.height = 90 + 24 * rows.length + "px";
  const end = Math.min(1, clock.end - clock.start) + clock.start;
  draws(node, (time) => {
    const most = narrow() ? 20 : 60, cut = (text) => (text.length > most ? text.slice(0, most - 1) + "…" : text);
    const names = rows.map((row) => plain(cut(row.name) + (row.more ? ` (${row.more} more)` : "")));
    const traces = rows.flatMap((row, number) => [
      marks(number, row.t, colour(row.sensor ? "sensor" : row.clock ? "ink" : "topic"), 0.3),
      ...(row.missing && row.missing.length ? [marks(number, row.missing, colour("lost"), 0.42)] : []),
    ]);
    plot(node, traces, { margin: { l: 20, r: 12, t: 8, b: 40 }, shapes: [cursor(time)],
      xaxis: axis("simulation time [s]", { range: [clock.start, end], zeroline: false }),
      yaxis: axis("", { tickvals: rows.map((_, number) => number), ticktext: names, range: [rows.length - 0.4, -0.6], automargin: true,
        zeroline: false, showgrid: false, fixedrange: true, tickfont: { size: narrow() ? 9 : 11 } }) });
  });
}

if (data.scene) drawScene(data.scene);
if (data.warnings.length) table("Warnings", ["code", "where", "message"], data.warnings, "", data.warnings.length > 6);
data.pictures.forEach(drawPictures);
data.groups.forEach(drawClouds);
const paths = data.poses.filter((one) => one.moves);
if (paths.length) drawPaths(paths.filter((one) => one.root === paths[0].root).slice(0, 40));
data.radars.forEach(drawRadar);
data.values.forEach(drawValues);
if (data.rows.length) drawTimeline(data.rows);
table("Topics", ["topic", "type", "what came"], data.topics);
show(clock.start);
