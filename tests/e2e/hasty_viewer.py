"""A viewer that waits half a second for an answer, not three: for tests in which no answer comes.

`python -m tests.e2e.hasty_viewer` has the options of `iw-viewer`.
"""

from __future__ import annotations

import sys

from intellwheels_viewer import viewer_peer
from intellwheels_viewer.__main__ import main

if __name__ == "__main__":
    viewer_peer.ANSWER_LIMIT = 0.5  # type: ignore[misc]
    sys.exit(main())
