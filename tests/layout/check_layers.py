# SPDX-License-Identifier: BSD-3-Clause
"""check_layers.py ROOT: who may include whom. Each finding names file:line and the rule that it breaks."""

import re
import sys

import tree

# A room sees itself and these. "rt/posix" is a room of its own: it may use threads, clocks and the kernel. So is
# "rt/convex": it alone sees libccd.
ROOMS = {
    "rt": {"rt"},
    "rt/posix": {"rt", "rt/posix"},
    "rt/convex": {"rt", "rt/convex"},
    "drivers": {"drivers", "rt", "rt/posix"},
    "estimators": {"estimators", "rt"},
    "mapping": {"mapping", "rt"},
    "planner": {"planner", "estimators", "mapping", "rt", "rt/convex"},
    "hil": {"hil", "drivers", "rt", "rt/posix", "rt/convex"},
    "firmware_like": {"firmware_like", "planner", "estimators", "mapping", "drivers", "rt", "rt/posix", "rt/convex"},
    "firmware_like/commands": {"firmware_like/commands", "hil", "firmware_like", "planner", "estimators", "mapping", "drivers", "rt", "rt/posix", "rt/convex"},
}

# The desktop program itself: it knows every command.
PROGRAM = {"firmware_like/main.cpp", "firmware_like/program.cpp", "firmware_like/program.hpp"}

# Headers from outside, and the only rooms or files that see them. CLI11, toml++ and JSON cost seconds a unit: one file each.
OUTSIDE = [
    ("Eigen", r"(unsupported/)?Eigen/", {"estimators", "mapping", "planner", "hil", "firmware_like", "firmware_like/commands"}),
    ("LCM", r"lcm/", {"drivers"}),
    ("sockets", r"(sys/socket|sys/un|arpa/|netinet/|netdb|net/|linux/can|linux/if)", {"drivers"}),
    ("CLI11", r"CLI/", {"firmware_like/command_line.cpp"}),
    ("toml++", r"toml(\+\+|\.hpp)", {"firmware_like/toml_file.cpp"}),
    ("JSON", r"nlohmann/", {"firmware_like/json_text.cpp"}),
    ("libccd", r"ccd/", {"rt/convex"}),
    (
        "the operating system, threads and streams",
        r"(sys/|linux/|unistd|fcntl|sched\.h|pthread|poll\.h|signal\.h|dlfcn|malloc\.h|time\.h|csignal|ctime|chrono"
        r"|thread|mutex|shared_mutex|condition_variable|future|semaphore|filesystem|fstream|iostream|cstdio|stdio)",
        {"rt/posix", "drivers", "hil", "firmware_like", "firmware_like/commands"},
    ),
    ("std random distributions", r"random$", set()),
]

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')


def room_of(path):
    if path.as_posix() in PROGRAM:
        return "firmware_like/commands"
    parts = path.parts
    for deep in ("/".join(parts[:2]), parts[0]):
        if deep in ROOMS and (len(parts) > deep.count("/") + 1):
            return deep
    return None


def target_room(include):
    parts = include.split("/")
    deep = "/".join(parts[:2])
    if deep in ROOMS and len(parts) > 2:
        return deep
    return parts[0] if parts[0] in ROOMS else None


def judge(path, room, kind, include):
    for name, pattern, allowed in OUTSIDE:
        if re.match(pattern, include) and not {room, path.as_posix()} & allowed:
            return f"{room} may not see {name} (<{include}>)"
    target = target_room(include)
    if target is not None and target not in ROOMS[room]:
        return f"{room} may not include {target} ({include})"
    if target is not None and kind == "<":
        return f"write the project's own headers in quotes ({include})"
    if target is None and kind == '"' and not include.startswith("sortie"):
        return f'includes are written from the root: "{include}" is not'
    return None


def main(root):
    findings, checked = [], 0
    for path in tree.files(root, {".hpp", ".cpp", ".h"}, tree.FOLDERS):
        room = room_of(path)
        if room is None:
            continue
        checked += 1
        for number, line in enumerate((tree.pathlib.Path(root) / path).read_text().splitlines(), 1):
            match = INCLUDE.match(line)
            verdict = judge(path, room, match[1], match[2]) if match else None
            if verdict:
                findings.append(f"{path}:{number}: {verdict}")
    tree.finish(findings, checked, "layers")


main(sys.argv[1])
