// SPDX-License-Identifier: BSD-3-Clause
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "firmware_like/scene/input_error.hpp"
#include "firmware_like/scene/json.hpp"
#include "toolchain/export/output_file.hpp"
#include "toolchain/sweep/sweep_folder.hpp"
#include "toolchain/sweep/sweep_report.hpp"

namespace sortie::toolchain {

namespace {

// Cell numbers are sorted: steps between them are short in text.
firmware::Json to_json(const MapVolume& map) {
  firmware::Json steps = firmware::Json::array();
  std::uint64_t last = 0;
  for (const std::uint64_t cell : map.cells) {
    steps.push_back(cell - last);
    last = cell;
  }
  return {{"voxel_m", map.voxel_m}, {"refused", map.refused}, {"steps", std::move(steps)}};
}

MapVolume map_from_json(const firmware::Json& json) {
  MapVolume map;
  json.at("voxel_m").get_to(map.voxel_m);
  json.at("refused").get_to(map.refused);
  std::uint64_t last = 0;
  for (const firmware::Json& step : json.at("steps")) map.cells.push_back(last += step.get<std::uint64_t>());
  return map;
}

SweepCellResult result_from_json(const firmware::Json& json) {
  SweepCellResult result;
  SweepCell& cell = result.cell;
  json.at("values").get_to(cell.values);
  json.at("profile_choice").get_to(cell.profile_choice);
  for (const auto& [name, value] : json.at("errors").items())
    cell.errors[name] = value.is_null() ? std::nan("") : value.get<double>();
  const auto read = [](const firmware::Json& from) {
    return [&from](const char* name, auto& value) { from.at(name).get_to(value); };
  };
  SweepCell::fields(cell, read(json));
  for (const firmware::Json& entry : json.at("tasks")) {
    SweepTiming& timing = cell.timing.emplace_back();
    entry.at("name").get_to(timing.task);
    SweepTiming::fields(timing, read(entry));
  }
  json.at("duration_s").get_to(result.duration_s);
  if (json.contains("map")) result.map = map_from_json(json.at("map"));
  return result;
}

}  // namespace

std::string own_suffix() {
  char host[256] = "";
  if (gethostname(host, sizeof host - 1) != 0) host[0] = '\0';
  return std::string(".") + host + "." + std::to_string(getpid());
}

void write_shared(const std::string& path, const std::string& text) {
  const std::string own = path + own_suffix();
  write_file(own, text);
  std::error_code error;
  std::filesystem::rename(own, path, error);
  if (error)
    throw firmware::InputError(path + ": cannot be written (" + error.message() + "); choose another --out");
}

std::string cell_file(std::size_t cell) {
  const std::string number = std::to_string(cell);
  return "cell-" + std::string(number.size() < 5 ? 5 - number.size() : 0, '0') + number + ".json";
}

void write_cell(const std::string& folder, std::size_t number, const std::string& key,
                const SweepCellResult& result) {
  const SweepCell& cell = result.cell;
  firmware::Json json{{"key", key}, {"values", cell.values}, {"profile_choice", cell.profile_choice}};
  json.update(figures_of(cell));
  json["duration_s"] = result.duration_s;
  if (result.map) json["map"] = to_json(*result.map);
  write_shared(folder + "/" + cell_file(number), json.dump() + "\n");
}

std::optional<SweepCellResult> read_cell(const std::string& folder, std::size_t cell,
                                         const SweepFolderPlan& plan) {
  std::ifstream in(folder + "/" + cell_file(cell), std::ios::binary);
  if (!in) return std::nullopt;
  const firmware::Json json = firmware::Json::parse_or_null(in);
  if (!json.is_object() || !json.contains("key") || json["key"] != plan.key(cell)) return std::nullopt;
  try {
    SweepCellResult result = result_from_json(json);
    if (result.cell.values.size() != plan.logs[plan.locate(cell).first].plan.sweep.keys.size())
      return std::nullopt;
    return result;
  } catch (const firmware::JsonError&) {
    return std::nullopt;  // as good as not there: it is run again
  }
}

}  // namespace sortie::toolchain
