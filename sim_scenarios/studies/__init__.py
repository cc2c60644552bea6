"""One engine for many runs: campaigns, bands and papers are studies.

A module imports only those before it: `quantities` (what is kept of a run), `measured` (what runs have
measured), `expectations`, `draws` and `plan` (what a study consists of), `store`, `runs`, `execution`,
`ensemble` (whole runs, to draw) and `campaign`; `statistics`, `table`, `pictures`, `page` tell what is found.
"""
