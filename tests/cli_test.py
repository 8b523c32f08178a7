#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Runs the real program: exit codes, one clear line for each thing that can be wrong, JSON that parses, help with
# examples. Usage: cli_test.py DATA_DIR PROGRAM [ARGUMENT...] (an emulator may stand before the program).
import json
import os
import pathlib
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time

DATA = pathlib.Path(sys.argv[1])
PROGRAM = sys.argv[2:]
work = pathlib.Path(tempfile.mkdtemp(prefix="sortie-cli-"))
os.chdir(work)
failures = []
checks = 0


def run(*arguments, **options):
    return subprocess.run(PROGRAM + [str(a) for a in arguments], capture_output=True, text=True, timeout=300,
                          stdin=subprocess.DEVNULL, **options)


def check(good, what, result=None):
    global checks
    checks += 1
    if good:
        return
    failures.append(what)
    print("FAILED", what)
    if result is not None:
        print("  exit", result.returncode, "\n  stdout:", result.stdout[:500], "\n  stderr:", result.stderr[:1500])


def expect(code, *arguments, says=(), only_line=False, **options):
    """The program ends with `code`, and one line of stderr holds every part of `says`."""
    result = run(*arguments, **options)
    name = "sortie " + " ".join(str(a) for a in arguments)
    check(result.returncode == code, f"{name}: exit {result.returncode}, not {code}", result)
    lines = [line for line in result.stderr.splitlines() if line]
    if says:
        hits = [line for line in lines if all(part in line for part in says)]
        check(len(hits) == 1, f"{name}: not one line on stderr with {says}", result)
    if only_line:
        check(len(lines) == 1, f"{name}: {len(lines)} lines on stderr, not one", result)
    return result


def parsed(result):
    try:
        return json.loads(result.stdout)
    except ValueError as error:
        check(False, f"no JSON on stdout: {error}", result)
        return {}


# Usage.
for command in ["run", "replay", "check", "index", "diff", "import", "export", "report", "spy", "set", "drive", "fly", "scenes", "doctor", "bench", "bench wcet", "bench rt", "bench plant", "bench mapping", "bench registration", "bench recognition", "bench rays", "bench posture", "bench flippers", "bench courses", "bench ground-path", "bench uav", "bench stability", "bench campaign"]:
    result = expect(0, *command.split(), "--help")
    check(f"sortie {command}" in result.stdout and "Example" in result.stdout, f"{command} --help has no example", result)
expect(0, "--help")
expect(0, "--version")
expect(2)
expect(2, "swim")
expect(2, "fly")
expect(2, "fly", "go", "--x", "1", says=["--x, --y and --z"], only_line=True)
expect(2, "run")
expect(2, "run", "--scene", "ugv_hall", "--no-such-option")
expect(2, "replay", "log.lcm", "--align", "sideways")

# Profiles: exit 2, place, fault, cure.
expect(2, "run", "--scene", "ugv_hal", says=["unknown scene", "ugv_hall"], only_line=True)
expect(2, "run", "--scene", "ugv_hall", "--set", "map.voxl_m=0.1", says=["unknown key map.voxl_m", "map.voxel_m?"],
       only_line=True)
expect(2, "run", "--scene", "ugv_hall", "--set", "hil.sed=3", "--virtual", says=["unknown key hil.sed", "hil.seed?"],
       only_line=True)
expect(2, "run", "--scene", "ugv_hall", "--set", "map.voxel_m=lots", says=["map.voxel_m", "must be a number"],
       only_line=True)
expect(2, "run", "--scene", "ugv_hall", "--set", "map.voxel_m=-1", says=["map.voxel_m", "outside"], only_line=True)
expect(2, "run", "--scene", "ugv_hall", "--set", "groups.control.rate_hz=300", says=["nearest legal", "250"],
       only_line=True)
expect(2, "run", "--scene", "ugv_hall", "--set", "tasks.map.budget_us=90000",
       says=["group mapping", "its deadline is 100 ms", "schedule.accept_overload"], only_line=True)
expect(2, "run", "--scene", "ugv_hall", "--set", "chains.imu_to_drive.max_reaction_ms=1",
       says=["worst reaction time is 2 ms", "allowed 1 ms"], only_line=True)
pathlib.Path("typo.toml").write_text('[scene]\nname = "typo"\nvehicle = "ugv"\n\n[map]\nvoxel_sise_m = 0.1\n')
expect(2, "run", "--scene", "typo.toml", says=["typo.toml:6", "map.voxel_sise_m"], only_line=True)
pathlib.Path("broken.toml").write_text('[scene]\nname = "broken\n')
expect(2, "run", "--scene", "broken.toml", says=["broken.toml:2", "not valid TOML"], only_line=True)
pathlib.Path("alien.toml").write_text('[scene]\nname = "alien"\nvehicle = "saucer"\n')
expect(2, "run", "--scene", "alien.toml", says=["alien.toml:3", "saucer", "ugv"], only_line=True)
expect(2, "run", "--scene", "absent.toml", says=["absent.toml", "cannot be read"], only_line=True)

