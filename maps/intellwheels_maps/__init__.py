"""Maps, robots and scenes as XML files, and the code that reads, checks and draws them.

Included files are found by name, and other files by path. The documents that `floor`, `robot` and `scene` return have
passed their schema and the checks of `check`. The included maps are in the folder `floors`.

    >>> from intellwheels_maps import floor, names
    >>> names("floors")
    ['corner', 'corridor15m', 'crossing', 'door', 'lounge', 'room', 'square', 'ward']
    >>> floor("corridor15m").doorway
    ()
"""

from intellwheels_maps.library import floor, names, robot, scene

__all__ = ["floor", "names", "robot", "scene"]
