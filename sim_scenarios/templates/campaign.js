// Curves of a campaign: one filter a colour and a dash, the same in every plot.
(async () => {
  const content = JSON.parse(document.getElementById("content").textContent);
  const element = (id) => document.getElementById(id);
  const STROKES = ["none", "7 4", "2 3", "7 3 2 3", "12 4", "12 3 2 3"];

  await run(element("plotly").textContent);
  fillControls();
  element("controls").hidden = false;
  element("case").addEventListener("change", chooseCounting);
  element("controls").addEventListener("change", draw);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { paintSwatches(); draw(); });
  chooseCounting();
  draw();

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
      traces.push({ name: "bound", x: one.time, y: bound, mode: "lines",
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
})();
