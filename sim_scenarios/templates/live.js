// A run while it goes on: what its filter says comes as events, first all that there has been.
(async () => {
  const element = (id) => document.getElementById(id);
  const degrees = (value) => (value === null ? "–" : `${value.toFixed(3)} deg`);
  const looks = [];
  let awaited = false;

  await run(element("plotly").textContent);
  const stream = new EventSource(JSON.parse(element("content").textContent));
  stream.addEventListener("open", () => {
    looks.length = 0;
    element("state").textContent = "The run goes on.";
  });
  stream.addEventListener("message", ({ data }) => { looks.push(...JSON.parse(data)); renew(); });
  stream.addEventListener("end", () => end("The run has ended; the terminal has the verdict and names the report."));
  stream.addEventListener("error", () => end("The command that ran it is gone."));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", renew);

  function end(sentence) {
    stream.close();
    element("state").textContent = sentence;
  }

  // Draw when the screen is drawn, however often there is news.
  function renew() {
    if (!awaited && looks.length) requestAnimationFrame(draw);
    awaited = true;
  }

  function draw() {
    awaited = false;
    const last = looks[looks.length - 1];
    element("time").textContent = `${last.time.toFixed(1)} of ${last.duration} s`;
    element("status").textContent = last.status || "–";
    for (const name of ["heading", "sigma", "error"]) element(name).textContent = degrees(last[name]);

    const time = looks.map((look) => look.time);
    const truth = continuous(looks.map((look) => look.true_heading));
    const heading = looks.map(({ error }, i) => error === null ? null : truth[i] + error);
    plot("headings", [curve({ label: "filter", i: 0 }, time, heading), curve({ label: "truth", i: 1 }, time, truth)],
         "Heading", "time [s]", "deg", false, LEGEND);
    // The logarithm of an error that passes through zero would take all the room.
    const error = looks.map(({ error, sigma }) => (Math.abs(error) > sigma / 100 ? Math.abs(error) : null));
    const sigma = looks.map((look) => look.sigma);
    plot("errors", [curve({ label: "error", i: 0 }, time, error), curve({ label: "1 sigma", i: 1 }, time, sigma)],
         "Heading error", "time [s]", "deg", true, LEGEND);
    const tracks = { filter: "place", truth: "true_place" };
    plot("track", Object.entries(tracks).map(([label, name], i) =>
           curve({ label, i }, looks.map((look) => look[name][0]), looks.map((look) => look[name][1]))),
         "Track", "", "", false, { ...LEGEND, ...equal("east [m]", "north [m]") });
  }

  // Angles without leaps of a turn.
  function continuous([first, ...angles]) {
    let before = first;
    return [first, ...angles.map((angle) => (before = angle + 360 * Math.round((before - angle) / 360)))];
  }
})();
