// A chair that avoids obstacles. It needs only zenoh and JSON. Usage: node avoid.js [NAME [BRIDGE]].

import { randomBytes } from "node:crypto";
import {
  Config, CongestionControl, Priority, ReplyError, Sample, SampleKind, Session,
} from "@eclipse-zenoh/zenoh-ts";

interface Reading { Id: string; Value?: number; Status?: string }
interface Measures { Run: string; Tick: number; Sensors: { Proximity: Reading[] } }
interface Complaint { Code: string; Text: string }

const [name = "avoid1", bridge = "ws/127.0.0.1:10000"] = process.argv.slice(2);
const KEY = "iw/v1/main";
const JSON_V1 = "application/json";
const instance = randomBytes(8).toString("hex");
const eye = (id: string, direction: number) =>
  ({ Id: id, X: 0.6, Y: 0.0, Z: 0.4, DirectionDeg: direction, ConeDeg: 40.0, MaxRange: 3.0 });
const robot = {
  Kind: "wheelchair", Instance: instance, Length: 1.1, Width: 0.6, Center: 0.4, TopSpeed: 1.0, Track: 0.57,
  Proximity: [eye("left", 35.0), eye("front", 0.0), eye("right", -35.0)],
};

const pause = (seconds: number) => new Promise((go) => setTimeout(go, 1000 * seconds));

/** Returns the Session from Joined, or an empty string if there is no simulator. */
async function join(): Promise<string> {
  for (;;) {
    const replies = await session.get(`${KEY}/join/${name}`, { payload: JSON.stringify(robot), encoding: JSON_V1 });
    let again = false;
    for await (const reply of replies!) {
      const result = reply.result();
      const text = result.payload().toString();
      if (!(result instanceof ReplyError)) return JSON.parse(text).Session;
      // An error that is not JSON comes from zenoh itself: no reply in time.
      if (!text.startsWith("{")) continue;
      const refused: Complaint = JSON.parse(text);
      if (refused.Code !== "no-token") {
        console.error(refused.Text);
        process.exit(1);
      }
      again = true; // our token has not arrived yet
    }
    if (!again) return "";
    await pause(0.2);
  }
}

function drive(measures: Measures): { LeftMotor: number; RightMotor: number } {
  const see = (id: string) => {
    const reading = measures.Sensors.Proximity.find((one) => one.Id === id);
    // A reading without a Value has the Status `none` (nothing within 3 m) or `near` (touching).
    return reading?.Value ?? (reading?.Status === "near" ? 0.0 : 3.0);
  };
  const [left, front, right] = [see("left"), see("front"), see("right")];
  const free = Math.min(left, front, right);
  const forward = free > 0.5 ? Math.min(0.5, 0.5 * (free - 0.5)) : 0.0;
  const turn = free > 0.5 ? 0.15 * (left - right) : 0.3;
  return { LeftMotor: forward - turn, RightMotor: forward + turn };
}

// Samples that arrived and were not processed yet. Handlers only store them.
const arrived: Sample[] = [];
let wake = () => {};
const keep = (sample: Sample) => {
  arrived.push(sample);
  wake();
};

const session = await Session.open(new Config(bridge, 5000));
await session.declareSubscriber(`${KEY}/out/${name}/*`, { handler: keep });
await session.liveliness().declareToken(`${KEY}/in/${name}/alive/both/${instance}`);
const actions = await session.declarePublisher(`${KEY}/in/${name}/actions`, {
  encoding: JSON_V1, congestionControl: CongestionControl.DROP, priority: Priority.INTERACTIVE_HIGH,
});
// The simulator's token appears when it starts, and again after a restart. We join each time.
await session.liveliness().declareSubscriber(`${KEY}/alive`, { handler: keep, history: true });

let [ours, run, tick] = ["", "", 0];
for (;;) {
  const sample = arrived.shift();
  if (sample === undefined) {
    await new Promise<void>((go) => { wake = go; });
    continue;
  }
  const kind = sample.keyexpr().toString().split("/").pop();
  if (kind === "alive") {
    ours = sample.kind() === SampleKind.PUT ? await join() : "";
    continue;
  }
  const text = sample.payload().toString();
  if (kind === "error") {
    const error: Complaint = JSON.parse(text);
    console.error(error.Text);
    if (error.Code === "not-joined" || error.Code === "session") ours = await join();
  } else if (kind === "measures" && ours) {
    const measures: Measures = JSON.parse(text);
    if (measures.Run === run && measures.Tick < tick) continue; // it arrived after a newer one
    [run, tick] = [measures.Run, measures.Tick];
    const said = { Run: run, Session: ours, Tick: tick, Seq: tick, ...drive(measures) };
    await actions.put(JSON.stringify(said));
  }
}
