#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# A plant and a runtime as two processes: a drive, its replay, its errors against the plant's own log, and what happens when
# either is killed. Usage: plant_test.py PROGRAM [ARGUMENT...] (an emulator may stand before the program).
#
# What must hold on any machine, however busy, is checked always. What needs the machine to be there is gathered beside a
# witness that measures whether it was, and gathered again if not.
import json
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time

PROGRAM = sys.argv[1:]
work = pathlib.Path(tempfile.mkdtemp(prefix="sortie-plant-"))
os.chdir(work)
failures = []
checks = 0
SCENE = ["--scene", "ugv_pallet", "--set", "hil.lidar_rows=4", "--set", "hil.lidar_columns=90"]
# Drives at once, over the pallet.
MISSION = ["--set", 'mission.commands=[{at_s=0.3,posture="climb"},{at_s=0.5,speed_m_s=0.3},{at_s=100.0}]']


def check(good, what, *shown):
    global checks
    checks += 1
    if not good:
        failures.append(what)
        print("FAILED", what, *shown)


class Witness:
    """The longest time that this process was away, measured by a thread that sleeps a millisecond at a time."""

    def __enter__(self):
        self.longest_s, self.ended = 0.0, False
        self.thread = threading.Thread(target=self.watch)
        self.thread.start()
        return self

    def watch(self):
        before = time.monotonic()
        while not self.ended:
            time.sleep(0.001)
            now = time.monotonic()
            self.longest_s, before = max(self.longest_s, now - before), now

    def __exit__(self, *_):
        self.ended = True
        self.thread.join()


def two_free_ports():
    for _ in range(100):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as first, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as second:
            first.bind(("127.0.0.1", 0))
            try:
                second.bind(("127.0.0.1", first.getsockname()[1] + 1))
            except OSError:
                continue
            return first.getsockname()[1]
    sys.exit("no two free ports side by side")


