"use strict";
// Curves of a campaign: one filter a colour and a dash, the same in every plot.
(async () => {
  const content = JSON.parse(document.getElementById("content").textContent);
  const element = (id) => document.getElementById(id);
  const DASHES = ["solid", "dash", "dot", "dashdot", "longdash", "longdashdot"];
  const STROKES = ["none", "7 4", "2 3", "7 3 2 3", "12 4", "12 3 2 3"];

  const TICKS = [-4, -3, -2, -1, 0, 1, 2, 3, 4, 5].flatMap((k) => [1, 2, 5].map((d) => Number(`${d}e${k}`)));

  await run(element("plotly").textContent);
  fillControls();
  element("controls").hidden = false;
  element("case").addEventListener("change", chooseCounting);
  element("controls").addEventListener("change", draw);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { paintSwatches(); draw(); });
  chooseCounting();
  draw();

  // Run a script that is given as base64 of gzip.
  async function run(text) {
    const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    const plain = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    const script = document.createElement("script");
    script.textContent = await new Response(plain).text();
    document.head.append(script);
  }

  function fillControls() {
    content.cases.forEach((one, i) => element("case").add(new Option(one.label, i)));
    for (const [name, about] of Object.entries(content.quantities)) {
      element("quantity").add(new Option(about.title, name));
    }
    content.filters.forEach((label, i) => {
      const box = Object.assign(document.createElement("input"), { type: "checkbox", checked: true, value: label });
      const line = `<svg width="34" height="10" aria-hidden="true"><line x2="34" y1="5" y2="5" stroke-width="2.5"
        stroke-dasharray="${STROKES[i % STROKES.length]}"/></svg>`;
      const entry = document.createElement("label");
      entry.append(box);
      entry.insertAdjacentHTML("beforeend", line);
      entry.append(label);
      element("filters").append(entry);
    });
    paintSwatches();
  }

  function chooseCounting() {
    element("quantity").value = content.cases[element("case").value].counting;
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

  function paintSwatches() {
    document.querySelectorAll("#filters line").forEach((line, i) => line.setAttribute("stroke", colour(i)));
  }

  // Filters that are switched on and that the case has: label, place in the campaign, data.
  function shown(one) {
    const on = new Set([...document.querySelectorAll("#filters input:checked")].map((box) => box.value));
    return content.filters
      .map((label, i) => ({ label, i, data: one.filters[label] }))
      .filter(({ label, data }) => data && on.has(label));
  }

  function curve({ label, i }, x, y, more = {}) {
    return { name: label, x, y, mode: "lines", line: { color: colour(i), dash: DASHES[i % DASHES.length], width: 2 }, ...more };
  }

  // Area between two curves.
  function area(x, lower, upper, fillcolor, opacity = 1) {
    const edge = { x, mode: "lines", line: { width: 0 }, hoverinfo: "skip", showlegend: false, opacity };
    return [{ ...edge, y: lower }, { ...edge, y: upper, fill: "tonexty", fillcolor }];
  }

  function draw() {
    const one = content.cases[element("case").value];
    const filters = shown(one);
    drawErrors(one, filters);
    drawRuns(one, filters);
    for (const what of ["nees", "nis"]) drawConsistency(one, filters, what);
  }

  function drawErrors(one, filters) {
    const quantity = element("quantity").value;
    const { title, unit } = content.quantities[quantity];
    const traces = [];
    if (element("percentiles").checked) {
      for (const filter of filters) {
        const { lower, upper } = filter.data.errors[quantity];
        traces.push(...area(one.time, lower, upper, `${colour(filter.i)}33`));
      }
    }
    const bound = one.bounds[quantity];
    if (bound && bound.some((value) => value !== null)) {
      traces.push({ name: "Cramer-Rao bound", x: one.time, y: bound, mode: "lines",
                    line: { color: theme().ink, width: 1.2 } });
    }
    for (const filter of filters) traces.push(curve(filter, one.time, filter.data.errors[quantity].middle));
    plot("error", traces, `${title} error`, "time [s]", unit, element("logarithmic").checked);
  }

  function drawRuns(one, filters) {
    const traces = filters.map((filter) => {
      const each = filter.data.each;
      return curve(filter, each, each.map((_, k) => (100 * (k + 1)) / filter.data.runs),
                   { line: { ...curve(filter).line, shape: "hv" } });
    });
    const { title, unit } = content.quantities[one.counting];
    plot("runs", traces, `Runs by ${title.toLowerCase()} RMSE`, unit, "% of the runs", false);
  }

  function drawConsistency(one, filters, what) {
    // A consistent filter with more channels keeps to a narrower band: one for all that have the same.
    const bands = new Map(filters.map(({ data }) => [JSON.stringify([data[what].lower, data[what].upper]), data[what]]));
    const traces = [...bands.values()].flatMap(({ lower, upper }) => area(one.time, lower, upper, theme().band));
    for (const filter of filters) traces.push(curve(filter, one.time, filter.data[what].middle));
    plot(what, traces, { nees: "Heading NEES", nis: "NIS / channels" }[what], "time [s]", "", true);
  }

  function plot(id, traces, title, x, y, logarithmic) {
    const { ink, line } = theme();
    const axis = { gridcolor: line, linecolor: line, zerolinecolor: line, automargin: true };
    const layout = {
      title: { text: title, x: 0.02, xanchor: "left", font: { size: 15 } },
      xaxis: { ...axis, title: { text: x } },
      yaxis: { ...axis, title: { text: y }, ...(logarithmic ? { type: "log", tickvals: TICKS, ticktext: TICKS.map(String) } : {}) },
      margin: { l: 48, r: 14, t: 42, b: 44 },
      font: { color: ink, family: "system-ui, sans-serif", size: 12 },
      paper_bgcolor: "rgba(0,0,0,0)",
      plot_bgcolor: "rgba(0,0,0,0)",
      modebar: { bgcolor: "rgba(0,0,0,0)", color: ink },
      hovermode: "x",
      hoverlabel: { namelength: -1 },
      showlegend: false,
      uirevision: id + logarithmic,
    };
    Plotly.react(id, traces, layout, { responsive: true, displaylogo: false });
  }
})();
