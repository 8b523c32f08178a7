// SPDX-License-Identifier: BSD-3-Clause
// What the figures were measured on, and what built the program.
#include <sys/utsname.h>

#include <fstream>
#include <thread>

#include "firmware_like/result/results.hpp"

namespace sortie::firmware {
namespace {

/// The first of these keys of /proc/cpuinfo; ARM kernels have no "model name".
std::string processor() {
  std::ifstream in("/proc/cpuinfo");
  std::string fallback = "unknown processor";
  for (std::string line; std::getline(in, line);) {
    const std::size_t colon = line.find(':');
    if (colon == std::string::npos || colon + 2 > line.size()) continue;
    const std::string value = line.substr(colon + 2);
    if (line.rfind("model name", 0) == 0) return value;
    if (line.rfind("Hardware", 0) == 0 || line.rfind("Model", 0) == 0) fallback = value;
  }
  return fallback;
}

}  // namespace

std::string machine_description() {
  const unsigned cores = std::thread::hardware_concurrency();
  std::string text = processor() + ", " + std::to_string(cores) + (cores == 1 ? " core" : " cores");
  utsname name{};
  if (uname(&name) == 0) text += std::string(", ") + name.sysname + " " + name.release + " " + name.machine;
  return text;
}

std::string compiler_description() {
#if defined(__clang__)
  std::string text = "clang++ " __clang_version__;
#elif defined(__GNUC__)
  std::string text = "g++ " __VERSION__;
#else
  std::string text = "unknown compiler";
#endif
#if defined(__OPTIMIZE_SIZE__)
  text += ", optimised for size";
#elif defined(__OPTIMIZE__)
  text += ", optimised";
#else
  text += ", not optimised";
#endif
#if defined(__x86_64__)
  text += ", x86-64";
#elif defined(__aarch64__)
  text += ", aarch64";
#elif defined(__arm__)
  text += ", arm";
#endif
  return text;
}

}  // namespace sortie::firmware
