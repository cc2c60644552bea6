"""The trajectories of the alignment problem in closed form, independent of the plant.

Sway about a mean heading, a constant speed that follows the course, surge/sway/heave, and course changes by a
quintic.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from sim_scenarios.bounds import Trajectory
from sim_scenarios.units import DEGREE

ZIGZAG = [
    (50, 1),
    (150, -2),
    (250, 2),
    (350, -2),
    (450, 2),
]  # begin [s], course change in units of the amplitude


def course_change(time, turns):
    """Course [rad] of turns given as (begin [s], duration [s], angle [deg]), clockwise."""
    course = np.zeros_like(time)
    for begin, duration, angle in turns:
        x = np.clip((time - begin) / duration, 0, 1)
        course += angle * DEGREE * x**3 * (10 - 15 * x + 6 * x**2)
    return course


def attitude(roll, pitch, heading):
    """C_bn of roll, pitch, heading [rad]; heading clockwise from north, shape (n, 3, 3)."""
    return Rotation.from_euler("ZXY", np.column_stack((-heading, pitch, roll))).as_matrix()


def ship(time, *, sway=True, speed=10.0, waves=False, turns=()):
    """True motion of the ship at latitude 32 deg."""
    course = course_change(time, turns)
    roll, pitch, yaw_left = (
        sway * amplitude * DEGREE * np.sin(2 * np.pi * time / period + phase)
        for amplitude, period, phase in ((8, 8, 0.3), (6, 10, 1.1), (5, 6, 2.0))
    )
    velocity = speed * np.column_stack((np.sin(course), np.cos(course), np.zeros_like(time)))
    if waves:
        for axis, period, phase in ((1, 9, 1.0), (0, 7, 0.0), (2, 8, 0.5)):
            velocity[:, axis] += 0.5 * np.sin(2 * np.pi * time / period + phase)
    return Trajectory(
        time=time,
        C_bn=attitude(roll, pitch, course - yaw_left),
        velocity=velocity,
        latitude=np.full_like(time, 32 * DEGREE),
        height=np.zeros_like(time),
    )


def zigzag(amplitude):
    """Turns of a zigzag of +-amplitude [deg]."""
    return [(begin, 30, change * amplitude) for begin, change in ZIGZAG]


MOTIONS = {
    "static": {"sway": False, "speed": 0.0},
    "steady": {},
    "waves": {"waves": True},
    "turn": {"turns": [(150, 60, 90)]},
    "zigzag 20": {"turns": zigzag(20)},
    "zigzag 45": {"turns": zigzag(45)},
}
"""Keywords of `ship`, by name: of a vehicle at rest, on a steady course, in swell, in manoeuvres."""
