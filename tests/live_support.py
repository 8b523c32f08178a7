# SPDX-License-Identifier: BSD-3-Clause
# What the tests of live runs share: a network of their own, the real programs, and a second hand that writes requests and
# reads answers, tag and all. A script that imports it is called with PROGRAM [SEED].
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
    sys.exit(f"usage: {os.path.basename(sys.argv[0])} PROGRAM [SEED]")
PROGRAM = os.path.abspath(sys.argv[1])
SEED = int(sys.argv[2]) if len(sys.argv) > 2 else random.SystemRandom().randrange(1 << 32)
if os.environ.get("SORTIE_OWN_NETWORK") != "1":
    if subprocess.run(["unshare", "-rn", "sh", "-c", "ip link set lo up && ip route add 224.0.0.0/4 dev lo"],
                      stderr=subprocess.DEVNULL).returncode != 0:
        print("skipped: no network namespace of its own")
        sys.exit(77)
    os.environ["SORTIE_OWN_NETWORK"] = "1"
    os.execvp("unshare", ["unshare", "-rn", sys.executable, os.path.abspath(sys.argv[0]), PROGRAM, str(SEED)])
subprocess.run("ip link set lo up && ip route add 224.0.0.0/4 dev lo", shell=True, check=True)
random.seed(SEED)
print("seed", SEED, flush=True)

work = pathlib.Path(tempfile.mkdtemp(prefix="sortie-live-"))
os.chdir(work)
GROUP = ("239.255.76.67", 7667)
KEY = bytes(random.randrange(256) for _ in range(16))
pathlib.Path("secret").write_text(KEY.hex() + "\n")
pathlib.Path("secret").chmod(0o600)
DRIVE, RELEASE, HALT = 0, 1, 2  # modes of a request
STOP_HALT, STOP_EMERGENCY = 2, 256  # why a drive stops
STANDS = {"stop": float(STOP_HALT), "speed_m_s": 0.0, "turn_rad_s": 0.0, "source": 3.0}
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


def ear():
    """A socket that hears the group."""
    heard = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    heard.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    heard.bind(GROUP)
    heard.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, socket.inet_aton(GROUP[0]) + bytes(4))
    return heard


class Air:
    """The group: sends what it is told, and remembers the newest answers of every run."""

    def __init__(self):
        self.out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.inward = ear()
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
            said = read_answers(payload)
            self.said[said["robot"]] = said
            self.raw.setdefault(said["robot"], []).append(bytes_)

    def forge(self, asked):
        """Whoever hears a request can say that it was admitted and that the robot stands, but not under the tag."""
        _, _, session, sender, counter = struct.unpack_from(">Qqqqq", asked)
        self.send(b"SORTIE_ANSWERS_drive", answers("otter", session, STANDS, [(sender, counter)], bytes(16)))

    def send(self, channel, payload):
        self.out.sendto(b"LC02" + bytes(4) + channel + b"\0" + payload, GROUP)

    def between(self, robot, began, ended):
        """What a robot has said of late between two times."""
        said = [read_answers(raw[8:].partition(b"\0")[2]) for raw in self.raw[robot][-100:]]
        return [one for one in said if began < one["utime"] * 1e-6 < ended]

    def until(self, robot, true, seconds=20):
        """The state of a robot as soon as it is so; the newest one after that time."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            said = self.said.get(robot)
            if said and said["state"] and true(said):
                return said
            time.sleep(0.02)
        return self.said.get(robot)


def answers(robot, session, state, asked, key=KEY):
    """What a drive says that has admitted these requests, of (sender, counter) each."""
    text = lambda word: struct.pack(">i", len(word) + 1) + word.encode() + b"\0"
    counter = max((counter for _, counter in asked), default=0)
    body = struct.pack(">Qqq", 0x054BF8BA8BEE8ABE, int(time.time() * 1e6), session) + text(robot) + text("drive")
    body += struct.pack(">bqi", 1, counter, len(asked))
    for column in zip(*asked):
        body += struct.pack(f">{len(column)}q", *column)
    body += bytes(4 * len(asked)) + struct.pack(">i", len(state))
    body += b"".join(map(text, state)) + struct.pack(f">{len(state)}d", *state.values())
    return body + struct.pack(">Q", siphash(key, body))


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


FINGERPRINT = {b"SORTIE_DRIVE": 0xB636FB087D9DDC3C, b"SORTIE_FLY": 0xC27E3E5B1C4AD42B}


def request(channel, session, sender, counter, mode, speed=0.0, key=KEY, age_s=0.0):
    body = struct.pack(">Qqqqq", FINGERPRINT[channel], int((time.time() - age_s) * 1e6), session, sender, counter)
    if channel == b"SORTIE_DRIVE":
        body += struct.pack(">ddiiidd", speed, 0.0, mode, -1, 0, 0.0, 0.0)
    else:
        body += struct.pack(">ddddi", 1.0, 0.0, 1.5, 0.0, mode)
    return body + struct.pack(">Q", siphash(key, body) if key else 0)


def stopped_by(said, why):
    return int(said["state"].get("stop", 0)) & why != 0


def halted(said):
    return stopped_by(said, STOP_HALT)


def run(name, *more, scene="ugv_circle", secret=True):
    words = [PROGRAM, "run", "--scene", scene, "--no-rt", "--quiet", "--json", "--seconds", "300", "--set", f"robot.name={name}"]
    if scene.startswith("ugv"):
        words += ["--set", "limits.voxels=1024"]
    if secret:
        words += ["--set", "parameters.secret_file=secret"]
    return subprocess.Popen(words + list(more), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def pause(process):
    """Stops a run by a signal. On a busy machine its threads go on for milliseconds, and what they take then they may obey."""
    process.send_signal(signal.SIGSTOP)
    state = lambda thread: (thread / "stat").read_text().rpartition(")")[2].split()[0]
    end = time.monotonic() + 10
    while not (stopped := all(state(thread) == "T" for thread in pathlib.Path(f"/proc/{process.pid}/task").iterdir())):
        if time.monotonic() > end:
            break
        time.sleep(0.001)
    check(stopped, "a run is stopped by a signal")


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


def finish(began):
    """Tells how it went and ends the test; what failed leaves its folder."""
    print(f"{len(failures)} failures, {time.monotonic() - began:.0f} s", flush=True)
    os.chdir("/")
    if not failures:
        shutil.rmtree(work)
    sys.exit(1 if failures else 0)
