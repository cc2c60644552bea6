// Curves of one run, or of filters beside each other: one panel at a time.
(async () => {
  const panels = JSON.parse(document.getElementById("content").textContent);
  const element = (id) => document.getElementById(id);

  await run(element("plotly").textContent);
  panels.forEach((panel, i) => element("panel").add(new Option(panel.title, i)));
  element("controls").hidden = false;
  element("curves").hidden = false;
  element("panel").addEventListener("change", () => {
    Plotly.purge("curve"); // which would go back to the ranges of the panel before
    draw();
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  draw();

  function draw() {
    const panel = panels[element("panel").value || 0];
    const bands = panel.curves.flatMap((one, i) => (one.lower ? area(one.x, one.lower, one.upper, `${colour(i)}33`) : []));
    const lines = panel.curves.map((one, i) => curve({ label: one.name, i }, one.x, one.y));
    const { title, x, y, range, logarithmic = false } = panel;
    const more = { uirevision: title, ...(lines.length > 1 ? LEGEND : {}), ...(panel.equal ? equal(x, y) : {}) };
    plot("curve", [...bands, ...lines], title, x, y, logarithmic, more, range);
  }
})();
