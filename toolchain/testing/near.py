# SPDX-License-Identifier: BSD-3-Clause
"""toolchain/test --near FILE...: builds and runs, in the release build, the tests that stand next to changed files: those
that include a file's header, or else those that include what includes it, and so on. [heavy] and long ones are left out."""

import json
import os
import pathlib
import re
import subprocess
import sys

INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)
FOLDERS = ("rt", "drivers", "estimators", "mapping", "planner", "hil", "firmware_like", "toolchain", "tests")


def include_graph(root):
    """Who includes each file, as paths from the root."""
    users = {}
    for folder in FOLDERS:
        for path in (root / folder).rglob("*.[ch]pp"):
            for included in INCLUDE.findall(path.read_text(errors="replace")):
                users.setdefault(included, set()).add(path.relative_to(root).as_posix())
    return users


def is_test(path):
    return path.endswith("_test.cpp")


def headers_of(root, file):
    """What a file is the body of: its own header, or where it has none those that it includes first and beside it."""
    own = re.sub(r"\.cpp$", ".hpp", file)
    if (root / own).exists():
        return {own}
    folder = os.path.dirname(file)
    return {one for one in INCLUDE.findall((root / file).read_text(errors="replace")) if os.path.dirname(one) == folder}


def nearest_tests(root, file, users):
    """The tests with the fewest includes between them and the file."""
    if is_test(file):
        return {file}
    ring, seen = {file} | headers_of(root, file), set()
    while ring:
        seen |= ring
        ring = {user for one in ring for user in users.get(one, set())} - seen
        ring |= {re.sub(r"\.cpp$", ".hpp", one) for one in ring if not is_test(one)} - seen
        found = {one for one in ring if is_test(one) and not one.endswith("_long_test.cpp")}
        if found:
            return found
    return set()


def scripts(root, names):
    """ctest's names of the tests whose command mentions one of these files."""
    shown = subprocess.run(["ctest", "--test-dir", root / "build/release", "--show-only=json-v1"], capture_output=True, text=True, check=False)
    tests = json.loads(shown.stdout or '{"tests": []}')["tests"]
    return [test["name"] for test in tests if any(word.endswith(name) for name in names for word in test.get("command", []))]


def run(root, jobs, files):
    files = [os.path.relpath(pathlib.Path(file).resolve(), root) for file in files]
    missing = [file for file in files if not (root / file).exists()]
    if missing:
        print(f"toolchain/test: no file {missing[0]}", file=sys.stderr)
        return 2
    users = include_graph(root)
    code_files = [file for file in files if file.endswith((".cpp", ".hpp"))]
    tests = set().union(*(nearest_tests(root, file, users) for file in code_files)) if code_files else set()
    steps = [["cmake", "--preset", "release", "-DSORTIE_LONG_TESTS=OFF", "-DSORTIE_BATCH_TESTS=ON", "-DSORTIE_TEST_FILES=", "-DSORTIE_DESK=ON"]]
    failures = []

    def step(words, quiet=False):
        result = subprocess.run([str(word) for word in words], cwd=root, stdin=subprocess.DEVNULL, check=False,
                                stdout=subprocess.PIPE if quiet else None, stderr=subprocess.STDOUT if quiet else None, text=True)
        if result.returncode != 0:
            failures.append(" ".join(map(str, words)))
            print(result.stdout or "", file=sys.stderr)
        return result.returncode == 0

    if not step(steps[0], quiet=True):
        return 1
    binaries = {}
    for test in sorted(tests):
        binaries.setdefault(test.split("/")[1], []).append(pathlib.Path(test).stem)
    targets = [f"sortie_tests_{folder}" for folder in binaries]
    # A header whose .cpp is not compiled alone stands in a file that shows that it needs nothing before it.
    alone = root / "build/release/tests/layout/headers"
    objects = [f"tests/layout/CMakeFiles/sortie_headers.dir/headers/{path.relative_to(alone)}.o" for path in sorted(alone.rglob("*.cpp"))
               if set(re.findall('"(.+)"', path.read_text())) & set(code_files)]
    if targets + objects and not step(["ninja", "-C", root / "build/release", "-j", jobs, *targets, *objects], quiet=True):
        return 1
    for folder, stems in binaries.items():
        step([root / f"build/release/tests/sortie_tests_{folder}", "-#", ",".join(f"[#{stem}]~[heavy]" for stem in stems)])
    if code_files:
        step(["clang-format-14", "--dry-run", "-Werror", *code_files])
    for check in ("layers", "arithmetic", "atomics", "orders", "files"):
        step([sys.executable, "-B", f"tests/layout/check_{check}.py", "."])
    named = scripts(root, [pathlib.Path(file).name for file in files if file not in code_files])
    if any(file.startswith("docs/") for file in files):
        named.append("docs/")
    if named:
        step(["ctest", "--test-dir", root / "build/release", "--output-on-failure", "-R", "|".join(map(re.escape, named))])
    if not tests and not named:
        print("toolchain/test: no test stands next to " + ", ".join(files))
    for failure in failures:
        print("FAILED " + failure)
    print(f"near: {len(tests)} test files, {len(failures)} steps failed")
    return 1 if failures else 0
