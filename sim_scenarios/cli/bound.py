"""`truenorth bound`."""

from __future__ import annotations

from functools import partial

from sim_scenarios.cli.options import AsJson, Output, Scenario, Seed, Settings, SettingsFile, settings
from sim_scenarios.cli.results import Results
from sim_scenarios.cli.terminal import print_json, print_pairs, print_table, refusing_bad_input
from sim_scenarios.units import ARCMIN


def show_bound(
    scenario: Scenario,
    output: Output = None,
    seed: Seed = None,
    set_: Settings = None,
    set_from: SettingsFile = None,
    as_json: AsJson = False,
) -> None:
    """Show how well any filter could know the heading in a scenario.

    The posterior Cramer-Rao bound along the true trajectory; no filter runs. It is a root mean square over
    many runs: a single run may lie below. Where the vehicle manoeuvres, the bound of the same motion without
    stands beside it: what the manoeuvres are worth.

    For example:

        truenorth bound zigzag
        truenorth bound waves --set gnss.velocity_sigma=0.02 --set gnss.rate=10
    """
    from sim_scenarios import report, scenario_bound  # slow: xarray, matplotlib

    with refusing_bad_input():
        results = Results(output)
        data = scenario_bound.bound(scenario, seed=seed, set=settings(set_, set_from))
    name = f"{data.attrs['scenario']}-bound"
    files = refusing_bad_input()(partial(results.write, data, report.report_bound, name))
    if as_json:
        steady = data.attrs.get("bound.heading_rms_steady")
        print_json(
            {
                "scenario": data.attrs["scenario"],
                "bound_arcmin": data.attrs["bound.heading_rms"] / ARCMIN,
                "bound_without_manoeuvres_arcmin": None if steady is None else steady / ARCMIN,
                "steady_course_limit_arcmin": data.attrs["bound.steady_course_limit"] / ARCMIN,
                "leaves_out": [name for name in data.attrs["bound.leaves_out"].split(", ") if name],
                "time_s": data["bound_time"].values.tolist(),
                "heading_sigma_arcmin": (data["bound.heading_sigma"].values / ARCMIN).tolist(),
                **files(),
            }
        )
        return
    print_table(report.bound_table(data))
    start, stop = data.attrs["evaluation.start"], data.attrs["evaluation.stop"]
    window = {"Evaluated": f"{start:g} to {stop:g} s"}
    print_pairs({**window, **report.about_bound(data), "Report": lambda: files()["report"]})
