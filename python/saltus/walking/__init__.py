"""What is drawn of legged robots: pictures, report, replay, film, survival maps."""

from . import units  # noqa: F401
