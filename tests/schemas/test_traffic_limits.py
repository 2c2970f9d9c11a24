from __future__ import annotations

import json

import zenoh

from intellwheels_schemas.channels import CHANNELS
from intellwheels_schemas.keys import VERBS
from intellwheels_schemas.messages import May
from intellwheels_schemas.router_link import router_settings
from intellwheels_schemas.traffic_limits import RATE, rates, size_limits

ENTRIES = (
    May(role="simulator"), May(role="agent", agents=("st1-*", "lab1")), May(role="mind", agents=("lab1",)),
    May(role="bridge", agents=("real1",)), May(role="viewer", agents=("st1-*",)), May(role="recorder"),
)  # fmt: skip


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


def test_each_agent_has_a_rate_of_its_own_for_each_key() -> None:
    puts, queries = rates(ENTRIES)
    assert (puts["messages"], queries["messages"]) == (["put"], ["query"])
    assert {rule["freq"] for rule in puts["rules"]} == {RATE}
    in_, out = "iw/v1/main/in", [rule["key_expr"] for rule in puts["rules"]]
    assert sorted(out) == [
        "iw/v1/main/crew/lab1/actions", "iw/v1/main/crew/st1-$*/actions",
        f"{in_}/lab1/actions", f"{in_}/lab1/say", f"{in_}/real1/pose", f"{in_}/st1-$*/actions", f"{in_}/st1-$*/say",
        "iw/v1/main/user/real1", "iw/v1/main/user/st1-$*",
    ]  # fmt: skip
    # A simulator's puts and others' questions have none: Zenoh would drop the second of two honest ones.
    assert {rule["key_expr"].split("/")[3] for rule in queries["rules"]} == {"join", "leave", "crew"}
    assert rates([May(role="simulator"), May(role="recorder")]) == []


def test_zenoh_takes_both() -> None:
    text = router_settings(["tcp/127.0.0.1:7000"], {"low_pass_filter": size_limits(), "downsampling": rates(ENTRIES)})
    config = zenoh.Config.from_json5(text)
    assert len(json.loads(config.get_json("low_pass_filter"))) == len(size_limits())
    assert len(json.loads(config.get_json("downsampling"))) == 2
