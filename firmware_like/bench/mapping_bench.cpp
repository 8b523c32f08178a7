// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/bench/mapping_bench.hpp"

#include <limits>
#include <map>

#include "firmware_like/bench/pareto.hpp"
#include "firmware_like/bench/peer_program.hpp"

namespace sortie::firmware {

namespace {

// Below these differences nothing is decided: run times of a busy machine repeat to some percent.
constexpr double kSameMappingTime = 0.05;
constexpr double kSameMappingError = 0.001;

double mapping_number(const Json& row, const char* key) {
  const auto found = row.find(key);
  return found != row.end() && found->is_number() ? found->get<double>()
                                                  : std::numeric_limits<double>::quiet_NaN();
}

// Error is what is not shown, and what is shown and belongs elsewhere. Each stream and policy has its front.
void mark_mapping_fronts(Json& sweep) {
  std::map<std::string, std::vector<std::size_t>> groups;
  for (std::size_t i = 0; i < sweep.size(); ++i) {
    Json& row = sweep[i];
    row["error"] = 1.0 - mapping_number(row, "agreement") * (1.0 - mapping_number(row, "missed"));
    groups[row.value("stream", "") + row.value("policy", "")].push_back(i);
  }
  for (const auto& [name, members] : groups) {
    std::vector<CostAndError> points;
    for (const std::size_t i : members)
      points.push_back({mapping_number(sweep[i], "p50_ms"), mapping_number(sweep[i], "error")});
    merge_close(points, &CostAndError::cost, kSameMappingTime);
    merge_close(points, &CostAndError::error, kSameMappingError);
    const std::vector<bool> front = pareto_front(points);
    for (std::size_t i = 0; i < members.size(); ++i) sweep[members[i]]["front"] = bool{front[i]};
  }
}

}  // namespace

Json run_mapping_bench(const MappingBenchOptions& options) {
  PeerProgram program{"sortie-bench-mapping", options.program, {}, -1, options.passes};
  program.arguments = {"--stride", std::to_string(options.stride), "--every", std::to_string(options.every)};
  const auto pass = [&program](const char* option, const std::string& value) {
    if (!value.empty()) program.arguments.insert(program.arguments.end(), {option, value});
  };
  pass("--count", options.count ? "yes" : "");
  pass("--only", options.only);
  pass("--stream", options.stream);
  pass("--file", options.file);
  Json result = run_peer_program(program);
  if (result.contains("sweep")) mark_mapping_fronts(result["sweep"]);
  return result;
}

}  // namespace sortie::firmware
