from __future__ import annotations

import json

import zenoh

from intellwheels_schemas.channels import CHANNELS
from intellwheels_schemas.keys import VERBS
from intellwheels_schemas.router_link import router_settings
from intellwheels_schemas.traffic_limits import size_limits


def test_every_put_and_query_of_the_contract_has_a_longest_size() -> None:
    limits = {key: item["size_limit"] for item in size_limits() for key in item["key_exprs"]}
    keys = [key for item in size_limits() for key in item["key_exprs"]]
    assert len(keys) == len(limits), "each key once"
    kinds = [channel for channel in CHANNELS.values() if channel.kind != "token" and "<verb>" not in channel.key]
    assert len(limits) == len(kinds) + len(VERBS)
    assert limits["iw/v1/*/in/*/actions"] == limits["iw/v1/*/user/*"] == limits["iw/v1/*/ctl/take/*"] == 4096
    assert limits["iw/v1/*/in/*/pose"] == 16_384
    assert limits["iw/v1/*/join/*"] == limits["iw/v1/*/ctl/spawn"] == 65_536
    assert limits["iw/v1/*/ctl/load"] == 1 << 20


def test_zenoh_takes_them() -> None:
    config = zenoh.Config.from_json5(router_settings(["tcp/127.0.0.1:7000"], {"low_pass_filter": size_limits()}))
    assert len(json.loads(config.get_json("low_pass_filter"))) == len(size_limits())
