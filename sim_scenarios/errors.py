"""What can go wrong, in the user's words."""


class InputError(ValueError):
    """What the user gave cannot be used; the message is a sentence that names it, its value and the rule."""


class NoRoomError(RuntimeError):
    """A disk is full, of which the user has not spoken; the message names it. Nothing goes on without it."""


class SimulationError(RuntimeError):
    """An FMU refused to go on; the message holds what it said."""
