"""Floors, robots and scenes as XML files, and what reads, checks and draws them.

Shipped files are found by name, a user's own by path. Whatever `floor`, `robot` and `scene` return has
passed its schema and the checks of `check`.

    >>> from intellwheels_maps import floor, names
    >>> names("floors")
    ['corner', 'corridor15m', 'door', 'room', 'ward']
    >>> floor("corridor15m").doorway
    ()
"""

from intellwheels_maps.library import floor, names, robot, scene

__all__ = ["floor", "names", "robot", "scene"]
