// SPDX-License-Identifier: BSD-3-Clause
#include <limits>
#include <map>

#include "toolchain/bench/peer_front.hpp"
#include "toolchain/judge/pareto.hpp"

namespace sortie::toolchain {

namespace {

double mapping_number(const firmware::Json& row, const char* key) {
  const auto found = row.find(key);
  return found != row.end() && found->is_number() ? found->get<double>()
                                                  : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

void mark_mapping_fronts(firmware::Json& result) {
  if (!result.contains("sweep")) return;
  firmware::Json& sweep = result["sweep"];
  std::map<std::string, std::vector<std::size_t>> groups;
  for (std::size_t i = 0; i < sweep.size(); ++i) {
    firmware::Json& row = sweep[i];
    row["error"] = 1.0 - mapping_number(row, "agreement") * (1.0 - mapping_number(row, "missed"));
    groups[row.value("stream", "") + row.value("policy", "")].push_back(i);
  }
  for (const auto& [name, members] : groups) {
    std::vector<CostAndError> points;
    for (const std::size_t i : members)
      points.push_back({mapping_number(sweep[i], "p50_ms"), mapping_number(sweep[i], "error")});
    const std::vector<bool> front = measured_front(std::move(points));
    for (std::size_t i = 0; i < members.size(); ++i) sweep[members[i]]["front"] = bool{front[i]};
  }
}

}  // namespace sortie::toolchain
