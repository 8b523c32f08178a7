# SPDX-License-Identifier: BSD-3-Clause
"""plant.py CHECK [COMPILER AR NM CLANG_FORMAT]: proves that a check can fail. It makes a tiny clean tree, sees the
check pass, plants one fault after another and sees each one caught, at the right place."""

import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
LICENCE = "// SPDX-License-Identifier: BSD-3-Clause\n"
CLEAN = {
    "rt/base.hpp": "// A value.\n#pragma once\n#include <cstdint>\nnamespace tiny {\nstd::uint32_t next(std::uint32_t x);\n}  // namespace tiny\n",
    "rt/base.cpp": '// Its body.\n#include "rt/base.hpp"\nnamespace tiny {\nstd::uint32_t next(std::uint32_t x) { return x + 1; }\n}  // namespace tiny\n',
    "estimators/filter.hpp": '// A filter.\n#pragma once\n#include "rt/base.hpp"\n',
    "drivers/bus.cpp": "// A bus.\n#include <sys/socket.h>\n",
    "firmware_like/robots/robot.cpp": '// A vehicle.\n#include "rt/base.hpp"\n\n#include "estimators/filter.hpp"\n',
    "drivers/line.cpp": '// A line.\n#include "rt/base.hpp"\n\n#include "drivers/line.hpp"\n',
    "firmware_like/scene/command_line.cpp": "// Options.\n#include <CLI/CLI.hpp>\n",
    "firmware_like/scene/toml_file.cpp": "// Scenes.\n#include <toml++/toml.h>\n",
}

