// SPDX-License-Identifier: BSD-3-Clause
// replay_inputs [--seconds N] FOLDER|FILE...: the main program of a fuzz target that does without libFuzzer.
// It runs the empty input and each file, a folder's in the order of their names, each for at most N s (10).
// It names an input only if it dies of it. Exit code 0: all ran to their end.
#include <unistd.h>
#include <algorithm>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

// A sanitizer that found something then raises SIGABRT, so that the input gets its name. No input of a few
// hundred bytes needs a gigabyte.
extern "C" const char* __asan_default_options() { return "abort_on_error=1:max_allocation_size_mb=1024"; }
extern "C" const char* __ubsan_default_options() { return "abort_on_error=1:print_stacktrace=1"; }

namespace {

constexpr int kDeadly[] = {SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGALRM};
struct sigaction before[std::size(kDeadly)];
char current[4096] = "none";
volatile std::sig_atomic_t told = 0;

void tell(const char* what) {
  if (told != 0) return;
  told = 1;
  const char* const words[] = {"replay_inputs: ", what, " on input ", current, "\n"};
  for (const char* text : words)
    if (::write(STDERR_FILENO, text, std::strlen(text)) < 0) return;
}

/// Names the input; then whoever was there before, the sanitizer or the kernel, gets the same signal.
void on_signal(int signal) {
  tell(signal == SIGALRM ? "out of time" : "died");
  if (signal == SIGALRM) ::_exit(1);
  for (std::size_t i = 0; i < std::size(kDeadly); ++i)
    if (kDeadly[i] == signal) ::sigaction(signal, &before[i], nullptr);
}

bool running = false;

void on_exit() {
  if (!running) return;
  tell("left by exit()");
  ::_exit(1);
}

void watch() {
  struct sigaction action = {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_ONSTACK;  // a stack that is full holds no handler; sanitizers bring another one
  for (std::size_t i = 0; i < std::size(kDeadly); ++i) ::sigaction(kDeadly[i], &action, &before[i]);
  std::atexit(on_exit);
}

/// An exception that comes out is a death, too.
void run(const std::string& name, const std::string& bytes, unsigned seconds) noexcept {
  std::snprintf(current, sizeof current, "%s", name.c_str());
  // On the heap and no byte too many, so that reading behind the end is found. (No byte at all becomes one.)
  const std::size_t size = bytes.size();
  const std::unique_ptr<std::uint8_t[]> memory(new std::uint8_t[std::max<std::size_t>(size, 1)]);
  std::uint8_t* const data = size == 0 ? memory.get() + 1 : memory.get();
  std::copy(bytes.begin(), bytes.end(), data);
  running = true;
  ::alarm(seconds);
  LLVMFuzzerTestOneInput(data, size);
  ::alarm(0);
  running = false;
}

std::vector<std::string> inputs_in(const std::string& path) {
  namespace fs = std::filesystem;
  std::vector<std::string> names;
  if (fs::is_directory(path)) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(path))
      if (entry.is_regular_file()) names.push_back(entry.path().string());
    std::sort(names.begin(), names.end());
    if (names.empty()) throw std::runtime_error("no inputs in " + path);
  } else if (fs::is_regular_file(path)) {
    names.push_back(path);
  } else {
    throw std::runtime_error("no such file or folder: " + path);
  }
  return names;
}

std::string read(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (!file.is_open() || file.bad()) throw std::runtime_error("cannot read " + path);
  return bytes;
}

std::vector<std::string> inputs_of(const std::vector<std::string>& paths) {
  std::vector<std::string> names;
  for (const std::string& path : paths)
    for (std::string& name : inputs_in(path)) names.push_back(std::move(name));
  if (names.empty()) throw std::runtime_error("usage: [--seconds N] FOLDER|FILE...");
  return names;
}

unsigned seconds_of(const std::string& text) {
  const unsigned long seconds = std::strtoul(text.c_str(), nullptr, 10);
  if (seconds < 1 || seconds > 3600) throw std::runtime_error("--seconds is 1 to 3600");
  return static_cast<unsigned>(seconds);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    std::vector<std::string> paths(argv + 1, argv + argc);
    unsigned seconds = 10;
    if (paths.size() >= 2 && paths[0] == "--seconds") {
      seconds = seconds_of(paths[1]);
      paths.erase(paths.begin(), paths.begin() + 2);
    }
    const std::vector<std::string> names = inputs_of(paths);
    watch();
    run("the empty one", "", seconds);
    for (const std::string& name : names) run(name, read(name), seconds);
    std::snprintf(current, sizeof current, "none: all have run");  // what is lost is found only now
    std::printf("%zu inputs and the empty one\n", names.size());
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "replay_inputs: %s\n", error.what());
    return 2;
  }
}
