"""A run that is watched while it goes on."""
