"""Input logs: written, read, run again, played, branched and traced. Nothing here imports `service`."""
