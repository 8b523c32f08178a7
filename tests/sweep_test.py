#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# A sweep over two logs: in one process, in several, killed in the middle and gone on with, in shards that are merged.
# Each gives the same table in all but run times. Usage: sweep_test.py PROGRAM
import json
import os
import shlex
import shutil
import signal
import subprocess
import sys
import time

from sweep_support import check, cells, drives, finish, run, table, work

PROGRAM = os.path.abspath(sys.argv[1])
logs = drives(PROGRAM, 2, 3)
KNOBS = ["--sweep", "map.voxel_m=0.2,0.1,0.4", "--sweep", "map.max_range_m=5,25"]
COUNT = 12  # the profile's own choice, 0.1 and 25, is in the grid


def sweep(*arguments, **options):
    return run(PROGRAM, "bench", *logs, *KNOBS, *arguments, **options)


def same(folder, what):
    check(table(folder) == local, what + " gives the table of the local run")


# In one process and in two at a time.
inside = sweep("--out", work / "inside")
check(inside.returncode == 0, "a sweep in one process", inside)
jobs = sweep("--jobs", 2, "--out", work / "local")
check(jobs.returncode == 0 and jobs.stderr.count(" left: ") == COUNT, "a sweep in two processes", jobs)
check(cells(work / "local") == list(range(COUNT)), "a file a cell")
local = table(work / "local")
same(work / "inside", "one process")
result = json.loads((work / "local" / "sweep.json").read_text())
check(len(result["logs"]) == 2 and len(result["spread"]) == 6 and result["error"] == "map_disagreement",
      "two logs and the spread over them")
for row in result["spread"]:
    of_logs = [cell["errors"]["map_disagreement"] for log in result["logs"] for cell in log["cells"]
               if cell["values"] == row["values"]]
    error = row["error"]
    check(row["logs"] == 2 and error["low"] == min(of_logs) and error["high"] == max(of_logs)
          and abs(error["mean"] - sum(of_logs) / 2) < 1e-12, f"the spread of {row['values']}")
check(sum(row["profile_choice"] for row in result["spread"]) == 1, "the profile's choice is marked once")

# Nothing is run twice.
again = sweep("--jobs", 2, "--out", work / "local")
check(again.returncode == 0 and f"{COUNT} cells were there already" in again.stderr and " left: " not in again.stderr,
      "a whole sweep is not run again", again)

