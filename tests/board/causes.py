# SPDX-License-Identifier: BSD-3-Clause
"""causes.py PROGRAM [PAUSES]: boots PROGRAM as the only program of an emulated board with Debian's PREEMPT_RT kernel,
pauses the whole board now and then, and counts how many of these pauses the board has called stolen time. Before that
the board works longer than it should, which must not be called so. Prints rows of the confusion table; exit code 1
below 95 % (own work: 75 %, for an emulated processor is never quite undisturbed). SORTIE_BOARD_KERNEL names a kernel,
else Debian's is downloaded once."""

import gzip
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import time

PAUSE_S = 0.08  # far above what an emulated processor on a busy host does by itself
CAUSES = ["own work", "interrupt", "run queue", "stolen", "unknown"]


def skip(why):
    print(f"skipped: {why}")
    sys.exit(0)


def kernel():
    named = os.environ.get("SORTIE_BOARD_KERNEL")
    if named:
        return named
    store = pathlib.Path(os.environ.get("XDG_CACHE_HOME", pathlib.Path.home() / ".cache")) / "sortie" / "board"
    store.mkdir(parents=True, exist_ok=True)
    found = sorted((store / "boot").glob("vmlinuz-*-rt-amd64"))
    if not found:
        depends = subprocess.run(["apt-cache", "depends", "linux-image-rt-amd64"], capture_output=True, text=True)
        names = [line.split()[-1] for line in depends.stdout.splitlines() if "Depends:" in line]
        if not names or subprocess.run(["apt-get", "download", names[0]], cwd=store, capture_output=True).returncode:
            skip("no kernel for the board; name one in SORTIE_BOARD_KERNEL")
        for package in store.glob("*.deb"):
            subprocess.run(["dpkg-deb", "--fsys-tarfile", package], stdout=(store / "files.tar").open("wb"), check=True)
            subprocess.run(["tar", "-xf", "files.tar", "--wildcards", "./boot/vmlinuz-*"], cwd=store, check=True)
            (store / "files.tar").unlink()
            package.unlink()
        found = sorted((store / "boot").glob("vmlinuz-*-rt-amd64"))
    return str(found[-1])


def initramfs(program, path):
    """One file, /init, in the format that the kernel unpacks (cpio, newc)."""
    def entry(name, mode, data):
        fields = [1, mode, 0, 0, 1, 0, len(data), 0, 0, 0, 0, len(name) + 1, 0]
        head = b"070701" + b"".join(b"%08X" % field for field in fields) + name.encode() + b"\0"
        head += b"\0" * (-len(head) % 4)
        return head + data + b"\0" * (-len(data) % 4)

    content = entry("init", 0o100755, pathlib.Path(program).read_bytes()) + entry("TRAILER!!!", 0, b"")
    path.write_bytes(gzip.compress(content, 1))


def undisturbed():
    """Ahead of everything ordinary: otherwise this machine's other programs steal from the board all the time."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(5))
    except OSError:
        pass


def row(name, injected, labels, right, total_ns, unknown_ns):
    share = 100.0 * labels[right] / max(sum(labels), 1)
    print(f"| {name} | {injected} | {sum(labels)} | " + " | ".join(str(label) for label in labels) +
          f" | {share:.1f} % | {total_ns / 1e6:.1f} | {100.0 * unknown_ns / max(total_ns, 1):.2f} % |")
    return share


def main(program, pauses):
    if shutil.which("qemu-system-x86_64") is None:
        skip("qemu-system-x86_64 is missing. Cure: toolchain/install board")
    image = kernel()
    ramdisk = pathlib.Path(program).with_suffix(".gz")
    initramfs(program, ramdisk)
    seconds = pauses * 0.4 + 5
    board = subprocess.Popen(
        ["qemu-system-x86_64", "-accel", "tcg", "-M", "q35", "-cpu", "max", "-smp", "1", "-m", "256", "-nodefaults",
         "-no-reboot", "-nographic", "-serial", "stdio", "-monitor", "none", "-kernel", image, "-initrd", str(ramdisk),
         "-append", f"console=ttyS0 quiet no_timer_check panic=-1 seconds={seconds}"],
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace",
        preexec_fn=undisturbed)
    chance = random.Random(1)
    lines = []
    for line in board.stdout:
        lines.append(line)
        if "BOARD-READY" in line:
            time.sleep(1.5)
            for _ in range(pauses):
                board.send_signal(signal.SIGSTOP)
                time.sleep(PAUSE_S)
                board.send_signal(signal.SIGCONT)
                time.sleep(0.2 + 0.1 * chance.random())
    board.wait(60)
    if not any("BOARD-END" in line for line in lines):
        print("".join(lines[-30:]))
        print("the board did not come to its end")
        sys.exit(1)
    delays = [line.split()[1:] for line in lines if line.startswith("DELAY ")]
    labels = [0] * len(CAUSES)
    others = [0] * len(CAUSES)
    total = unknown = 0
    for delay in delays:
        late, parts = int(delay[1]), [int(part) for part in delay[2:7]]
        if late < 0.75e9 * PAUSE_S:  # the emulation's own
            others[parts.index(max(parts))] += 1
            continue
        labels[parts.index(max(parts))] += 1
        total += late
        unknown += parts[4]
    end = [line for line in lines if "BOARD-END" in line][0].strip()
    print(f"{end}; shorter delays: " + ", ".join(f"{n} {cause}" for n, cause in zip(others, CAUSES)))
    own = [line.split("OWN-WORK")[1].split() for line in lines if "OWN-WORK" in line][0]
    own = [int(number) for number in own]
    own_share = row("own work on an emulated board", own[0], own[2:7], 0, own[7], own[8])
    share = row("emulated board paused", pauses, labels, 3, total, unknown)
    sys.exit(0 if share >= 95.0 and own_share >= 75.0 and sum(labels) >= 0.9 * pauses else 1)


main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 60)
