#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# The real programs in a network of their own: an emergency stop by request, on motors of each protocol. What the commands
# say, what the robot says of itself, and what `sortie spy` shows of its motors.
# Usage: emergency_test.py PROGRAM [SEED]
import json
import math
import random
import signal
import socket
import struct
import subprocess
import threading
import time

from live_support import (PROGRAM, STANDS, STOP_EMERGENCY, STOP_HALT, Air, answers, check, ear, end, finish, halted, run, sortie,
                          stopped_by)

SECRET = ("--secret", "secret")
BRIEF = (*SECRET, "--seconds", "1")
EMERGENCY_STOP = 9  # drivers::StopReason
STILL_M = 0.01  # what suspension and brakes give


class Parrot(threading.Thread):
    """Admits all that it is asked, under the right tag, and says of itself what it is told to."""

    def __init__(self, air, stop):
        super().__init__(daemon=True)
        self.air, self.state, self.session, self.going = air, {**STANDS, "stop": float(stop)}, random.randrange(1, 1 << 62), True

    def run(self):
        heard, asked, next_s = ear(), [], 0.0
        heard.settimeout(0.05)
        while self.going:
            try:
                channel, _, payload = heard.recv(65536)[8:].partition(b"\0")
            except socket.timeout:
                channel = b""
            if channel == b"SORTIE_DRIVE":
                _, _, session, sender, counter = struct.unpack_from(">Qqqqq", payload)
                asked = [(sender, counter)] if session == self.session else asked
            if time.monotonic() >= next_s:
                next_s = time.monotonic() + 0.05
                self.air.send(b"SORTIE_ANSWERS_drive", answers("parrot", self.session, self.state, asked))


def admitted_is_not_done(air):
    """A request that was admitted is not yet a robot that stands without torque."""
    for what, stop, code, says in [("emergency", STOP_HALT, 1, "does not say that it is stopped"),
                                   ("emergency", STOP_HALT | STOP_EMERGENCY, 0, "stopped: halt, emergency"),
                                   ("emergency-end", STOP_HALT | STOP_EMERGENCY, 1, "the emergency stop still holds"),
                                   ("emergency-end", STOP_HALT, 0, "stopped: halt")]:
        parrot = Parrot(air, stop)
        parrot.start()
        sortie("drive", what, *BRIEF, code=code, says=[says])
        parrot.going = False
        parrot.join()


def spy():
    """The newest values of each channel."""
    said = sortie("spy", "--json", "--values", "--seconds", "0.3", code=0)
    return {row["channel"]: row["values"] for row in json.loads(said.stdout)["channels"]}


def motors_until(emergency, running, reason, what, seconds=8):
    """Waits until spy shows the motors like that."""
    wanted = {"emergency": emergency, "running": running, "stop_reason": reason}
    end_s = time.monotonic() + seconds
    while (row := spy().get("SORTIE_FIELDS_motors")) != wanted and time.monotonic() < end_s:
        pass
    check(row == wanted, f"{what}: spy shows {wanted}", row)


def place():
    pose = spy()["POSE_BODY"]
    return pose["pos[0]"], pose["pos[1]"]


def moves(air, protocol, start, way, what, seconds=15):
    """Waits until it has come a bit further; `way`: 1 forwards, -1 backwards."""
    end_s = time.monotonic() + seconds
    while way * ((now := place())[0] - start[0]) < 0.05 and time.monotonic() < end_s:
        pass
    check(way * (now[0] - start[0]) >= 0.05, f"{protocol}: {what}", start, now, air.said[protocol], spy().get("SORTIE_FIELDS_motors"))