# Killed with all its processes in the middle; what is there is taken, but not what is damaged or of something else.
killed = work / "killed"
started = subprocess.Popen([PROGRAM, "bench", *map(str, logs), *KNOBS, "--jobs", "1", "--out", str(killed)],
                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
end = time.monotonic() + 120
while len(cells(killed)) < 4 and time.monotonic() < end and started.poll() is None:
    time.sleep(0.01)
os.killpg(started.pid, signal.SIGKILL)
started.wait()
left = cells(killed)
check(4 <= len(left) < COUNT, f"killed in the middle, with {left}")
(killed / "cell-00000.json").write_bytes((work / "local" / "cell-00000.json").read_bytes()[:200])
stale = json.loads((killed / "cell-00001.json").read_text())
stale["key"] = "0" * 16
stale["digest"] = "not this one"
(killed / "cell-00001.json").write_text(json.dumps(stale))
short = json.loads((killed / "cell-00002.json").read_text())
short["values"] = []
(killed / "cell-00002.json").write_text(json.dumps(short))
resumed = sweep("--jobs", 2, "--out", killed)
check(resumed.returncode == 0 and f"{len(left) - 3} cells were there already" in resumed.stderr
      and "3 cells were of another program" in resumed.stderr
      and resumed.stderr.count(" left: ") == COUNT - len(left) + 3, "a sweep goes on", resumed)
same(killed, "a sweep that was killed")

# Stopped by a signal to the sweep alone: its processes end with it.
stopped = subprocess.Popen([PROGRAM, "bench", *map(str, logs), *KNOBS, "--jobs", "1", "--repeat", "3", "--out",
                            str(work / "stopped")], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
line = stopped.stderr.readline()
stopped.send_signal(signal.SIGTERM)
words = stopped.communicate(timeout=60)[1]
check(" left: " in line and stopped.returncode == 128 + signal.SIGTERM and "goes on where it was" in words,
      f"a sweep that is stopped says how it goes on: {stopped.returncode} {words}")

# Shards: each cell in exactly one, wherever it runs; merged they are the local table.
shards = [work / f"shard{i}" for i in (1, 2, 3)]
for i, folder in enumerate(shards, 1):
    part = sweep("--shard", f"{i}/3", "--jobs", 2, "--out", folder)
    check(part.returncode == 0 and not part.stdout, f"shard {i} of 3", part)
check(sorted(sum((cells(folder) for folder in shards), [])) == list(range(COUNT)), "each cell is in one shard")
check(cells(shards[1]) == [1, 4, 7, 10], "a shard's cells are every third")
merged = run(PROGRAM, "merge", *shards, "--out", work / "merged")
check(merged.returncode == 0, "shards are merged", merged)
same(work / "merged", "merging shards")
alone = run(PROGRAM, "merge", shards[0], shards[2])
check(alone.returncode == 1 and not alone.stdout and "1,4,7,10" in alone.stderr
      and "missing cell 4: map.voxel_m=0.4 map.max_range_m=5 of hall1.lcm" in alone.stderr, "missing cells are named",
      alone)
resubmit = run(PROGRAM, "merge", shards[0], shards[2], "--resubmit")
check(resubmit.returncode == 1 and resubmit.stdout.count("\n") == 1, "one line runs them again", resubmit)
made_up = subprocess.run(shlex.split(resubmit.stdout), capture_output=True, text=True, timeout=300)
check(made_up.returncode == 0, "the line runs", made_up)
check(run(PROGRAM, "merge", shards[0], shards[2], "--out", work / "again").returncode == 0, "then nothing is missing")
same(work / "again", "cells that were run again")

# A cell of other figures must not pass for the same table: proves that the comparison can fail.
shutil.copytree(work / "local", work / "planted")
planted = json.loads((work / "planted" / "cell-00005.json").read_text())
planted["errors"]["map_disagreement"] = 0.125
planted["memory_bytes"] += 1
(work / "planted" / "cell-00005.json").write_text(json.dumps(planted))
run(PROGRAM, "merge", work / "planted", "--out", work / "planted")
check(table(work / "planted") != local, "another figure is another table")

# Each knob alone: a sweep a knob, each with its own front and the profile's choice; the same in processes.
small = work / "small.lcm"
run(PROGRAM, "run", "--scene", "ugv_hall", "--virtual", "--seconds", 0.5, "--lcm-url", "none", "--record", small,
    "--set", "hil.lidar_rows=8", "--set", "hil.lidar_columns=64", "--set", "limits.voxels=32768")
alone = run(PROGRAM, "bench", small, "--sweep", "knobs", "--out", work / "knobs")
beside = run(PROGRAM, "bench", small, "--sweep", "knobs", "--jobs", 2, "--out", work / "knobs beside")
check(alone.returncode == 0 and beside.returncode == 0 and table(work / "knobs") == table(work / "knobs beside"),
      "each knob alone gives the same table in processes", beside)
result = json.loads((work / "knobs" / "sweep.json").read_text())
of_knob = {knob: one for one in result["logs"] for knob in one["knobs"]}
check(len(of_knob) == len(result["logs"]) > 10 and not result["spread"] and not result["warnings"], "one sweep a knob")
check(all(sum(cell["profile_choice"] for cell in one["cells"]) == 1 and any(cell["on_front"] for cell in one["cells"])
          for one in of_knob.values()), "each knob has its front and the profile's choice")
check(of_knob["groups.mapping.rate_hz"]["error"] == of_knob["map.voxel_m"]["error"] == "map_disagreement"
      and of_knob["attitude.track_aid"]["error"] == "inclination_rmse_deg", "the map's knobs are judged by the map")
check(of_knob["attitude.track_aid"]["cells"][0]["voxels"] == 0 < of_knob["map.voxel_m"]["cells"][0]["voxels"],
      "no map where the knob is not the map's")
check([cell["values"]["map.voxel_m"] for cell in of_knob["map.voxel_m"]["cells"]] == ["0.025", "0.05", "0.1", "0.2", "0.4"],
      "a number is tried around what it is")
check((work / "knobs" / "sweep.md").read_text().count("\n## ") == len(of_knob), "a section a knob on the page")

# Instructions are the same wherever they are counted, and belong to the cell.
if shutil.which("valgrind"):
    counted = []
    for name, more in (("counted", []), ("counted beside", ["--jobs", 2])):
        told = run(PROGRAM, "bench", small, "--sweep", "attitude.acc_time_constant_s=1,3", "--sweep", "map.voxel_m=0.2,0.4",
                   "--task", "attitude", "--task", "map", "--instructions", *more, "--out", work / name)
        check(told.returncode == 0, f"a sweep is {name}", told)
        log = json.loads((work / name / "sweep.json").read_text())
        log = log.get("logs", [log])[0]
        counted.append({tuple(cell["values"].values()): cell["instructions_per_s"] for cell in log["cells"]})
    check(counted[0] == counted[1] and min(counted[0].values()) > 1e5, f"counts are the same: {counted}")
    check(counted[0][("1", "0.2")] > counted[0][("1", "0.4")], "finer voxels cost more instructions")
else:
    print("skipped: instructions of cells: no valgrind")

# What is refused, with its cure.
moved = work / "moved"
plan = sweep("--slurm", work / "sweep.sh", "--out", moved)
check(plan.returncode == 0 and not cells(moved) and "sbatch" in plan.stderr, "a script is written, nothing run", plan)
script = run("bash", work / "sweep.sh")
check(script.returncode == 2 and "slurm-client" in script.stderr, "the script without sbatch names the cure", script)
other = run(PROGRAM, "merge", shards[0], moved, work / "nothing")
check(other.returncode == 3 and "nothing/plan.json" in other.stderr, "a folder without a plan", other)
with open(logs[1], "ab") as log:
    log.write(b"more")
changed = run(PROGRAM, "bench", "--cell", COUNT - 1, "--out", moved)
check(changed.returncode == 3 and "is not the log" in changed.stderr, "a log that changed is refused", changed)
first = run(PROGRAM, "bench", "--cell", "0,2-3", "--out", moved)
check(first.returncode == 0 and cells(moved) == [0, 2, 3], "cells by list", first)
for arguments, says in [(["--shard", "4/3", "--out", "x"], "1 <= i <= n"), (["--shard", "a", "--out", "x"], "--shard 2/5"),
                        (["--jobs", "2"], "add --out DIR"), (["--jobs", "0"], "--jobs"),
                        (["--sweep", "knobs"], "--sweep knobs: no values"), (["--scene", "a", "--scene", "b"], "one scene"),
                        (["--cell", "3-1", "--out", "x"], "0,3-7"), (["--cell", "99", "--out", moved], "it has 0 to 11")]:
    refused = sweep(*arguments, cwd=work)
    check(refused.returncode == 2 and says in refused.stderr, f"{arguments} is refused", refused)
mixed = run(PROGRAM, "bench", logs[0], "--sweep", "map.voxel_m=0.2", "--shard", "1/2", "--out", work / "mixed")
refused = run(PROGRAM, "merge", shards[0], work / "mixed")
check(mixed.returncode == 0 and refused.returncode == 2 and "another sweep" in refused.stderr, "two sweeps do not mix",
      refused)

# Without a log the scene is simulated, once.
scene = ["bench", "--scene", "ugv_hall", "--seconds", "1", "--seeds", "2", "--sweep", "map.voxel_m=0.2", "--jobs", "2",
         "--out", work / "scene"]
simulated = run(PROGRAM, *scene)
recorded = {path: path.stat().st_mtime_ns for path in (work / "scene" / "drives").iterdir()}
check(simulated.returncode == 0 and len(recorded) == 2, "a scene is simulated", simulated)
run(PROGRAM, *scene)
check(recorded == {path: path.stat().st_mtime_ns for path in (work / "scene" / "drives").iterdir()}
      and cells(work / "scene") == [0, 1, 2, 3], "and not again")
finish("sweeps: all tables agree")
