"""Tests below use the modules beside this file: signals of the plant, and files as loggers write them."""
