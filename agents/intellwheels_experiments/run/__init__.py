"""One run of a scene: its processes, its record and its verdict."""