# Logs that are none: exit 3.
pathlib.Path("text.lcm").write_text("a shopping list, not a log\n")
pathlib.Path("empty.lcm").write_bytes(b"")
for command in (["replay"], ["check"], ["report", "--out", "out"], ["export", "tum"]):
    expect(3, *command, "absent.lcm", says=["absent.lcm"], only_line=True)
    expect(3, *command, "text.lcm", says=["text.lcm"], only_line=True)
    expect(3, *command, "empty.lcm", says=["empty.lcm", "SORTIE_HEADER"], only_line=True)
    expect(3, *command, ".", says=["is a folder"], only_line=True)
expect(3, "diff", "absent.lcm", "text.lcm", says=["absent.lcm"], only_line=True)
expect(3, "run", "--scene", "ugv_hall", "--virtual", "--seconds", "0.1", "--record", "no/such/folder/x.lcm",
       says=["no/such/folder"], only_line=True)

# A run, its replay, its check, its digest.
small = ["--set", "hil.lidar_rows=8", "--set", "hil.lidar_columns=128"]
result = expect(0, "run", "--scene", "ugv_hall", "--virtual", "--seconds", "2", "--record", "hall.lcm", "--record-fields",
                "--json", *small)
first = parsed(result)
check(set("digest ticks scene errors tasks pools counters".split()) <= set(first), "keys of run --json", result)
check(all(set("name period_us budget_us count missed p50_us p99_us p999_us max_us".split()) <= set(task)
          for task in first.get("tasks", [])), "keys of tasks[]", result)
check(all(set("name capacity high_water refused".split()) <= set(pool) for pool in first.get("pools", [])),
      "keys of pools[]", result)
for extra in ([], ["--threads"]):
    again = parsed(expect(0, "replay", "hall.lcm", "--json", *extra))
    check(again.get("digest") == first.get("digest"), f"replay {extra} gives another digest")
verdict = parsed(expect(0, "check", "hall.lcm", "--json"))
check(verdict.get("passed") is True and verdict.get("digest") == first.get("digest"), f"check --json: {verdict}")
# A release gate: the digest and a bound are kept, then broken, each with its line. (The thread sanitizer's build has no heap trap.)
heap = "counters.heap_calls = 0\n" if "heap_calls" in first.get("counters", {}) else ""
pathlib.Path("gate.toml").write_text(f'[max]\n{heap}all.missed = 0\n[equal]\ndigest = "{first.get("digest")}"\n')
expect(0, "check", "hall.lcm", "--gate", "gate.toml")
pathlib.Path("gate.toml").write_text('[max]\nticks = 1\n[equal]\ndigest = "none"\n')
result = expect(1, "check", "hall.lcm", "--gate", "gate.toml")
check(result.stdout.splitlines() == ["FAILED  gate.toml:4: digest = " + first.get("digest", "") + ", wanted none",
                                     f"FAILED  gate.toml:2: ticks = {first.get('ticks')}, at most 1"], "a gate names what is broken", result)
pathlib.Path("gate.toml").write_text("[max]\nall.mised = 0\n")
expect(2, "check", "hall.lcm", "--gate", "gate.toml", says=["gate.toml:2: ", "all.mised"], only_line=True)
# The robot's times are known in a live run and in its log; in simulated time they are refused with the cure, and so is a gate that cannot fail.
pathlib.Path("late.toml").write_text("[max]\ngroups.control.late_max_us = -1\nall.response_max_us = -1\n")
pathlib.Path("kept.toml").write_text("[max]\ngroups.control.late_max_us = 1e9\nall.response_max_us = 1e9\nall.max_us = 1e9\n")
live = ["run", "--scene", "ugv_hall", "--seconds", "0.5", "--lcm-url", "none", "--quiet", "--no-rt"]
expect(0, *live, "--record", "gated.lcm", "--gate", "kept.toml")
gated = expect(1, *live, "--gate", "late.toml", "--json")
check(parsed(gated).get("passed") is False and len(parsed(gated)["failures"]) == 2, "run --gate names what is broken", gated)
expect(0, "check", "gated.lcm", "--gate", "kept.toml")
result = expect(1, "check", "gated.lcm", "--gate", "late.toml")
check("late.toml:2: groups.control.late_max_us" in result.stdout and "late.toml:3: all.response_max_us" in result.stdout, "check judges the robot's times", result)
told = parsed(expect(0, "check", "gated.lcm", "--json"))
expect(0, "report", "gated.lcm", "--out", "gated")
paged = json.loads(pathlib.Path("gated/results.json").read_text())
check(told["live"]["known"] and paged["live"] == told["live"] and paged["groups"] == told["groups"], "check and report tell the same of the robot")
check("Run times on the robot" in pathlib.Path("gated/report.html").read_text(), "the page tells the robot's run times")
expect(2, "check", "hall.lcm", "--gate", "kept.toml", says=["kept.toml:", "simulated time", "record a live run"], only_line=True)
pathlib.Path("empty.toml").write_text("[max]\n")
expect(2, *live, "--gate", "empty.toml", says=["empty.toml", "could not fail"], only_line=True)
# A bound that cannot be computed, one that is exceeded, a scene that refuses every scan of a log.
mine = ["--set", 'chains.mine.path=["IMU", "attitude"]', "chains.mine.max_age_ms=4"]
virtual = ["run", "--scene", "ugv_hall", "--virtual", "--seconds", "1", "--lcm-url", "none", "--quiet"]
expect(2, *virtual, *mine, says=["chains.mine.max_age_ms", "source_interval_ms is missing"], only_line=True)
result = expect(1, *virtual, *mine, "chains.mine.source_interval_ms=1")
check("FAILED  chain mine: data age up to" in result.stdout, "an exceeded bound is told", result)
result = expect(1, "replay", "hall.lcm", "--set", "limits.scan_points=16")
check("FAILED  channel SCAN: " in result.stdout, "a replay that used no scan says so", result)
wrong = expect(1, "check", "hall.lcm", "--fault", "odometry.8@1200", "--json")
where = parsed(wrong).get("divergence", {})
check((where.get("tick"), where.get("task"), where.get("field")) == (1200, "odometry", "p_world_body_m[0]"),
      f"the planted fault is located at {where}", wrong)
