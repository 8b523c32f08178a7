// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/sweep/sweep_report.hpp"

#include <cmath>
#include <ostream>
#include <set>
#include <type_traits>

#include "firmware_like/scene/json_reader.hpp"
#include "firmware_like/scene/text_format.hpp"

namespace sortie::toolchain {

namespace {

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

firmware::Json figures_of(const SweepCell& cell) {
  firmware::Json errors = firmware::Json::object();
  for (const auto& [name, value] : cell.errors) errors[name] = firmware::json_number(value);
  firmware::Json tasks = firmware::Json::array();
  for (const SweepTiming& timing : cell.timing) {
    firmware::Json task{{"name", timing.task}};
    task.update(firmware::json_of(timing));
    tasks.push_back(std::move(task));
  }
  firmware::Json figures{{"errors", std::move(errors)}};
  figures.update(firmware::json_of(cell));
  figures["tasks"] = std::move(tasks);
  return figures;
}

firmware::Json to_json(const Sweep& sweep) {
  const bool counted = counts_instructions(sweep);
  firmware::Json cells = firmware::Json::array();
  for (const SweepCell& cell : sweep.cells) {
    firmware::Json values = firmware::Json::object();
    for (std::size_t i = 0; i < sweep.keys.size(); ++i) values[sweep.keys[i]] = cell.values[i];
    firmware::Json row{
        {"values", std::move(values)}, {"profile_choice", cell.profile_choice}, {"on_front", cell.on_front}};
    row.update(figures_of(cell));
    if (!counted) row["instructions_per_s"] = nullptr;
    cells.push_back(std::move(row));
  }
  return firmware::Json{{"scene", sweep.scene},
                        {"knobs", sweep.keys},
                        {"tasks", sweep.tasks},
                        {"error", sweep.error},
                        {"cost", "load_us_per_s"},
                        {"repeat", sweep.repeat},
                        {"duration_s", firmware::json_number(sweep.duration_s)},
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
  const SweepTiming named;
  for (const std::string& task : sweep.tasks)
    SweepTiming::fields(named, [&](const char* name, auto) { out << "," << field(task + "_" + name); });
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
      SweepTiming::fields(timing, [&out]<class T>(const char*, const T& value) {
        out << ",";
        if constexpr (std::is_floating_point_v<T>)
          out << firmware::format_exact(value);
        else
          out << value;
      });
    }
    out << "," << cell.digest << "\n";
  }
}

}  // namespace sortie::toolchain
