"""A swaying ship finds its heading: verdict, figures against the bound, and a page with the pictures."""

from pathlib import Path

import sim_scenarios
from sim_scenarios.units import ARCMIN

run = sim_scenarios.run("swaying_ship", seed=7, set={"prior.heading_sigma": "20 deg"})
print(sim_scenarios.judge(run))

# A run is an xarray Dataset with units: errors, sigmas, innovations ...
error, sigma = (float(run[name][-1]) / ARCMIN for name in ("heading_error", "heading_sigma"))
print(f"At the end the heading is off by {error:+.1f} arcmin, and the filter claims {sigma:.1f} arcmin")

page = sim_scenarios.report.report_run(run, Path("truenorth-results/first_alignment"))
print(f"Pictures: {page}")
