"""`python -m sim_scenarios.bands`: the command `truenorth bands`."""

import sys

from sim_scenarios.cli import main

if __name__ == "__main__":
    sys.argv.insert(1, "bands")
    main()