result = expect(1, "check", "hall.lcm", "--fault", "map@1000")
check("FAILED" in result.stdout and "task map" in result.stdout, "check names the faulty task", result)
expect(2, "check", "hall.lcm", "--fault", "nobody@1", says=["task@tick"], only_line=True)
parsed(expect(1, "diff", "hall.lcm", "hall.lcm", "--set", "map.voxel_m=0.2", "--json"))
parsed(expect(0, "diff", "hall.lcm", "hall.lcm", "--json"))
parsed(expect(0, "scenes", "--json"))
keys = parsed(expect(0, "scenes", "--keys", "ugv_hall", "--json", "--set", "limits.voxels=4096", "hil.lidar_rows=9"))["keys"]
check({"4096", "9"} <= {key["value"] for key in keys if key["key"] in ("limits.voxels", "hil.lidar_rows")}, "--keys does not show what --set says")
expect(2, "scenes", "--keys", "ugv_hall", "--set", "hil.lidar_rose=9", says=["hil.lidar_rose"], only_line=True)
pools = parsed(expect(0, "scenes", "--memory", "ugv_hall", "--json", "--set", "limits.voxels=4096"))
check(pools["bytes"] < parsed(expect(0, "scenes", "--memory", "ugv_hall", "--json"))["bytes"], "--memory does not heed --set")
expect(2, "scenes", "--memory", "ugv_hall", "--set", "limits.voxel=4096", says=["limits.voxel"], only_line=True)
expect(2, "scenes", "--cost", "imu_bench", says=["imu_bench has no simulated robot", "--log LOG"], only_line=True)
small = ["--set", "hil.lidar_rows=8", "hil.lidar_columns=64", "limits.voxels=32768"]
cost = parsed(expect(0, "scenes", "--cost", "ugv_hall", "--seconds", "1", "--runs", "1", "--json", *small))["costs"][0]
check([part["part"] for part in cost["without"] if "+" in part["part"]] == ["attitude+odometry+drive", "odometry+drive"], "what goes with a part is not what tasks say")
check(all(part["saves_bytes"] == cost["whole"]["bytes"] - part["bytes"] for part in cost["without"]), "bytes do not add up")
table = expect(0, "scenes", "--cost", "ugv_hall", "--seconds", "1", "--runs", "1", *small).stdout
check(all(str(part["bytes"]) in table for part in cost["without"] if "bytes" in part), "table and JSON of costs differ")
hall = expect(0, "scenes", "ugv_hall")
check("schedulable" in hall.stdout and "imu_to_drive" in hall.stdout, "scenes NAME shows no table", hall)
expect(0, "replay", "hall.lcm", "--out", "out")
for name in ("results.json", "report.html", "trajectory.tum", "truth.tum"):
    check(pathlib.Path("out", name).exists(), f"--out writes {name}")
# Two logs on one page, and a map that one robot hands to another.
expect(0, "run", "--scene", "ugv_rescue", "--virtual", "--seconds", "3", "--record", "ugv.lcm",
       "--set", "hil.lidar_columns=64", "--set", "tasks.ssl.units=20000")
made = expect(0, "export", "flight_map", "ugv.lcm", "--for", "uav_rescue", "-o", "uav.toml")
check("voxels are free" in made.stderr, "what the flight map holds", made)
expect(0, "run", "--scene", "uav.toml", "--virtual", "--seconds", "2", "--record", "uav.lcm")
expect(0, "report", "ugv.lcm", "uav.lcm", "--out", "both")
both = json.loads(pathlib.Path("both/results.json").read_text())["runs"]
check([r["scene"] for r in both] == ["ugv_rescue", "uav_rescue"], f"results of two logs: {both}")
check(all(r["digest"] in pathlib.Path("both/report.html").read_text() for r in both), "the page of two logs has both digests")
expect(2, "export", "flight_map", "ugv.lcm", says=["--for"], only_line=True)
expect(2, "export", "flight_map", "ugv.lcm", "--for", "uav_neo11", says=["uav_neo11", "no [flight_map]"], only_line=True)
expect(2, "export", "flight_map", "hall.lcm", "--for", "uav_rescue", says=["hall.lcm", "no occupancy map"], only_line=True)
# A map of surfaces from one run to another.
expect(0, "run", "--scene", "ugv_hall", "--virtual", "--seconds", "1", "--record", "surfels.lcm",
       "--set", "tasks.locate.enabled=true", "tasks.map.budget_us=20000", *small[1:])
