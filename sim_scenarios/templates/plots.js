"use strict";
// What pages with curves have in common: plotly, the colours of the page, layouts.

const DASHES = ["solid", "dash", "dot", "dashdot", "longdash", "longdashdot"];
const TICKS = [-4, -3, -2, -1, 0, 1, 2, 3, 4, 5].flatMap((k) => [1, 2, 5].map((d) => Number(`${d}e${k}`)));

// Run a script that is given as base64 of gzip.
async function run(text) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const plain = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  const script = document.createElement("script");
  script.textContent = await new Response(plain).text();
  document.head.append(script);
}

function theme() {
  const style = getComputedStyle(document.documentElement);
  const value = (name) => style.getPropertyValue(name).trim();
  return { ink: value("--ink"), line: value("--line"), band: value("--band"), filters: value("--filters").split(/\s+/) };
}

function colour(i) {
  const colours = theme().filters;
  return colours[i % colours.length];
}

function curve({ label, i }, x, y, more = {}) {
  return { name: label, x, y, mode: "lines", line: { color: colour(i), dash: DASHES[i % DASHES.length], width: 2 }, ...more };
}

// Names of curves above the plot, in the place of a title: they may take several lines.
const LEGEND = {
  title: { text: "" },
  showlegend: true,
  legend: { orientation: "h", x: 0, y: 1, yanchor: "bottom", traceorder: "normal" },
};

// Area between two curves.
function area(x, lower, upper, fillcolor, opacity = 1) {
  const edge = { x, mode: "lines", line: { width: 0 }, hoverinfo: "skip", showlegend: false, opacity };
  return [{ ...edge, y: lower }, { ...edge, y: upper, fill: "tonexty", fillcolor }];
}

// A plot; `range` is what of y is seen at first.
function plot(id, traces, title, x, y, logarithmic, more = {}, range = null) {
  const { ink, line } = theme();
  const axis = { gridcolor: line, linecolor: line, zerolinecolor: line, automargin: true };
  const layout = {
    title: { text: title, x: 0.02, xanchor: "left", y: 1, yref: "container", yanchor: "top", pad: { t: 12 }, font: { size: 15 } },
    xaxis: { ...axis, title: { text: x }, exponentformat: "none" },
    yaxis: { ...axis, title: { text: y }, ...(range ? { range } : {}),
             ...(logarithmic ? { type: "log", tickvals: TICKS, ticktext: TICKS.map(String) } : {}) },
    margin: { l: 48, r: 14, t: 42, b: 52 },
    font: { color: ink, family: "system-ui, sans-serif", size: 12 },
    paper_bgcolor: "rgba(0,0,0,0)",
    plot_bgcolor: "rgba(0,0,0,0)",
    modebar: { bgcolor: "rgba(0,0,0,0)", color: ink },
    hovermode: "x",
    hoverlabel: { namelength: -1 },
    showlegend: false,
    uirevision: id + logarithmic,
    ...more,
  };
  Plotly.react(id, traces, layout, { responsive: true, displaylogo: false });
}

// A map, on which east and north are equally long.
function equal(x, y) {
  const { line } = theme();
  const axis = { gridcolor: line, zerolinecolor: line, automargin: true };
  return {
    hovermode: "closest",
    xaxis: { ...axis, title: { text: x } },
    yaxis: { ...axis, title: { text: y }, scaleanchor: "x" },
  };
}
