"""Options of subcommands that take a recording: what it goes through, and what is known at its start."""

from __future__ import annotations

from enum import Enum
from typing import TYPE_CHECKING, Annotated

import typer

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.choices import Filter
from sim_scenarios.units import DEGREE

if TYPE_CHECKING:
    from sim_scenarios.recordings.start import Start


class Where(str, Enum):
    """Where in a recording the filter starts."""

    first = "first"
    course = "course"


Through = Annotated[Filter, typer.Option("--filter", help="What the recording goes through.")]
Heading = Annotated[
    float | None,
    typer.Option(
        help="Heading to start from [deg], clockwise from north; needed where the error model needs one.",
        show_default=False,
    ),
]
HeadingSigma = Annotated[float | None, typer.Option(help="Sigma of that heading [deg].", show_default="10")]
StartsAt = Annotated[
    Where,
    typer.Option(
        help="Start at the first sample, or at the first fix that is fast, on its course over ground."
    ),
]
CourseSpeed = Annotated[
    float, typer.Option(help="Speed from which the course is taken for the heading [m/s].")
]
Levelling = Annotated[
    float,
    typer.Option(help="Seconds before the start, or the first ones, whose mean force gives roll and pitch."),
]

COURSE_SPEED = 3.0
LEVELLING = 1.0


def begin(
    heading: float | None,
    heading_sigma: float | None,
    start: Where,
    course_speed: float,
    levelling: float,
    position: tuple[float, float, float] | None = None,
) -> Start:
    """What these options say of the start."""
    from sim_scenarios.recordings.start import Start  # slow: scipy

    if heading_sigma is not None and heading_sigma < 0:
        raise InputError(f"--heading-sigma {heading_sigma:g}: must be at least 0 deg")
    if not course_speed > 0:
        raise InputError(f"--course-speed {course_speed:g}: must be greater than 0 m/s")
    return Start(
        None if heading is None else heading * DEGREE,
        None if heading_sigma is None else heading_sigma * DEGREE,
        levelling,
        position,
        course_speed if start is Where.course else None,
    )
