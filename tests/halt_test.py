#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# The real programs in a network of their own: halts among racing and lying senders, a run that is stopped while it is
# commanded, two robots with one secret, and what the commands say when something is missing.
# Usage: halt_test.py PROGRAM [SEED]
import pathlib
import random
import signal
import struct
import threading
import time

from live_support import (DRIVE, GROUP, HALT, KEY, RELEASE, STANDS, Air, check, end, finish, halted, pause, request, run, sortie)


class Racer(threading.Thread):
    """Sends as fast as it is told, as long as it is told: with a counter that it counts on by itself."""

    def __init__(self, air, robot, channel, hertz, mode=0, **how):
        super().__init__(daemon=True)
        self.air, self.robot, self.channel, self.pause, self.mode, self.how = air, robot, channel, 1 / hertz, mode, how
        self.going, self.sent, self.sender = True, 0, random.randrange(1 << 62)

    def run(self):
        counter = 0
        while self.going:
            said = self.air.said[self.robot]
            counter = max(counter, said["counter"]) + 1
            self.air.send(self.channel, request(self.channel, said["session"], self.sender, counter, self.mode, 0.2, **self.how))
            self.sent += 1
            time.sleep(self.pause)

    def stop(self):
        self.going = False
        self.join()


class Liar(threading.Thread):
    """Without the secret: telemetry that says that counters are far ahead, answers that say that the robot stands, and halts and releases."""

    def __init__(self, air, robot):
        super().__init__(daemon=True)
        self.air, self.robot, self.going = air, robot, True

    def run(self):
        while self.going:
            said = self.air.said[self.robot]
            fields = struct.pack(">Qq", 0x667A1249A4FD0D23, int(time.time() * 1e6)) + struct.pack(">i", 6) + b"drive\0"
            values = {"request_counter": 1e15, **STANDS}
            fields += struct.pack(">i", len(values)) + b"".join(struct.pack(">i", len(n) + 1) + n.encode() + b"\0" for n in values)
            self.air.send(b"SORTIE_FIELDS_drive", fields + b"".join(struct.pack(">d", v) for v in values.values()))
            newest = self.air.raw[self.robot][-1]
            forged = bytearray(newest)
            forged[-10] ^= 1  # the state's last value
            self.air.out.sendto(bytes(forged), GROUP)
            for mode in (HALT, RELEASE):
                self.air.send(b"SORTIE_DRIVE", request(b"SORTIE_DRIVE", said["session"], 5, said["counter"] + 1, mode, key=None))
            time.sleep(0.01)


def words_for_what_is_missing():
    sortie("drive", "halt", "--seconds", "0.5", code=3, says=["no run"])
    process = run("mute", secret=False)
    time.sleep(2)
    sortie("drive", "halt", code=3, says=["takes no requests to drive", "drive.remote=true", "secret_file"])
    end(process)
    process = run("open", "--set", "drive.remote=true", secret=False)
    time.sleep(2)
    sortie("drive", "halt", code=3, says=["open takes no requests, for it has no secret", "chmod 600"])
    end(process)


def racing_halts(air, halts=8):
    """A second sender at 100 Hz, and a liar: each halt that says it was taken was, and each is."""
    process = run("otter", "--set", "drive.remote=true")
    check(air.until("otter", lambda said: True), "the run answers")
    sortie("drive", "halt", code=2, says=["give --secret"])
    pathlib.Path("wrong").write_text("0" * 32)
    pathlib.Path("wrong").chmod(0o600)
    sortie("drive", "halt", "--secret", "wrong", code=2, says=["another secret"])
    # Taken is what the robot does: one that is halted takes no go, whatever its desk admits.
    sortie("drive", "go", "--speed", "0.2", "--for", "0.6", "--secret", "secret", code=0, says=["taken", "requests"])
    sortie("drive", "go", "--speed", "99", "--for", "0.6", "--seconds", "1", "--secret", "secret", code=1, says=["refused", "not taken"])
    sortie("drive", "halt", "--secret", "secret", code=0, says=["halted"])
    sortie("drive", "go", "--speed", "0.2", "--for", "0.6", "--seconds", "1", "--secret", "secret", code=1, says=["not taken", "drive release"])
    racers = [Racer(air, "otter", b"SORTIE_DRIVE", 100), Liar(air, "otter")]
    for racer in racers:
        racer.start()
    longest = 0
    for number in range(halts):
        sortie("drive", "release", "--secret", "secret", code=0)
        check(not halted(air.until("otter", lambda said: not halted(said))), f"halt {number}: the robot was released")
        began = time.time()
        sortie("drive", "halt", "--secret", "secret", code=0, says=["halted"])
        ended = time.time()
        longest = max(longest, ended - began)
        time.sleep(0.2)  # until this listener has heard what the command had
        said = air.between("otter", began, ended)
        stood = [one for one in said if halted(one) and one["state"]["speed_m_s"] == 0]
        check(stood, f"halt {number}: before the command ended the robot itself said that it stands", said)
        check(halted(air.said["otter"]), f"halt {number}: and it stays", air.said["otter"])
    for racer in racers:
        racer.going = False
        racer.join()
    # A robot that says nothing is not halted, whatever was recorded of it.
    recorded = air.raw["otter"][-20:]
    pause(process)
    player = threading.Thread(target=lambda: [(air.out.sendto(old, GROUP), time.sleep(0.1)) for old in recorded * 2], daemon=True)
    player.start()
    air.forges = True
    sortie("drive", "halt", "--secret", "secret", "--seconds", "2", code=1, says=["not halted"])
    air.forges = False
    player.join()
    process.send_signal(signal.SIGCONT)
    counters = end(process)
    check(counters["requests_bad_tag"] > 100 and racers[0].sent > 300, "there were racers and liars", counters, racers[0].sent)
    print(f"{halts} halts, the longest command took {longest:.2f} s; the racer sent {racers[0].sent}", flush=True)


