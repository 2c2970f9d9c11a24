"""The line that a paper can quote: what a run was, and that running its log again gave the same result."""

from __future__ import annotations

import shlex

from intellwheels_schemas.version import versions_of
from intellwheels_server.log.input_log import PACKAGES
from intellwheels_server.log.resimulate import Resimulation
from intellwheels_server.world import map_hash


def proof_line(found: Resimulation) -> str:
    """Return the line.

    The versions are those that wrote the log. `again-with` lists those of this installation that differ, if any.

    Args:
        found: A log that was run again to its end, without a difference, and that has checksums.
    """
    header = found.header
    here = versions_of(*PACKAGES)
    other = [f"{name}-{here[name]}" for name in here if here[name] != header.versions.get(name)]
    fields = {
        "map": header.map.name or "unnamed",
        "map-hash": map_hash(header.map),
        "seed": header.seed,
        "run": header.run,
        "runs": str(found.runs),
        "ticks": str(found.ticks),
        "hash": found.hash,
        "chain": found.chain,
        **header.versions,
        **({"again-with": ",".join(other)} if other else {}),
    }
    return " ".join(["proved", *(f"{name}={shlex.quote(value)}" for name, value in fields.items())])