# check: [(file, text to add at its end, what the check must say)]
FAULTS = {
    "layers": [
        ("estimators/filter.hpp", '#include "mapping/grid/grid.hpp"\n', "estimators/filter.hpp:5: estimators may not include mapping"),
        ("mapping/grid/grid.hpp", '#include "drivers/bus.hpp"\n', "mapping/grid/grid.hpp:2: mapping/grid may not include drivers"),
        ("drivers/bus.cpp", '#include "estimators/filter.hpp"\n', "drivers may not include estimators"),
        ("firmware_like/scene/profile.cpp", '#include "toolchain/commands/run.hpp"\n', "firmware_like/scene may not include toolchain"),
        ("firmware_like/live/run.hpp", '#include "toolchain/judge/evaluate.hpp"\n', "firmware_like/live may not include toolchain"),
        ("firmware_like/main.cpp", '#include "toolchain/program/program.hpp"\n', "firmware_like may not include toolchain"),
        ("firmware_like/main.cpp", '#include "hil/plant.hpp"\n', "firmware_like may not include hil"),
        ("firmware_like/result/results.hpp", '#include "firmware_like/runtime/runtime.hpp"\n', "firmware_like/result may not include firmware_like/runtime"),
        ("firmware_like/log/replay.hpp", '#include "firmware_like/doctor/doctor.hpp"\n', "firmware_like/log may not include firmware_like/doctor"),
        ("firmware_like/link/telemetry.hpp", '#include "firmware_like/doctor/doctor.hpp"\n', "firmware_like/link may not include firmware_like/doctor"),
        ("firmware_like/live/run.hpp", '#include "firmware_like/command_program.hpp"\n', "firmware_like/live may not include firmware_like"),
        ("firmware_like/cellar/box.hpp", "\n", "firmware_like/cellar/box.hpp:1: firmware_like has rooms: this file lies in none of them"),
        ("mapping/box.hpp", "\n", "mapping/box.hpp:1: mapping has rooms"),
        ("mapping/grid/block.hpp", '#include "mapping/segments/segmenter.hpp"\n', "mapping/grid may not include mapping/segments"),
        ("mapping/segments/table.hpp", '#include "mapping/occupancy/view.hpp"\n', "mapping/segments may not include mapping/occupancy"),
        ("mapping/registration/credit.hpp", '#include "mapping/recognition/store.hpp"\n', "mapping/registration may not include mapping/recognition"),
        ("mapping/recognition/store.hpp", '#include "mapping/occupancy/view.hpp"\n', "mapping/recognition may not include mapping/occupancy"),
        ("toolchain/judge/errors.cpp", '#include "toolchain/import/text_file.hpp"\n', "toolchain/judge may not include toolchain/import"),
        ("toolchain/import/broad.cpp", '#include "toolchain/judge/errors.hpp"\n', "toolchain/import may not include toolchain/judge"),
        ("toolchain/export/ply.hpp", '#include "toolchain/report/svg.hpp"\n', "toolchain/export may not include toolchain/report"),
        ("toolchain/simulate/ugv.cpp", '#include "toolchain/export/csv.hpp"\n', "toolchain/simulate may not include toolchain/export"),
        ("toolchain/report/html.hpp", '#include "toolchain/bench/wcet.hpp"\n', "toolchain/report may not include toolchain/bench"),
        ("toolchain/bench/wcet.cpp", '#include "toolchain/sweep/sweep.hpp"\n', "toolchain/bench/wcet.cpp:2: toolchain/bench may not include toolchain/sweep"),
        ("toolchain/sweep/sweep.hpp", '#include "toolchain/commands/commands.hpp"\n', "toolchain/sweep may not include toolchain/commands"),
        ("toolchain/commands/run.cpp", '#include "toolchain/program/program.hpp"\n', "toolchain/commands may not include toolchain/program"),
        ("toolchain/program/program.hpp", '#include "toolchain/package/own.hpp"\n', "toolchain/program may not include toolchain/package"),
        ("toolchain/commands/run.cpp", '#include "hil/plant.hpp"\n', "toolchain/commands may not include hil"),
        ("toolchain/cellar/box.hpp", "\n", "toolchain/cellar/box.hpp:1: toolchain has rooms: this file lies in none of them"),
        ("toolchain/box.cpp", "\n", "toolchain/box.cpp:1: toolchain has rooms"),
        ("hil/plant.cpp", '#include "toolchain/simulate/course.hpp"\n', "hil may not include toolchain"),
        ("hil/plant.cpp", '#include "estimators/filter.hpp"\n', "hil may not include estimators"),
        ("planner/plan.cpp", '#include "firmware_like/scene/profile.hpp"\n', "planner may not include firmware_like"),
        ("firmware_like/robots/robot.cpp", '#include "hil/plant.hpp"\n', "firmware_like/robots may not include hil"),
        ("rt/base.hpp", "#include <Eigen/Core>\n", "rt may not see Eigen"),
        ("hil/plant.cpp", "#include <Eigen/Core>\n", "hil may not see Eigen"),
        ("rt/base.hpp", "#include <thread>\n", "rt/base.hpp:8: rt may not see the operating system"),
        ("rt/base.cpp", '#include "rt/posix/clock.hpp"\n', "rt may not include rt/posix"),
        ("estimators/filter.hpp", '#include "rt/posix/clock.hpp"\n', "estimators may not include rt/posix"),
        ("planner/plan.cpp", "#include <lcm/lcm-cpp.hpp>\n", "planner may not see LCM"),
        ("hil/plant.cpp", "#include <netinet/in.h>\n", "hil may not see sockets"),
        ("drivers/bus.cpp", "#include <nlohmann/json.hpp>\n", "drivers may not see JSON"),
        ("firmware_like/scene/profile.cpp", "#include <nlohmann/json.hpp>\n", "firmware_like/scene may not see JSON"),
        ("mapping/grid/grid.hpp", "#include <toml++/toml.h>\n", "mapping/grid may not see toml++"),
        ("drivers/bus.cpp", "#include <CLI/CLI.hpp>\n", "drivers may not see CLI11"),
        ("toolchain/commands/run.cpp", "#include <CLI/CLI.hpp>\n", "toolchain/commands/run.cpp:2: toolchain/commands may not see CLI11"),
        ("firmware_like/scene/profile.cpp", "#include <toml++/toml.h>\n", "firmware_like/scene may not see toml++"),
        ("estimators/filter.hpp", "#include <chrono>\n", "estimators may not see the operating system"),
        ("rt/base.cpp", '#include "base.hpp"\n', "includes are written from the root"),
        ("planner/plan.cpp", "#include <ccd/ccd.h>\n", "planner may not see libccd"),
        ("rt/base.hpp", "#include <ccd/vec3.h>\n", "rt may not see libccd"),
        ("rt/base.cpp", '#include "rt/convex/query.hpp"\n', "rt may not include rt/convex"),
        ("estimators/filter.hpp", '#include "rt/convex/query.hpp"\n', "estimators may not include rt/convex"),
    ],
    "headers": [
        ("rt/other.hpp", "\n", "rt/other.hpp: nothing compiles it alone: configure"),
        ("drivers/bus.hpp", "#pragma once\n", "drivers/bus.hpp: nothing compiles it alone: drivers/bus.cpp must include it first"),
        ("drivers/line.hpp", "#pragma once\n", "drivers/line.hpp: nothing compiles it alone: drivers/line.cpp must include it first"),
        ("estimators/filter.hpp", '#include "estimators/filter.hpp"\n', "estimators/filter.hpp: nothing compiles it alone"),
    ],
    "freestanding": [
        ("rt/base.cpp", "namespace tiny { int* sink; void f() { sink = new int(1); } }\n", "asks for the heap: operator new"),
        ("rt/base.cpp", '#include <cstdlib>\nnamespace tiny { void* g() { return std::malloc(8); } }\n', "asks for the heap: malloc"),
        ("rt/base.cpp", "namespace tiny { void h() { throw 1; } }\n", "asks for exceptions: __cxa_throw"),
        ("rt/base.cpp", '#include <cstdio>\nnamespace tiny { void p(int x) { std::printf("%d", x); } }\n', "asks for printing"),
        ("rt/base.cpp", "#include <mutex>\nnamespace tiny { std::mutex m; void l() { m.lock(); } }\n", "asks for locks"),
        ("rt/base.cpp", "#include <ctime>\nnamespace tiny { long t() { timespec s; clock_gettime(0, &s); return s.tv_sec; } }\n", "asks for clocks"),
        ("rt/base.cpp", "#include <string>\nnamespace tiny { std::string s(int x) { return std::to_string(x) + std::string(99, 'x'); } }\n", "base.cpp.o"),
    ],
    "arithmetic-symbols": [
        ("rt/base.cpp", "#include <cmath>\nnamespace tiny { double s(double x) { return std::sin(x); } }\n", "asks for mathematics that differs by processor: sin"),
        ("rt/base.cpp", "#include <cmath>\nnamespace tiny { float a(float y, float x) { return std::atan2(y, x); } }\n", "atan2f"),
    ],
    "collision-symbols": [
        ("rt/base.cpp", 'extern "C" int ccdGJKPenetration();\nnamespace tiny { int e() { return ccdGJKPenetration(); } }\n', "asks for libccd's expanding polytope: ccdGJKPenetration"),
        ("rt/base.cpp", 'extern "C" int ccdGJKIntersect();\nnamespace tiny { int i() { return ccdGJKIntersect(); } }\n', "ccdGJKIntersect"),
        ("rt/base.cpp", "namespace tiny { int* sink; void f() { sink = new int(1); } }\n", "asks for the heap: operator new"),
    ],
    "arithmetic": [
        ("rt/base.cpp", "double f(double x) { return std::exp(x); }\n", "rt/base.cpp:7: std::exp(: use rt/math.hpp"),
        ("hil/plant.cpp", "std::normal_distribution<double> noise;\n", "hil/plant.cpp:2: std::normal_distribution"),
        ("mapping/grid/grid.hpp", "std::unordered_map<int, int> cells;\n", "std::unordered_map"),
        ("firmware_like/robots/robot.cpp", "double f(double x) { return std::hypot(x, x); }\n", "firmware_like/robots/robot.cpp:6: std::hypot("),
    ],
    "atomics": [
        ("rt/base.hpp", "std::atomic<std::uint64_t> refused{};\n", "rt/base.hpp:8: atomic<std::uint64_t>"),
        ("rt/base.cpp", "std::atomic<Nanoseconds> newest;\n", "rt/base.cpp:7: atomic<Nanoseconds>"),
        ("rt/base.hpp", "Atomic<std::int64_t> words[2];\n", "rt/base.hpp:8: Atomic<std::int64_t>"),
    ],
    "orders": [
        ("rt/base.cpp", "int f() { return word.load(std::memory_order_acquire); }\n", "rt/base.cpp:7: a memory order that no model takes away"),
        ("drivers/bus.cpp", "void f() { word.store(1, std::memory_order::release); }\n", "drivers/bus.cpp:4: a memory order"),
        ("rt/mailbox.hpp", "#pragma once\n", "rt/mailbox.hpp: has no memory order any more"),
        ("rt/ledger.hpp", "#pragma once\nint f() { return word.load(std::memory_order_acquire); }\n", "ledger_model_test.cpp is gone"),
    ],
    "files": [
        ("rt/base.cpp", 'bool map() { return kBuilt<"mapp">; }\n', 'part "mapp" is not in'),
        ("rt/base.cpp", "// TO" "DO: the rest\n", "rt/base.cpp:7: 'TO" "DO'"),
        ("docs/page.md", "Good enough for " "now.\n", "docs/page.md:2: 'for " "now'"),
        ("docs/page.md", "See [what](absent.md#there).\n", "docs/page.md:2: the link to absent.md leads nowhere"),
        ("toolchain/run", "cd /wo" "rk/tree\n", "a path of one machine"),
        ("rt/base.hpp", "\n" * 300, "307 lines"),
        ("toolchain/debian12-packages.txt", "base  cowsay\n", "debian12-packages.txt:2: a package line is: group, package, # reason"),
        ("rt/other.hpp", "\n", "rt/other.hpp:1: a header says #pragma once"),
        ("tests/rt/base_test.cpp", 'TEST_CASE("one half; " "the other") {}\n', "base_test.cpp:2: CTest cuts the name"),
    ],
    "format": [("rt/base.cpp", "int  badly( int spaced ) ;\n", "rt/base.cpp:7:")],
}