class Child:
    """A command of the program; its stderr is read line by line as it comes."""

    def __init__(self, *arguments):
        self.process = subprocess.Popen(PROGRAM + [str(a) for a in arguments], stdin=subprocess.DEVNULL, text=True,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.lines = []
        self.reader = threading.Thread(target=lambda: self.lines.extend(iter(self.process.stderr.readline, "")))
        self.reader.start()

    def wait_for(self, text, seconds=60):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if any(text in line for line in list(self.lines)):
                return True
            if self.process.poll() is not None and not self.reader.is_alive():
                break
            time.sleep(0.02)
        return any(text in line for line in self.lines)

    def end(self, sign=None):
        if sign is not None and self.process.poll() is None:
            self.process.send_signal(sign)
        output = self.process.stdout.read()
        self.code = self.process.wait(timeout=120)
        self.reader.join()
        try:
            return json.loads(output)
        except ValueError:
            return {}


def call(*arguments, code=0):
    result = subprocess.run(PROGRAM + [str(a) for a in arguments], capture_output=True, text=True, timeout=300,
                            stdin=subprocess.DEVNULL)
    check(result.returncode == code, f"sortie {' '.join(map(str, arguments))}: exit {result.returncode}", result.stderr[:800])
    return result


def answer(*arguments):
    try:
        return json.loads(call(*arguments, "--json").stdout)
    except ValueError:
        return {}


def poses(log):
    """Truth of a plant's log: (time in s, x, y, z)."""
    return [tuple(map(float, line.split()[:4])) for line in call("export", "tum", log, "--task", "truth").stdout.splitlines()
            if line and not line.startswith("#")]


def speed(path, since_s, until_s):
    part = [p for p in path if since_s <= p[0] <= until_s]
    if len(part) < 2:
        return None
    way = sum((a[i] - b[i]) ** 2 for a, b in [(part[0], part[-1])] for i in (1, 2, 3)) ** 0.5
    return way / (part[-1][0] - part[0][0])


def plant(port, *more):
    return Child("plant", *SCENE, "--port", port, "--json", *more)


def runtime(port, seconds, *more):
    return Child("run", *SCENE, *MISSION, "--plant", f"own:{port}", "--seconds", seconds, "--no-rt", "--lcm-url", "none",
                 "--json", *more)


def drive():
    """Five seconds with both processes, runtime first. Invariants are checked here; the rest is returned."""
    port = two_free_ports()
    with Witness() as witness:
        ours = runtime(port, 5, "--record", "drive.lcm")
        beside = plant(port, "--record", "truth.lcm")
        run = ours.end()
        sim = beside.end(signal.SIGTERM)
    check(ours.code == 0 and beside.code == 0, f"both end well: {ours.code} {beside.code}", ours.lines, beside.lines)
    verdict = answer("check", "drive.lcm", "--truth", "truth.lcm")
    counters = run.get("counters", {})
    # Behind a gap nobody knows what was run: then the part before it replays, and the run has to say so.
    lost = counters.get("log_lost_jobs", 0) + counters.get("log_lost_samples", 0)
    says_so = any("the log has gaps" in warning for warning in run.get("warnings", []))
    digests = [verdict.get("digest"), verdict.get("recorded_digest"), run.get("digest")]
    check(verdict.get("passed") is True and (len(set(digests)) == 1 or (lost > 0 and says_so)), "the drive replays to its digest",
          lost, digests, verdict.get("compared_jobs"), verdict.get("failures"), run.get("warnings"))
    check(counters.get("heap_calls", 0) == 0, "heap calls of a drive")
    # The sums fit, whatever came late: what one end sent the other took, or it was lost and counted.
    check(counters.get("plant_can_foreign", 1) == 0 and counters.get("plant_can_oversized", 1) == 0, "refusals", counters)
    missed = sum(task["missed"] for task in run.get("tasks", []))
    late = sim.get("counters", {}).get("late_wakes", 0)
    calm = witness.longest_s < 0.1 and late == 0 and missed < 50 and lost == 0
    return run, sim, verdict, calm, (witness.longest_s, late, missed, lost)


for attempt in range(6):
    run, sim, verdict, calm, seen = drive()
    if calm:
        break
    print("disturbed: away for %.2f s, the plant woke late %d times, %d jobs missed, %d not in the log" % seen)
inside = answer("run", *SCENE, *MISSION, "--seconds", "5", "--virtual", "--lcm-url", "none")
if calm:
    errors, usual = verdict.get("errors", {}), inside.get("errors", {})
    check(errors.get("distance_m", 0) > 0.5, "it drove", errors)
    for name, room in (("ate_max_m", 0.02), ("inclination_max_deg", 0.5), ("heading_max_deg", 0.5)):
        check(errors.get(name, 99) < 1.5 * usual.get(name, 0) + room, f"{name} with two processes", errors, usual)
    check(run["counters"].get("plant_can_lost") == 0 and run["counters"].get("scans", 0) > 10, "frames and scans", run["counters"])
    check(sim["counters"].get("bench_commands", 0) > 300, "commands", sim.get("counters"))
else:
    print("left out: figures of a drive, this machine does not stay")
check(len(call("export", "csv", "truth.lcm", "--task", "truth_contacts").stdout.splitlines()) > 1000, "contacts in the plant's log")
call("report", "drive.lcm", "--truth", "truth.lcm", "--out", "page")
page = pathlib.Path("page/report.html").read_text()
check("Contacts by part" in page and "Flipper torques" in page, "contacts in the report")
both = answer("diff", "drive.lcm", "drive.lcm", "--truth", "truth.lcm", "truth.lcm")
check(both.get("same_digest") is True and both.get("first", {}).get("errors") == both.get("second", {}).get("errors") != {},
      "diff with the truth of a plant")

def kill_runtime(kind, *drives):
    """The runtime is killed in full drive: the drives stop by a rule of their own. Its successor drives on."""
    port = two_free_ports()
    killed, after = f"kill-{kind}.lcm", f"second-{kind}.lcm"
    beside = plant(port, "--record", killed, *drives)
    first = runtime(port, 100, *drives)
    check(first.wait_for("the plant is heard"), "the runtime hears the plant", first.lines)
    time.sleep(3.5)
    first.end(signal.SIGKILL)
    check(first.code in (-signal.SIGKILL, 128 + signal.SIGKILL), "killed")
    check(beside.wait_for("the runtime has gone"), "the plant notices", beside.lines)
    time.sleep(1.5)
    second = runtime(port, 3, "--record", after, *drives)
    run = second.end()
    sim = beside.end(signal.SIGTERM)
    check(beside.code == 0 and second.code == 0, "plant and second runtime end well", second.lines, beside.lines)
    check(sim.get("counters", {}).get("can_peers") == 2, "two runtimes were met", sim.get("counters"))
    gone_s = [int(line.split(" at ")[1].split()[0]) * 1e-3 for line in beside.lines if "has gone" in line][0]
    path = poses(killed)
    zero_s = path[0][0] - 0.001  # the log's times may be dates
    # Found gone after 0.5 s of silence; until then the drives (0.2 s, then a ramp of 2 m/s2) have stopped, by the plant's own clock.
    still = speed(path, zero_s + gone_s + 0.4, zero_s + gone_s + 1.2)
    check(still is not None and still < 1e-3, "the robot stands after its runtime was killed", kind, still)
    fastest = max(speed(path, zero_s + t / 10, zero_s + t / 10 + 0.3) or 0 for t in range(int(10 * gone_s)))
    check(fastest > 0.05, "it drove until then", kind, fastest, gone_s, path[-1][0] - path[0][0])
    check(answer("check", after).get("passed") is True, "the second runtime's log replays")
    return run.get("counters", {}), sim.get("counters", {})


# An emergency stop that cannot be read is pressed: a button that never spoke, a line that is not there.
for protocol in ("own", "canopen", "odrive"):
    for key in ("emergency.button_timeout_ms=100", "emergency.gpio_chip=/dev/none"):
        run = answer("run", *SCENE, *MISSION, "--seconds", "3", "--virtual", "--lcm-url", "none", "--set", f"drives.protocol={protocol}",
                     "--set", key)
        counters = run.get("counters", {})
        told = protocol == "own" or counters.get(f"{protocol}_stop_reason") == 9  # the robot's own drives have no group that stops
        check(counters.get("emergency_pressed") == 1 and told, "pressed", protocol, key, counters)
        # ODrives tell no travel before they are set up, and a set-up waits for the release: then no pose is compared.
        never_on = protocol == "odrive" and counters.get("odrive_axes_set_ups") == 0
        check(never_on or run.get("errors", {}).get("distance_m", 9) < 1e-3, "nothing moves while it is pressed", protocol, key, run)
run, sim = kill_runtime("own")
check(sim.get("bench_drive_stale_ms", 0) > 500, "the silence rule was at work", sim)
# Drives whose process has died end without torque: on the pallet the robot would roll, so these drive away from it.
BACK = ["--set", 'mission.commands=[{at_s=0.3,posture="climb"},{at_s=0.5,speed_m_s=-0.3},{at_s=100.0}]']
run, sim = kill_runtime("canopen", "--set", "drives.protocol=canopen", *BACK)
# Once for the first runtime, and again when the second had ended.
check(sim.get("bench_heartbeats_lost", 0) >= 6, "every CANopen drive missed the heartbeat", sim)
check(run.get("canopen_drives_set_ups", 0) >= 6, "the second runtime set all drives up", run)
run, sim = kill_runtime("odrive", "--set", "drives.protocol=odrive", *BACK)
# At the proof of each runtime, and when each had ended.
check(sim.get("bench_watchdogs", 0) >= 18, "every axis was stopped by its watchdog", sim)
check(run.get("odrive_axes_set_ups", 0) >= 6, "the second runtime set all axes up", run)
check(80_000 <= run.get("odrive_watchdog_us", 0) <= 300_000, "the proof took what the watchdog takes", run)

# The plant is killed: the runtime finds its sensors stale, brakes, says so and goes on; with a new plant it drives again.
port = two_free_ports()
beside = plant(port, "--record", "cut.lcm")
ours = runtime(port, 100, "--record", "silent.lcm")
check(ours.wait_for("the plant is heard"), "the runtime hears the plant", ours.lines)
time.sleep(2.0)
beside.end(signal.SIGKILL)
check(ours.wait_for("the plant has gone silent"), "the runtime tells that its plant is gone", ours.lines)
beside = plant(port)
check(beside.wait_for("a runtime is heard"), "the new plant hears the runtime", beside.lines)
time.sleep(2.5)
run = ours.end(signal.SIGINT)
sim = beside.end(signal.SIGTERM)
check(ours.code == 0, "the runtime ends well", ours.lines)
counters = run.get("counters", {})
check(counters.get("stale_IMU", 0) > 100 and counters.get("drive_stops_imu_stale", 0) >= 1, "stale sensors stop the drive", counters)
check(counters.get("plant_can_peers") == 2, "two plants were met", counters)
check(any("restarted 1 times" in w for w in run.get("warnings", [])) and any("went silent" in w for w in run.get("warnings", [])),
      "the closing words", run.get("warnings"))
check(sim.get("counters", {}).get("bench_commands", 0) > 0, "the new plant is driven", sim.get("counters"))
check(answer("check", "silent.lcm").get("passed") is True, "a log across a plant's death replays")
call("export", "tum", "cut.lcm", "--task", "truth", "--accept-damage")

# Rays of a solid-state lidar between two processes. The plant is killed and started again; then rays go on, and the log replays
# with the units that its boot had chosen.
RAYS = ["--scene", "ugv_ssl", "--set", "hil.lidar_columns=16"]
with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
    probe.bind(("127.0.0.1", 0))
    port = min(probe.getsockname()[1], 65533)
beside = Child("plant", *RAYS, "--port", port, "--json")
ours = Child("run", *RAYS, *MISSION, "--set", "tasks.ssl.units=auto", "--set", "tasks.ssl.budget_us=4000", "--plant", f"own:{port}",
             "--seconds", 100, "--no-rt", "--lcm-url", "none", "--json", "--record", "rays.lcm")
check(ours.wait_for("the plant is heard"), "the runtime hears the plant with rays", ours.lines)
time.sleep(1.5)
beside.end(signal.SIGKILL)
check(ours.wait_for("the plant has gone silent"), "the runtime tells that its plant with rays is gone", ours.lines)
beside = Child("plant", *RAYS, "--port", port, "--json")
check(beside.wait_for("a runtime is heard"), "the new plant with rays hears the runtime", beside.lines)
time.sleep(2.5)
run = ours.end(signal.SIGINT)
sim = beside.end(signal.SIGTERM)
counters, fired = run.get("counters", {}), sim.get("counters", {})
check(counters.get("plant_ssl_peers") == 2 and counters.get("plant_rays_frames", 0) > 0, "rays came back", counters)
for never in ("malformed", "unasked", "repeated", "mismatched"):
    check(counters.get(f"plant_rays_{never}") == 0, f"no answer is {never}", counters)
check(fired.get("rays_commands", 0) > 0 and fired.get("rays_malformed") == 0, "the new plant was asked for rays", fired)
check(counters.get("calibration_ssl_units", 0) > 0, "units were chosen", counters)
verdict = answer("check", "rays.lcm")
check(verdict.get("passed") is True and verdict.get("digest") == run.get("digest"), "rays replay to their digest", verdict)
call("report", "rays.lcm", "--out", "rays")
page = pathlib.Path("rays/report.html").read_text()
check("Rays that were fired" in page and "units spent, median" in page, "rays in the report")

# What is wrong is told in one line, with exit code 2.
with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
    taken.bind(("127.0.0.1", 0))
    result = call("plant", *SCENE, "--port", min(taken.getsockname()[1], 65533), "--seconds", "1", code=2)
    check("is another plant running" in result.stderr and len(result.stderr.splitlines()) == 1, "a port that is taken", result.stderr)
for wrong in ("mine", "own:80", "own:65535"):
    check("own:PORT" in call("run", *SCENE, "--plant", wrong, code=2).stderr, f"--plant {wrong}")
call("run", *SCENE, "--plant", "own", "--virtual", code=2)
check("simulated robot" in call("plant", "--scene", "imu_bench", code=2).stderr, "a scene without a robot")
check("unknown key hil.frictoin" in call("plant", *SCENE, "--set", "hil.frictoin=1", code=2).stderr, "a key that is misspelt")
call("plant", *SCENE, "--can", "can9", "--seconds", "1", code=2)
call("replay", "drive.lcm", "--truth", "absent.lcm", code=3)
check("holds no truth" in call("replay", "drive.lcm", "--truth", "drive.lcm", code=3).stderr, "a log without truth")
check("of another time" in call("replay", "drive.lcm", "--truth", "kill-own.lcm", code=3).stderr, "truth of another time")

shutil.rmtree(work, ignore_errors=True)
print(f"{checks - len(failures)} of {checks} checks passed")
sys.exit(1 if failures else 0)
