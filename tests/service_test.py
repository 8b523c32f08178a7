#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# A run under a supervisor: what it tells it, what its flight ring tells after it died, and that the next start stands
# still until it is released; and that systemd takes the unit. Usage: service_test.py death|unit SERVICE_FOLDER PROGRAM
import json
import os
import pathlib
import re
import shlex
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

PART, FOLDER, PROGRAM = sys.argv[1], pathlib.Path(sys.argv[2]), os.path.abspath(sys.argv[3])
UNIT = (FOLDER / "sortie@.service").read_text()
work = pathlib.Path(tempfile.mkdtemp(prefix="sortie-service-"))
os.chdir(work)
failures = []
checks = 0


def check(good, what, *shown):
    global checks
    checks += 1
    if not good:
        failures.append(what)
        print("FAILED", what, *shown)


# What the unit starts with, so that the test is of the unit and not of a copy of its options.
DISARMED = shlex.split(re.search(r'^Environment="SORTIE_DISARMED=(.*)"$', UNIT, re.M).group(1))
# Drives from the start, as it would before somebody thought of a death.
DRIVES = ["--scene", "ugv_hall", "--set", "mission.start_s=0", "--set", "limits.voxels=1024",
          "--set", "mission.commands=[{at_s=0.0,speed_m_s=0.3},{at_s=50.0}]"]
LIVE = ["run", *DRIVES, "--seconds", "60", "--no-rt", "--lcm-url", "none", "--flight-ring", "robot.ring"]


def sortie(*arguments):
    return subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, timeout=120, stdin=subprocess.DEVNULL)


def wait_for_jobs(process):
    """Until the ring is of this process, not of the one that died before, and holds some jobs."""
    for _ in range(300):
        time.sleep(0.1)
        lines = sortie("export", "jobs", "robot.ring", "--last", "5").stdout.splitlines()
        if process.poll() is not None or (len(lines) > 8 and f"process {process.pid} still runs" in lines[1]):
            return


def start(*more, environment=None):
    return subprocess.Popen([PROGRAM, *LIVE, *more], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                            stderr=subprocess.PIPE, text=True, env={**os.environ, **(environment or {})})


def ending(path):
    result = sortie("export", "jobs", path, "--last", "1")
    check(result.returncode == 0, f"{path} is read", result.stderr)
    return next((line for line in result.stdout.splitlines() if line.startswith("ended")), "")


def deaths():
    # Each death in turn; each start after it tells of the one before.
    told = ""
    for number, says in ((signal.SIGKILL, "died without a signal that can be caught"),
                         (signal.SIGSEGV, "died of SIGSEGV, sent by another process, at "),
                         (signal.SIGABRT, "died of SIGABRT, sent by another process, at ")):
        process = start()
        wait_for_jobs(process)
        process.send_signal(number)
        stderr = process.communicate(timeout=60)[1]
        check(process.returncode == -number, f"{number.name} ends it as ever", process.returncode)
        line = ending("robot.ring")
        check(says in line, f"the ring after {number.name}", line)
        tick = re.search(r"; last tick (\d+); (no task was running|running was )", line)
        check(tick is not None and int(tick.group(1)) > 0, "the ring tells the last tick and the running task", line)
        check(told in stderr and (not told or "an earlier run did not end by itself" in stderr),
              f"the start before {number.name} tells of the death before it", told, stderr[:500])
        told = says


def next_start():
    # The ring of the last death is still there. Virtual time: what it does is the same on every machine.
    def moved(*more):
        result = sortie("run", *DRIVES, "--virtual", "--seconds", "3", "--record", "run.lcm", "--lcm-url", "none", "--json", *more)
        check(result.returncode == 0, f"it starts with {more}", result.stderr[:500])
        poses = [[float(x) for x in line.split()] for line in sortie("export", "tum", "run.lcm").stdout.splitlines()
                 if line and not line.startswith("#")]
        check(len(poses) > 100, "poses", len(poses))
        far = max((((p[1] - poses[0][1]) ** 2 + (p[2] - poses[0][2]) ** 2) ** 0.5 for p in poses), default=0.0)
        return far, json.loads(result.stdout)["counters"]

    far, _ = moved()
    check(far > 0.3, "without the unit's options this mission drives", far)
    far, counters = moved(*DISARMED)
    check(far < 0.02 and counters["drive_stops_halt"] == 1, "with them it stands in a halt", far, counters["drive_stops_halt"])
    result = sortie("run", "--scene", "ugv_hall", "--set", "drive.start_halted=true", "--virtual", "--seconds", "0.1")
    check(result.returncode == 2 and "start_halted" in result.stderr, "a halt that nobody could end is refused", result.stderr)


def supervised():
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as supervisor:
        supervisor.bind(str(work / "notify"))
        supervisor.settimeout(30)
        process = start(environment={"NOTIFY_SOCKET": str(work / "notify"), "WATCHDOG_USEC": "400000"})
        check(supervisor.recv(100) == b"READY=1", "it says that it is ready")
        # What is to be seen is that it keeps on saying so, and not while it is stopped.
        check([supervisor.recv(100) for _ in range(4)] == [b"WATCHDOG=1"] * 4, "it says that it lives")
        process.send_signal(signal.SIGSTOP)
        time.sleep(0.2)
        supervisor.setblocking(False)
        try:
            while True:
                supervisor.recv(100)
        except BlockingIOError:
            pass
        time.sleep(0.6)
        try:
            check(False, "a process that does not run says that it lives", supervisor.recv(100))
        except BlockingIOError:
            check(True, "silence")
        process.send_signal(signal.SIGCONT)
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=60)
        supervisor.settimeout(1)
        rest = b""
        try:
            while b"STOPPING=1" not in rest:
                rest = supervisor.recv(100)
        except (TimeoutError, BlockingIOError):
            pass
        check(rest == b"STOPPING=1", "it says that it ends", rest)
        check(process.returncode == 0, "SIGTERM is a good end, which no supervisor restarts", process.returncode)
    check("ended by itself" in ending("robot.ring"), "the ring of a run that was told to end")


def unit():
    if shutil.which("systemd-analyze") is None:
        print("skipped: no systemd-analyze; install systemd")
        sys.exit(77)
    for key in ("Restart=on-failure", "WatchdogSec=", "CPUAffinity=", "LimitRTPRIO=", "LimitMEMLOCK=infinity", "--require-rt"):
        check(key in UNIT, f"the unit has {key}")

    def problems(text):
        (work / "sortie@.service").write_text(text)
        result = subprocess.run(["systemd-analyze", "verify", "--man=no", "--recursive-errors=no", str(work / "sortie@hall.service")],
                                capture_output=True, text=True, timeout=100)
        return result.returncode, [line for line in result.stderr.splitlines() if "sortie@" in line or "hall" in line]

    here = UNIT.replace("ExecStart=sortie ", f"ExecStart={PROGRAM} ")
    (work / "sortie@hall.service").symlink_to(work / "sortie@.service")
    code, lines = problems(here)
    check(code == 0 and not lines, "systemd takes the unit", code, lines)
    # A check that cannot fail is none.
    code, lines = problems(here.replace("WatchdogSec=2s", "WatchdogSec=soon").replace("ExecStart=", "ExecStart=/nowhere"))
    check(any("WatchdogSec" in line or "soon" in line for line in lines), "systemd sees a value that cannot be", code, lines)


if PART == "unit":
    unit()
else:
    deaths()
    next_start()
    supervised()
shutil.rmtree(work, ignore_errors=True)
print(f"{checks} checks, {len(failures)} failed")
sys.exit(1 if failures else 0)
