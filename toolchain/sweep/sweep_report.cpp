// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/sweep/sweep_report.hpp"

#include <cmath>
#include <ostream>
#include <set>

#include "firmware_like/scene/json.hpp"
#include "firmware_like/scene/text_format.hpp"

namespace sortie::toolchain {

namespace {

firmware::Json number(double value) {
  return std::isfinite(value) ? firmware::Json(value) : firmware::Json(nullptr);
}

std::set<std::string> error_names(const Sweep& sweep) {
  std::set<std::string> names;
  for (const SweepCell& cell : sweep.cells) {
    for (const auto& [name, unused] : cell.errors) names.insert(name);
  }
  return names;
}

std::string field(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

}  // namespace

std::string listed(const std::vector<std::string>& values) {
  std::string text;
  for (const std::string& value : values) text += (text.empty() ? "" : ", ") + value;
  return text;
}

firmware::Json to_json(const Sweep& sweep) {
  const bool counted = counts_instructions(sweep);
  firmware::Json cells = firmware::Json::array();
  for (const SweepCell& cell : sweep.cells) {
    firmware::Json values = firmware::Json::object();
    for (std::size_t i = 0; i < sweep.keys.size(); ++i) values[sweep.keys[i]] = cell.values[i];
    firmware::Json errors = firmware::Json::object();
    for (const auto& [name, value] : cell.errors) errors[name] = number(value);
    firmware::Json tasks = firmware::Json::array();
    for (const SweepTiming& timing : cell.timing) {
      tasks.push_back({{"name", timing.task},
                       {"n", timing.n},
                       {"p50_us", number(timing.p50_us)},
                       {"p99_us", number(timing.p99_us)},
                       {"max_us", number(timing.max_us)}});
    }
    cells.push_back(
        {{"values", std::move(values)},
         {"profile_choice", cell.profile_choice},
         {"on_front", cell.on_front},
         {"errors", std::move(errors)},
         {"digest", cell.digest},
         {"voxels", cell.voxels},
         {"voxels_refused", cell.voxels_refused},
         {"memory_bytes", cell.memory_bytes},
         {"load_us_per_s", number(cell.load_us_per_s)},
         {"instructions_per_s", counted ? number(cell.instructions_per_s) : firmware::Json(nullptr)},
         {"tasks", std::move(tasks)}});
  }
  return firmware::Json{{"scene", sweep.scene},
                        {"knobs", sweep.keys},
                        {"tasks", sweep.tasks},
                        {"error", sweep.error},
                        {"cost", "load_us_per_s"},
                        {"repeat", sweep.repeat},
                        {"duration_s", number(sweep.duration_s)},
                        {"cells", std::move(cells)},
                        {"machine", firmware::machine_description()},
                        {"compiler", firmware::compiler_description()},
                        {"warnings", sweep.warnings}};
}

void write_sweep_csv(std::ostream& out, const Sweep& sweep) {
  const std::set<std::string> errors = error_names(sweep);
  for (const std::string& key : sweep.keys) out << field(key) << ",";
  out << "profile_choice,on_front";
  for (const std::string& name : errors) out << "," << field(name);
  const bool counted = counts_instructions(sweep);
  out << ",voxels,voxels_refused,memory_bytes,load_us_per_s";
  if (counted) out << ",instructions_per_s";
  for (const std::string& task : sweep.tasks) {
    for (const char* figure : {"_n", "_p50_us", "_p99_us", "_max_us"}) out << "," << field(task + figure);
  }
  out << ",digest\n";
  for (const SweepCell& cell : sweep.cells) {
    for (const std::string& value : cell.values) out << field(value) << ",";
    out << cell.profile_choice << "," << cell.on_front;
    for (const std::string& name : errors) {
      const auto value = cell.errors.find(name);
      out << ",";
      if (value != cell.errors.end() && std::isfinite(value->second))
        out << firmware::format_exact(value->second);
    }
    out << "," << cell.voxels << "," << cell.voxels_refused << "," << cell.memory_bytes << ","
        << firmware::format_exact(cell.load_us_per_s);
    if (counted) out << "," << firmware::format_exact(cell.instructions_per_s);
    for (const SweepTiming& timing : cell.timing) {
      out << "," << timing.n << "," << firmware::format_exact(timing.p50_us) << ","
          << firmware::format_exact(timing.p99_us) << "," << firmware::format_exact(timing.max_us);
    }
    out << "," << cell.digest << "\n";
  }
}

}  // namespace sortie::toolchain