expect(0, "export", "surfels", "surfels.lcm", "-o", "hall.surfels")
expect(0, "run", "--scene", "ugv_hall", "--virtual", "--seconds", "1", "--map", "hall.surfels", "--record", "on_map.lcm",
       "--set", "tasks.locate.enabled=true", "tasks.map.budget_us=20000", "locate.start_on_map=true", *small[1:])
expect(0, "check", "on_map.lcm", "--map", "hall.surfels")
expect(0, "index", "on_map.lcm", "--map", "hall.surfels", "--every", "0.5")
expect(2, "check", "on_map.lcm", says=["begins with the map hall.surfels", "--map FILE"], only_line=True)
expect(2, "replay", "on_map.lcm", "--map", "hall.lcm", says=["hall.surfels", "is another one"], only_line=True)
expect(2, "run", "--scene", "ugv_hall", "--virtual", "--map", "hall.surfels", says=["no part that uses a map of surfaces"], only_line=True)
expect(3, "run", "--scene", "ugv_locate", "--virtual", "--map", "none.surfels", says=["export surfels"], only_line=True)
expect(2, "export", "surfels", "hall.lcm", "-o", "none.surfels", says=["hall.lcm", "makes no map of surfaces"], only_line=True)
result = expect(0, "run", "--scene", "ugv_hall", "--seconds", "0.5", "--record", "live.lcm", "--no-rt", "--lcm-url", "none",
                "--json", *small)
check(parsed(result).get("counters", {}).get("heap_calls", 0) == 0, "heap calls in a live run", result)
result = expect(0, "check", "live.lcm", "--json")
check(parsed(result).get("passed") is True, "the live run's log does not check", result)

# Run-time parameters: a script in the profile, what is refused, and what `set` says when nobody is there.
def script(name, value, at=1.0):
    return ["--set", f'script=[{{at_s={at},set="{name}",value={value}}}]']


changed = parsed(expect(0, "run", "--scene", "ugv_hall", "--virtual", "--seconds", "2", "--record", "set.lcm", "--json",
                        *small, *script("odometry.scale", 1.05)))
check(changed.get("digest") != first.get("digest"), "a scripted change shows in the digest")
check(changed.get("counters", {}).get("parameters_applied") == 1, f"counters of a change: {changed.get('counters')}")
check(parsed(expect(0, "check", "set.lcm", "--json")).get("digest") == changed.get("digest"), "a log with a change checks")
result = expect(0, "export", "csv", "set.lcm", "--task", "parameters_control")
check("1.05" in result.stdout, "values in force in export csv", result)
expect(0, "replay", "set.lcm", "--set", "drive.max_speed_m_s=0.2")
quick_run = ["run", "--scene", "ugv_hall", "--virtual", "--seconds", "0.1"]
expect(2, *quick_run, *script("odometry.scal", 1), says=["script[0]", "odometry.scal", "known: "], only_line=True)
expect(2, *quick_run, *script("odometry.scale", 100), says=["outside 0.1 .. 10"], only_line=True)
expect(2, *quick_run, *script("odometry.scale", "nan"), says=["odometry.scale = nan"], only_line=True)
expect(2, *quick_run, "--set", "parameters.remot=true", says=["parameters.remote?"], only_line=True)
elsewhere = ["--lcm-url", "udpm://239.255.76.67:7699?ttl=0", "--seconds", "0.3"]
expect(2, "set", "drive.max_speed_m_s", *elsewhere, says=["NAME=NUMBER"], only_line=True)
expect(2, "set", "drive.max_speed_m_s=fast", *elsewhere, says=["NAME=NUMBER"], only_line=True)
expect(2, "set", "a=1", "--secret", "absent", *elsewhere, says=["absent", "cannot be read"], only_line=True)
pathlib.Path("open.secret").write_text("0" * 32)
pathlib.Path("open.secret").chmod(0o644)
expect(2, "set", "a=1", "--secret", "open.secret", *elsewhere, says=["chmod 600"], only_line=True)
result = run("set", *elsewhere)
check(result.returncode == 3 and len(result.stderr.splitlines()) == 1, "set without a run, or without multicast", result)

# What is not asked for as real time is a warning, what is required and refused is exit 4.
def without_room():
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (600 << 10, 600 << 10))


def without_rights():
    resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))
    resource.setrlimit(resource.RLIMIT_MEMLOCK, (0, 0))


rights = {"preexec_fn": without_rights}
if os.geteuid() == 0:
    rights.update(user=65534, group=65534, extra_groups=[])
try:
    reachable = subprocess.run(PROGRAM + ["--version"], capture_output=True, **rights).returncode == 0
except OSError:
    reachable = False
if reachable:
    quick = ["run", "--scene", "ugv_hall", "--seconds", "0.3", "--lcm-url", "none", *small]
    expect(4, *quick, "--require-rt", **rights)
    expect(0, *quick, **rights)
else:
    print("left out: exit code 4, an unprivileged user cannot start the program here")

