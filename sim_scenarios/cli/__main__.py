"""`python -m sim_scenarios.cli` is the command `truenorth`."""

from sim_scenarios.cli import main

main()
