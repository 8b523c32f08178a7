#!/bin/bash
# SPDX-License-Identifier: BSD-3-Clause
# own_robot.sh PROGRAM TREE WORK: what a robot engineer's own program gets unasked. PROGRAM is the built example, TREE the
# source tree, WORK a scratch directory. Prints "skipped: why" for the part that this machine refuses.
set -euo pipefail
program=$1 tree=$2 work=$3
scene=$tree/examples/own_robot/gas.toml
rm -rf "$work" && mkdir -p "$work"
cd "$work"
fail() { echo "own_robot: $*" >&2; exit 1; }
expect() { grep -qE -- "$1" "$2" || { cat "$2" >&2; fail "$2 does not hold: $1"; }; }

"$program" scenes "$scene" >scenes.txt
expect '^gas +gas .* gas_alarm +a gas sensor' scenes.txt
"$program" scenes --keys "$scene" >keys.txt
expect '^gas\.alarm_ppm += 50 +ppm' keys.txt
expect '^hil\.peak_ppm += 100 +ppm' keys.txt

# Twice in virtual time: the same digest, and no heap call in a task.
for n in 1 2; do "$program" run --scene "$scene" --virtual --seconds 3 --lcm-url none --json >virtual$n.json; done
[ "$(grep '"digest"' virtual1.json)" = "$(grep '"digest"' virtual2.json)" ] || fail "two virtual runs differ"
expect '"heap_calls": 0' virtual1.json
expect '"name": "gas_alarm"' virtual1.json

# The how-to's table is what this run prints.
"$program" run --scene "$scene" --virtual --seconds 3 --record howto.lcm --record-fields --out howto >howto.txt 2>howto.err
"$tree/tests/docs/printed_results.py" --table howto.txt "$tree/docs/driver-howto.md" || fail "docs/driver-howto.md prints another table"

# Live, with a log, a table, a report; a listener in the same private network sees the task's fields.
cat >live.sh <<LIVE
"$program" spy --json --seconds 6 >spy.json 2>spy.err &
sleep 1
"$program" run --scene "$scene" --seconds 3 --record gas.lcm --record-fields --out out >table.txt 2>run.err
wait
LIVE
"$tree/toolchain/own-network" bash -e live.sh 2>network.txt || { cat network.txt run.err spy.err >&2; fail "the live run failed"; }
expect '^gas_alarm +sensing +20000 +20 ' table.txt
expect '^digest +[0-9a-f]{16}' table.txt
expect '<svg' out/report.html
expect '"histogram"' out/results.json
if grep -q 'no network of its own' network.txt; then
  echo "skipped: telemetry of the example robot: $(cat network.txt)"
else
  expect 'SORTIE_FIELDS_gas_alarm' spy.json
fi

# The log replays to the run's digest, a planted fault is found by its field, and other tools can read it.
digest=$(grep -oE '^digest +[0-9a-f]{16}' table.txt | grep -oE '[0-9a-f]{16}')
"$program" check gas.lcm >check.txt
expect "^passed .* $digest, as recorded" check.txt
"$program" check gas.lcm --fault gas_alarm.8@1000 >fault.txt && fail "check did not see a planted fault"
expect 'mean_ppm' fault.txt
"$program" index gas.lcm --every 0.5 >index.txt
expect 'gas.lcm.keyframes: [0-9]+ keyframes' index.txt
"$program" check gas.lcm --from 1.7 >from.txt
expect "^passed .* $digest, as recorded" from.txt
"$program" replay gas.lcm --json >replay.json
expect "\"digest\": \"$digest\"" replay.json
"$program" replay gas.lcm --set gas.alarm_ppm=1 --json >what_if.json
! grep -q "\"digest\": \"$digest\"" what_if.json || fail "a lower alarm changed nothing"
"$program" report gas.lcm --out report >report.txt 2>&1
expect '<svg' report/report.html
"$program" export csv gas.lcm --task gas_alarm -o gas.csv
expect '^time,stamp_ns,mean_ppm,alarm,rejected$' gas.csv
[ "$(wc -l <gas.csv)" -gt 100 ] || fail "gas.csv has too few rows"
"$program" export candump gas.lcm -o gas.candump
expect ' can0 150#[0-9A-F]{4}$' gas.candump
"$program" export trace gas.lcm -o gas.trace.json

# Its promise: fewer than 100 lines of C++ in all.
lines=$(cat "$tree"/examples/own_robot/*.hpp "$tree"/examples/own_robot/*.cpp | wc -l)
[ "$lines" -lt 100 ] || fail "the example has $lines lines of C++"
echo "own_robot: $lines lines of C++, digest $digest"
