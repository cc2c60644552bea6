"""Tables in Markdown."""

from __future__ import annotations

from collections.abc import Sequence


def table(rows: Sequence[Sequence[str]]) -> str:
    """A table, its heading first; a cell is one line, and none begins another."""
    heading, *body = ([cell.replace("\n", " ").replace("|", r"\|") for cell in cells] for cells in rows)
    lines = [heading, ["---"] * len(heading), *body]
    return "".join(f"| {' | '.join(cells)} |\n" for cells in lines)
