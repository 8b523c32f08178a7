#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# The real programs in a network of their own: halts among racing and lying senders, a run that is stopped while it is
# commanded, two robots with one secret, and what the commands say when something is missing. Requests and answers are
# written and read here by a second hand, tag and all.
# Usage: halt_test.py PROGRAM [SEED]
import json
import os
import pathlib
import random
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time

if len(sys.argv) < 2:
    sys.exit("usage: halt_test.py PROGRAM [SEED]")
PROGRAM = os.path.abspath(sys.argv[1])
SEED = int(sys.argv[2]) if len(sys.argv) > 2 else random.SystemRandom().randrange(1 << 32)
if os.environ.get("SORTIE_OWN_NETWORK") != "1":
    if subprocess.run(["unshare", "-rn", "sh", "-c", "ip link set lo up && ip route add 224.0.0.0/4 dev lo"],
                      stderr=subprocess.DEVNULL).returncode != 0:
        print("skipped: no network namespace of its own")
        sys.exit(77)
    os.environ["SORTIE_OWN_NETWORK"] = "1"
    os.execvp("unshare", ["unshare", "-rn", sys.executable, os.path.abspath(__file__), PROGRAM, str(SEED)])
subprocess.run("ip link set lo up && ip route add 224.0.0.0/4 dev lo", shell=True, check=True)
random.seed(SEED)
print("seed", SEED, flush=True)

work = pathlib.Path(tempfile.mkdtemp(prefix="sortie-halt-"))
os.chdir(work)
GROUP = ("239.255.76.67", 7667)
KEY = bytes(random.randrange(256) for _ in range(16))
pathlib.Path("secret").write_text(KEY.hex() + "\n")
pathlib.Path("secret").chmod(0o600)
DRIVE, RELEASE, HALT = 0, 1, 2
failures = []


def check(good, what, *shown):
    if not good:
        failures.append(what)
        print("FAILED", what, *shown, flush=True)


def siphash(key, data):
    mask = (1 << 64) - 1
    rot = lambda x, b: ((x << b) | (x >> (64 - b))) & mask
    k0, k1 = struct.unpack("<QQ", key)
    v = [k0 ^ 0x736F6D6570736575, k1 ^ 0x646F72616E646F6D, k0 ^ 0x6C7967656E657261, k1 ^ 0x7465646279746573]

    def rounds(n):
        for _ in range(n):
            v[0] = (v[0] + v[1]) & mask
            v[2] = (v[2] + v[3]) & mask
            v[1], v[3] = rot(v[1], 13) ^ v[0], rot(v[3], 16) ^ v[2]
            v[0] = rot(v[0], 32)
            v[2] = (v[2] + v[1]) & mask
            v[0] = (v[0] + v[3]) & mask
            v[1], v[3] = rot(v[1], 17) ^ v[2], rot(v[3], 21) ^ v[0]
            v[2] = rot(v[2], 32)

    padded = data + bytes((-len(data) - 1) % 8) + bytes([len(data) % 256])
    for (word,) in struct.iter_unpack("<Q", padded):
        v[3] ^= word
        rounds(2)
        v[0] ^= word
    v[2] ^= 0xFF
    rounds(4)
    return v[0] ^ v[1] ^ v[2] ^ v[3]


