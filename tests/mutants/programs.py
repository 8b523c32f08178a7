# SPDX-License-Identifier: BSD-3-Clause
"""A build tree as Ninja knows it, and test programs of one file each that are linked with a fault in them."""

import collections
import json
import os
import pathlib
import re
import shlex
import signal
import subprocess
import threading
import time

from listed import ListError, changed

MOST_UNITS = 40  # a header that more of a program's units include is no place for a fault: it takes minutes


def run(words, folder, limit=600):
    result = subprocess.run(words, cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace", timeout=limit, check=False)
    return result.returncode, result.stdout + result.stderr


class Tree:
    """A build tree: how its units are compiled, what they include, and how the test programs are linked."""

    def __init__(self, root, build, jobs):
        self.root, self.build, self.jobs = root, build, jobs
        self.units = {}  # object, relative to the build tree: (source, words of its command)
        for entry in json.loads((build / "compile_commands.json").read_text()):
            words = shlex.split(entry["command"])
            self.units[words[words.index("-o") + 1]] = (entry["file"], words)
        self.lock = threading.Lock()
        self.links = {}
        self.includes = {}  # file: objects that were made with it

    def read_includes(self):
        found = collections.defaultdict(set)
        unit = ""
        for line in run(["ninja", "-t", "deps"], self.build)[1].splitlines():
            if line.startswith("    "):
                found[os.path.normpath(self.build / line.strip())].add(unit)
            else:
                unit = line.partition(":")[0]
        return found

    def link(self, folder):
        """The words before and after the test's own objects. The first time the libraries are built."""
        with self.lock:
            if folder not in self.links:
                code, output = run(["ninja", "-t", "commands", f"sortie_tests_{folder}"], self.build)
                if code != 0:
                    raise ListError(f"{self.build} has no sortie_tests_{folder}: configure it with all tests")
                words = [word for word in shlex.split(output.splitlines()[-1]) if word not in (":", "&&")]
                out = words.index("-o")
                objects = [word for word in words[:out] if word.endswith(".o")]
                needed = [word for word in words if "sortie_test_main" in word or (word.endswith(".a") and not word.startswith("/"))]
                code, output = run(["nice", "ninja", "-j", str(self.jobs), *dict.fromkeys(needed), "sortie_test_catch",
                                    f"cmake_object_order_depends_target_sortie_tests_{folder}"], self.build, 7200)
                if code != 0:
                    raise ListError("the tree does not build:\n" + "\n".join(output.splitlines()[-5:]))
                self.includes = self.read_includes()
                self.links[folder] = ([word for word in words[:out] if word not in objects or "sortie_test_main" in word], words[out + 2:])
            return self.links[folder]

    def compile(self, words, source, obj, overlay=None):
        words = [*words[:1], *(["-I", str(overlay)] if overlay else []), *words[1:words.index("-o")], "-o", str(obj), "-c", str(source)]
        obj.parent.mkdir(parents=True, exist_ok=True)
        code, output = run(words, self.build)
        if code != 0:
            raise ListError("does not compile:\n" + "\n".join([line for line in output.splitlines() if "error" in line][:5] or output.splitlines()[-5:]))


class Program:
    """One file of tests, linked without a fault, and what of the libraries got into it."""

    def __init__(self, tree, test, scratch):
        self.tree, self.folder = tree, test.partition("/")[0]
        self.source, self.object = tree.root / f"tests/{test}.cpp", scratch / "tests" / f"{test}.o"
        self.seconds, self.cases = 0.0, 0
        tree.link(self.folder)
        self.words = next(words for obj, (_, words) in tree.units.items() if f"/sortie_tests_{self.folder}.dir/" in obj)
        deps = self.object.with_suffix(".d")
        tree.compile([*self.words[:1], "-MD", "-MF", str(deps), *self.words[1:]], self.source, self.object)
        self.headers = {os.path.normpath(tree.build / word) for word in deps.read_text().replace("\\\n", " ").split()[1:]}
        table = self.object.with_suffix(".map")
        self.link(self.object.with_suffix(""), [self.object], [f"-Wl,-Map={table}"])
        self.members = set(re.findall(r"^([^\s()]+\.a)\(([^\s()]+\.o)\)", table.read_text(errors="replace"), re.M))
        self.seconds, how = self.cases_of(self.object.with_suffix(""), 600)
        if how:
            raise ListError(f"{test}: fails without any fault: {how}")
        if not self.cases:
            raise ListError(f"{test}: runs no case")

    def link(self, program, objects, more=()):
        before, after = self.tree.link(self.folder)
        code, output = run([*before, *more, *map(str, objects), "-o", str(program), *after], self.tree.build)
        if code != 0:
            raise ListError("does not link:\n" + "\n".join(output.splitlines()[-5:]))

    def has(self, obj):
        """Whether the unit of a library is part of the program."""
        library, _, name = obj.partition("/CMakeFiles/")
        target, _, name = name.partition(".dir/")
        return (f"{library}/lib{target}.a", pathlib.PurePath(name).name) in self.members

    def cases_of(self, program, limit):
        """Seconds, and the first case that failed, or an empty text."""
        notes = program.with_suffix(".notes")
        notes.write_text("")
        begin = time.monotonic()
        process = subprocess.Popen([program, "--abort"], cwd=program.parent, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL, start_new_session=True, env={**os.environ, "SORTIE_TEST_NOTES": str(notes)})
        try:
            code, end = process.wait(limit), ""
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            code, end = process.wait(), f" (hangs: more than {limit:.0f} s)"
        seconds = time.monotonic() - begin
        case, verdict = "", ""
        for word, _, rest in (line.partition("\t") for line in notes.read_text(errors="replace").splitlines()):
            if word == "begin":
                case, verdict = rest, word
                self.cases += self.seconds == 0.0
            elif word in ("passed", "failed"):
                verdict = word
        if code == 0:
            return seconds, ""
        return seconds, case + (end or (f" (dies of {signal.Signals(-code).name})" if code < 0 else "") if verdict != "passed" else " ends badly")

    def trial(self, fault, scratch):
        """The first case that the fault makes fail, or an empty text."""
        overlay = scratch / "overlay"
        copy = overlay / fault["file"]
        copy.parent.mkdir(parents=True)
        copy.write_text(changed(self.tree.root, fault))
        original = os.path.normpath(self.tree.root / fault["file"])
        units = [obj for obj in self.tree.includes.get(original, ()) if self.has(obj)]
        if not units and original not in self.headers:
            raise ListError(f"nothing in the tests of {fault['test']} is compiled from {fault['file']} by itself")
        if len(units) > MOST_UNITS:
            raise ListError(f"{len(units)} units of the program include {fault['file']}, more than {MOST_UNITS}")
        objects = []
        for index, unit in enumerate(sorted(units)):
            source, words = self.tree.units[unit]
            objects.append(scratch / f"{index}.o")
            source = pathlib.Path(source)
            if os.path.normpath(source) == original:
                source = copy
            elif copy.suffix == ".cpp":  # compiled in a batch: a file that includes several
                batch = scratch / source.name
                batch.write_text(source.read_text().replace(original, str(copy)))
                source = batch
            self.tree.compile(words, source, objects[-1], overlay)
        if original in self.headers:
            objects.append(scratch / "test.o")
            self.tree.compile(self.words, self.source, objects[-1], overlay)
        else:
            objects.append(self.object)
        self.link(scratch / "program", objects)
        return self.cases_of(scratch / "program", 20 + 10 * self.seconds)[1]
