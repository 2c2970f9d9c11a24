//! A node of ROS 2 that hiroz alone puts on Zenoh: `hiroz_peer ENDPOINT CHAIR ENTITY`.
//!
//! It reads a chair's topics, drives half a metre by `cmd_vel`, joins `/map` late, and calls two services. Each message
//! and answer is a line of JSON. Numbers that JSON has not, such as infinity, are `null`.

include!(concat!(env!("OUT_DIR"), "/generated.rs"));
// The generated code looks for it at the root.
use hiroz_msgs::size_estimation;

use std::{
    collections::HashSet,
    env,
    sync::mpsc::{channel, Receiver, Sender},
    time::{Duration, Instant},
};

use hiroz::{
    entity::{entity_get_endpoint, EndpointKind, Entity},
    graph::Graph,
    msg::{ZDeserializer, ZMessage, ZService},
    prelude::*,
};
use hiroz_msgs::ros::{
    builtin_interfaces::Time,
    geometry_msgs::{Pose, Transform, Twist, Vector3},
    nav_msgs::{OccupancyGrid, Odometry},
    rosgraph_msgs::Clock,
    sensor_msgs::LaserScan,
    tf2_msgs::TFMessage,
};
use ros::simulation_interfaces::{
    srv::{GetEntityState, SetSimulationState},
    GetEntityStateRequest, SetSimulationStateRequest, SimulationState,
};
use serde_json::{json, Value};

const DEADLINE: Duration = Duration::from_secs(60);
const PERIOD: Duration = Duration::from_millis(100);
const SPEED: f64 = 0.5;
const WAY: f64 = 0.5;
const PAUSED: u8 = 2;

fn main() -> Result<()> {
    let words: Vec<String> = env::args().skip(1).collect();
    let [endpoint, chair, entity] = &words[..] else {
        return Err("expected ENDPOINT CHAIR ENTITY".into());
    };
    let context = ZContextBuilder::default().with_domain_id(0).with_connect_endpoints([endpoint.as_str()]).build()?;
    let node = context.create_node("hiroz_peer").build()?;
    let (to, lines) = channel();
    let topic = |name: &str| format!("/{chair}/{name}");

    let command = node.create_pub::<Twist>(&topic("cmd_vel")).build()?;
    let _odometry = hear(&node, &topic("odom"), QosProfile::default(), to.clone(), odometry)?;
    let _scan = hear(&node, &topic("scan"), best_effort(5), to.clone(), scan)?;
    let _tf = hear(&node, "/tf", keeping(100), to.clone(), frames)?;
    let _clock = hear(&node, "/clock", best_effort(1), to.clone(), clock)?;
    let mut missing: HashSet<String> = [topic("odom"), topic("scan"), "/tf".into(), "/clock".into()].into();
    wait(&lines, "all topics", |line| {
        missing.remove(line["topic"].as_str().unwrap_or_default());
        missing.is_empty()
    })?;
    print_graph(node.graph());

    let forward = Twist { linear: Vector3 { x: SPEED, ..Default::default() }, ..Default::default() };
    let mut sent: Option<Instant> = None;
    wait(&lines, "half a metre", |line| {
        if sent.map_or(true, |at| at.elapsed() >= PERIOD) {
            sent = Some(Instant::now());
            command.publish(&forward).expect("cmd_vel");
        }
        line["topic"] == topic("odom") && line["position"][0].as_f64() >= Some(WAY)
    })?;
    command.publish(&Twist::default())?;

    let latched = QosProfile { durability: QosDurability::TransientLocal, ..keeping(1) };
    let _map = hear(&node, "/map", latched, to, grid)?;
    wait(&lines, "the map", |line| line["topic"] == "/map")?;

    let pause = SetSimulationStateRequest { state: SimulationState { state: PAUSED } };
    let paused = call::<SetSimulationState>(&node, "/set_simulation_state", &pause)?;
    println!("{}", json!({"service": "/set_simulation_state", "result": paused.result.result}));
    let about = GetEntityStateRequest { entity: entity.clone() };
    let found = call::<GetEntityState>(&node, "/get_entity_state", &about)?;
    println!(
        "{}",
        json!({
            "service": "/get_entity_state", "result": found.result.result, "frame": found.state.header.frame_id,
            "nanoseconds": nanoseconds(&found.state.header.stamp), "pose": pose(&found.state.pose),
        })
    );
    Ok(())
}

fn keeping(depth: usize) -> QosProfile {
    QosProfile { history: QosHistory::from_depth(depth), ..Default::default() }
}

fn best_effort(depth: usize) -> QosProfile {
    QosProfile { reliability: QosReliability::BestEffort, ..keeping(depth) }
}

