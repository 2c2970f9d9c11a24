"""The prose of KEYS.md, between its tables. Braces and `<late>` are filled in by `keys_page`."""

from __future__ import annotations

from typing import Final

HEAD: Final = """<!-- Made by python -m intellwheels_schemas from the message classes; do not edit. -->

# Keys, messages, limits and codes

This page is the reference of the contract, the protocol between the simulator and other programs.
[FIRST-AGENT.md](FIRST-AGENT.md) is the introduction. Examples with their exact bytes are in [vectors](vectors), and
[Schemas](#schemas) are in [xsd](xsd) and [json](json).

Every key starts with `iw/v1/<world>/`. Each of `<world>`, `<agent>` and `<crew>` is
{name}. The name {reserved} is reserved.

Units are SI. Angles are in radians, and in degrees where a name ends in `Deg`. Two frames are used:

- The *map frame* has the origin and axes of the loaded map. Headings count anticlockwise from its x axis.
- The *body frame* has its origin at the centre of movement, with x forward and y to the left.

Terms:

- A *tick* is one step of the simulation. A *run* is a sequence of ticks. A *session* is one join of an agent.
- A process joins as the *body* of an agent, as its *mind*, which controls the body, or as *both*.
- In *lockstep*, a step waits for the answers of all members of the *barrier*. `Barrier` in `Robot` makes an agent a
  member.
- A *crew* is a group of agents in one process. They share one key for actions and one for measures.
- An *operator* is a person or a program that controls the run or steers bodies. A *lease* allows an operator to steer a
  body instead of its mind, for a limited time.

## Keys
"""

NOTES: Final = """
- Every put is sent with congestion control *drop*. A slow reader delays no other process, and loses messages instead.
  Gaps in `Tick` and `Seq` show the loss.
- A query that fails, for whatever reason, gets an error reply with the message in the last column. A `Result` in an
  ordinary reply therefore always has the code `ok`. If a query gets no reply at all, no simulator is running or access
  is not allowed. `iw-router --lab` answers an identity at `iw/v1/@rights/<identity>` with its own `Identity` of the
  [Lab](#lab), which says what it may do.
- A `get` may have wildcards, as in `iw/v1/*/clock` or `iw/v1/main/*`. It brings a reply on each key that it matches and
  that has `get` in its row. A control verb, a join and a leave need their own key.
- Messages are ordered by (`Run`, `Tick`). A start, reset, load or restore gives a new `Run`. All messages of an earlier
  `Run` are then invalid.
- `join` takes `?session=S`, the `Session` of the last join. With it, a process gets its body back even while the token
  of its old instance exists. Without it, the reply is `already-here` until that token has disappeared.
- In a run that does not wait for answers (`realtime`, `free`), `Actions` with the present `Run` count even if they are
  late, by at most <late> s of simulated time. They act on the current tick, unless newer ones have acted. Others are
  dropped with the Error `late`. In lockstep, only answers to the current tick count.
- An agent can send one message to other agents per tick. If `Actions` and a `Say` both have one for the same tick, the
  simulator drops the `Say` and the sender gets an Error `too-many`.
- `ctl/load` may take some seconds, and the world goes on meanwhile. `ctl/reset`, `restore`, `save`, `spawn`, `delete`
  and `teleport` that arrive after it wait until it is answered. All other requests are answered at once.
- The key of `ctl/delete`, `teleport` and `take` ends with the agent, so that a router can grant them for one agent. A
  query without it, and one whose payload names another agent, is refused.
- `event` takes `?since=N`, and replies with the events from number N on. `Oldest` in the reply is the number of the
  oldest event that is kept. A `since` that is not a number gets an error reply.
- A message on an unknown key below `in/<agent>/` or `user/<agent>` is dropped, and `out/<agent>/error` gets an Error
  `field` with the key. `UserInput` for an agent that has no `UserInput` in its `Robot` and is not taken is dropped, and
  `out/<agent>/error` gets an Error `role`; for an agent that is not there, `not-joined`. These errors come at most once
  in 5 s for an agent, after the first two. A program that steers an agent should subscribe to that key.
- A crew has at most 250 agents, each with a token of its own that ends with the crew's name. With it, the agent's
  owner allows the crew to act for the agent. `crew/<crew>/join` joins with many agents at once. It waits 1 s for
  their tokens, and accepts or refuses each agent by itself. While a token of the crew's process exists, the crew is
  refused to any other process, as `already-here`. Robots of a crew are simulated, with the role `both` or `mind`.
- `CrewActions` and `CrewMeasures` come in parts of about 48 kB. Each part counts by itself, and has each agent at most
  once. Wrong actions of an agent do not affect the others. Their Error goes to `out/<agent>/error` and to
  `crew/<crew>/error`. An agent that did not join with this crew, or a whole message that is wrong, has its Error on
  `crew/<crew>/error` only.
- What an agent of a crew does by itself has the keys of any agent: `in/<agent>/say`, `leave/<agent>`, `user/<agent>`.
  Its `Body` names its crew, and nothing is put on `out/<agent>/measures`.
- To follow `state/*`, subscribe first and then `get` the same keys. Drop each message that is older than the newest one
  you have.
- To find worlds, query the liveliness tokens `iw/v1/*/alive`.
- A simulator also claims its world with the token `alive/<since>/<instance>`. `since` is when the claim began, in
  nanoseconds of Unix time, as 16 hex digits. `instance` is the first half of its Zenoh id, of 32 hex digits: if several
  sessions answer a query, only the answer of that id is the simulator's. If two simulators start together, the earlier
  claim wins and the other simulator ends.
- `Pose` and `Power` of a real robot carry a `Code`, which the bridge and the simulator make with the `Key` of the
  `Joined`. [PROTOCOL.md](../agents/intellwheels_agents/bridge/PROTOCOL.md) says how.
- In a world without access rules anybody can put `Measures`. A careful agent takes those of another `Run`, or of a tick
  far ahead, only after a `get` of `clock` has the same `Run` and no lower `Tick`. Real `Measures` come in order: if a
  lower `Tick` follows a higher one, one of them is forged or a copy.

## Encodings

| Encoding | Payload |
|---|---|
| `application/json` | a JSON object with the fields of the message |
| `application/xml` | an element with the name of the message |
| none, `zenoh/bytes`, `zenoh/string` | JSON if the first byte is `{`, XML if it is `<` |

The key has the version, so the encoding needs none. A reader also accepts the suffix `;iw.v1`, and refuses that of
another version. The simulator accepts JSON and XML on all keys. It writes `out/<agent>/...` in the encoding of the
`join`: measures in that of the mind, and power in that of the body. Puts for all processes (`state`, `clock`, `event`,
`map`, `body`) are in JSON. The reply to a `get` on these keys has the encoding of the query.

- In XML, scalars are attributes and records are child elements. A list of records is a repeated child element, and a
  list of scalars is one attribute with spaces between the items. `Text` is the text of the element. In JSON, a list has
  the same name, in the singular.
- Fields with their default value and empty lists are left out. In messages `null` is refused, except in a lidar's
  `Ranges` (`-` in XML). A field may occur only once in a record.
- Numbers follow the JSON grammar in both encodings: no `+5`, `.5`, `007`, `NaN` or `INF`, and no fraction or exponent
  in a whole number.
- The simulator writes a number as the shortest decimal that reads back as the same double-precision number. A number
  that need not be whole has a fraction or an exponent: `5.0`, `0.00001`, `1e-7`. A reader takes `5` for `5.0`.
- The simulator rounds what it measures to 1e-6: readings, true states, contacts, distances and times. It never writes
  `-0.0` there. What a program declared or commanded is repeated as it was. `Measures` with a scan of 180 rays below
  100 m have at most {scan_json:,} bytes in JSON and {scan_xml:,} bytes in XML.
- Text consists of XML 1.0 characters without carriage return. Its length is counted in code points. XML documents have
  no document type and define no entities.
- The simulator refuses unknown fields. All other programs must ignore them.
- Errors name the place of the wrong value, with list items counted from 0, as in `Robot.Proximity[2].ConeDeg: expected
  degrees in (0, 360], got 0`.
"""

