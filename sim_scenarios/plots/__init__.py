"""Pictures of runs: heading, navigation errors, states, fixes."""
