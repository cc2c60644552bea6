"""The bands that the filters must keep: campaigns with expectations, a file a scenario.

A figure is taken over a window and over all runs (`metrics.figures`). Most bands are of an independent
prototype of the filters; fewer runs than a file has scatter more. `truenorth bands` runs them all.
"""
