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
    stands beside it: what the manoeuvres are worth. Where the heading is not known to 20 deg beforehand, its
    errors are not small, and a bound of errors of any size stands beside it too: a mean over 200 draws.

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
        rms, steady, of_any, standard_error = (
            data.attrs[name] / ARCMIN if name in data.attrs else None
            for name in map("bound.heading_rms{}".format, ("", "_steady", "_any", "_any_standard_error"))
        )
        sigma = {
            f"{name}_arcmin": (data[f"bound.{name}"].values / ARCMIN).tolist()
            for name in ("heading_sigma", "heading_sigma_any")
            if f"bound.{name}" in data
        }
        print_json(
            {
                "scenario": data.attrs["scenario"],
                "bound_arcmin": rms,
                "bound_any_arcmin": of_any,
                "bound_any_standard_error_arcmin": standard_error,
                "bound_without_manoeuvres_arcmin": steady,
                "steady_course_limit_arcmin": data.attrs["bound.steady_course_limit"] / ARCMIN,
                "leaves_out": [name for name in data.attrs["bound.leaves_out"].split(", ") if name],
                "time_s": data["bound_time"].values.tolist(),
                **sigma,
                **files(),
            }
        )
        return
    print_table(report.bound_table(data))
    start, stop = data.attrs["evaluation.start"], data.attrs["evaluation.stop"]
    window = {"Evaluated": f"{start:g} to {stop:g} s"}
    print_pairs({**window, **report.about_bound(data), "Report": lambda: files()["report"]})
