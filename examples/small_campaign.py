"""A few seeds of two filters on every core, and what they say together.

The same call goes on where it was stopped, and does only what is missing.
"""

import sim_scenarios
from sim_scenarios.studies.statistics import summarise
from sim_scenarios.units import ARCMIN

if __name__ == "__main__":  # the workers are processes that import this file
    results = sim_scenarios.campaign(
        "zigzag",
        "truenorth-results/small_campaign",
        runs=4,
        filters=("EKF", "UKF"),
        set={"duration": 400.0},
    )
    for case in summarise(results):
        for label, summary in case.filters.items():
            rmse, ratio = summary.rmse["heading"] / ARCMIN, summary.to_bound
            print(
                f"{label}: heading RMSE {rmse.value:.2f} arcmin ({rmse.lower:.2f} to {rmse.upper:.2f}) over "
                f"{summary.runs} runs, {ratio.value:.2f} times the Cramer-Rao bound"
            )