# The doctor: a made-up board that is well, the same with one thing bad, and this one.
board = {
    "proc/version": "Linux version 6.1.0 #1 SMP PREEMPT_RT", "proc/sys/kernel/osrelease": "6.1.0",
    "proc/self/limits": "Max locked memory unlimited unlimited bytes\nMax realtime priority 99 99",
    "sys/devices/system/cpu/online": "0-1", "sys/devices/system/cpu/isolated": "1", "sys/devices/system/cpu/nohz_full": "1",
    "sys/devices/system/clocksource/clocksource0/current_clocksource": "tsc", "dev/cpu_dma_latency": "",
}
for name, content in board.items():
    path = pathlib.Path("board", name)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(content + "\n")
well = parsed(expect(0, "doctor", "--root", "board", "--core", "1", "--seconds", "0", "--json"))
check(well.get("verdict") == "good" and len(well.get("findings", [])) == 16, f"the doctor on a good board: {well}")
pathlib.Path("board/sys/devices/system/clocksource/clocksource0/current_clocksource").write_text("hpet\n")
ill = expect(1, "doctor", "--root", "board", "--core", "1", "--seconds", "0")
check(ill.stdout.startswith("bad     clock_source") and "cure: " in ill.stdout, "the doctor names the bad clock", ill)
expect(2, "doctor", "--root", "board", "--core", "2", "--seconds", "0", says=["--core 2", "cores 0-1"], only_line=True)
here = run("doctor", "--seconds", "0", "--json")
found = parsed(here)
check(here.returncode in (0, 1) and set("verdict summary machine findings".split()) <= set(found), "doctor here", here)
check(all(f["cure"] or f["verdict"] in ("good", "unknown") for f in found.get("findings", [])), "a finding without cure", here)
check(len(first.get("doctor", {}).get("findings", [])) == 16, "run --json tells of the board")

# The flight ring: left by a run that is killed, read in words, as a trace and as a plot; damaged files are told.
killed = subprocess.Popen(PROGRAM + ["run", "--scene", "ugv_hall", "--seconds", "60", "--no-rt", "--lcm-url", "none",
                                     "--flight-ring", "dead.ring", *small], stdout=subprocess.DEVNULL,
                          stderr=subprocess.DEVNULL, stdin=subprocess.DEVNULL)
for _ in range(300):
    time.sleep(0.1)
    if len(run("export", "jobs", "dead.ring", "--last", "5").stdout.splitlines()) > 8:
        break
