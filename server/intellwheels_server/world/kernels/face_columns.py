"""The columns of a face block, float64[faces, 7]: the faces of walls around a mount of sonars.

Written with the module's name, `faces[at, face_columns.LENGTH]`, which numba compiles to the constant.
"""

X = 0
"""Corner from which the face runs anticlockwise around its wall, along (-NY, NX), m."""
Y = 1
"""The same corner, m."""
NX = 2
"""Unit normal outwards."""
NY = 3
"""Unit normal outwards."""
LENGTH = 4
"""Of its piece of the wall, m."""
LOW = 5
"""Lower end of the half-open z interval, m."""
HIGH = 6
"""Upper end, m."""
COUNT = 7