class Air:
    """The group: sends what it is told, and remembers the newest answers of every run."""

    def __init__(self):
        self.out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.inward = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.inward.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.inward.bind(GROUP)
        self.inward.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, socket.inet_aton(GROUP[0]) + bytes(4))
        self.said, self.raw, self.forges = {}, {}, False
        threading.Thread(target=self.listen, daemon=True).start()

    def listen(self):
        while True:
            bytes_ = self.inward.recv(65536)
            channel, _, payload = bytes_[8:].partition(b"\0")
            if channel == b"SORTIE_DRIVE" and self.forges:
                self.forge(payload)
            if not channel.startswith(b"SORTIE_ANSWERS_"):
                continue
            if struct.unpack(">Q", payload[-8:])[0] != siphash(KEY, payload[:-8]):
                continue
            answers = read_answers(payload)
            self.said[answers["robot"]] = answers
            self.raw.setdefault(answers["robot"], []).append(bytes_)

    def forge(self, asked):
        """Whoever hears a request can say that it was admitted and that the robot stands, but not under the tag."""
        _, _, session, sender, counter = struct.unpack_from(">Qqqqq", asked)
        text = lambda word: struct.pack(">i", len(word) + 1) + word.encode() + b"\0"
        values = {"stop": 2.0, "speed_m_s": 0.0, "turn_rad_s": 0.0, "source": 3.0}
        body = struct.pack(">Qqq", 0x054BF8BA8BEE8ABE, int(time.time() * 1e6), session) + text("otter") + text("drive")
        body += struct.pack(">bqiqqi", 1, counter, 1, sender, counter, 0) + struct.pack(">i", len(values))
        body += b"".join(map(text, values)) + b"".join(struct.pack(">d", v) for v in values.values())
        assert read_answers(body)["asked"] == [counter]
        self.send(b"SORTIE_ANSWERS_drive", body + struct.pack(">Q", siphash(bytes(16), body)))

    def send(self, channel, payload):
        self.out.sendto(b"LC02" + bytes(4) + channel + b"\0" + payload, GROUP)

    def until(self, robot, true, seconds=20):
        """The state of a robot as soon as it is so; the newest one after that time."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            said = self.said.get(robot)
            if said and said["state"] and true(said):
                return said
            time.sleep(0.02)
        return self.said.get(robot)


def read_answers(data):
    at = 8

    def take(form):
        nonlocal at
        value = struct.unpack_from(">" + form, data, at)
        at += struct.calcsize(">" + form)
        return value[0] if len(value) == 1 else value

    def text():
        nonlocal at
        size = take("i")
        at += size
        return data[at - size:at - 1].decode()

    said = {"utime": take("q"), "session": take("q"), "robot": text(), "task": text(), "keyed": take("b"), "counter": take("q")}
    count = take("i")
    for name in ("sender", "asked"):
        said[name] = [take("q") for _ in range(count)]
    said["status"] = [take("i") for _ in range(count)]
    names = [text() for _ in range(take("i"))]
    said["state"] = {name: take("d") for name in names}
    return said


FINGERPRINT = {b"SORTIE_DRIVE": 0xD10AC911FFC49358, b"SORTIE_FLY": 0xC27E3E5B1C4AD42B}


def request(channel, session, sender, counter, mode, speed=0.0, key=KEY, age_s=0.0):
    body = struct.pack(">Qqqqq", FINGERPRINT[channel], int((time.time() - age_s) * 1e6), session, sender, counter)
    if channel == b"SORTIE_DRIVE":
        body += struct.pack(">ddiii", speed, 0.0, mode, -1, 0)
    else:
        body += struct.pack(">ddddi", 1.0, 0.0, 1.5, 0.0, mode)
    return body + struct.pack(">Q", siphash(key, body) if key else 0)


def halted(said):
    return int(said["state"].get("stop", 0)) & 2 != 0


def run(name, *more, scene="ugv_circle", secret=True):
    words = [PROGRAM, "run", "--scene", scene, "--no-rt", "--quiet", "--json", "--seconds", "300", "--set", f"robot.name={name}"]
    if scene.startswith("ugv"):
        words += ["--set", "limits.voxels=1024"]
    if secret:
        words += ["--set", "parameters.secret_file=secret"]
    return subprocess.Popen(words + list(more), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def end(process):
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    check(process.returncode == 0, "a run ends well", process.returncode, err[-500:])
    return json.loads(out)["counters"] if process.returncode == 0 else {}


def sortie(*words, code=None, says=()):
    result = subprocess.run([PROGRAM, *words], stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60)
    what = " ".join(words)
    if code is not None:
        check(result.returncode == code, f"{what} ends with {code}", result.returncode, result.stdout, result.stderr)
    for part in says:
        check(part in result.stdout + result.stderr, f"{what} says \"{part}\"", result.stdout, result.stderr)
    return result


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
            values = {"request_counter": 1e15, "stop": 2.0, "source": 3.0, "speed_m_s": 0.0, "turn_rad_s": 0.0}
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
        said = [read_answers(raw[8:].partition(b"\0")[2]) for raw in air.raw["otter"][-100:]]
        stood = [one for one in said if began < one["utime"] * 1e-6 < ended and halted(one) and one["state"]["speed_m_s"] == 0]
        check(stood, f"halt {number}: before the command ended the robot itself said that it stands", said[-3:])
        check(halted(said[-1]), f"halt {number}: and it stays", said[-1])
    for racer in racers:
        racer.going = False
        racer.join()
    # A robot that says nothing is not halted, whatever was recorded of it.
    recorded = air.raw["otter"][-20:]
    process.send_signal(signal.SIGSTOP)
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
    process.send_signal(signal.SIGSTOP)
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
    process.send_signal(signal.SIGSTOP)
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
print(f"{len(failures)} failures, {time.monotonic() - began:.0f} s", flush=True)
os.chdir("/")
if not failures:
    shutil.rmtree(work)
sys.exit(1 if failures else 0)
