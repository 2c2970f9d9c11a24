"""The simulator: a pure world of arrays, and the service that puts it on the network.

Importing this package chooses where compiled kernels are kept, before numba is imported
anywhere: numba reads the place once, and a read-only installation whose user has no
writable home would otherwise fail at import.
"""

from intellwheels_server.kernel_cache import choose

choose()
