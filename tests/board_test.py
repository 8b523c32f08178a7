#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# The program on an emulated ARM board with a real PREEMPT_RT kernel and real CAN drivers (hil/board): it drives its stub devices
# over SocketCAN, the same twice; nothing is lost; whoever dies, the drives stop in time; and the board's log gives the board's digest here.
# Usage: board_test.py short|long ARM_BUILD PROGRAM EXPECTED. SORTIE_UPDATE_EXPECTED=1 writes the table of the long run anew.
import concurrent.futures
import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "hil/board"))
sys.dont_write_bytecode = True
import emulate  # noqa: E402

LENGTH, BUILD, PROGRAM, EXPECTED = sys.argv[1], *map(pathlib.Path, sys.argv[2:5])
SECONDS, FRAMES, DATAGRAMS = (5, 10000, 10000) if LENGTH == "short" else (18, 100000, 1000000)
# Bounds for any kernel and compiler: instructions (a nanosecond each) of a task's worst job with its interrupts, and of the
# worst wake-up after a release. The long run's table is exact.
MOST_US = {"parameters_control": 10, "attitude": 80, "odometry": 40, "odometry_state": 10, "drive": 20, "flippers": 10,
           "parameters_mapping": 10, "map": 4000}
LATE_US = 40
TIMER_STEPS = 64  # four steps of 16 ns, see compare_logs()
# What docs/canopen.md promises: 150 ms after the last heartbeat, and a SYNC (10 ms) more where the master decides.
HEARTBEAT_S, SYNC_S, TORQUE_OFF_S = 0.150, 0.010, 0.5
MASTER = "77F"
NODES = ["01", "02", "0B", "0C", "0D", "0E"]
DRIVE_TARGETS, DRIVE_STATES = ({f"{first}{node[1]}" for node in NODES} for first in ("20", "18"))
work = pathlib.Path(tempfile.mkdtemp(prefix="sortie-board-"))
failures = []


def check(good, what, *shown):
    if not good:
        failures.append(what)
        print("FAILED", what, *shown)


def run(*words):
    return subprocess.run([str(w) for w in (PROGRAM, *words)], capture_output=True, text=True, timeout=600, stdin=subprocess.DEVNULL)


def boot(name, *jobs):
    code, console = emulate.boot(jobs, work / name, BUILD, settings=[f"seconds={SECONDS}", f"frames={FRAMES}", f"datagrams={DATAGRAMS}"])
    check(code == 0, f"{name}: the board's jobs end well", code, console)
    return console


def read(*parts):
    return json.loads(work.joinpath(*parts).read_text())


def bus(*parts):
    """Rows of (time, identifier, data) of a candump log."""
    words = (line.split() for line in work.joinpath(*parts).read_text().splitlines())
    return [(float(w[0][1:-1]), *w[2].split("#")) for w in words]


def clock_of(log):
    """CLOCK_MONOTONIC in seconds at time 0 of a log: its event of kind clock (event_t)."""
    data = log.read_bytes()
    at = data.index(b"\0\0\0\x06clock\0")
    subject = at + 10
    length, = struct.unpack_from(">I", data, subject)
    return struct.unpack_from(">q", data, subject + 4 + length)[0] * 1e-9


def standstill(log, after_s):
    """When the robot that the truth tells of has stopped for good, on CLOCK_MONOTONIC, and how fast it went before."""
    rows = [list(map(float, line.split()[:3])) for line in run("export", "tum", log, "--task", "truth").stdout.splitlines()
            if not line.startswith("#")]
    zero = clock_of(log)
    speeds = [(zero + b[0], ((b[1] - a[1]) ** 2 + (b[2] - a[2]) ** 2) ** 0.5 / max(b[0] - a[0], 1e-6)) for a, b in zip(rows, rows[1:])]
    moving = [t for t, v in speeds if v > 0.005]
    return (moving[-1] if moving else 0.0), max((v for t, v in speeds if t < after_s), default=0.0)


def events(log):
    """Events of an LCM log: (channel, all its bytes)."""
    data, at, found = log.read_bytes(), 0, []
    while at < len(data):
        channel, message = struct.unpack_from(">II", data, at + 20)
        end = at + 28 + channel + message
        found.append((data[at + 28:at + 28 + channel], data[at:end]))
        at = end
    return found


