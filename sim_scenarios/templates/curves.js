// Curves of one run, or of filters beside each other: one panel at a time.
(async () => {
  const panels = JSON.parse(document.getElementById("content").textContent);
  const element = (id) => document.getElementById(id);

  await run(element("plotly").textContent);
  panels.forEach((panel, i) => element("panel").add(new Option(panel.title, i)));
  element("controls").hidden = false;
  element("curves").hidden = false;
  element("panel").addEventListener("change", draw);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  draw();

  function draw() {
    const panel = panels[element("panel").value || 0];
    const bands = panel.curves.flatMap((one, i) => (one.lower ? area(one.x, one.lower, one.upper, `${colour(i)}33`) : []));
    const lines = panel.curves.map((one, i) => curve({ label: one.name, i }, one.x, one.y));
    const legend = { showlegend: lines.length > 1, legend: { orientation: "h", y: -0.15 }, uirevision: panel.title };
    const { x, y, logarithmic = false } = panel;
    plot("curve", [...bands, ...lines], panel.title, x, y, logarithmic, panel.equal ? { ...legend, ...equal(x, y) } : legend);
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
})();
