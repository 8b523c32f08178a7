// SPDX-License-Identifier: BSD-3-Clause
// Collects the repetitions of every benchmark and prints them against the first of their group.
#pragma once

#include <benchmark/benchmark.h>

#include <iosfwd>
#include <map>
#include <string>
#include <vector>

namespace sortie::bench {

/// Benchmarks are named "group/who": in every group "sortie" is the one that the others are compared with.
/// Every repetition counts as one sample: CPU time per operation (counter "ops" = operations an iteration).
class RatioReporter final : public benchmark::BenchmarkReporter {
 public:
  bool ReportContext(const Context& context) override;
  void ReportRuns(const std::vector<Run>& runs) override;

  /// The table as Markdown: n, median, p99, max in ns per operation, and the ratio of medians.
  void print(std::ostream& out) const;
  bool failed() const { return failed_; }

 private:
  std::vector<std::string> order_;
  std::map<std::string, std::vector<double>> samples_ns_;
  std::map<std::string, std::string> skipped_;
  bool failed_{};
};

/// Names a peer that this build does not have; it becomes a line of the table. Returns its index.
int skip_peer(const std::string& name, const std::string& why);

}  // namespace sortie::bench
