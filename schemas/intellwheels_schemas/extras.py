"""What the base installation lacks: the modules of each extra, and how to install one."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Final

MODULES: Final = {
    "foxglove": ("foxglove",),
    "server": ("numpy", "numba", "shapely"),
    "viewer": ("numpy", "viser", "PIL", "mapbox_earcut"),
    "video": ("av",),
    "joystick": ("pygame",),
    "lsl": ("pylsl",),
    "voice": ("pocketsphinx", "sounddevice"),
    "experiments": ("numpy", "scipy", "shapely", "matplotlib"),
    "cluster": ("distributed",),
    "bridge": ("serial",),
    "luci": ("grpc", "google"),
    "rnet": ("can",),
    "navigate": ("numpy",),
    "ros": ("rosbags",),
    "lab": ("cryptography",),
    "floors": ("numpy", "shapely", "yaml", "PIL", "ezdxf"),
    "ifc": ("ifcopenshell", "numpy", "shapely"),
    "learn": ("gymnasium", "pettingzoo", "numpy", "numba", "shapely"),
}
"""The modules that each extra installs, under the names that `import` takes."""


def install_hint(*extras: str) -> str:
    """Return how to install extras. The project is on no package index, so its folder is named."""
    return f"run pip install '.[{','.join(extras)}]' in the project's folder"


def missing_extra(*extras: str) -> str | None:
    """Return a sentence that names the extras of these that are not installed, or None if all are."""
    absent = {extra: [name for name in MODULES[extra] if find_spec(name) is None] for extra in extras}
    names = [extra for extra, modules in absent.items() if modules]
    if not names:
        return None
    modules = ", ".join(dict.fromkeys(module for found in absent.values() for module in found))
    noun = "extra" if len(names) == 1 else "extras"
    return f"expected the {noun} {', '.join(names)} (no module {modules}): {install_hint(*names)}"
