#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# The images of firmware_like/bare_metal on an emulated microcontroller, beside their twins on this machine: equal digests, no heap, and
# what flash, memory, stack and instructions they take. Usage: bare_metal_test.py BOARD IMAGES TWINS BARE_RECORDING SORTIE
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

board_name = sys.argv[1]
images, twins, recorder, program = (pathlib.Path(a).resolve() for a in sys.argv[2:6])
for tool in ("qemu-system-arm", "arm-none-eabi-size"):
    if shutil.which(tool) is None:
        print(f"skipped: {tool} is missing (toolchain/install board)")
        sys.exit(77)
if not (images / "sortie_bare_uav").exists():
    print(f"skipped: no images (cmake --preset {board_name} && cmake --build --preset {board_name})")
    sys.exit(77)
work = pathlib.Path(tempfile.mkdtemp(prefix="sortie-bare-"))
failures = []
MACHINE = {"cortex-m7": "mps2-an500", "cortex-m4f": "mps2-an386"}[board_name]
QEMU = f"qemu-system-arm -M {MACHINE} -nographic -monitor none -serial none -semihosting-config enable=on,target=native -icount shift=0"
NS_A_COUNT = 40  # SysTick at 25 MHz; with shift=0 an instruction is a nanosecond
# A flight has to fit 64 KiB of each on a Cortex-M7. The others are what they took when this was written, and a few per cent more.
LIMITS = {
    "cortex-m7": {"uav": {"flash": 65536, "ram": 65536, "share": 0.06}, "ugv": {"flash": 122000, "ram": 26000, "share": 0.03}},
    "cortex-m4f": {"uav": {"flash": 79000, "ram": 67500, "share": 0.80}, "ugv": {"flash": 136000, "ram": 26000, "share": 0.12}},
}[board_name]


def check(good, what, *shown):
    if not good:
        failures.append(what)
        print("FAILED", what, *shown)


def emulate(image, expect=0):
    result = subprocess.run(QEMU.split() + ["-kernel", str(image)], cwd=work, stdin=subprocess.DEVNULL, capture_output=True,
                            text=True, timeout=200)
    check(result.returncode == expect, f"{image.name} ends with {expect}", result.returncode, result.stdout, result.stderr)
    return result.stdout + result.stderr  # QEMU writes what the board prints to stderr


def record(*arguments):
    subprocess.run([str(recorder), *map(str, arguments), str(work / "recording.bin")], check=True)


sums, sums_here = json.loads(emulate(images / "sortie_bare_arithmetic")), json.loads(
    subprocess.run([str(twins / "sortie_bare_arithmetic")], capture_output=True, text=True, check=True).stdout)
check(len(sums) == 16 and sums == sums_here, "arithmetic is the desktop's", [name for name in sums_here if sums.get(name) != sums_here[name]])
check("no recording.bin" in emulate(images / "sortie_bare_uav", expect=3), "a board without a recording says so")
log = work / "drive.lcm"
subprocess.run([str(program), "run", "--scene", "ugv_ramp", "--virtual", "--seconds", "10", "--record", str(log), "--lcm-url", "none"],
               check=True, capture_output=True)
for robot, source in (("uav", ("flight", 20)), ("ugv", ("log", log))):
    record(*source)
    twin = json.loads(subprocess.run([str(twins / f"sortie_bare_{robot}")], cwd=work, capture_output=True, text=True, check=True).stdout)
    image = images / f"sortie_bare_{robot}"
    board = json.loads(emulate(image))
    check(board["records"] == twin["records"] > 1000, "all records were read", board, twin)
    check(board["digest"] == twin["digest"], f"{robot}: the digest of the desktop", board, twin)
    text, data, bss = map(int, subprocess.run(["arm-none-eabi-size", str(image)], capture_output=True, text=True,
                                              check=True).stdout.splitlines()[1].split()[:3])
    names = subprocess.run(["arm-none-eabi-nm", "-C", str(image)], capture_output=True, text=True, check=True).stdout
    check(not any(f" {name}" in names for name in ("malloc", "__cxa_throw", "_sbrk", "sbrk")), "no heap, no exceptions")
    flash, ram = text + data, data + bss + board["stack_bytes"]
    share = board["counts"] * NS_A_COUNT / (board["ticks"] * 1e6) * 1000 / 216  # of 216 million instructions a second
    most = board["most_counts"] * NS_A_COUNT
    check(flash <= LIMITS[robot]["flash"], f"{robot}: flash", flash)
    check(ram <= LIMITS[robot]["ram"], f"{robot}: memory", ram)
    check(share <= LIMITS[robot]["share"], f"{robot}: share of 216 MHz", share)
    print(f"{robot}: flash {flash} B, memory {ram} B (stack {board['stack_bytes']} B of it), {100 * share:.1f} % of 216 million "
          f"instructions a second, dearest task run {most} instructions, digest {board['digest']}")
# A recording that was cut off is told, and nothing else is claimed.
whole = (work / "recording.bin").read_bytes()
(work / "recording.bin").write_bytes(whole[:-7])
check("ends within a record" in emulate(images / "sortie_bare_ugv", expect=3), "a recording that is cut off")
# One changed bit of one reading changes the digest: the comparison can fail. A reading of the drive: a robot that stands, as at the
# start, does not move by a bit.
changed = bytearray(whole)
changed[80 * (len(whole) // 160) + 30] ^= 1
(work / "recording.bin").write_bytes(bytes(changed))
check(json.loads(emulate(images / "sortie_bare_ugv"))["digest"] != board["digest"], "a changed bit changes the digest")
shutil.rmtree(work, ignore_errors=True)
sys.exit(1 if failures else 0)