/// Subscribe to a topic; each message becomes a line with the topic in it.
fn hear<T>(
    node: &ZNode,
    topic: &str,
    qos: QosProfile,
    to: Sender<Value>,
    said: fn(&T) -> Value,
) -> Result<ZSub<T, (), T::Serdes>>
where
    T: ZMessage + WithTypeInfo,
    for<'a> T::Serdes: ZDeserializer<Output = T, Input<'a> = &'a [u8]> + 'static,
{
    let name = topic.to_owned();
    node.create_sub::<T>(topic).with_qos(qos).build_with_callback(move |message: T| {
        let mut line = said(&message);
        line["topic"] = json!(name);
        // Whoever reads the lines may be gone.
        let _ = to.send(line);
    })
}

/// Print the lines until one is what was waited for.
fn wait(lines: &Receiver<Value>, what: &str, mut is_it: impl FnMut(&Value) -> bool) -> Result<()> {
    let end = Instant::now() + DEADLINE;
    loop {
        let left = end.saturating_duration_since(Instant::now());
        let line = lines.recv_timeout(left).map_err(|_| format!("expected {what}, got none"))?;
        println!("{line}");
        if is_it(&line) {
            return Ok(());
        }
        if left.is_zero() {
            return Err(format!("expected {what}, got other messages").into());
        }
    }
}

fn call<T>(node: &ZNode, service: &str, request: &T::Request) -> Result<T::Response>
where
    T: ZService + ServiceTypeInfo,
    T::Request: ZMessage,
    T::Response: ZMessage,
    for<'a> <T::Response as ZMessage>::Serdes: ZDeserializer<Output = T::Response, Input<'a> = &'a [u8]>,
{
    let client = node.create_client::<T>(service).build()?;
    tokio::runtime::Runtime::new()?.block_on(client.call_with_timeout(request, DEADLINE))
}

/// Print each publisher and service of the graph, as hiroz reads their tokens.
fn print_graph(graph: &Graph) {
    for (topic, _) in graph.get_topic_names_and_types() {
        for entity in graph.get_entities_by_topic(EndpointKind::Publisher, &topic) {
            print_entity("publisher", &entity);
        }
    }
    for (service, _) in graph.get_service_names_and_types() {
        for entity in graph.get_entities_by_service(EndpointKind::Service, &service) {
            print_entity("server", &entity);
        }
    }
}

fn print_entity(kind: &str, entity: &Entity) {
    let Some(found) = entity_get_endpoint(entity) else { return };
    let (Some(node), Some(of)) = (&found.node, &found.type_info) else { return };
    println!(
        "{}",
        json!({
            kind: found.topic, "node": format!("{}/{}", node.namespace, node.name), "type": of.name,
            "hash": of.hash.to_rihs_string(), "qos": found.qos.encode(),
        })
    );
}

fn nanoseconds(stamp: &Time) -> i64 {
    i64::from(stamp.sec) * 1_000_000_000 + i64::from(stamp.nanosec)
}

fn pose(of: &Pose) -> Value {
    let (at, turn) = (&of.position, &of.orientation);
    json!([at.x, at.y, at.z, turn.x, turn.y, turn.z, turn.w])
}

fn transform(of: &Transform) -> Value {
    let (at, turn) = (&of.translation, &of.rotation);
    json!([at.x, at.y, at.z, turn.x, turn.y, turn.z, turn.w])
}

fn odometry(of: &Odometry) -> Value {
    let at = &of.pose.pose.position;
    json!({
        "nanoseconds": nanoseconds(&of.header.stamp), "frame": of.header.frame_id, "child": of.child_frame_id,
        "position": [at.x, at.y, at.z], "pose": pose(&of.pose.pose),
        "speed": of.twist.twist.linear.x, "turn_rate": of.twist.twist.angular.z,
    })
}

fn scan(of: &LaserScan) -> Value {
    json!({
        "nanoseconds": nanoseconds(&of.header.stamp), "frame": of.header.frame_id, "first": of.angle_min,
        "step": of.angle_increment, "least": of.range_min, "largest": of.range_max, "ranges": of.ranges,
    })
}

fn frames(of: &TFMessage) -> Value {
    let all = of.transforms.iter().map(|one| {
        json!({
            "nanoseconds": nanoseconds(&one.header.stamp), "frame": one.header.frame_id,
            "child": one.child_frame_id, "transform": transform(&one.transform),
        })
    });
    json!({ "transforms": all.collect::<Vec<_>>() })
}

fn clock(of: &Clock) -> Value {
    json!({"nanoseconds": nanoseconds(&of.clock)})
}

fn grid(of: &OccupancyGrid) -> Value {
    let info = &of.info;
    json!({
        "frame": of.header.frame_id, "resolution": info.resolution, "width": info.width, "height": info.height,
        "origin": pose(&info.origin), "data": of.data,
    })
}
