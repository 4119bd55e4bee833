"""What is drawn of legged robots: pictures, report, replay, film, survival maps."""