def write(root, path, text):
    file = root / path
    file.parent.mkdir(parents=True, exist_ok=True)
    start = "" if file.exists() else LICENCE if file.suffix in {".hpp", ".cpp"} else "# A file.\n"
    with file.open("a") as out:
        out.write(start + text)


def archive(root, tools):
    compiler, ar = tools[:2]
    run = lambda *command: subprocess.run(command, cwd=root, check=True)  # noqa: E731
    run(compiler, "-std=c++20", "-O2", "-I.", "-c", "rt/base.cpp", "-o", "base.cpp.o")
    run(ar, "qc", "tiny.a", "base.cpp.o")
    return str(root / "tiny.a")


def check(name, root, tools):
    """Runs the check on the tree: (exit code, output)."""
    if name in ("freestanding", "arithmetic-symbols", "collision-symbols"):
        command = ["check_symbols.py", name.split("-")[0], tools[2], archive(root, tools)]
    elif name == "headers":
        compiled = [str(path) for path in root.rglob("*.cpp")]
        (root / "commands.json").write_text(json.dumps([{"file": path} for path in compiled]))
        command = ["check_headers.py", str(root), str(root / "commands.json")]
    elif name == "format":
        shutil.copy(HERE / "../../.clang-format", root)
        command = ["check_format.py", str(root), tools[3]]
    else:
        command = [f"check_{name}.py", str(root)]
    result = subprocess.run([sys.executable, "-B", HERE / command[0], *command[1:]], capture_output=True, text=True, check=False)
    return result.returncode, result.stdout + result.stderr


def trial(name, tools, fault=None):
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        for path, text in CLEAN.items():
            write(root, path, text)
        if fault:
            write(root, fault[0], fault[1])
        return check(name, root, tools)


def main(name, tools):
    failures = 0
    code, output = trial(name, tools)
    if code != 0:
        failures += 1
        print(f"the clean tree does not pass:\n{output}")
    for fault in FAULTS[name]:
        code, output = trial(name, tools, fault)
        caught = code == 1 and fault[2] in output
        failures += not caught
        print(f"{'caught' if caught else 'MISSED'}: {fault[0]} + {fault[1].strip()[:70]!r}")
        if not caught:
            print(f"  expected '{fault[2]}', got {code}:\n{output}")
    print(f"{name}: {len(FAULTS[name])} faults planted, {failures} not caught")
    sys.exit(1 if failures else 0)


main(sys.argv[1], sys.argv[2:])
