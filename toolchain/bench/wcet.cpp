// SPDX-License-Identifier: BSD-3-Clause
// The counting side: valgrind's log comes through a pipe, two counts a job.
#include "toolchain/bench/wcet.hpp"

#include <unistd.h>
#ifdef __GLIBC__
#include <gnu/libc-version.h>
#endif

#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "firmware_like/result/results.hpp"
#include "firmware_like/scene/input_error.hpp"
#include "toolchain/bench/child_process.hpp"
#include "toolchain/bench/instruction_count.hpp"

namespace sortie::toolchain {

namespace {

// The C library picks its memory functions by processor; the oldest ones are there on all of them. Symbols
// are bound at the start, not within the first job that needs one.
constexpr const char* kTunables =
    "GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX,-AVX2,-AVX512F,-AVX512VL,-AVX512BW,-AVX_Fast_Unaligned_Load,-BMI1,-"
    "BMI2,"
    "-ERMS,-FMA,-FMA4,-FSRM,-LZCNT,-MOVBE,-POPCNT,-RTM,-SSE4_1,-SSE4_2,-SSSE3:"
    "glibc.cpu.x86_non_temporal_threshold=0xc0000:glibc.cpu.x86_rep_movsb_threshold=0x800:"
    "glibc.cpu.x86_rep_stosb_threshold=0x800";

class JobsFile {
 public:
  JobsFile() {
    std::string name = (std::filesystem::temp_directory_path() / "sortie-wcet-XXXXXX").string();
    const int fd = mkstemp(name.data());
    if (fd < 0) throw std::runtime_error(name + ": cannot be made; set TMPDIR to a folder that is writable");
    close(fd);
    path = name;
  }
  ~JobsFile() {
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
  }
  JobsFile(const JobsFile&) = delete;
  JobsFile& operator=(const JobsFile&) = delete;
  std::string path;
};

ChildCommand counted_command(const WcetOptions& options, const std::string& jobs_file) {
  ChildCommand child;
  child.arguments = {"valgrind",
                     "--quiet",
                     "--tool=callgrind",
                     "--callgrind-out-file=/dev/null",
                     "--instr-atstart=no",
                     "--cache-sim=no",
                     "--branch-sim=no",
                     "--log-fd=9",
                     own_program_path(),
                     "bench",
                     "wcet",
                     options.log,
                     "--counted",
                     jobs_file};
  if (!options.scene.empty()) child.arguments.insert(child.arguments.end(), {"--scene", options.scene});
  for (const std::string& pair : options.overrides)
    child.arguments.insert(child.arguments.end(), {"--set", pair});
  firmware::KeptMapPaths::fields(options.maps, [&child](const char* name, const std::string& path) {
    if (!path.empty()) child.arguments.insert(child.arguments.end(), {std::string("--") + name, path});
  });
  if (!options.fault.empty()) child.arguments.insert(child.arguments.end(), {"--fault", options.fault});
  // An environment of its own: what the user's holds moves the stack.
  child.alone = true;
  const char* path = std::getenv("PATH");
  child.environment = {std::string("PATH=") + (path != nullptr ? path : "/usr/bin:/bin"), "LC_ALL=C",
                       "LD_BIND_NOW=1", kTunables};
  for (const char* name : {"TMPDIR", "HOME", "LD_LIBRARY_PATH", "VALGRIND_LIB"}) {
    if (const char* value = std::getenv(name); value != nullptr)
      child.environment.push_back(std::string(name) + "=" + value);
  }
  child.read_fd = 9;
  return child;
}

std::string built_by() {
  std::string text = firmware::compiler_description() + " (" SORTIE_BUILD_FLAGS ")";
#ifdef __GLIBC__
  text += std::string(", C library ") + gnu_get_libc_version();
#endif
  return text;
}

Wcet join(const std::string& jobs_file, const std::vector<std::uint64_t>& counts) {
  std::ifstream in(jobs_file);
  Wcet wcet;
  wcet.built_by = built_by();
  std::size_t tasks = 0;
  std::getline(in, wcet.scene);
  in >> tasks;
  for (std::size_t i = 0; i < tasks && in; ++i) {
    WcetTask& task = wcet.tasks.emplace_back();
    in >> task.name >> task.group >> task.budget_us;
  }
  std::uint64_t empty_pair = 0;
  std::size_t pair = 0;
  std::size_t index = 0;
  for (CountedJob job; in >> index >> job.tick; ++pair) {
    if (2 * pair + 1 >= counts.size() || index >= tasks)
      throw std::runtime_error("callgrind's log ends before the jobs do");
    job.instructions = counts[2 * pair + 1] - counts[2 * pair];
    if (job.tick == ~std::uint64_t{0}) {
      empty_pair = job.instructions;
      continue;
    }
    job.instructions -= job.instructions < empty_pair ? job.instructions : empty_pair;
    wcet.tasks[index].jobs.push_back(job);
  }
  if (2 * pair != counts.size()) throw std::runtime_error("callgrind counted more than the jobs' marks");
  return wcet;
}

}  // namespace

Wcet measure_wcet(const WcetOptions& options) {
  if (const char* why = why_not_counting(); why != nullptr) throw CountRefused(why);
  if (find_in_path("valgrind").empty())
    throw CountRefused("valgrind is not in PATH; apt-get install valgrind");
  const JobsFile jobs;
  std::vector<std::uint64_t> counts;
  std::string complaints;
  const ChildEnd end = run_child(counted_command(options, jobs.path), [&](std::string_view line) {
    constexpr std::string_view kCount = "events-1: ";  // of the first thread, the only one of a replay
    if (line.substr(0, kCount.size()) == kCount) {
      std::uint64_t value = 0;
      line.remove_prefix(kCount.size());
      std::from_chars(line.data(), line.data() + line.size(), value);
      counts.push_back(value);
    } else if (line.substr(0, 2) == "==") {
      complaints += std::string(line) + "\n";
    }
  });
  if (end.exit_code != 0) {
    throw firmware::InputError("the counted replay ended with " + std::to_string(end.exit_code) +
                                   (complaints.empty() ? ", it says why above" : ":\n" + complaints),
                               end.exit_code);
  }
  return join(jobs.path, counts);
}

}  // namespace sortie::toolchain
