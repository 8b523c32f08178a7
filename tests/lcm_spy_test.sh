#!/bin/bash
# SPDX-License-Identifier: BSD-3-Clause
# tests/lcm_spy_test.sh PUBLISHER [PICTURE]: starts toolchain/lcm-spy under a virtual display in a network of its own,
# publishes every message type of ours (PUBLISHER URL SECONDS --with-cut), and reads the table in the spy's window: each
# type must be shown with messages and none undecodable, and the one damaged message must be shown as such. PICTURE:
# saves the screen, with three messages opened. Exit code 77 with a reason where something is missing.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
publisher=$1
picture=${2:-}
skip() { echo "skipped: $1"; exit 77; }

for tool in Xvfb xdotool openbox unshare ip; do
  command -v $tool >/dev/null || skip "$tool is missing. Cure: toolchain/install spy"
done
why=$("$here/../toolchain/lcm-spy" --check 2>&1) || skip "$why"
[ -z "$picture" ] || command -v import >/dev/null || skip "import (imagemagick) is missing. Cure: toolchain/install spy"
if [ "${SORTIE_OWN_NETWORK:-}" != 1 ]; then
  options=(--net --pid --fork --kill-child)   # whatever is started ends with the test
  [ "$(id -u)" -eq 0 ] || options+=(--map-root-user)
  unshare "${options[@]}" true 2>/dev/null || skip "this system refuses a network namespace"
  SORTIE_OWN_NETWORK=1 exec unshare "${options[@]}" "$0" "$@"
fi
ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo || skip "no multicast on the loopback"

work=$(mktemp -d)
trap 'kill $(jobs -p) 2>/dev/null || true; rm -rf "$work"' EXIT
fail() {
  echo "FAILED: $1"
  echo "--- the spy said:"
  cat "$work/spy.log"
  exit 1
}
# wait_for SECONDS COMMAND...: true as soon as the command is.
wait_for() {
  local end=$((SECONDS + $1))
  until "${@:2}" >/dev/null 2>&1; do
    [ $SECONDS -lt $end ] || return 1
    sleep 0.2
  done
}

mkfifo "$work/display"
Xvfb -displayfd 3 -screen 0 1460x880x24 -nolisten tcp 3>"$work/display" 2>"$work/xvfb.log" &
read -r -t 60 number <"$work/display" || { cat "$work/xvfb.log"; skip "Xvfb does not start"; }
export DISPLAY=:$number
openbox >/dev/null 2>&1 &

mkdir "$work/agent"
javac -d "$work/agent" "$here/tools/SpyTableAgent.java"
echo 'Premain-Class: SpyTableAgent' >"$work/manifest"
jar cfm "$work/agent.jar" "$work/manifest" -C "$work/agent" .

url='udpm://239.255.76.67:7667?ttl=0'
JDK_JAVA_OPTIONS=-javaagent:$work/agent.jar "$here/../toolchain/lcm-spy" --lcm-url="$url" >"$work/spy.log" 2>&1 &
types=("$here"/../drivers/messages/*.lcm)
wait_for 90 grep -q 'Found [0-9]* LCM types' "$work/spy.log" || fail "the spy found no types within 90 s"
grep -q "Found ${#types[@]} LCM types" "$work/spy.log" || fail "the spy should find ${#types[@]} types"
wait_for 60 xdotool search --onlyvisible --name 'LCM Spy' || fail "the spy's window did not open"
window=$(xdotool search --onlyvisible --name 'LCM Spy' | head -n 1)

options=(--with-cut)
[ -z "$picture" ] || options=()
"$publisher" "$url" 600 "${options[@]}" &
for file in "${types[@]}"; do
  type=$(basename "$file" .lcm)
  wait_for 30 grep -qE "^row [A-Za-z_]+ $type [1-9][0-9]* 0\$" "$work/spy.log" || fail "$type is not shown, or not decoded"
done
if [ -n "$picture" ]; then
  sleep 3
  xdotool windowsize --sync "$window" 798 395 windowmove --sync "$window" 0 0
  for place in 9:0,440 1:655,440 2:805,0; do  # statistics, IMU, pose: row, then where its window goes
    xdotool mousemove --window "$window" 60 $((28 + 16 * ${place%%:*})) click --repeat 2 --delay 60 1
    sleep 2
    xdotool windowmove --sync "$(xdotool getactivewindow)" $(tr , ' ' <<<"${place#*:}")
  done
  sleep 3
  import -window root "$picture"
  exit 0
fi
wait_for 30 grep -qE '^row CUT imu_t [1-9][0-9]* [1-9][0-9]*$' "$work/spy.log" || fail "a damaged message passed for a good one"
sed -n '/^row CAN/h;/^row CAN/!H;${x;p}' "$work/spy.log"
echo "LCM spy decoded all ${#types[@]} message types"