def moved_ns(first, second):
    """How far apart the kernel's stamps (the first field) of two CAN frames are that are otherwise equal; None where they are not."""
    stamp = 28 + len(first[0]) + 8
    if first[0] != second[0] or first[0] != b"CAN" or first[1][:stamp] + first[1][stamp + 8:] != second[1][:stamp] + second[1][stamp + 8:]:
        return None
    return abs(struct.unpack_from(">q", first[1], stamp)[0] - struct.unpack_from(">q", second[1], stamp)[0])


def compare_logs():
    """Two runs: what went into the runtime and came out of it is equal to the last bit. Times that it measured of itself may differ by a step
    of the timer, and one frame in 10,000 may have been stamped up to 1 us apart: QEMU's own threads see to that when this machine is busy.
    Returns how many times and stamps did."""
    first, second = (events(work / name / "mission/drive.lcm") for name in ("first", "second"))
    others = [[e for e in log if e[0] != b"SORTIE_TIMING"] for log in (first, second)]
    check(len(others[0]) == len(others[1]) > 1000, "two runs: as many events", len(others[0]), len(others[1]))
    apart = [moved_ns(a, b) for a, b in zip(*others) if a != b]
    check(None not in apart and max(apart, default=0) <= 1000, "two runs: the same log", apart[:5])
    check(len(apart) <= len(others[0]) / 10000, "two runs: the same stamps", apart[:5], len(apart))
    return sum(a != b for a, b in zip(first, second)) - len(apart), len(apart)


def mission():
    with concurrent.futures.ThreadPoolExecutor(2) as both:
        consoles = list(both.map(lambda name: boot(name, "can", "mission"), ("first", "second")))
    if failures:
        return {}
    check("realtime 1" in consoles[0], "the kernel is PREEMPT_RT", consoles[0])
    # How long the log is depends on the times that a run measured of itself; compare_logs() looks at each of its events.
    told = [[line for line in console.splitlines() if '"log_bytes"' not in line] for console in consoles]
    check(told[0] == told[1], "two runs: the same console, with digest and counters", *consoles)
    times, stamps = compare_logs()
    print(f"{times} of the log's measured times and {stamps} of its frames' stamps differ between two runs")
    here = run("check", work / "first/mission/drive.lcm", "--json")
    checked, result = json.loads(here.stdout), read("first", "mission", "run.json")
    check(here.returncode == 0 and checked["digest"] == result["digest"], "the board's log gives the board's digest here", here.stdout[-400:])
    counters = result["counters"]
    check(result["ticks"] == SECONDS * 1000, "all ticks were run", result["ticks"])
    check(counters["heap_calls"] == 0, "no heap on the real-time threads", counters["heap_calls"])
    check(counters["canopen_running"] == 1 and counters["canopen_drives_set_ups"] == 6, "six drives were set up over SocketCAN", counters)
    check(counters["log_lost_jobs"] == counters["log_lost_samples"] == 0, "the log is whole", counters)
    missed = sum(group["missed"] + group["skipped"] for group in result["groups"])
    check(missed == 0, "every release was met", missed)
    _, speed = standstill(work / "first/mission/truth.lcm", 1e9)
    check(speed > 0.2, "the robot drives", speed)
    figures = {"mission": {task["name"]: round(task["max_us"] * 1000) for task in result["tasks"]}}
    for task in result["tasks"]:
        check(task["max_us"] <= MOST_US[task["name"]], f"instructions of {task['name']}", task["max_us"])
    control = result["groups"][0]
    check(control["late_max_us"] <= LATE_US, "release of control", control["late_max_us"])
    figures["mission"]["release of control"] = round(control["late_max_us"] * 1000)
    return figures


