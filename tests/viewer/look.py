"""Take pictures of the drawings: `python tests/viewer/look.py FOLDER [VIEW ...]`. A viewer without a simulator.

The floor of figure6 with five bodies in the states that the drawings tell apart. Chromium must be there.
"""

from __future__ import annotations

import base64
import math
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import viser
from playwright.sync_api import Page, sync_playwright

from intellwheels_maps import library
from intellwheels_schemas.messages import Body, Entity, Event, Goal, Measures, Position, ProximityReading, Sensors
from intellwheels_viewer.drawings.bodies import Bodies
from intellwheels_viewer.drawings.contact_flashes import Contacts
from intellwheels_viewer.drawings.extruded_walls import Walls
from intellwheels_viewer.drawings.floor_plate import Floor
from intellwheels_viewer.drawings.ghosts import Ghost, Ghosts
from intellwheels_viewer.drawings.goals import Goals
from intellwheels_viewer.drawings.labels import Labels
from intellwheels_viewer.drawings.trails import Trails
from intellwheels_viewer.drawings.wedges import Wedges
from intellwheels_viewer.palette import Colours
from intellwheels_viewer.snapshot import Sample, Words

FLAGS = [
    "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--disable-dev-shm-usage", "--hide-scrollbars", "--force-color-profile=srgb",
]  # fmt: skip
PICTURE = "() => { window.__viserMutable.requestRender(); return window.__viserMutable.canvas.toDataURL('image/png'); }"
RUN = "0" * 16
VIEWS = {
    "free": ((6.5, -3.6, 12.5), (6.5, 3.6, 0.0), 50),
    "plan": ((6.5, 3.95, 75.0), (6.5, 4.0, 0.0), 8),
    "close": ((3.2, -0.4, 2.2), (1.6, 2.4, 0.45), 45),
    "pair": ((8.4, 4.3, 2.4), (6.6, 6.2, 0.4), 45),
    "top": ((1.5, 2.55, 4.5), (1.5, 2.6, 0.0), 30),
    "door": ((6.0, 2.4, 3.0), (9.0, 4.2, 0.5), 50),
    "ward": ((18.0, -15.0, 24.0), (18.0, -0.5, 0.0), 50),
    "side": ((1.45, 0.15, 1.1), (1.45, 2.6, 0.6), 45),
}


def body(robot: str, name: str, **fields: Any) -> Body:
    document = msgspec.structs.replace(library.robot(robot), name=name, **fields)
    return Body(run=RUN, tick=0, robot=document)


def cast() -> tuple[dict[str, Body], list[Entity]]:
    hinge = Position(x=9.0, y=3.51, heading=-math.pi / 2)
    bodies = {
        "chair1": body("rear-wheel", "chair1"),
        "chair2": body("mid-wheel", "chair2"),
        "chair3": body("intellwheels", "chair3"),
        "table": body("table", "table"),
        "door": body("door", "door", position=hinge),
        "nurse": body("person", "nurse"),
        "crate": body("crate", "crate"),
    }
    entities = [
        Entity(name="chair1", x=1.2, y=2.6, heading=0.0, speed=0.5, goal=Goal(x=4.6, y=2.6)),
        Entity(name="chair2", x=7.4, y=6.6, heading=2.6, speed=0.35),
        Entity(name="chair3", x=5.9, y=2.0, heading=2.9, contact=True, contacts=1),
        Entity(name="table", x=4.5, y=4.5, heading=0.0),
        Entity(name="door", x=9.0, y=3.51, heading=-math.pi / 2 - 0.9),
        Entity(name="nurse", x=2.6, y=6.2, heading=-0.6, speed=1.1),
        Entity(name="crate", x=10.9, y=5.2, heading=0.5),
    ]
    return bodies, entities


CONTACT = Event(run=RUN, tick=1, number=0, code="contact", agent="chair3", x=5.25, y=2.3)
VALUES = {"front": 2.9, "front-left": 1.2, "left": 0.42, "back-left": 0.3, "back": 1.0, "back-right": 3.1}


def measures(bodies: dict[str, Body]) -> dict[str, Measures]:
    seen = {}
    for name, each in bodies.items():
        readings = []
        for sensor in each.robot.proximity:
            if sensor.id == "right":
                readings.append(ProximityReading(id=sensor.id, status="none"))
            elif sensor.id == "front-right":
                readings.append(ProximityReading(id=sensor.id, status="fault"))
            else:
                readings.append(ProximityReading(id=sensor.id, value=VALUES.get(sensor.id, 1.1)))
        seen[name] = Measures(run=RUN, tick=0, time=0.0, sensors=Sensors(proximity=tuple(readings)))
    return seen