ACCESS: Final = """## Who may do what

`iw-router --lab LAB.xml` allows each identity of a [Lab](#lab) what its roles have here, and nothing else. A process
that queries a key *writes* it, and one that answers the query *reads* it. `<agent>` stands for the `Agents` of the
identity. In a key without an agent, `<crew>` must match `Agents` too, as if it were the name of an agent. These roles
read about every agent: {overseers}. An operator asks for its `Verbs` only, or for all if it lists none, and a viewer
only for `take`. The router drops what is longer than the [limits](#limits). It does not limit the rate: Zenoh's way
to do so would drop honest messages that arrive together. It closes Zenoh sessions beyond 100 of one certificate, or of
one address of another machine (`--max-sessions`), and says so; Zenoh does not tell it whose password opened a session.

The simulator limits floods. It reads 64 messages of an agent in a row, then 400 a second and 4 more for each tick;
user input of an agent counts apart, and a crew counts as one agent. Further ones are dropped with the Error
`too-many`. Of each key it keeps 128 messages a tick at most, and of all keys whose agents are not there 256. It
answers queries between ticks: up to 2,048 wait for each key. It reports what it has no room for. Dropping a message
still takes some microseconds, and all messages share the connection to the router: while a program sends tens of
thousands a second, ticks and commands of others may be late, and commands may be lost.

"""

SCHEMAS: Final = """## Schemas

There are two kinds of schemas. Those for writers refuse unknown fields, as the simulator does. Those for readers let
them pass, as every other program must.

| For | JSON Schema 2020-12 | XML Schema 1.0 |
|---|---|---|
| writers | `json/writer/<Document>.json` | `xsd/writer/iw.xsd`; `xsd/writer/operator-say.xsd` for `ctl/say` |
| readers | `json/reader/<Document>.json` | `xsd/reader/<Document>.xsd` |
| both | | `xsd/rules.sch`, Schematron with XPath 1.0: rules that XML Schema cannot express |

Every document that the simulator accepts is valid. Of the {refused} documents in `vectors/refused`, the schemas for
writers accept {accepted}. They accept these kinds of wrong documents, because the language cannot express the rule.
`python -m intellwheels_schemas check` refuses them.

"""

LOGS: Final = """## Files for programs

`iw-server` writes two kinds of JSON Lines files. The first line of an input log (`input.jsonl`) is an
[InputHeader](#inputheader), every further line is an [InputTick](#inputtick), and the last one is an
[InputEnd](#inputend). Re-simulating the log gives the same hashes. The first line of a trace (`trace.jsonl`) is a
[TraceHeader](#traceheader), and every further line is a [TraceTick](#tracetick) with the true state at that tick. A
reader refuses a header with a `Version` that it does not know, and ignores fields that it does not know.

Each line of an input log ends with a checksum, `Chain`, over itself and all lines before it. A log without an
`InputEnd` was truncated, and can be used up to its last whole line. A log with a wrong checksum was edited. Input logs
of version 1 have no `Chain` and no `InputEnd`.

"""
