"""One run of a scene: its processes, the record of what happened, and the verdict."""
