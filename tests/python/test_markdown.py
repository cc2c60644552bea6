"""Tables in Markdown: whatever a cell holds, it is one cell."""

import re

from sim_scenarios import markdown


def test_a_cell_stays_a_cell() -> None:
    rows = [["filter", "RMSE\n[']"], ["UKF | tuned", "1.2"], ["a|b", "-"]]
    lines = markdown.table(rows).splitlines()
    cells = [re.split(r"(?<!\\)\|", line)[1:-1] for line in lines]
    read = [[cell.strip().replace(r"\|", "|") for cell in row] for row in cells]
    assert read == [["filter", "RMSE [']"], ["---", "---"], *rows[1:]]
