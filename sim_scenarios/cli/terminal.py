"""What stands on the terminal: results on standard output, progress and messages on standard error."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from enum import Enum
from typing import TYPE_CHECKING, Final, NoReturn

import typer
from rich.cells import cell_len
from rich.console import Console
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from sim_scenarios.errors import InputError, NoRoomError, SimulationError

if TYPE_CHECKING:
    import xarray as xr


class Volume(Enum):
    """How much is said on standard error, besides what went wrong."""

    quiet = "no progress, no messages"
    normal = "progress, and a few messages of the FMUs"
    verbose = "progress, and all messages of the FMUs"


FEW: Final = 5
"""Messages of the FMUs that are told unless all are asked for."""

LONGEST: Final = 100_000
"""More characters than a line of a table has."""

_volume = Volume.normal


def speak(volume: Volume) -> None:
    """Say so much, and no more, from now on."""
    global _volume
    _volume = volume


def is_quiet() -> bool:
    """Whether there is no progress to be told."""
    return _volume is Volume.quiet


@contextmanager
def refusing_bad_input() -> Iterator[None]:
    """Turn what the user can mend into a sentence and exit code 2."""
    try:
        yield
    except (InputError, NoRoomError, SimulationError) as error:
        _refuse(str(error))
    except OSError as error:  # of the machine: no space, no file descriptor, no permission
        where = "" if error.filename is None else f"{error.filename}: "
        _refuse(f"{where}{error.strerror or error}")


def _refuse(sentence: str) -> NoReturn:
    from sim_scenarios.names import printable  # slow: pydantic

    typer.echo(f"truenorth: {printable(sentence)}", err=True)
    raise typer.Exit(2) from None


@contextmanager
def progress(title: str) -> Iterator[Callable[[float], None]]:
    """Progress on standard error: a bar on a terminal, else a line for each quarter."""
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    if is_quiet():
        yield lambda _: None
        return
    standard_error = Console(stderr=True)
    if not standard_error.is_terminal:
        yield _quarters(title)
        return
    titles = TextColumn("{task.description}", markup=False)
    columns = (titles, BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    with Progress(*columns, console=standard_error, transient=True) as bar:
        task = bar.add_task(title, total=1.0)
        last = time.monotonic()

        def advance(share: float) -> None:
            nonlocal last
            if (now := time.monotonic()) - last > 0.05 or share >= 1:
                last = now
                bar.update(task, completed=share)

        yield advance


def _quarters(title: str) -> Callable[[float], None]:
    reported = 0

    def advance(share: float) -> None:
        nonlocal reported
        if (quarter := int(4 * share)) > reported:
            reported = quarter
            print(f"{title}: {25 * quarter} %", file=sys.stderr, flush=True)

    return advance


def console() -> Console:
    """Standard output; wide where it is not a terminal, so that a log keeps its lines."""
    standard_output = Console()
    return standard_output if standard_output.is_terminal else Console(width=160)


def print_json(content: Mapping[str, object]) -> None:
    """One JSON object."""
    print(json.dumps(content, indent=2, allow_nan=False))


def say_messages(data: xr.Dataset) -> None:
    """What the FMUs said, the beginning of it unless all is asked for."""
    from sim_scenarios.names import printable  # slow: pydantic

    messages = json.loads(data.attrs["messages"])
    most = {Volume.quiet: 0, Volume.normal: FEW, Volume.verbose: len(messages)}[_volume]
    standard_error = Console(stderr=True, highlight=False, quiet=is_quiet())
    for message in messages[:most]:
        standard_error.print(printable(message), style="dim", markup=False, soft_wrap=True)
    if len(messages) > most:
        standard_error.print(f"... and {len(messages) - most} more messages, in the report", style="dim")


def say(sentence: str) -> None:
    """What is about to happen, on standard error."""
    if not is_quiet():
        print(sentence, file=sys.stderr, flush=True)


def print_verdict(sentence: str, good: bool) -> None:
    """A verdict, in its colour."""
    console().print(sentence, style=f"bold {'green' if good else 'red'}", highlight=False, markup=False)


def print_names(rows: list[list[str]], output: Console | None = None) -> None:
    """Names and what they stand for, the heading first. Where it is narrow the second column folds."""
    table = Table(box=None, pad_edge=False)
    for i, title in enumerate(rows[0]):
        table.add_column(Text(title), no_wrap=not i)
    for row in rows[1:]:
        table.add_row(*map(Text, row))
    (output or console()).print(table)


def print_table(rows: list[list[str]], output: Console | None = None) -> None:
    """Rows, the heading first. Where it is narrow the first column folds, never a figure.

    Where it is too narrow for that too, every row is a block, a figure a line.
    """
    table = Table(box=None, pad_edge=False)
    for i, column in enumerate(zip(*rows, strict=True)):
        # Rich takes a cell of several words for one that may be cut.
        widest = max(cell_len(line) for cell in column for line in cell.splitlines() or [""])
        table.add_column(
            Text(column[0]),
            justify="right" if i else "left",
            no_wrap=bool(i),
            min_width=widest if i else None,
            vertical="bottom",
        )
    for row in rows[1:]:
        table.add_row(*map(Text, row))
    page = output or console()
    unbounded = page.options.update(max_width=LONGEST)
    if Measurement.get(page, unbounded, table).minimum <= page.width:
        page.print(table)
        return
    titles = [title.replace("\n", " ") for title in rows[0]]
    for label, *cells in rows[1:]:
        page.print(f"{titles[0]} {label}", highlight=False, markup=False)
        for title, cell in zip(titles[1:], cells, strict=True):
            page.print(f"  {title}: {cell}", highlight=False, markup=False)


def print_pairs(pairs: Mapping[str, str | Callable[[], str]]) -> None:
    """A name and a value on each line; what takes long is a function, called when it is its turn."""
    output, width = console(), max(map(len, pairs))
    for name, given in pairs.items():
        value = given() if callable(given) else given
        output.print(f"{name:<{width}}  {value}", soft_wrap=True, highlight=False, markup=False)


def print_notes(notes: str) -> None:
    """What to expect of a scenario."""
    if notes:
        console().print(notes.strip().replace("\n", " "), style="italic", highlight=False, markup=False)
