"""Output for legged robots: pictures, report, replay, film, survival maps."""
