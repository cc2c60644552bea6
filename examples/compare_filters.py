"""Filters on the same signals, 5 % of which are wrong by 2 m/s: what the innovation gate is worth."""

import sim_scenarios
from sim_scenarios.units import ARCMIN

runs = sim_scenarios.compare("gnss_outliers", seed=3, set={"duration": 400.0})
for label in runs["filter"].values:
    verdict = sim_scenarios.judge(runs.sel(filter=label))
    rmse = verdict.heading_rmse / ARCMIN
    print(f"{label:24} heading RMSE {rmse:7.2f} arcmin, {verdict.rejected_fixes} refused")
