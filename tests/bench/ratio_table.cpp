// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/ratio_table.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <ostream>

namespace sortie::bench {

namespace {

std::vector<std::pair<std::string, std::string>>& skips() {
  static std::vector<std::pair<std::string, std::string>> list;
  return list;
}

// Element of rank ceil(share * n) of sorted samples.
double rank_of(const std::vector<double>& sorted, double share) {
  const auto n = static_cast<double>(sorted.size());
  const auto rank = static_cast<std::size_t>(std::max(1.0, std::ceil(share * n)));
  return sorted[std::min(rank, sorted.size()) - 1];
}

std::string text(const char* format, double value) {
  char buffer[48];
  std::snprintf(buffer, sizeof buffer, format, value);
  return buffer;
}

std::string figure(double ns) { return text(ns < 10 ? "%.2f" : ns < 100 ? "%.1f" : "%.0f", ns); }

}  // namespace

int skip_peer(const std::string& name, const std::string& why) {
  skips().emplace_back(name, why);
  return static_cast<int>(skips().size());
}

bool RatioReporter::ReportContext(const Context&) { return true; }

void RatioReporter::ReportRuns(const std::vector<Run>& runs) {
  for (const Run& run : runs) {
    if (run.run_type != Run::RT_Iteration) continue;
    const std::string& name = run.run_name.function_name;
    if (samples_ns_.find(name) == samples_ns_.end() && skipped_.find(name) == skipped_.end())
      order_.push_back(name);
    if (run.error_occurred) {
      skipped_[name] = run.error_message;
      failed_ = failed_ || run.error_message.rfind("skipped", 0) != 0;
      continue;
    }
    const auto ops = run.counters.find("ops");
    const double operations =
        static_cast<double>(run.iterations) * (ops == run.counters.end() ? 1.0 : ops->second.value);
    samples_ns_[name].push_back(1e9 * run.cpu_accumulated_time / operations);
    if (samples_ns_[name].size() == 1) std::cerr << "." << std::flush;
  }
}

void RatioReporter::print(std::ostream& out) const {
  // Interleaving shuffles the order in which results come; the table has that of the names.
  std::vector<std::string> order = order_;
  std::sort(order.begin(), order.end(), [](const std::string& a, const std::string& b) {
    const std::string group_a = a.substr(0, a.find('/'));
    const std::string group_b = b.substr(0, b.find('/'));
    if (group_a != group_b) return group_a < group_b;
    const bool own_a = a == group_a + "/sortie";
    const bool own_b = b == group_b + "/sortie";
    return own_a != own_b ? own_a : a < b;
  });
  out << "| benchmark | who | n | median ns | p99 ns | max ns | against sortie |\n"
         "|---|---|---:|---:|---:|---:|---:|\n";
  for (const std::string& name : order) {
    const std::string group = name.substr(0, name.find('/'));
    const std::string who = name.substr(name.find('/') + 1);
    if (const auto why = skipped_.find(name); why != skipped_.end()) {
      out << "| " << group << " | " << who << " | - | " << why->second << " | | | |\n";
      continue;
    }
    std::vector<double> sorted = samples_ns_.at(name);
    std::sort(sorted.begin(), sorted.end());
    const auto own = samples_ns_.find(group + "/sortie");
    std::string ratio = "-";
    if (own != samples_ns_.end()) {
      std::vector<double> base = own->second;
      std::sort(base.begin(), base.end());
      ratio = who == "sortie" ? "1" : text("%.2g x", rank_of(sorted, 0.5) / rank_of(base, 0.5));
    }
    out << "| " << group << " | " << who << " | " << sorted.size() << " | " << figure(rank_of(sorted, 0.5))
        << " | " << figure(rank_of(sorted, 0.99)) << " | " << figure(sorted.back()) << " | " << ratio
        << " |\n";
  }
  for (const auto& [name, why] : skips()) out << "\nskipped: " << name << ": " << why << "\n";
}

}  // namespace sortie::bench
