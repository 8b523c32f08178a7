# SPDX-License-Identifier: BSD-3-Clause
"""check_layers.py ROOT: who may include whom. Each finding names file:line and the rule that it breaks."""

import re
import sys

import tree

# A room sees itself and these. "rt/posix" is a room of its own: it may use threads, clocks and the kernel. So is
# "rt/convex": it alone sees libccd. The map's rooms stand on its grid; recognition stands on segments and registration, too.
MAPPING = {"mapping/grid", "mapping/segments", "mapping/occupancy", "mapping/registration", "mapping/recognition", "mapping/elevation"}
GROUND = {"rt", "rt/posix", "rt/convex"}
BELOW = GROUND | {"planner", "estimators", "drivers"} | MAPPING


def floors(folder, names, below):
    """The rooms of a folder, floor by floor: each sees itself, the floors below it and what is below the folder."""
    rooms = {}
    for floor in names:
        lower = set(rooms) | below
        rooms |= {f"{folder}/{name}": {f"{folder}/{name}"} | lower for name in floor}
    return rooms


# What is flashed.
FLASHED = floors("firmware_like", [["scene"], ["result"], ["runtime"], ["log", "parts"], ["link", "doctor", "robots"], ["live"]], BELOW)
# The desk: one room of it alone sees simulated robots. `package` holds headers that are installed.
DESK = floors(
    "toolchain",
    [["import", "export", "judge", "simulate"], ["report"], ["bench"], ["sweep"], ["commands"], ["program"], ["package"]],
    {"firmware_like", *FLASHED} | BELOW,
)
DESK["toolchain/simulate"] |= {"hil"}
ROOMS = {
    "rt": {"rt"},
    "rt/posix": {"rt", "rt/posix"},
    "rt/convex": {"rt", "rt/convex"},
    "drivers": {"drivers", "rt", "rt/posix"},
    "estimators": {"estimators", "rt"},
    "mapping/grid": {"mapping/grid", "rt"},
    "mapping/segments": {"mapping/segments", "mapping/grid", "rt"},
    "mapping/occupancy": {"mapping/occupancy", "mapping/grid", "rt"},
    "mapping/elevation": {"mapping/elevation", "mapping/grid", "rt"},
    "mapping/registration": {"mapping/registration", "mapping/grid", "rt"},
    "mapping/recognition": {"mapping/recognition", "mapping/segments", "mapping/registration", "mapping/grid", "rt"},
    "planner": {"planner", "estimators", "rt", "rt/convex"} | MAPPING,
    "hil": {"hil", "drivers"} | GROUND,
    **FLASHED,
    # The program of one scene: it stands on every room, and no room on it.
    "firmware_like": {"firmware_like", *FLASHED} | BELOW,
    # Programs without an operating system have none of the rooms.
    "firmware_like/bare_metal": {"firmware_like/bare_metal", "planner", "estimators", "rt"} | MAPPING,
    **DESK,
}
ROOMED = ("firmware_like", "mapping", "toolchain")  # every file lies in a room, but for the program's own

# Headers from outside, and the only rooms or files that see them. CLI11, toml++ and JSON cost seconds a unit: one file each.
HOSTED = {*FLASHED, "firmware_like", "firmware_like/bare_metal", *DESK}
OUTSIDE = [
    ("Eigen", r"(unsupported/)?Eigen/", {"estimators", "planner", *MAPPING, *HOSTED}),
    ("LCM", r"lcm/", {"drivers"}),
    ("sockets", r"(sys/socket|sys/un|arpa/|netinet/|netdb|net/|linux/can|linux/if)", {"drivers"}),
    ("CLI11", r"CLI/", {"firmware_like/scene/command_line.cpp"}),
    ("toml++", r"toml(\+\+|\.hpp)", {"firmware_like/scene/toml_file.cpp"}),
    ("JSON", r"nlohmann/", {"firmware_like/scene/json_text.cpp"}),
    ("libccd", r"ccd/", {"rt/convex"}),
    (
        "the operating system, threads and streams",
        r"(sys/|linux/|unistd|fcntl|sched\.h|pthread|poll\.h|signal\.h|dlfcn|malloc\.h|time\.h|csignal|ctime|chrono"
        r"|thread|mutex|shared_mutex|condition_variable|future|semaphore|filesystem|fstream|iostream|cstdio|stdio)",
        {"rt/posix", "drivers", "hil", *HOSTED},
    ),
    ("std random distributions", r"random$", set()),
]

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')


def room_of(path):
    """The room of a file, from its path; None outside the rooms."""
    parts = path.split("/")
    deep = "/".join(parts[:2])
    if len(parts) > 2 and deep in ROOMS:
        return deep
    return parts[0] if parts[0] in ROOMS else None


def homeless(path):
    """A file of a folder of rooms that lies in none of them, or beside them where only the program may be."""
    parts = path.split("/")
    if parts[0] not in ROOMED:
        return False
    return "/".join(parts[:2]) not in ROOMS if len(parts) > 2 else parts[0] not in ROOMS


def judge(path, room, kind, include):
    for name, pattern, allowed in OUTSIDE:
        if re.match(pattern, include) and not {room, path} & allowed:
            return f"{room} may not see {name} (<{include}>)"
    target = room_of(include)
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
        room = room_of(path.as_posix())
        if homeless(path.as_posix()):
            findings.append(f"{path}:1: {path.parts[0]} has rooms: this file lies in none of them")
        if room is None:
            continue
        checked += 1
        for number, line in enumerate((tree.pathlib.Path(root) / path).read_text().splitlines(), 1):
            match = INCLUDE.match(line)
            verdict = judge(path.as_posix(), room, match[1], match[2]) if match else None
            if verdict:
                findings.append(f"{path}:{number}: {verdict}")
    tree.finish(findings, checked, "layers")


main(sys.argv[1])
