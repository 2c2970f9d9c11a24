from __future__ import annotations

from intellwheels_maps.importers.plan_layers import part_of
from tests.every_case import every_case


@every_case(
    ("layer", "part"),
    [
        ("A-WALL", "wall"), ("wall", "wall"), ("Walls_ext", "wall"), ("PAREDES", "wall"), ("Wände", "wall"),
        ("S-COLS", "wall"), ("A-DOOR", "door"), ("doors", "door"), ("Türen", "door"), ("windows line", "window"),
        ("A-GLAZ", "window"), ("0", None), ("Furniture", None), ("wallpaper", None), ("outdoors", None), ("", None),
        ("x" * 10_000, None),
    ],
)  # fmt: skip
def test_layer_tells_what_it_holds(layer: str, part: str | None) -> None:
    assert part_of(layer) == part


def test_the_name_of_a_block_counts_more() -> None:
    assert part_of("doors", "wind 1400") == "window"
    assert part_of("0", "door1000a") == "door"
    assert part_of("A-WALL", "block17") == "wall"