def histories() -> dict[str, list[Sample]]:
    times = [0.2 * index for index in range(101)]
    curve = [Sample(t, 7.4 + 0.2 * (20 - t), 6.6 - 0.9 * math.sin((20 - t) / 4), 0.0, 0.3) for t in times]
    return {"chair2": [s for s in curve if s.x < 8.6]}


def light(server: viser.ViserServer) -> None:
    scene = server.scene
    scene.configure_environment_map(None)
    scene.configure_default_lights(False)
    scene.add_light_hemisphere("/lights/sky", sky_color=(255, 255, 255), ground_color=(214, 216, 222), intensity=2.0)
    scene.add_light_directional("/lights/sun", intensity=1.2, cast_shadow=True, position=(4.0, -6.0, 14.0))
    ramp = np.linspace(0, 1, 64)[:, None, None]
    sky = np.array([[[226, 231, 239]]]) * (1 - ramp) + np.array([[[247, 248, 250]]]) * ramp
    scene.set_background_image(np.broadcast_to(sky, (64, 2, 3)).astype(np.uint8), format="png")


def draw(server: viser.ViserServer) -> None:
    floor = library.floor("room")
    bodies, entities = cast()
    colours = Colours()
    with server.atomic():
        Floor(server.scene).show(floor)
        Walls(server.scene).show(floor)
        Bodies(server.scene).show(bodies, entities, colours, {"ghost"}, "chair1")
        Wedges(server.scene).show(bodies, entities, measures(bodies), {"chair1", "chair2", "door"})
        Trails(server.scene).show(histories(), 20.0, colours)
        Goals(server.scene).show(entities, colours)
        Contacts(server.scene).show([CONTACT], 4, 0.05)
        Labels(server.scene).show(bodies, entities, [Words("chair2", 19.0, "I wait for you")], 20.0)
        Ghosts(server.scene).show({"drag": Ghost(bodies["chair3"].robot, 2.6, 1.0, 0.4, colours.rgb("chair3"))})


def shoot(page: Page, port: int, view: str, path: Path) -> None:
    position, look_at, fov = VIEWS[view]
    text = [",".join(str(number) for number in vector) for vector in (position, look_at)]
    # The page's camera looks up along z; the lens is in radians there.
    page.goto(
        f"http://127.0.0.1:{port}/?fixedDpr=1&initialCameraPosition={text[0]}&initialCameraLookAt={text[1]}"
        f"&initialCameraFov={math.radians(fov)}"
    )
    page.wait_for_function(
        "window.__viserSceneTree && Object.keys(window.__viserSceneTree.getState()).includes('/bodies/tint')",
        timeout=60_000,
    )
    page.evaluate("window.__viserMutable.requestRender()")
    seen = page.evaluate("window.__viserTestpoints ? window.__viserTestpoints.rendererInfo.render.frame : 0")
    deadline = time.monotonic() + 20
    while time.monotonic() < deadline:
        page.evaluate("window.__viserMutable.requestRender()")
        if (
            page.evaluate("window.__viserTestpoints ? window.__viserTestpoints.rendererInfo.render.frame : 9")
            > seen + 4
        ):
            break
        page.wait_for_timeout(100)
    path.parent.mkdir(parents=True, exist_ok=True)
    page.wait_for_timeout(300)
    path.write_bytes(base64.b64decode(page.evaluate(PICTURE).split(",")[1]))


CROWD = 100


def crowd(server: viser.ViserServer) -> None:
    """Show the ward with many chairs, of more colours than there are."""
    floor = library.floor("ward")
    kinds = ("rear-wheel", "mid-wheel", "intellwheels", "front-wheel", "person")
    bodies = {f"a{index}": body(kinds[index % 5], f"a{index}") for index in range(CROWD)}
    entities = [
        Entity(
            name=f"a{index}",
            x=0.8 + 1.75 * (index % 20),
            y=-0.6 + 1.2 * (index // 20 % 5 - 2) * 2.2,
            heading=0.7 * index,
        )
        for index in range(CROWD)
    ]
    with server.atomic():
        Floor(server.scene).show(floor)
        Walls(server.scene).show(floor)
        Bodies(server.scene).show(bodies, entities, Colours(), set(list(bodies)[::7]), "a3")


def main(arguments: Sequence[str]) -> None:
    folder, views = Path(arguments[0]), arguments[1:] or [view for view in VIEWS if view != "ward"]
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    server.gui.configure_theme(show_logo=False, show_share_button=False)
    light(server)
    if "ward" in views:
        crowd(server)
    else:
        draw(server)
    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path="/usr/bin/chromium", args=FLAGS)
        page = browser.new_page(viewport={"width": 1280, "height": 800}, device_scale_factor=1)
        for view in views:
            shoot(page, server.get_port(), view, folder / f"{view}.png")
        browser.close()
    server.stop()


if __name__ == "__main__":
    main(sys.argv[1:])
