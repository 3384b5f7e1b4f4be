"use strict";
// Plotly reads <a>, <b> and &...; in texts as markup. Names of a recording are text: they are escaped on their way to it.
const escaped = (value) => {
  if (typeof value === "string") return value.replaceAll("&", "&amp;").replaceAll("<", "&lt;").replaceAll(">", "&gt;");
  if (Array.isArray(value)) return value.every((one) => typeof one === "number") ? value : value.map(escaped);
  if (value === null || typeof value !== "object" || ArrayBuffer.isView(value)) return value;
  return Object.fromEntries(Object.entries(value).map(([key, one]) => [key, escaped(one)]));
};
for (const name of ["react", "newPlot"]) {
  const draw = Plotly[name];
  Plotly[name] = (node, traces, layout, options) => draw(node, escaped(traces), escaped(layout), options);
}
