//! A chair that avoids obstacles. It needs only zenoh and JSON. Usage: avoid [NAME [ENDPOINT]].

use std::hash::{BuildHasher, Hasher, RandomState};
use std::sync::mpsc::channel;
use std::time::Duration;
use std::{env, process, thread};

use serde_json::{json, Value};
use zenoh::qos::{CongestionControl, Priority};
use zenoh::sample::{Sample, SampleKind};
use zenoh::{Config, Session, Wait};

const KEY: &str = "iw/v1/main";
const JSON: &str = "application/json";

fn connect(endpoint: &str) -> Session {
    let mut config = Config::default();
    config.insert_json5("mode", "\"client\"").unwrap();
    config.insert_json5("connect/endpoints", &json!([endpoint]).to_string()).unwrap();
    config.insert_json5("scouting/multicast/enabled", "false").unwrap();
    loop {
        match zenoh::open(config.clone()).wait() {
            Ok(session) => return session,
            Err(_) => thread::sleep(Duration::from_secs(1)),
        }
    }
}

/// Returns the Session from Joined, or None if there is no simulator.
fn join(session: &Session, name: &str, robot: &Value) -> Option<String> {
    loop {
        let replies = session
            .get(format!("{KEY}/join/{name}"))
            .payload(robot.to_string())
            .encoding(JSON)
            .timeout(Duration::from_secs(12))
            .wait()
            .unwrap();
        let reply = replies.recv().ok()?;
        match reply.result() {
            Ok(joined) => {
                let joined: Value = serde_json::from_slice(&joined.payload().to_bytes()).ok()?;
                return joined["Session"].as_str().map(String::from);
            }
            Err(error) => {
                // An error that is not JSON comes from zenoh itself: no reply in time.
                let refused: Value = serde_json::from_slice(&error.payload().to_bytes()).ok()?;
                if refused["Code"] != "no-token" {
                    eprintln!("{}", refused["Text"].as_str().unwrap_or("refused"));
                    process::exit(1);
                }
                thread::sleep(Duration::from_millis(200)); // our token has not arrived yet
            }
        }
    }
}

fn drive(measures: &Value) -> (f64, f64) {
    let see = |eye: &str| {
        let readings = measures["Sensors"]["Proximity"].as_array();
        let reading = readings.and_then(|all| all.iter().find(|one| one["Id"] == eye));
        // A reading without a Value has the Status `none` (nothing within 3 m) or `near` (touching).
        match reading {
            Some(one) => one["Value"].as_f64().unwrap_or(if one["Status"] == "near" { 0.0 } else { 3.0 }),
            None => 3.0,
        }
    };
    let (left, front, right) = (see("left"), see("front"), see("right"));
    let free = left.min(front).min(right);
    let (forward, turn) = if free > 0.5 {
        ((0.5 * (free - 0.5)).min(0.5), 0.15 * (left - right))
    } else {
        (0.0, 0.3)
    };
    (forward - turn, forward + turn)
}

fn main() {
    let mut arguments = env::args().skip(1);
    let name = arguments.next().unwrap_or("avoid1".into());
    let endpoint = arguments.next().unwrap_or("tcp/127.0.0.1:7447".into());
    let instance = format!("{:016x}", RandomState::new().build_hasher().finish());
    let eye = |id: &str, direction: f64| {
        json!({"Id": id, "X": 0.6, "Y": 0.0, "Z": 0.4, "DirectionDeg": direction, "ConeDeg": 40.0, "MaxRange": 3.0})
    };
    let robot = json!({
        "Kind": "wheelchair", "Instance": instance,
        "Length": 1.1, "Width": 0.6, "Center": 0.4, "TopSpeed": 1.0, "Track": 0.57,
        "Proximity": [eye("left", 35.0), eye("front", 0.0), eye("right", -35.0)],
    });

    let session = connect(&endpoint);
    let (send, arrived) = channel::<Sample>();
    let keep = send.clone();
    let _measures = session
        .declare_subscriber(format!("{KEY}/out/{name}/*"))
        .callback(move |sample| keep.send(sample).unwrap_or(()))
        .wait()
        .unwrap();
    let _token =
        session.liveliness().declare_token(format!("{KEY}/in/{name}/alive/both/{instance}")).wait().unwrap();
    let actions = session
        .declare_publisher(format!("{KEY}/in/{name}/actions"))
        .encoding(JSON)
        .congestion_control(CongestionControl::Drop)
        .priority(Priority::InteractiveHigh)
        .wait()
        .unwrap();
    // The simulator's token appears when it starts, and again after a restart. We join each time.
    let _alive = session
        .liveliness()
        .declare_subscriber(format!("{KEY}/alive"))
        .history(true)
        .callback(move |sample| send.send(sample).unwrap_or(()))
        .wait()
        .unwrap();

    let (mut ours, mut run, mut tick) = (None, String::new(), 0);
    for sample in arrived {
        let kind = sample.key_expr().as_str().rsplit('/').next().unwrap_or("");
        if kind == "alive" {
            let there = sample.kind() == SampleKind::Put;
            ours = if there { join(&session, &name, &robot) } else { None };
            continue;
        }
        let Ok(message) = serde_json::from_slice::<Value>(&sample.payload().to_bytes()) else {
            continue;
        };
        if kind == "error" {
            eprintln!("{}", message["Text"].as_str().unwrap_or(""));
            if message["Code"] == "not-joined" || message["Code"] == "session" {
                ours = join(&session, &name, &robot);
            }
        } else if let (true, Some(ours), Some(now), Some(new)) =
            (kind == "measures", &ours, message["Run"].as_str(), message["Tick"].as_u64())
        {
            if now == run && new < tick {
                continue; // it arrived after a newer one
            }
            (run, tick) = (now.to_string(), new);
            let (left, right) = drive(&message);
            let answer = json!({
                "Run": run, "Session": ours, "Tick": tick, "Seq": tick, "LeftMotor": left, "RightMotor": right,
            });
            actions.put(answer.to_string()).wait().unwrap();
        }
    }
}
