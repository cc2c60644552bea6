"""`truenorth list`."""

from __future__ import annotations

from typing import Annotated

import typer

from sim_scenarios import catalogue
from sim_scenarios.cli.options import AsJson
from sim_scenarios.cli.terminal import print_json, print_names


def list_what_there_is(
    scenarios: Annotated[bool, typer.Option("--scenarios", help="The scenarios alone.")] = False,
    campaigns: Annotated[bool, typer.Option("--campaigns", help="The campaigns alone.")] = False,
    papers: Annotated[bool, typer.Option("--papers", help="The papers alone.")] = False,
    as_json: AsJson = False,
) -> None:
    """List the scenarios, campaigns and papers that come with the package.

    With `--json` that is one object of names and descriptions, of the scenarios unless another kind is named.

    For example:

        truenorth list
        truenorth list --campaigns
        truenorth list --papers --json
    """
    kinds = [
        (scenarios, catalogue.scenarios, ["scenario", "what happens: `truenorth run NAME`"]),
        (campaigns, catalogue.campaigns, ["campaign", "what many runs show: `truenorth campaign NAME`"]),
        (papers, catalogue.papers, ["paper", "what is reproduced: `truenorth paper NAME`"]),
    ]
    chosen = [kind for kind in kinds if kind[0]] or (kinds[:1] if as_json else kinds)
    if as_json:
        print_json({name: text for _, described, _ in chosen for name, text in described().items()})
        return
    for _, described, titles in chosen:
        print_names([titles, *([name, text] for name, text in described().items())])
        print()
