from __future__ import annotations

import json

import pytest
import zenoh

from intellwheels_schemas.router_link import OPEN, open_router, open_words, router_settings


def test_settings_nest_by_their_paths_and_zenoh_accepts_them() -> None:
    more = {"access_control": {"enabled": True, "default_permission": "deny"}, "adminspace/enabled": False}
    text = router_settings(["tcp/127.0.0.1:7000"], more)
    settings = json.loads(text)
    assert settings["mode"] == "router"
    assert settings["adminspace"] == {"enabled": False}
    assert settings["scouting"] == {"multicast": {"enabled": False}, "gossip": {"enabled": False}}
    assert json.loads(zenoh.Config.from_json5(text).get_json("access_control/default_permission")) == "deny"


def test_wrong_setting_is_told_in_words() -> None:
    with pytest.raises(ConnectionError, match=r"cannot listen at tcp/127\.0\.0\.1:7000"):
        open_router(["tcp/127.0.0.1:7000"], {"access_control": {"default_permission": "perhaps"}})


def test_open_process_says_where_other_machines_reach_it() -> None:
    assert open_words(["tcp/127.0.0.1:7447"]) == open_words([]) == OPEN
    words = open_words(["tcp/127.0.0.1:7447", "tcp/0.0.0.0:7447"])
    assert words == f"{OPEN}; other machines too, at tcp/0.0.0.0:7447"
