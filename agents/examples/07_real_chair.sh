#!/bin/sh
# Lesson 7: a real chair. `iw-bridge` connects it to the simulation. It reports the pose of the chair, and sends motor
# powers over the serial line. Any mind can drive the chair; here it is the mind of lesson 1.
#
#     sh 07_real_chair.sh
#
# No hardware is needed: `firmware_stand_in` plays the chair's controller on a pseudo-terminal, and prints `moving` and
# `stopped`. With a real chair, omit it and use --port /dev/ttyUSB0. What a controller must do is described in
# agents/intellwheels_agents/bridge/PROTOCOL.md. Ctrl-C ends all processes. To use another endpoint, run
# `sh 07_real_chair.sh tcp/127.0.0.1:7448`.
set -eu
cd "$(dirname "$0")"
endpoint=${1:-tcp/127.0.0.1:7447}
folder=$(mktemp -d)
processes=
trap 'kill $processes; wait; rm -rf "$folder"' EXIT
trap 'exit 0' INT TERM

iw-server --map room --listen "$endpoint" &
processes="$processes $!"
python -m intellwheels_agents.bridge.firmware_stand_in --link "$folder/chair" &
processes="$processes $!"
iw-bridge serial --port "$folder/chair" --name chair1 --robot intellwheels --place start1 --connect "$endpoint" &
processes="$processes $!"
iw-agent 01_first_mind.py --name chair1 --role mind --connect "$endpoint" &
processes="$processes $!"
wait
