from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from intellwheels_viewer.drawings.textures import METRES, SIZE, Texture, picture


@pytest.mark.parametrize("texture", METRES)
def test_a_texture_is_small_light_and_has_no_seam(texture: Texture) -> None:
    data = picture(texture)
    assert len(data) < 24_000
    grey = np.asarray(Image.open(io.BytesIO(data)), np.float64)
    assert grey.shape == (SIZE, SIZE)
    assert grey.mean() > 215.0
    # No two lines beside each other differ more across the seam than elsewhere.
    for lines in (grey, grey.T):
        steps = np.abs(np.diff(np.vstack([lines, lines[:1]]), axis=0)).mean(axis=1)
        assert steps[-1] <= steps[:-1].max() + 3.0


def test_it_is_made_once() -> None:
    assert picture("wood") is picture("wood")