def stopped_process(air, seconds=4.0):
    """A run that is stopped by a signal while it is commanded obeys nothing of that but the halt."""
    process = run("badger", "--set", "drive.remote=true")
    said = air.until("badger", lambda said: True)
    sortie("drive", "halt", "--secret", "secret", code=0)
    before = air.said["badger"]
    pause(process)
    began = time.monotonic()
    counter = before["counter"]
    for i in range(16):
        counter += 1
        mode = RELEASE if i % 4 == 0 else DRIVE
        air.send(b"SORTIE_DRIVE", request(b"SORTIE_DRIVE", said["session"], 7, counter, mode, 0.3))
    time.sleep(seconds - 0.7)
    counter += 1  # young enough for the sender's clock, too old for the drive
    air.send(b"SORTIE_DRIVE", request(b"SORTIE_DRIVE", said["session"], 7, counter, RELEASE))
    time.sleep(seconds - (time.monotonic() - began))
    process.send_signal(signal.SIGCONT)
    moved = False
    end_s = time.monotonic() + 2
    while time.monotonic() < end_s:
        state = air.said["badger"]["state"]
        moved = moved or (state and (not halted(air.said["badger"]) or state["speed_m_s"] != 0))
        time.sleep(0.02)
    check(not moved, "what was asked of a stopped process moves nothing", air.said["badger"])
    # Now it drives. A crowd of speeds fills the kernel's queue of the stopped process, then comes one halt.
    sortie("drive", "release", "--secret", "secret", code=0)
    said = air.until("badger", lambda said: not halted(said))
    counter = max(counter, said["counter"])
    pause(process)
    for i in range(3000):
        air.send(b"SORTIE_DRIVE", request(b"SORTIE_DRIVE", said["session"], 8, counter + 1 + i, DRIVE, 0.3, key=None if i % 2 else KEY))
    air.send(b"SORTIE_DRIVE", request(b"SORTIE_DRIVE", said["session"], 9, 1, HALT))
    time.sleep(3)
    process.send_signal(signal.SIGCONT)
    said = air.until("badger", lambda said: halted(said) and said["state"]["speed_m_s"] == 0, 5)
    check(halted(said), "a halt is found behind 3,000 datagrams in a stopped process's queue", said)
    counters = end(process)
    check(counters["requests_wrong_time"] >= 16 and counters["requests_held_back"] >= 1, "and each is counted", counters)


def two_robots(air):
    """Two robots, one group, one secret: a request names its robot."""
    both = [run(name, "--set", "drive.remote=true") for name in ("stoat", "weasel")]
    for name in ("stoat", "weasel"):
        check(air.until(name, lambda said: True), f"{name} answers")
    sortie("drive", "halt", "--secret", "secret", code=2, says=["2 robots", "stoat", "weasel", "--robot"])
    sortie("drive", "halt", "--secret", "secret", "--robot", "mink", code=2, says=["no robot mink"])
    sortie("drive", "halt", "--secret", "secret", "--robot", "weasel", code=0, says=["halted"])
    time.sleep(0.5)
    check(halted(air.said["weasel"]) and not halted(air.said["stoat"]), "only the one that was named is halted")
    for process in both:
        end(process)


def flight(air, stops=3):
    process = run("heron", "--set", "flight.remote=true", scene="uav_neo11")
    check(air.until("heron", lambda said: True), "the vehicle answers")
    racer = Racer(air, "heron", b"SORTIE_FLY", 100)
    racer.start()
    for number in range(stops):
        sortie("fly", "release", "--secret", "secret")  # the racer takes over again at once
        released = air.until("heron", lambda said: said["state"]["step"] != 10, 5)
        check(released is not None and released["state"]["step"] != 10, f"stop {number}: the vehicle was released before it")
        sortie("fly", "stop", "--secret", "secret", code=0, says=["stopped"])
        time.sleep(0.5)
        check(air.said["heron"]["state"]["step"] == 10, f"stop {number}: goals that go on start no rotor")
    racer.stop()
    end(process)


began = time.monotonic()
words_for_what_is_missing()
air = Air()
racing_halts(air)
stopped_process(air)
two_robots(air)
flight(air)
finish(began)
