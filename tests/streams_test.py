#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Every command with a standard output that is full or closed, and with the signals that a terminal sends when it goes.
# Usage: streams_test.py DATA_DIR PROGRAM
import json
import os
import pathlib
import re
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import time

DATA, PROGRAM = pathlib.Path(sys.argv[1]), os.path.abspath(sys.argv[2])
work = pathlib.Path(tempfile.mkdtemp(prefix="sortie-streams-"))
os.chdir(work)
failures = []
checks = 0
LOST = "standard output: cannot be written"
SMALL = ["--set", "limits.voxels=1024"]
LIVE = ["run", "--scene", "ugv_circle", "--no-rt", "--quiet", *SMALL]
URL = "udpm://239.255.76.67:7698?ttl=0"


def check(good, what, result=None):
    global checks
    checks += 1
    if good:
        return
    failures.append(what)
    print("FAILED", what)
    if result is not None:
        print("  exit", result.returncode, "\n  stdout:", (result.stdout or "")[:300], "\n  stderr:", (result.stderr or "")[:900])


def run(*arguments, out=subprocess.PIPE, **options):
    return subprocess.run([PROGRAM, *map(str, arguments)], stdout=out, stderr=subprocess.PIPE, text=True, timeout=300,
                          stdin=subprocess.DEVNULL, **options)


def closed_reader():
    """The writing end of a pipe that nobody reads."""
    reading, writing = os.pipe()
    os.close(reading)
    return writing


def start(*arguments, **options):
    return subprocess.Popen([PROGRAM, *map(str, arguments)], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                            stderr=subprocess.PIPE, text=True, **options)


def until(true, seconds=60):
    end = time.monotonic() + seconds
    while not true() and time.monotonic() < end:
        time.sleep(0.02)


def names_in(help_text):
    return re.findall(r"^  ([a-z]+) ", help_text.split("Subcommands:")[-1].split("\n\n")[0], re.M) if "Subcommands:" in help_text else []


def words_are_lost(what, *arguments):
    """What prints in the good case fails with 3 and one line where nobody takes it; the rest is as ever."""
    good = run(*arguments)
    if not good.stdout:
        return False
    with open("/dev/full", "w") as full:
        results = {"full": run(*arguments, out=full),
                   "closed": run(*arguments, out=None, preexec_fn=lambda: os.close(1)),
                   "left": run(*arguments, out=closed_reader())}
    for how, result in results.items():
        lines = [line for line in result.stderr.splitlines() if LOST in line]
        check(result.returncode == 3 and len(lines) == 1, f"{what}: standard output {how}", result)
    return True


# A log to work on, by a run whose own words are lost: the log is whole all the same, and holds none of them.
result = run("run", "--scene", "ugv_hall", "--virtual", "--seconds", "0.3", *SMALL, "--record", "a.lcm", "--lcm-url", "none",
             "--out", "out", out=None, preexec_fn=lambda: (os.close(0), os.close(1)))
check(result.returncode == 3 and LOST in result.stderr and pathlib.Path("out/report.html").exists(), "run with 0 and 1 closed", result)
check(run("check", "a.lcm").returncode == 0, "the log of a run with a closed standard output")
check(run("run", "--scene", "nowhere", out=closed_reader()).returncode == 2, "a usage error stays one")
check(run("index", "a.lcm", "-o", "a.keyframes").returncode == 0, "index")
result = run("export", "tum", "a.lcm", "-o", "a.tum", out=None, preexec_fn=lambda: os.close(1))
check(result.returncode == 0 and pathlib.Path("a.tum").stat().st_size > 0, "export to a file needs no standard output", result)
result = subprocess.run([PROGRAM, "doctor", "--seconds", "0"], stdout=subprocess.PIPE, preexec_fn=lambda: os.close(2))
check(result.returncode in (0, 1) and result.stdout, "a closed standard error is nobody's fault")

# A run that the commands for live ones can talk to, where this machine lets datagrams through.
live = start(*LIVE, "--seconds", "300", "--set", "drive.remote=true", "--set", "parameters.without_secret=true",
             "--lcm-url", URL)
