// SPDX-License-Identifier: BSD-3-Clause
// The main function of every test binary, and the notes that it keeps of its cases. Catch2 compiles slowly,
// so this file is compiled once and shared.
#define CATCH_CONFIG_MAIN
#define CATCH_CONFIG_CONSOLE_WIDTH 200  // Reasons for skipping stay on one line.
#include <fcntl.h>
#include <unistd.h>

#include <catch2/catch.hpp>

#include <chrono>
#include <cstdlib>
#include <string>

namespace {

// Writes a line when a case begins, says that it is skipped, and ends, to the file that SORTIE_TEST_NOTES
// names. What has begun and never ends is the case in which the process died: tests/one_process.py reads it.
class CaseNotes : public Catch::TestEventListenerBase {
 public:
  using TestEventListenerBase::TestEventListenerBase;

  void testRunStarting(const Catch::TestRunInfo& /*run*/) override {
    if (const char* path = std::getenv("SORTIE_TEST_NOTES"); path != nullptr)
      file_ = ::open(path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  }

  void testCaseStarting(const Catch::TestCaseInfo& info) override {
    begin_ = std::chrono::steady_clock::now();
    note("begin\t" + info.name);
  }

  bool assertionEnded(const Catch::AssertionStats& stats) override {
    if (stats.assertionResult.getResultType() == Catch::ResultWas::Warning) {
      const std::string why = stats.assertionResult.getMessage();
      if (why.rfind("skipped: ", 0) == 0) note("skip\t" + why.substr(9, why.find('\n') - 9));
    }
    return false;
  }

  void testCaseEnded(const Catch::TestCaseStats& stats) override {
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begin_;
    note((stats.totals.assertions.failed == 0 ? "passed\t" : "failed\t") + std::to_string(passed.count()));
  }

 private:
  void note(const std::string& line) const {
    const std::string text = line + "\n";
    if (file_ >= 0 && ::write(file_, text.data(), text.size()) < 0) std::abort();
  }

  int file_{-1};
  std::chrono::steady_clock::time_point begin_;
};

CATCH_REGISTER_LISTENER(CaseNotes)

}  // namespace
