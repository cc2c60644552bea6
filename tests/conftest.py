"""What all tests share."""

from hypothesis import settings

# How long an example takes is the machine's business; `make bench` measures times.
settings.register_profile("timeless", deadline=None)
settings.load_profile("timeless")
