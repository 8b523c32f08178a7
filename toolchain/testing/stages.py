# SPDX-License-Identifier: BSD-3-Clause
"""The stages of a test run, in their order: what each builds, and what it runs. The short run is what a change must pass;
the long one adds what takes hours, stage by stage."""

from dataclasses import dataclass, field

SHORT_CASES = "long|heavy|timing"  # labels that the short run leaves out


@dataclass
class Stage:
    """Presets are built first, then commands run, then ctest over the preset's tests."""

    name: str
    what: str
    builds: list = field(default_factory=list)  # (preset, [cmake definitions], [targets])
    tests: list = field(default_factory=list)  # (preset, [ctest arguments])
    commands: list = field(default_factory=list)  # (title, [words]); exit code 77 is a skip
    long: bool = False


ROBOT = ["-DSORTIE_DESK=OFF", "-DSORTIE_LONG_TESTS=OFF"]
ON_BOARD = ["rt/", "drivers/", "estimators/", "mapping/", "planner/", "firmware_like/", "toolchain/(calibration|export|import|trajectory)_"]
THREADS = ["rt/(queue|live|ledger|guards|posix|parameter|delay|spin|flight_ring|crash|fast_clock|executive|ports|schedule|anytime|miss|ladder|cause|usual|command_outlet|interval_log)",
           "drivers/(can_socket|can_stub|datagram_link|lcm_network|lcm_publisher|lcm_requests)",
           "firmware_like/(live|recorder|refusal|outlets|parameters|drive_requests|fly_requests|request_desk|plant_process|flight_ring_run|input_port|replay)_test"]
EVERYTHING = ["-DSORTIE_DESK=ON", "-DSORTIE_LONG_TESTS=ON", "-DSORTIE_TEST_FILES=", "-DSORTIE_BATCH_TESTS=ON"]
SHORT_OF_ALL = ["-DSORTIE_DESK=ON", "-DSORTIE_LONG_TESTS=OFF", "-DSORTIE_TEST_FILES=", "-DSORTIE_BATCH_TESTS=ON"]
MATHS = ["-DSORTIE_DESK=ON", "-DSORTIE_LONG_TESTS=OFF", "-DSORTIE_TEST_FILES=rt/math_"]
ON_ARM = ["sortie_replay_digest", "sortie_tests_rt"]
ONE_THREAD = "(estimators|mapping|planner)"  # folders that start no thread: a thread sanitizer has nothing to see there
AFTER_ARM = "bare|size"  # tests of release that look at programs for other processors


def files(*expressions):
    return "-DSORTIE_TEST_FILES=" + ";".join(expressions)


def only(label):
    return ["-L", label, "-LE", SHORT_CASES]


STAGES = [
    Stage("release", "the program, its tests, every header alone", builds=[("release", SHORT_OF_ALL, [])]),
    Stage("release tests", "unit tests, layers, command line, page, instructions, an outside project",
          tests=[("release", ["-LE", f"{SHORT_CASES}|{AFTER_ARM}"])]),
    Stage("address", "what runs on the robot, with address and undefined-behaviour sanitizers", builds=[("debug", [*ROBOT, files(*ON_BOARD)], [])]),
    Stage("address tests", "unit tests, committed inputs of the fuzzers", tests=[("debug", ["-LE", SHORT_CASES])]),
    Stage("thread", "what has threads, with the thread sanitizer",
          builds=[("tsan", [*ROBOT, files(*THREADS)], [])]),
    Stage("thread tests", "executive, queues, live runs, links, recorder", tests=[("tsan", ["-LE", SHORT_CASES])]),
    Stage("ARM", "the runtime for 64 and 32 bits, and two boards without an operating system",
          builds=[("aarch64", MATHS, ON_ARM), ("armhf", MATHS, ON_ARM),
                  ("cortex-m7", [], []), ("cortex-m4f", [], [])]),
    Stage("ARM tests", "deterministic maths, digests of the boards, sizes",
          tests=[("aarch64", ["-R", "^aarch64 rt$"]), ("armhf", ["-R", "^armhf rt$"]), ("release", only(AFTER_ARM))]),
    Stage("digests", "one digest a log, whatever compiled the program",
          commands=[("digest/every processor gives the same", ["toolchain/digest-matrix", "--no-build"])]),
    # What follows takes hours. The stages that tell most in a minute come first.
    Stage("long release", "thousands of draws, months of ticks, boards that boot, programs of one scene, a cluster of one node, gates beside peers",
          builds=[("release", EVERYTHING, ["all", "sortie_benchmarks"])], tests=[("release", ["-L", "long|size", "-LE", "timing"])], long=True),
    Stage("faults", "faults of one line, one at a time, each caught by a case",
          builds=[("release", EVERYTHING, [])], commands=[("mutants/each fault of one line is caught", ["tests/mutants/run.py"])], long=True),
    Stage("compilers", "gcc -O0 and -O3, clang, for x86-64, x86-64-v3 and both ARM: one digest a log",
          builds=[(preset, ["-DSORTIE_TESTS=ON"], ["sortie_replay_digest"])
                  for preset in ("clang", "o0", "o3", "v3", "clang-v3", "clang-aarch64", "clang-armhf")],
          commands=[("digest/every compiler and processor gives the same", ["toolchain/digest-matrix", "--no-build"])], long=True),
    Stage("all of address", "the desk as well, and what takes long there",
          builds=[("debug", SHORT_OF_ALL, [])], tests=[("debug", ["-LE", "long|timing"])], long=True),
    Stage("all of armhf", "the program, and all tests under emulation",
          builds=[("armhf", SHORT_OF_ALL, [])], tests=[("armhf", ["-LE", "long|timing", "-E", f"{ONE_THREAD}, heavy"])], long=True),
    Stage("all of thread", "all tests of what has threads", builds=[("tsan", SHORT_OF_ALL, [])],
          tests=[("tsan", ["-LE", "long|timing", "-E", f"^tsan {ONE_THREAD}"])], long=True),
    Stage("all of aarch64", "the program, and all tests under emulation",
          builds=[("aarch64", SHORT_OF_ALL, [])], tests=[("aarch64", ["-LE", "long|timing", "-E", f"{ONE_THREAD}, heavy"])], long=True),
    Stage("fuzz", "search by fuzzers from the committed inputs, SORTIE_FUZZ_SECONDS each (60)",
          builds=[("fuzz", ["-DSORTIE_FUZZ_SECONDS=${SORTIE_FUZZ_SECONDS:-60}"], ["fuzzers"])],
          tests=[("fuzz", ["-L", "^fuzz$"])], long=True),
]
