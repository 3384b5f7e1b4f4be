// One scene of everything that the recorded transforms place: clouds, frames, paths, boxes and what cameras see.

const AXES = [["x", "#e04848"], ["y", "#3faf5a"], ["z", "#4a7fe8"]];
const EDGES = [[0, 1], [0, 2], [0, 4], [1, 3], [1, 5], [2, 3], [2, 6], [3, 7], [4, 5], [4, 6], [5, 7], [6, 7]];

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

// The place and the axes of a frame at a time, between its samples.
function poseAt(frame, time) {
  const at = before(frame.t.length, (one) => frame.t[one], time), next = Math.min(at + 1, frame.t.length - 1);
  const span = frame.t[next] - frame.t[at], share = span > 0 ? Math.min(1, Math.max(0, (time - frame.t[at]) / span)) : 0;
  const place = frame.places[at].map((one, axis) => one + share * (frame.places[next][axis] - one));
  const [a, b] = [frame.turns[at], frame.turns[next]];
  const same = a.reduce((sum, one, i) => sum + one * b[i], 0) < 0 ? -1 : 1;
  const mixed = a.map((one, i) => one + share * (same * b[i] - one)), length = Math.hypot(...mixed) || 1;
  const [x, y, z, w] = mixed.map((one) => one / length);
  return { place, axes: [
    [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
    [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
    [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]] };
}

// Separate lines [[x, y, z], [x, y, z], ...] as one trace.
function segments(lines, more) {
  const trace = { type: "scatter3d", mode: "lines", x: [], y: [], z: [], hoverinfo: "skip", showlegend: false, connectgaps: false, ...more };
  for (const line of lines) {
    for (const point of line) { trace.x.push(point[0]); trace.y.push(point[1]); trace.z.push(point[2]); }
    for (const name of ["x", "y", "z"]) trace[name].push(null);
  }
  return trace;
}

function drawScene(scene) {
  const clouds = scene.clouds.map((number) => data.clouds[number]), inside = (one) => one.root === scene.root;
  const frames = data.poses.filter(inside), boxes = data.boxes.filter((topic) => topic.frames.some(inside));
  const base = frames.find((one) => one.name === scene.base);
  const radars = new Set(data.radars.map((one) => one.topic));
  const counted = (number, name) => (number ? [`${number} ${name}${number > 1 ? "s" : ""}`] : []);
  const parts = [...counted(clouds.length, "cloud"), ...counted(frames.length, "frame"), ...(boxes.length ? ["boxes"] : [])];
  const [section, row] = panel("Scene", `${parts.join(", ")} in ${scene.root}; axes of frames: x red, y green, z blue`, true);
  const views = choice(row, "what part is shown", ["everything", ...(base ? [`around ${base.name}`] : [])]);
  const colours = choice(row, "what colours the points", ["colour: height", "colour: sensor"]);
  const said = element("span", row, { className: "soft" });
  const node = element("div", section, { className: "scene" });
  const extent = Math.max(...scene.high.map((one, axis) => one - scene.low[axis]));
  const reach = Math.min(extent / 2, Math.max(2, 5 * scene.reach));
  const camera = { eye: { x: -0.8, y: -1.02, z: 0.66 }, center: { x: 0, y: 0, z: -0.12 }, up: { x: 0, y: 0, z: 1 } };
  const close = { eye: { x: -0.9, y: -1.0, z: 0.75 }, center: { x: 0, y: 0, z: -0.1 }, up: { x: 0, y: 0, z: 1 } };

  function cloudTraces(time) {
    return clouds.filter((cloud) => cloud.frames.length).flatMap((cloud, number) => {
      const frame = decoded(cloud, frameAt(cloud.frames, time)), n = frame.x.length, radar = radars.has(cloud.topic);
      const shade = radar ? colour("lost") : sensors[number % sensors.length], symbol = radar ? "diamond" : "circle";
      const marker = { size: radar ? 5 : n > 5000 ? 1.4 : n > 500 ? 2 : 3.5, symbol, color: shade };
      if (!colours.selectedIndex && !radar && !cloud.flat) Object.assign(marker, { color: frame.z, coloraxis: "coloraxis" });
      const name = plain(cloud.topic), group = { name, legendgroup: name, type: "scatter3d", mode: "markers" };
      return [{ ...group, showlegend: false, x: frame.x, y: frame.y, z: frame.z, marker, hovertemplate: "%{x:.2f}, %{y:.2f}, %{z:.2f} m" },
        { ...group, x: [null], y: [null], z: [null], marker: { symbol, size: 6, color: shade } }];
    });
  }

  function frameTraces(time, length, labelled) {
    const poses = frames.map((frame) => poseAt(frame, time));
    const tip = (pose, axis) => pose.place.map((one, i) => one + length * pose.axes[axis][i]);
    const axes = AXES.map(([, shade], axis) => segments(poses.map((pose) => [pose.place, tip(pose, axis)]), { line: { width: 4, color: shade } }));
    const places = (axis) => poses.map((pose) => pose.place[axis]);
    const names = frames.map((frame) => plain(frame.name));
    const text = { type: "scatter3d", mode: labelled ? "markers+text" : "markers", x: places(0), y: places(1), z: places(2), name: "frames",
      text: names, textposition: "top center", textfont: { size: 11, color: colour("ink") }, marker: { size: 2.5, color: colour("ink") },
      hovertemplate: "%{text}<br>%{x:.3f}, %{y:.3f}, %{z:.3f} m<extra></extra>" };
    const lenses = data.lenses.flatMap((lens) => {
      const at = frames.findIndex((frame) => frame.name === lens.frame);
      if (at < 0) return [];
      const corner = (ray) => poses[at].place.map((one, i) => one + 2.5 * length * ray.reduce((sum, part, k) => sum + part * poses[at].axes[k][i], 0));
      const corners = lens.rays.map(corner);
      return [...corners.map((one) => [poses[at].place, one]), [...corners, corners[0]]];
    });
    const seen = lenses.length ? [segments(lenses, { line: { width: 2, color: "#c9a227" }, name: "what cameras see", showlegend: true })] : [];
    return [...axes, text, ...seen];
  }

  function boxTraces(time) {
    return boxes.flatMap((topic, number) => {
      const frame = frameAt(topic.frames, time), shade = sensors[(number + 3) % sensors.length];
      const lines = frame.corners.flatMap((one) => EDGES.map(([a, b]) => [one[a], one[b]]));
      const tops = frame.corners.map((one) => one.reduce((best, corner) => (corner[2] > best[2] ? corner : best)));
      return [segments(lines, { line: { width: 3, color: shade }, name: plain(topic.topic), showlegend: true }),
        { type: "scatter3d", mode: "text", x: tops.map((one) => one[0]), y: tops.map((one) => one[1]), z: tops.map((one) => one[2]),
          text: frame.labels.map(plain), textfont: { color: shade, size: 11 }, hoverinfo: "skip", showlegend: false }];
    });
  }

  const moving = frames.filter((one) => one.moves && one.parent === scene.root).slice(0, 20);
  const draw = (time) => {
    const around = views.selectedIndex > 0, middle = around ? poseAt(base, time).place : null;
    const ranges = [0, 1, 2].map((axis) => {
      if (!around) return [scene.low[axis], scene.high[axis]];
      return axis < 2 ? [middle[axis] - reach, middle[axis] + reach] : [Math.max(scene.low[2], middle[2] - reach), middle[2] + 0.6 * reach];
    });
    const paths = segments(moving.map((one) => one.places), { line: { width: 3, color: colour("mark") }, name: "paths", showlegend: true });
    const traces = [...cloudTraces(time), ...(moving.length ? [paths] : []), ...boxTraces(time),
      ...(frames.length ? frameTraces(time, around ? reach / 12 : extent / 40, around) : [])];
    said.textContent = `at ${seconds(time)}`;
    const heights = clouds.filter((one) => !one.flat).flatMap((one) => one.fields.filter((field) => field.name === "height [m]"));
    const span = heights.length ? heights : [{ low: scene.low[2], high: scene.high[2] }];
    plot(node, traces, { margin: { l: 0, r: 0, t: 0, b: 0 }, showlegend: true, uirevision: views.selectedIndex,
      legend: { orientation: "h", y: 0.02, x: 0, bgcolor: "rgba(0,0,0,0)", itemsizing: "constant" },
      coloraxis: { colorscale: palette(), cmin: Math.min(...span.map((one) => one.low)), cmax: Math.max(...span.map((one) => one.high)),
        showscale: heights.length > 0 && !colours.selectedIndex, colorbar: { ...colourBar("height [m]"), len: 0.55 } },
      scene: { xaxis: spatial("x [m]", ranges[0]), yaxis: spatial("y [m]", ranges[1]), zaxis: spatial("z [m]", ranges[2]),
        aspectmode: "data", camera: around ? close : camera } });
  };
  views.onchange = colours.onchange = () => draw(clock.time);
  draws(node, draw);
}