def trouble():
    """The other boot: frames under load, a runtime that is killed, drives that go."""
    console = boot("trouble", "killed", "gone", "pressed", "flood", "fd", "overrun", "storm", "tools")
    if not (work / "trouble/flood/can0-can1.json").exists():
        return {}
    figures = {}
    for pair, frames in (("vcan0-vcan0", FRAMES), ("can0-can1", FRAMES // 10)):
        flood = read("trouble", "flood", f"{pair}.json")
        check(flood["sent"] == flood["received"] == frames and flood["out_of_order"] == 0, f"{pair}: all frames both ways", flood)
        check(flood["heap_calls"] == 0 and flood["page_faults"] <= 1, f"{pair}: no heap, one page fault at most", flood)
        check(flood["late_max_ns"] <= LATE_US * 1000, f"{pair}: release under load", flood)
        figures[pair] = {key: flood[key] for key in ("received", "lost", "page_faults", "releases", "late_p50_ns", "late_max_ns", "work_max_ns")}
    killed, frames = read("trouble", "killed", "killed.json")["killed_s"], bus("trouble", "killed", "bus.log")
    last = max(t for t, i, _ in frames if i == MASTER)
    check(last < killed, "a killed runtime is silent", last, killed)
    noticed = {n: next((t for t, i, d in frames if t > killed and i == f"08{n[1]}" and d.startswith("3081")), 9e9) for n in NODES}
    slowest = max(noticed.values()) - last
    # The simulated drives hear and act once in a step of their process, which is slow on the emulated board: it says how slow.
    step = read("trouble", "killed", "plant.json")["counters"]["longest_step_us"] * 1e-6
    check(slowest <= HEARTBEAT_S + 2 * step + 0.001, "killed runtime: every drive says that its master is gone", noticed, last, step)
    stopped, speed = standstill(work / "trouble/killed/truth.lcm", killed)
    check(speed > 0.1, "the robot was driving when its runtime was killed", speed)
    check(stopped - last <= HEARTBEAT_S + TORQUE_OFF_S, "killed runtime: the robot stands", stopped - last)
    figures["killed"] = {"drives notice after the last heartbeat [us]": round(slowest * 1e6), "robot stands [ms]": round((stopped - last) * 1e3)}
    killed, frames = read("trouble", "gone", "killed.json")["killed_s"], bus("trouble", "gone", "bus.log")
    first = min(max(t for t, i, _ in frames if i == f"7{n}") for n in NODES)
    stop = min(t for t, i, d in frames if t > killed and i.startswith("20") and not d.startswith("0F00"))
    later = [r for r in frames if r[0] > stop + 1e-9 and r[1].startswith("20") and r[2].startswith("0F00")]
    check(stop - first <= HEARTBEAT_S + SYNC_S + 0.002, "lost drives: the others are told to stop", stop - first)
    check(not later, "lost drives: nobody is told to go on", later[:3])
    counters = read("trouble", "gone", "run.json")["counters"]
    check(counters["canopen_drives_lost"] == 6 and counters["canopen_running"] == 0, "lost drives are counted", counters)
    figures["gone"] = {"quick stop after the last heartbeat [us]": round((stop - first) * 1e6)}
    figures["pressed"] = pressed()
    fd = read("trouble", "fd", "fd.json")
    check(fd["received"] == FRAMES and fd["wrong"] == fd["heap_calls"] == 0, "CAN FD: every frame as it was sent, no heap", fd)
    check(0 < fd["classical"] == fd["classical_received"] < FRAMES, "a classical port beside it has the classical frames alone", fd)
    check("carries no CAN FD" in fd["without_fd"] and "mtu 72" in fd["without_fd"], "a bus without FD is refused with the cure", fd)
    check("BOARD-DONE overrun 0" in console, "frames that the kernel dropped are counted", console)
    figures["storm"] = storm()
    can_utils()
    return figures


def pressed():
    """An emergency stop on the bus, again and again while the robot drives: when the last drive is told to stop, and when
    the last one says that it has no torque."""
    frames, counters = bus("trouble", "pressed", "bus.log"), read("trouble", "pressed", "run.json")["counters"]
    presses = [t for t, i, d in frames if i == "101" and d.startswith("AA")]
    releases = [t for t, i, d in frames if i == "101" and d.startswith("55")]
    check(len(presses) == len(releases) == 8 and counters["emergency_stops"] == 8, "every press is taken", len(presses), counters)
    told_us, off_us = [], []
    for press, release in zip(presses, releases):
        before = {i for t, i, d in frames if press - 0.1 < t < press and i in DRIVE_TARGETS and d.startswith("0F00")}
        check(before == DRIVE_TARGETS, "all drives were running when it was pressed", press, before)
        asked = [t - press for t, i, d in frames if press < t < release and i in DRIVE_TARGETS and d.startswith("0F00")]
        told = [min((t - press for t, i, d in frames if press < t < release and i == target and not d.startswith("0F00")), default=9) for target in DRIVE_TARGETS]
        check(max(asked, default=0) <= max(told), "nobody asks for torque again", press, asked[-3:])
        told_us.append(max(told) * 1e6)
        # Bit 2 of a status word: operation enabled, or a quick stop that goes on.
        off_us.append(max((t - press for t, i, d in frames if press < t < release and i in DRIVE_STATES and int(d[1], 16) & 4), default=0) * 1e6)
        check(off_us[-1] < (release - press) * 1e6 - 50e3, "no torque while it is pressed", press, off_us)
    check(max(told_us) <= SYNC_S * 1e6 + 2000, "all are told to stop within a SYNC period", told_us)
    _, speed = standstill(work / "trouble/pressed/truth.lcm", presses[0])
    check(speed > 0.1, "the robot was driving", speed)
    return {"last drive is told to stop, worst of 8 [us]": round(max(told_us)), "last drive's torque off, worst of 8 [us]": round(max(off_us))}


def storm():
    """A robot that listens: what a stranger sends is counted and refused, and the control loop's wake-ups are those of a calm network."""
    calm, wild = read("trouble", "storm", "calm.json"), read("trouble", "storm", "storm.json")
    counters = wild["counters"]
    heard = sum(counters[f"network_{kind}"] for kind in ("messages", "fragments", "malformed"))
    check(heard >= DATAGRAMS, "every datagram is counted", counters)
    refused = sum(counters[f"{door}_{why}"] for door in ("requests", "parameters") for why in ("bad_tag", "malformed"))
    check(refused > DATAGRAMS / 4 and counters["network_fragments"] > DATAGRAMS / 10, "and of each kind there were many", counters)
    check(counters["requests_admitted"] == counters["parameters_admitted"] == counters["heap_calls"] == 0, "none is taken, no heap", counters)
    for name, result in (("calm", calm), ("storm", wild)):
        control = result["groups"][0]
        check(control["missed"] == control["skipped"] == 0, f"{name}: every release was met", control)
        check(control["late_max_us"] <= LATE_US, f"{name}: release of control", control["late_max_us"])
    late = {name: [round(result["groups"][0][f"late_{rank}_us"] * 1000) for rank in ("p50", "p99", "max")]
            for name, result in (("calm", calm), ("storm", wild))}
    check(abs(late["storm"][0] / late["calm"][0] - 1) <= 0.02, "storm: the median wake-up is that of the calm", late)
    return {f"{name}, wake-up {rank} [ns]": value for name, values in late.items() for rank, value in zip(("p50", "p99", "max"), values)}


def spacing_s(first, second):
    """Of the same frames written down twice: how much their times differ, less the two clocks' difference; infinite where frames do."""
    if [row[1:] for row in first] != [row[1:] for row in second] or not first:
        return float("inf")
    apart = [a[0] - b[0] for a, b in zip(first, second)]
    return max(apart) - min(apart)


def can_utils():
    """candump and canplayer beside the runtime: both write the same log of a bus, and what one writes the other plays and reads."""
    theirs, ours = bus("trouble", "tools", "candump.log"), bus("trouble", "tools", "watch.log")
    check(len(ours) > 3000 and spacing_s(theirs, ours) <= 2e-6, "candump and our watch: the same frames with the kernel's stamps", len(theirs), len(ours))
    drive = bus("trouble", "tools", "drive.log")
    rest = iter(ours)
    check(len(drive) > 1000 and all(any(frame[1:] == other[1:] for other in rest) for frame in drive), "the run's log holds the bus's frames in order", len(drive))
    identifiers = {row[1] for row in drive}  # of what the runtime took in; on the other bus it speaks, too
    played = [row for row in bus("trouble", "tools", "played.log") if row[1] in identifiers]
    check(spacing_s(played, drive) <= 0.01, "canplayer plays the run's log: the same frames at the same times", len(played), spacing_s(played, drive))
    heard = bus("trouble", "tools", "heard.log")
    check(spacing_s(heard, played) <= 1e-5, "a run takes in all that canplayer plays, with the kernel's stamps", len(heard), spacing_s(heard, played))


def compare_figures(now, was):
    for part, rows in was.items():
        check(list(now.get(part, {})) == list(rows), f"{part}: the table's rows", now)
        for name, value in rows.items():
            steps = now.get(part, {}).get(name, 0) - value
            check(abs(steps) <= TIMER_STEPS, f"{part}, {name}: {value} in the table", now.get(part, {}).get(name))


def main():
    try:
        _, versions = emulate.fetch()
        figures = mission()
        figures.update(trouble())
    except emulate.Missing as missing:
        print(f"skipped: {missing}")
        return 77
    print(json.dumps(figures, indent=1))
    if LENGTH == "long" and not failures:
        if "SORTIE_UPDATE_EXPECTED" in os.environ:
            EXPECTED.write_text(json.dumps(figures, indent=1) + "\n")
        elif emulate.is_pinned(versions):
            compare_figures(figures, json.loads(EXPECTED.read_text()))
        else:
            print("not the pinned versions, so only bounds were checked:", versions)
    if failures:
        print("files are in", work)
        return 1
    shutil.rmtree(work, ignore_errors=True)
    return 0


sys.exit(main())