def emergency(air, protocol):
    told = protocol != "own"  # the robot's own frames do not tell whether its motors run
    on, reason = int(told), EMERGENCY_STOP if told else 0
    # On a starved machine frames come late, and a drive that was lost for that would wait to be asked anew. Re-arming starts
    # it again; after an emergency stop, which is what is tried here, it starts nothing.
    rearm = ["--set", "drives.rearm_s=0.5"] if told else []
    process = run(protocol, *rearm, "--set", "drive.remote=true", "--set", f"drives.protocol={protocol}", "--set", "hil.course=[]",
                  "--set", "hil.lidar_rows=4", "--set", "hil.lidar_columns=64", "--set",
                  "mission.commands=[{at_s=0.5,speed_m_s=-0.1},{at_s=1000.0}]", scene="ugv_pallet")
    check(air.until(protocol, lambda said: True), f"{protocol}: the run answers")
    motors_until(0, on, 0, f"{protocol}, on its way")
    start = place()
    # Somebody asks for speed, and goes on asking all the while.
    driver = subprocess.Popen([PROGRAM, "drive", "go", "--speed", "0.3", "--for", "60", *BRIEF], stdin=subprocess.DEVNULL,
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    moves(air, protocol, start, 1, "go moves it")
    moving = air.until(protocol, lambda said: said["state"]["speed_m_s"] > 0.1)
    check(moving["state"]["speed_m_s"] > 0.1, f"{protocol}: it drives before the emergency stop", moving)
    began = time.time()
    sortie("drive", "emergency", *SECRET, code=0, says=["taken", "emergency"])
    ended = time.time()
    time.sleep(0.2)  # until this listener has heard what the command had
    said = air.between(protocol, began, ended)
    check(any(stopped_by(one, STOP_EMERGENCY) for one in said), f"{protocol}: before the command ended the robot itself said so", said)
    motors_until(1, 0, reason, f"{protocol}, pressed")
    stands = place()
    driver.send_signal(signal.SIGINT)
    check(driver.wait(10) == 0, f"{protocol}: what was asked for before it was taken", driver.returncode)
    sortie("drive", "release", *BRIEF, code=1, says=["not taken", "sortie drive emergency-end and then release end that"])
    sortie("drive", "go", "--speed", "0.3", "--for", "0.3", *BRIEF, code=1, says=["not taken", "sortie drive emergency-end"])
    motors_until(1, 0, reason, f"{protocol}, pressed still", 0)
    lines = sortie("spy", "--values", "--seconds", "0.3", code=0).stdout.splitlines()
    row = [lines[i + 1].split() for i, line in enumerate(lines) if line.startswith("SORTIE_FIELDS_motors ")]
    check(row == [["emergency=1", "running=0", f"stop_reason={reason}"]], f"{protocol}: the table shows the row", lines)
    check(math.dist(stands, place()) < STILL_M, f"{protocol}: nothing moves while it is pressed", stands, place())

    sortie("drive", "emergency-end", *SECRET, code=0, says=["taken", "stopped: halt"])
    said = air.until(protocol, lambda said: not stopped_by(said, STOP_EMERGENCY))
    check(halted(said) and not stopped_by(said, STOP_EMERGENCY), f"{protocol}: it is halted after the end", said)
    sortie("drive", "go", "--speed", "0.3", "--for", "0.3", *BRIEF, code=1, says=["not taken", "sortie drive release ends that"])
    motors_until(0, 0, reason, f"{protocol}, after the end", 0)
    check(math.dist(stands, place()) < STILL_M, f"{protocol}: the end moves nothing", stands, place())
    check(halted(air.said[protocol]), f"{protocol}: and it stays halted", air.said[protocol])

    sortie("drive", "release", *SECRET, code=0, says=["taken; in control: the mission's rows"])
    motors_until(0, on, 0, f"{protocol}, released")
    moves(air, protocol, stands, -1, "after the release the mission goes on")
    counters = end(process)
    for name in ("emergency_stops", "drive_stops_emergency"):
        check(counters[name] == 1, f"{protocol}: one emergency stop is counted", name, counters[name])


began = time.monotonic()
air = Air()
admitted_is_not_done(air)
for protocol in ("own", "canopen", "odrive"):
    emergency(air, protocol)
finish(began)
