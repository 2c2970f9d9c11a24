#!/bin/sh
# Lesson 7: a real chair. `iw-bridge` puts it into the simulation: it reports where the chair is, and passes motor powers
# down the serial line. Any mind can drive it; here it is the mind of lesson 1.
#
#     sh 07_real_chair.sh
#
# No hardware is needed: `firmware_stand_in` plays the chair's controller on a pseudo-terminal. With a real chair, leave it
# out and write --port /dev/ttyUSB0; agents/intellwheels_agents/bridge/PROTOCOL.md says what its controller must do.
# The controller prints `moving` and `stopped`. Ctrl-C ends all. Another endpoint: sh 07_real_chair.sh tcp/127.0.0.1:7448
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