until(lambda: live.poll() is not None or run("set", "--lcm-url", URL, "--seconds", "1").returncode == 0, 30)
to_live = ["--lcm-url", URL, "--seconds", "3"]
quick = {
    "run": ["--scene", "ugv_hall", "--virtual", "--seconds", "0.1", *SMALL, "--lcm-url", "none"],
    "plant": ["--scene", "ugv_hall", "--seconds", "0.1", "--port", "23450"],
    "replay": ["a.lcm"], "check": ["a.lcm"], "diff": ["a.lcm", "a.lcm"], "index": ["a.lcm", "--list", "-o", "a.keyframes"],
    "import": ["husky", DATA / "husky_skid", "-o", "husky.lcm"], "export": ["tum", "a.lcm"], "report": ["a.lcm", "--out", "page"],
    "bench": ["a.lcm", "--sweep", "map.voxel_m=0.2", "--jobs", "1", "--out", "cells"], "merge": ["cells"],
    "spy": ["--lcm-url", URL, "--seconds", "0.2"], "set": to_live, "drive": ["halt", *to_live], "fly": ["hover", *to_live],
    "scenes": [], "doctor": ["--seconds", "0"],
    "bench rt": ["--only", "executive", "--rounds", "1", "--slice", "0.05"], "bench plant": ["--only", "metrics", "--scene", "straight"],
    "bench rays": ["--only", "nothing"], "bench mapping": ["--only", "nothing"],
    "bench registration": ["--only", "nothing"], "bench recognition": ["--only", "streets", "--cases", "1"], "bench uav": ["--only", "plant"],
    "bench elevation": ["--only", "scan", "--way", "1"],
    "bench posture": ["--only", "bounds", "--cases", "1"],
    "bench courses": ["--only", "tuning", "--cases", "1", "--family", "gap"],
    "bench flippers": ["--only", "search", "--cases", "5"],
    "bench ground-path": ["--only", "budget", "--maps", "1"],
    "bench odometry": ["--scene", "ugv_ramp", "--rounds", "1"], "bench stability": ["--only", "planner"],
    "bench campaign": ["--only", "stamps", "--seed", "5", "--count", "20"], "bench wcet": ["a.lcm"], "bench all": ["--only", "nothing"],
}
NEEDS_MORE = {"fly": "a robot that flies", "bench rays": "minutes", "bench mapping": "minutes", "bench registration": "minutes", "bench all": "an hour"}
commands = names_in(run("--help").stdout)
commands += ["bench " + name for name in names_in(run("bench", "--help").stdout)]
check(len(commands) >= 17, f"commands in the help: {commands}")
for command in commands:
    check(words_are_lost(command + " --help", *command.split(), "--help"), f"{command} --help prints nothing")
    check(command in quick, f"{command} is not in the list of this test")
    if not words_are_lost(command, *command.split(), *quick.get(command, [])):
        print(f"left out: {command} prints nothing here ({NEEDS_MORE.get(command, 'not built, or no multicast')}); its help stands for it")
for option in ("--help", "--help-all", "--version"):
    check(words_are_lost(option, option), f"{option} prints nothing")

# The signals of a terminal that goes. Whoever drives by hand is gone with it: the robot stops.
if live.poll() is None and run("set", *to_live).returncode == 0:
    released = run("drive", "release", *to_live)  # the list above has halted it
    check(released.returncode == 0, "drive release", released)
    for number in (signal.SIGHUP, signal.SIGTERM):
        driver = start("drive", "go", "--speed", "0.1", "--for", "0", "--lcm-url", URL)
        taken = select.select([driver.stdout], [], [], 20)[0]
        check(taken, "drive go says that it was taken while it drives")
        driver.send_signal(number)
        words = driver.communicate(timeout=60)
        check(driver.returncode == 0 and "0.00 m/s" in words[0], f"drive go, {number.name}: {driver.returncode} {words}")
else:
    print("left out: drive go, no multicast here")
live.send_signal(signal.SIGHUP)
words = live.communicate(timeout=60)
check(live.returncode == 0 and "digest" in words[0], f"run, SIGHUP: {live.returncode} {words}")
spy = start("spy", "--lcm-url", URL)
time.sleep(0.5)
spy.send_signal(signal.SIGHUP)
check(spy.wait(60) in (0, 3), "spy, SIGHUP")  # 3 where there is no multicast
plant = start("plant", "--scene", "ugv_hall", "--port", "23450", "--record", "truth.lcm")
until(lambda: pathlib.Path("truth.lcm").exists())
plant.send_signal(signal.SIGHUP)
words = plant.communicate(timeout=60)
check(plant.returncode == 0 and words[0].startswith("plant"), f"plant, SIGHUP: {plant.returncode} {words}")

run_with = [*LIVE, "--lcm-url", "none", "--record", "b.lcm", "--flight-ring", "b.ring", "--seconds"]
for number in (signal.SIGHUP, signal.SIGTERM, signal.SIGINT):
    pathlib.Path("b.lcm").unlink(missing_ok=True)
    process = start(*run_with, "60")
    until(lambda: pathlib.Path("b.lcm").exists())
    process.send_signal(number)
    words = process.communicate(timeout=60)
    check(process.returncode == 0 and "log: b.lcm" in words[1], f"run, {number.name}: {process.returncode} {words}")
    check("did not end by itself" not in words[1], f"after {number.name} the next run finds no death: {words[1]}")
    check("the run ended by itself" in run("export", "jobs", "b.ring").stdout, f"the ring after {number.name}")
    check(run("check", "b.lcm").returncode == 0, f"the log after {number.name}")
# What nobody reads any more, and a PIPE that is sent, are nothing; so is HUP under nohup.
for number, options in ((signal.SIGPIPE, {}), (signal.SIGHUP, {"preexec_fn": lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN)})):
    pathlib.Path("b.lcm").unlink(missing_ok=True)
    process = start(*run_with, "0.5", "--json", restore_signals=True, **options)
    process.stderr.close()
    until(lambda: pathlib.Path("b.lcm").exists())
    process.send_signal(number)
    words = process.stdout.read()
    check(process.wait(60) == 0 and json.loads(words)["ticks"] == 500, f"run, {number.name} is nothing: {process.returncode}")
shutil.rmtree(work, ignore_errors=True)
print(f"{checks - len(failures)} of {checks} checks passed")
sys.exit(1 if failures else 0)
