#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Boots the emulated ARM board (QEMU, Debian's PREEMPT_RT kernel), lets it do jobs (hil/board/jobs), and collects what they left.
Instructions are its clock: one is a nanosecond, whatever this machine does meanwhile, so that a run repeats to the last byte.
As a program: emulate.py JOB... [--out DIR] [--build DIR]; the console goes to stdout. docs/board.md tells more."""
import argparse
import fcntl
import gzip
import io
import os
import pathlib
import shutil
import subprocess
import sys
import tarfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
CACHE = pathlib.Path(os.environ.get("SORTIE_BOARD", ROOT / "build/board"))
# Exact figures are promised for these alone. A mirror that has moved on gives its present kernel instead.
PINNED = ["linux-image-6.1.0-50-rt-arm64=6.1.176-1", "busybox-static=1:1.35.0-4+deb12u1+b1", "can-utils=2020.11.0-1"]
PRESENT = ["linux-image-rt-arm64:", "busybox-static", "can-utils"]
CAN_TOOLS = ["candump", "canplayer"]
MODULES = ["can", "can-dev", "can-raw", "vcan", "sja1000", "kvaser_pci", "virtio_pci_modern_dev", "virtio_pci_legacy_dev", "virtio_pci",
           "virtio_blk"]
TRIPLE = "aarch64-linux-gnu"
QEMU = ("qemu-system-aarch64 -accel tcg -M virt,gic-version=3,dtb-randomness=off -cpu cortex-a72 -smp 1 -m 1024 -nodefaults -no-reboot "
        "-nographic -serial stdio -monitor none -rtc base=2026-01-01T00:00:00,clock=vm -icount shift=0,sleep=off "
        "-object can-bus,id=bus -device kvaser_pci,canbus=bus -device kvaser_pci,canbus=bus")


class Missing(Exception):
    """Something that the board needs is not on this machine; the text says what and the cure."""


def require_tools():
    for tool in ("qemu-system-aarch64", "apt-get", "dpkg-deb", f"{TRIPLE}-objdump"):
        if shutil.which(tool) is None:
            raise Missing(f"{tool} is missing (toolchain/install cross board)")


def fetch():
    """Kernel, busybox and can-utils of the board, from Debian's packages; kept in build/board. Returns (folder, versions)."""
    require_tools()
    CACHE.mkdir(parents=True, exist_ok=True)
    tree = CACHE / "packages"
    with open(CACHE / "lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        complete, names = tree / ".complete", " ".join(p.split("=")[0] for p in PINNED)
        if not complete.exists() or complete.read_text() != names:
            for wanted in (PINNED, PRESENT):
                shutil.rmtree(tree, ignore_errors=True)
                if subprocess.run([ROOT / "toolchain/foreign-packages", "arm64", tree, *wanted], stdout=sys.stderr).returncode == 0:
                    break
            else:
                raise Missing("no kernel for the board: the package mirror did not answer")
            complete.write_text(names)
    return tree, dict(line.split() for line in (tree / ".versions").read_text().splitlines())


def is_pinned(versions):
    """Whether kernel, busybox, can-utils and emulator are those that exact figures were committed for."""
    emulator = subprocess.run(["qemu-system-aarch64", "--version"], capture_output=True, text=True).stdout
    return all(versions.get(p.split("=")[0]) == p.split("=")[1] for p in PINNED) and "version 7.2." in emulator


def needed_libraries(programs, folders):
    """Shared libraries of these programs, and theirs."""
    found, open_files = {}, list(programs)
    while open_files:
        text = subprocess.run([f"{TRIPLE}-objdump", "-p", open_files.pop()], capture_output=True, text=True, check=True).stdout
        for name in (line.split()[1] for line in text.splitlines() if "NEEDED" in line):
            if name in found:
                continue
            path = next((f / name for f in folders if (f / name).exists()), None)
            if path is None:
                raise Missing(f"library {name} for ARM is missing (toolchain/sysroot arm64)")
            found[name] = path
            open_files.append(path)
    return found


class Archive:
    """An initramfs (cpio, newc), the same bytes every time."""

    def __init__(self):
        self.data, self.number, self.folders = io.BytesIO(), 0, set()

    def entry(self, name, mode, content):
        self.number += 1
        fields = (self.number, mode, 0, 0, 1, 0, len(content), 0, 0, 0, 0, len(name) + 1, 0)
        self.data.write(b"070701" + b"".join(b"%08x" % f for f in fields) + name.encode() + b"\0")
        self.data.write(b"\0" * (-self.data.tell() % 4) + content)
        self.data.write(b"\0" * (-self.data.tell() % 4))

    def add(self, name, path, mode=0o100755):
        folder = os.path.dirname(name)
        if folder and folder not in self.folders:
            self.folders.add(folder)
            if "/" in folder and os.path.dirname(folder) not in self.folders:
                self.folders.add(os.path.dirname(folder))
                self.entry(os.path.dirname(folder), 0o40755, b"")
            self.entry(folder, 0o40755, b"")
        self.entry(name, mode, pathlib.Path(path).read_bytes())

    def write(self, path):
        self.entry("TRAILER!!!", 0, b"")
        with open(path, "wb") as file, gzip.GzipFile("", "wb", 1, file, mtime=0) as packed:
            packed.write(self.data.getvalue())


def make_initramfs(path, tree, build):
    programs = [build / "sortie", build / "sortie_board"]
    for program in programs:
        if not program.exists():
            raise Missing(f"{program.name} for ARM is missing (cmake --preset aarch64 && cmake --build --preset aarch64 --target sortie sortie_board)")
    cache = (build / "CMakeCache.txt").read_text()
    sysroot = pathlib.Path(next(line.split("=", 1)[1] for line in cache.splitlines() if line.startswith("SORTIE_SYSROOT:"))
                           if "SORTIE_SYSROOT:" in cache else ROOT / "build/sysroots/arm64")
    folders = [sysroot / "usr/lib" / TRIPLE, sysroot / "lib" / TRIPLE, pathlib.Path(f"/usr/{TRIPLE}/lib")]
    archive = Archive()
    archive.add("init", HERE / "init")
    archive.add("bin/busybox", tree / "bin/busybox")
    with_symbols = []
    for program in programs:
        lean = pathlib.Path(path).parent / f"{program.name}.lean"  # without debug information: the board has no use for it
        subprocess.run([f"{TRIPLE}-strip", "-o", lean, program], check=True)
        archive.add(f"bin/{program.name}", lean)
        with_symbols.append(lean)
    tools = [tree / "usr/bin" / tool for tool in CAN_TOOLS]
    for tool in tools:
        archive.add(f"bin/{tool.name}", tool)
    for name, library in sorted(needed_libraries(programs + tools, folders).items()):
        archive.add(f"lib/{name}", library)
    for lean in with_symbols:
        lean.unlink()
    modules = {p.stem: p for p in (tree / "lib/modules").rglob("*.ko")}
    for module in MODULES:
        archive.add(f"lib/modules/{module}.ko", modules[module], 0o100644)
    for job in sorted((HERE / "jobs").iterdir()):
        archive.add(f"jobs/{job.name}", job, 0o100644)
    archive.write(path)


def boot(jobs, out, build, timeout_s=3000, echo=None, settings=()):
    """Runs the jobs on a fresh board; settings ("seconds=5") reach them as variables. Their files come to out/JOB/. Returns (exit code of the board, console)."""
    tree, _ = fetch()
    out = pathlib.Path(out)
    out.mkdir(parents=True, exist_ok=True)
    initramfs, disk = out / "initramfs.gz", out / "disk"
    make_initramfs(initramfs, tree, pathlib.Path(build))
    with open(disk, "wb") as file:
        file.truncate(1 << 29)
    kernel = next((tree / "boot").glob("vmlinuz-*"))
    command = QEMU.split() + ["-kernel", str(kernel), "-initrd", str(initramfs), "-drive", f"if=none,id=out,format=raw,file={disk}",
                              "-device", "virtio-blk-pci,drive=out,romfile=", "-append",
                              f"console=ttyAMA0 quiet panic=-1 nokaslr {' '.join(settings)} jobs={','.join(jobs)}"]
    lines = []
    emulator = subprocess.Popen(["timeout", str(timeout_s), *command], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                stderr=subprocess.STDOUT)
    for raw in emulator.stdout:
        line = raw.decode(errors="replace").rstrip("\r\n")
        lines.append(line)
        if echo is not None:
            print(line, file=echo, flush=True)
    emulator.wait()
    code = next((int(line.split()[1]) for line in lines if line.startswith("BOARD-EXIT ")), 255)
    if code != 255:
        with tarfile.open(disk) as archive:
            for member in archive.getmembers():
                if member.isfile():
                    target = out / member.name
                    target.parent.mkdir(parents=True, exist_ok=True)
                    target.write_bytes(archive.extractfile(member).read())
    disk.unlink()
    initramfs.unlink()
    # What follows the last word waits for this machine's disk, and only that does.
    last = next((i + 1 for i, line in enumerate(lines) if line.startswith("BOARD-EXIT ")), len(lines))
    console = "\n".join(lines[:last]) + "\n"
    (out / "console.txt").write_text(console)
    return code, console


def main():
    parser = argparse.ArgumentParser(description="Boots the emulated ARM board and lets it do jobs; see docs/board.md")
    parser.add_argument("jobs", nargs="*", help="names in hil/board/jobs, and NAME=VALUE for them; none: only fetches kernel and busybox")
    parser.add_argument("--out", default=str(CACHE / "out"), help="where consoles and files go (%(default)s)")
    parser.add_argument("--build", default=str(ROOT / "build/aarch64"), help="build tree with the board's programs (%(default)s)")
    options = parser.parse_args()
    try:
        _, versions = fetch()
        if not options.jobs:
            print("\n".join(f"{name} {version}" for name, version in sorted(versions.items())))
            return 0
        settings = [word for word in options.jobs if "=" in word]
        return boot([job for job in options.jobs if "=" not in job], options.out, options.build, echo=sys.stdout, settings=settings)[0]
    except Missing as missing:
        print(f"board: {missing}", file=sys.stderr)
        return 4


if __name__ == "__main__":
    sys.exit(main())