killed.kill()
killed.wait()
result = expect(0, "export", "jobs", "dead.ring", "--last", "3")
check(" died" in result.stdout and len(result.stdout.splitlines()) > 5, "the last jobs of a killed run", result)
trace = parsed(expect(0, "export", "trace", "dead.ring"))
check(any(event.get("args", {}).get("verdict") for event in trace.get("traceEvents", [])), "the trace of a killed run")
check(expect(0, "export", "latency", "dead.ring").stdout.startswith("<svg"), "the latency plot of a killed run")
check(expect(0, "export", "latency", "live.lcm").stdout.startswith("<svg"), "the latency plot of a log")
expect(2, "export", "latency", "hall.lcm", says=["simulated time"], only_line=True)
expect(2, "export", "tum", "dead.ring", says=["is a flight ring"], only_line=True)
expect(3, "export", "jobs", "hall.lcm", says=["is no flight ring"], only_line=True)
expect(3, "export", "jobs", "absent.ring", says=["absent.ring", "No such file"], only_line=True)
ring = pathlib.Path("dead.ring").read_bytes()
pathlib.Path("cut.ring").write_bytes(ring[:len(ring) // 2])
expect(3, "export", "jobs", "cut.ring", says=["cut.ring", str(len(ring) // 2), str(len(ring))], only_line=True)
pathlib.Path("bad.ring").write_bytes(ring[:100] + b"\xff" + ring[101:])
expect(3, "export", "trace", "bad.ring", says=["bad.ring", "damaged"], only_line=True)
again = ["run", "--scene", "ugv_hall", "--seconds", "0.2", "--no-rt", "--lcm-url", "none", *small, "--flight-ring"]
result = expect(0, *again, "dead.ring", "--json")
check(pathlib.Path("dead.ring.previous").exists(), "the ring of the killed run is kept", result)
expect(3, *again, "text.lcm", says=["text.lcm", "no flight ring"], only_line=True)
expect(0, *again, "none")
check(pathlib.Path("text.lcm").read_text().startswith("a shopping"), "a file that is no ring stays as it is")

# Keyframes: the end of the log from any place in it, and everything that is no keyframe of it refused.
expect(3, "check", "hall.lcm", "--from", "1", "--keyframes", "text.lcm", says=["text.lcm", "sortie index"], only_line=True)
result = parsed(expect(0, "index", "hall.lcm", "--every", "0.25", "--json"))
check(len(result.get("keyframes", [])) == 7 and pathlib.Path("hall.lcm.keyframes").exists(), f"index: {result}")
listed = parsed(expect(0, "index", "hall.lcm", "--list", "--json"))
check(listed.get("keyframes") == result.get("keyframes"), f"index --list: {listed}")
for extra in ([], ["--threads"]):
    part = parsed(expect(0, "check", "hall.lcm", "--from", "1.6", "--json", *extra))
    check(part.get("digest") == first.get("digest") and part.get("passed") is True, f"check --from {extra}: {part}")
part = parsed(expect(0, "check", "hall.lcm", "--from", "@600", "--to", "0.9", "--json"))
check(part.get("ticks") == 300 and part.get("passed") is True, f"check --from --to: {part}")
check(part.get("compared_jobs") == 404 and part.get("counters", {}).get("jobs") == 909, f"jobs of check --from --to: {part}")
for line, part in (("404 jobs in 400 ticks (500 to 899)", ["--from", "@600", "--to", "0.9"]), ("2020 jobs in 2000 ticks", [])):
    result = expect(0, "check", "hall.lcm", *part)
    check(result.stdout.startswith(f"passed  {line} give digest"), "check says what it has compared", result)
wrong = expect(1, "check", "hall.lcm", "--from", "1", "--fault", "odometry.8@1200", "--json")
where = parsed(wrong).get("divergence", {})
check((where.get("tick"), where.get("task"), where.get("field")) == (1200, "odometry", "p_world_body_m[0]"),
      f"the planted fault behind a keyframe is located at {where}", wrong)
expect(2, "check", "hall.lcm", "--from", "1", "--fault", "odometry@200", says=["before tick 1000"], only_line=True)
expect(2, "replay", "hall.lcm", "--from", "noon", says=["--from noon", "12.5", "@12500"], only_line=True)
expect(2, "replay", "hall.lcm", "--from", "7", says=["nothing lies between"], only_line=True)
expect(2, "replay", "hall.lcm", "--from", "1", "--set", "map.voxel_m=0.2", says=["another profile", "sortie index"],
       only_line=True)
expect(2, "index", "hall.lcm", "--every", "0")
expect(3, "index", "absent.lcm", says=["absent.lcm"], only_line=True)
expect(3, "index", "hall.lcm", "-o", "no/such/folder/x", says=["no/such/folder"], only_line=True)
check(not list(pathlib.Path(".").glob("*.part")), "index leaves nothing half written")
hurt = bytearray(pathlib.Path("hall.lcm.keyframes").read_bytes())
hurt[len(hurt) // 2] ^= 1
pathlib.Path("hurt.keyframes").write_bytes(hurt)
expect(3, "index", "hall.lcm", "--list", "-o", "hurt.keyframes", says=["hurt.keyframes", "damaged", "sortie index"],
       only_line=True)

# A disk that is full: the run ends well and says what its log lacks, and the log says it, too.
full = ["run", "--scene", "ugv_hall", "--virtual", "--seconds", "2", "--record", "disk/full.lcm", "--lcm-url", "none", *small]
pathlib.Path("disk").mkdir()
mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=600k", "tmpfs", "disk"], capture_output=True).returncode == 0
result = expect(0, *full) if mounted else expect(0, *full, preexec_fn=without_room)
check("writing failed" in result.stdout + result.stderr, "a full disk is told", result)
result = expect(0, "check", "disk/full.lcm", says=["GAP from tick", "disk was full"])
check("passed" in result.stdout, "the good part of a log that filled the disk", result)
if mounted:
    subprocess.run(["umount", "disk"])
else:
    print("left out: a full tmpfs, no right to mount; a limit on the file's size stood for it")

# A log that is cut off: the good part is used, the byte is named, and it is exit 3 unless that is accepted.
whole = pathlib.Path("hall.lcm").read_bytes()
pathlib.Path("cut.lcm").write_bytes(whole[:len(whole) * 2 // 3 + 1])
for command in ("replay", "check"):
    result = expect(3, command, "cut.lcm", "--json", says=["cut.lcm", "byte ", "--accept-damage"])
    part = parsed(result)
    check(0 < part.get("ticks", 0) < first.get("ticks", 0), f"{command} uses the good part of a cut log", result)
    expect(0, command, "cut.lcm", "--accept-damage")
expect(1, "check", "cut.lcm", "--accept-damage", "--fault", "odometry@500")

# The worst case in instructions, where valgrind is: exact, so a second count agrees; a loop in one job does not.
expect(2, "bench", "wcet")
expect(2, "bench", "hall.lcm")
result = run("bench", "wcet", "hall.lcm", "--json", "--out", "count")
if len(PROGRAM) > 1:
    print("left out: counting instructions under an emulator")
elif result.returncode == 0:
    tasks = {task["name"]: task for task in parsed(result).get("tasks", [])}
    check(tasks.get("odometry", {}).get("jobs") == 2000 and tasks["odometry"]["median"] > 100, "counted jobs", result)
    expect(3, "bench", "wcet", "absent.lcm", says=["absent.lcm"])
    expect(0, "bench", "wcet", "hall.lcm", "--expect", "count/wcet.txt")
    expect(1, "bench", "wcet", "hall.lcm", "--expect", "count/wcet.txt", "--fault", "map@100", says=["task map", "total"])
    expect(2, "bench", "wcet", "hall.lcm", "--fault", "nobody@1", says=["task@tick"])
    expect(2, "bench", "wcet", "hall.lcm", "--fault", "map@101", says=["no job at that tick"])
    pathlib.Path("other.txt").write_text(pathlib.Path("count/wcet.txt").read_text().replace("built by", "built by an old"))
    expect(0, "bench", "wcet", "hall.lcm", "--expect", "other.txt", says=["skipped", "an old"])
    expect(3, "bench", "wcet", "hall.lcm", "--expect", "text.lcm", says=["text.lcm:1"])
else:
    check(result.returncode == 4 and ("valgrind" in result.stderr or "sanitizer" in result.stderr), "bench wcet says what is missing", result)
    print("left out: counting instructions:", result.stderr.strip())

# The real-time benchmark is a program of its own: without it the cure is named.
expect(4, "bench", "rt", "--program", "absent/sortie-bench-rt", says=["is not built", "cmake --build"], only_line=True)
expect(2, "bench", "rt", "--only", "nothing")
result = run("bench", "rt", "--only", "executive", "--rounds", "1", "--slice", "0.05", "--json", "--out", "rt")
if len(PROGRAM) > 1:
    print("left out: the real-time benchmark under an emulator")
elif result.returncode == 0:
    figures = parsed(result).get("figures", [])
    check(len(figures) >= 4 and all(figure["ours"]["value"] >= 0 for figure in figures), "figures of bench rt", result)
    check("## executive" in pathlib.Path("rt/bench-rt.md").read_text(), "bench rt --out writes a page", result)
else:
    check(result.returncode == 4 and "is not built" in result.stderr, "bench rt says what is missing", result)
    print("left out: the real-time benchmark is not built")

expect(4, "bench", "rays", "--program", "absent/sortie-bench-rays", says=["is not built", "cmake --build"], only_line=True)
expect(2, "bench", "rays", "--only", "nothing")
expect(4, "bench", "uav", "--program", "absent/sortie-bench-uav", says=["is not built", "cmake --build"], only_line=True)
expect(2, "bench", "uav", "--only", "nothing")
expect(4, "bench", "ground-path", "--program", "absent/sortie-bench-ground-path", says=["is not built", "cmake --build"], only_line=True)
expect(2, "bench", "ground-path", "--only", "nothing")
result = run("bench", "uav", "--only", "plant", "--json", "--out", "uav")
if len(PROGRAM) > 1:
    print("left out: the flight benchmark under an emulator")
elif result.returncode == 0:
    answer = parsed(result)
    check(all(figure["met"] for figure in answer.get("figures", [])) and answer.get("figures"), "the multirotor's plant is as exact as it must be", result)
    check("bench-uav-steps.svg" in pathlib.Path("uav/bench-uav.md").read_text(), "bench uav --out writes a page", result)
    check("<svg" in pathlib.Path("uav/bench-uav-steps.svg").read_text(), "bench uav --out draws", result)
else:
    check(result.returncode == 4 and "is not built" in result.stderr, "bench uav says what is missing", result)
    print("left out: the flight benchmark is not built")
# So is the plant's. Its drives are the same at each run, their times are not: nothing here looks at those.
expect(4, "bench", "plant", "--program", "absent/sortie-bench-plant", says=["is not built", "cmake --build"], only_line=True)
expect(2, "bench", "plant", "--only", "nothing")
expect(2, "bench", "plant", "--scene", "nowhere")
result = run("bench", "plant", "--only", "metrics", "--scene", "straight", "--json", "--out", "plant")
if len(PROGRAM) > 1:
    print("left out: the plant's benchmark under an emulator")
elif result.returncode == 0:
    answer = parsed(result)
    check(all(figure["met"] for figure in answer.get("figures", [])) and answer.get("figures"), "a straight drive ends where it must", result)
    engines = [row[2] for table in answer.get("tables", []) for row in table["rows"]]
    check("ours" in engines and ("ODE QuickStep" in engines or answer["skipped"]), "bench plant names a peer that is missing", result)
    check("| straight |" in pathlib.Path("plant/bench-plant.md").read_text(), "bench plant --out writes a page", result)
    result = expect(0, "bench", "plant", "--only", "pictures", "--scene", "pallet", "--out", "plant")
    check("<svg" in pathlib.Path("plant/bench-plant-pallet.svg").read_text(), "bench plant --out draws a side view", result)
else:
    check(result.returncode == 4 and "is not built" in result.stderr, "bench plant says what is missing", result)
    print("left out: the plant's benchmark is not built")

# The stiff and extreme cases: exact at each run.
expect(4, "bench", "stability", "--program", "absent/sortie-bench-stability", says=["is not built", "cmake --build"], only_line=True)
expect(2, "bench", "stability", "--only", "nothing")
result = run("bench", "stability", "--only", "planner", "--json", "--out", "stability")
if len(PROGRAM) > 1:
    print("left out: the stability benchmark under an emulator")
elif result.returncode == 0:
    answer = parsed(result)
    figures = answer.get("figures", [])
    check(figures and all(figure["met"] and figure["group"] == "planner" for figure in figures), "every bound of the planner lies between ours and the naive method", result)
    check(answer.get("summary", {}).get("cases") == len(figures), "bench stability counts its cases", result)
    check("| ties between rays |" in pathlib.Path("stability/bench-stability.md").read_text(), "bench stability --out writes a page", result)
else:
    check(result.returncode == 4 and "is not built" in result.stderr, "bench stability says what is missing", result)
    print("left out: the stability benchmark is not built")

# The random campaign: a seed repeats itself, a sequence from a file is run again.
expect(4, "bench", "campaign", "--program", "absent/sortie-bench-campaign", says=["is not built", "cmake --build"], only_line=True)
expect(2, "bench", "campaign", "--count", "0")
result = run("bench", "campaign", "--only", "stamps", "--seed", "5", "--count", "20", "--json", "--out", "campaign")
if len(PROGRAM) > 1:
    print("left out: the random campaign under an emulator")
elif result.returncode == 0:
    first = parsed(result)["figures"][0]
    check(first["accepted"] + first["refused"] == first["given"] > 0, "bench campaign counts its inputs", result)
    check("| rt stamps |" in pathlib.Path("campaign/bench-campaign.md").read_text(), "bench campaign --out writes a page", result)
    again = run("bench", "campaign", "--only", "stamps", "--seed", "5", "--count", "20", "--json")
    check(parsed(again)["figures"][0]["digest"] == first["digest"], "bench campaign repeats a seed", again)
    pathlib.Path("sequence.txt").write_text("module stamps\nop 0 1000000 0 0 0 0 0 0 0\n")
    again = run("bench", "campaign", "--replay", "sequence.txt", "--json")
    check(parsed(again)["figures"][0]["given"] == 1, "bench campaign --replay runs a sequence", again)
else:
    check(result.returncode == 4 and "is not built" in result.stderr, "bench campaign says what is missing", result)
    print("left out: the random campaign is not built")

# Imports.
expect(2, "import", "sheep", "x", "-o", "x.lcm")
expect(3, "import", "husky", "absent", "-o", "x.lcm", says=["absent"], only_line=True)
expect(3, "import", "rls", "text.lcm", "-o", "x.lcm", says=["text.lcm"], only_line=True)
expect(3, "import", "broad", "text.lcm", "-o", "x.lcm", says=["text.lcm"], only_line=True)
expect(3, "import", "carmen", "text.lcm", "-o", "x.lcm", says=["text.lcm", "no CARMEN log"], only_line=True)
expect(3, "import", "swp", "text.lcm", "-o", "x.lcm", says=["text.lcm", "SWP1"], only_line=True)
expect(2, "import", "husky", "absent", "-o", "x.lcm", "--no-poses", says=["--no-poses is for kind rls"], only_line=True)
expect(2, "import", "carmen", "absent", "-o", "x.lcm", "--max-range", "-1", says=["--max-range"], only_line=True)
check(not pathlib.Path("x.lcm").exists(), "a failed import leaves no log")
husky = DATA / "husky_skid"
if husky.is_dir():
    shutil.copytree(husky, "husky")
    imu = pathlib.Path("husky/husky_a_imu.csv")
    imu.chmod(0o644)
    rows = imu.read_text().splitlines()

    def spoil(share):
        spoiled = list(rows)
        for i in range(1, len(rows)):
            if (i * 7919) % 1000 < share * 1000:
                fields = rows[i].split(",")
                fields[3] = "nan"
                spoiled[i] = ",".join(fields)
        imu.write_text("\n".join(spoiled) + "\n")

    counted = parsed(expect(0, "import", "husky", husky, "-o", "clean.lcm", "--json"))
    fields = rows[41].split(",")
    fields[3] = "nan"
    imu.write_text("\n".join(rows[:41] + [",".join(fields)] + rows[42:]) + "\n")
    result = expect(0, "import", "husky", "husky", "-o", "husky.lcm", "--json", says=["husky_a_imu.csv:42"])
    spoiled = parsed(result)
    check(spoiled.get("bad_rows") == counted.get("bad_rows", 0) + 1, "the NaN row is counted", result)
    check(spoiled.get("imu") == counted.get("imu", 0) - 1, "the NaN row is dropped", result)
    result = parsed(expect(0, "replay", "husky.lcm", "--scene", "skid_outdoor", "--align", "se2", "--json"))
    check(result.get("errors", {}).get("ate_rmse_m", 99) <= 3.3, f"errors with one bad row: {result.get('errors')}")
    check(result.get("speed", 0) > 0, "speed of the replay")
    expect(3, "import", "husky", "husky", "-o", "x.lcm", "--strict", says=["husky_a_imu.csv:42"])
    spoil(0.1)
    expect(0, "import", "husky", "husky", "-o", "husky.lcm")
    spoil(0.3)
    expect(3, "import", "husky", "husky", "-o", "x.lcm")
    expect(2, "replay", "husky.lcm", says=["--scene"], only_line=True)
    expect(2, "check", "husky.lcm", says=["husky.lcm", "--gate"], only_line=True)
else:
    print(f"left out: bad rows of real data, no {husky}")

walk = DATA / "lidar_os64" / "os64_thin4_000_109.rls"
if walk.exists():
    expect(0, "import", "rls", walk, "-o", "walk.lcm")
    refused = expect(1, "replay", "walk.lcm", "--scene", "ugv_hall")
    check("110 of 110 samples were refused by scene ugv_hall" in refused.stdout, "the wrong scene for a walk is told", refused)
    expect(1, "replay", "walk.lcm", "--scene", "imu_bench")
    expect(0, "replay", "walk.lcm", "--scene", "imu_bench", "--accept-unused")
    expect(0, "replay", "walk.lcm", "--scene", "building_walk")
else:
    print(f"left out: the wrong scene for a walk, no {walk}")

shutil.rmtree(work, ignore_errors=True)
print(f"{checks - len(failures)} of {checks} checks passed")
sys.exit(1 if failures else 0)
