"""The viewer: a page in which a run is seen and steered."""
