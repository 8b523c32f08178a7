// SPDX-License-Identifier: BSD-3-Clause
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "firmware_like/scene/input_error.hpp"
#include "firmware_like/scene/json.hpp"
#include "toolchain/export/output_file.hpp"
#include "toolchain/sweep/sweep_folder.hpp"

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
  json.at("digest").get_to(cell.digest);
  json.at("voxels").get_to(cell.voxels);
  json.at("voxels_refused").get_to(cell.voxels_refused);
  json.at("memory_bytes").get_to(cell.memory_bytes);
  json.at("load_us_per_s").get_to(cell.load_us_per_s);
  json.at("instructions_per_s").get_to(cell.instructions_per_s);
  for (const firmware::Json& entry : json.at("tasks")) {
    cell.timing.push_back({entry.at("name").get<std::string>(), entry.at("n").get<std::uint64_t>(),
                           entry.at("p50_us").get<double>(), entry.at("p99_us").get<double>(),
                           entry.at("max_us").get<double>()});
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
  write_file(own, [&text](std::ostream& out) { out << text; });
  std::error_code error;
  std::filesystem::rename(own, path, error);
  if (error)
    throw firmware::InputError(path + ": cannot be written (" + error.message() + "); choose another --out");
}

std::string cell_file(std::size_t cell) {
  const std::string number = std::to_string(cell);
  return "cell-" + std::string(number.size() < 5 ? 5 - number.size() : 0, '0') + number + ".json";
}

void write_cell(const std::string& folder, std::size_t cell, const std::string& key,
                const SweepCellResult& result) {
  const SweepCell& figures = result.cell;
  firmware::Json errors = firmware::Json::object();
  for (const auto& [name, value] : figures.errors)
    errors[name] = std::isfinite(value) ? firmware::Json(value) : firmware::Json(nullptr);
  firmware::Json tasks = firmware::Json::array();
  for (const SweepTiming& timing : figures.timing) {
    tasks.push_back({{"name", timing.task},
                     {"n", timing.n},
                     {"p50_us", timing.p50_us},
                     {"p99_us", timing.p99_us},
                     {"max_us", timing.max_us}});
  }
  firmware::Json json{{"key", key},
                      {"values", figures.values},
                      {"profile_choice", figures.profile_choice},
                      {"errors", std::move(errors)},
                      {"digest", figures.digest},
                      {"voxels", figures.voxels},
                      {"voxels_refused", figures.voxels_refused},
                      {"memory_bytes", figures.memory_bytes},
                      {"load_us_per_s", figures.load_us_per_s},
                      {"instructions_per_s", figures.instructions_per_s},
                      {"tasks", std::move(tasks)},
                      {"duration_s", result.duration_s}};
  if (result.map) json["map"] = to_json(*result.map);
  write_shared(folder + "/" + cell_file(cell), json.dump() + "\n");
}

std::optional<SweepCellResult> read_cell(const std::string& folder, std::size_t cell,
                                         const std::string& key) {
  std::ifstream in(folder + "/" + cell_file(cell), std::ios::binary);
  if (!in) return std::nullopt;
  const firmware::Json json = firmware::Json::parse_or_null(in);
  if (!json.is_object() || !json.contains("key") || json["key"] != key) return std::nullopt;
  try {
    return result_from_json(json);
  } catch (const firmware::JsonError&) {
    return std::nullopt;  // as good as not there: it is run again
  }
}

}  // namespace sortie::toolchain
