// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/sweep/sweep_folder.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>

#include "firmware_like/scene/input_error.hpp"
#include "firmware_like/scene/json_reader.hpp"
#include "firmware_like/scene/text_format.hpp"
#include "rt/digest.hpp"
#include "toolchain/export/output_file.hpp"

namespace sortie::toolchain {

namespace {

constexpr int kPlanFormat = 3;

firmware::Json to_json(const PlannedLog& log) {
  firmware::Json cells = firmware::Json::array();
  for (std::size_t i = 0; i < log.plan.sweep.cells.size(); ++i) {
    cells.push_back({{"values", log.plan.sweep.cells[i].values},
                     {"profile_choice", log.plan.sweep.cells[i].profile_choice},
                     {"overrides", log.plan.overrides[i]},
                     {"profile", log.plan.profiles[i]}});
  }
  firmware::Json json = firmware::json_of(log);
  json["cells"] = std::move(cells);
  return json;
}

// As json_of() writes a struct.
template <class T>
T struct_from_json(const firmware::Json& json) {
  T value;
  T::fields(value, [&json](const char* name, auto& field) { json.at(name).get_to(field); });
  return value;
}

PlannedLog log_from_json(const firmware::Json& json) {
  auto log = struct_from_json<PlannedLog>(json);
  for (const firmware::Json& entry : json.at("cells")) {
    SweepCell cell;
    entry.at("values").get_to(cell.values);
    if (cell.values.size() != log.plan.sweep.keys.size())
      throw firmware::JsonError("a cell has another number of values than there are knobs");
    entry.at("profile_choice").get_to(cell.profile_choice);
    log.plan.sweep.cells.push_back(std::move(cell));
    log.plan.overrides.push_back(entry.at("overrides").get<std::vector<std::string>>());
    log.plan.profiles.push_back(entry.at("profile").get<std::uint64_t>());
  }
  return log;
}

}  // namespace

SweepOptions sweep_options(const SweepRequest& request) {
  SweepOptions options;
  options.replay.scene = request.scene;
  options.replay.maps = request.maps;
  options.replay.overrides = request.overrides;
  options.evaluation.align = parse_alignment(request.align);
  options.evaluation.calibrate_s = request.calibrate_s;
  options.each_knob = request.knobs == std::vector<std::string>{"knobs"};
  if (!options.each_knob) options.knobs = parse_knobs(request.knobs);
  options.tasks = request.tasks;
  options.error = request.error;
  options.repeat = request.repeat;
  options.instructions = request.instructions;
  return options;
}

std::size_t SweepFolderPlan::cell_count() const {
  std::size_t count = 0;
  for (const PlannedLog& log : logs) count += log.plan.sweep.cells.size();
  return count;
}

std::pair<std::size_t, std::size_t> SweepFolderPlan::locate(std::size_t cell) const {
  std::size_t log = 0;
  while (cell >= logs.at(log).plan.sweep.cells.size()) cell -= logs[log++].plan.sweep.cells.size();
  return {log, cell};
}

std::string SweepFolderPlan::key(std::size_t cell) const {
  const auto [l, c] = locate(cell);
  std::string text = program + " " + logs[l].identity + " " + std::to_string(logs[l].plan.profiles[c]) + " " +
                     std::to_string(request.repeat) + (request.instructions ? " counted " : " ") +
                     request.align + " " + firmware::format_exact(request.calibrate_s);
  for (const std::string& task : logs[l].plan.sweep.tasks) text += " " + task;
  return hex_digest(text);
}

std::string SweepFolderPlan::title(std::size_t cell) const {
  const auto [l, c] = locate(cell);
  std::string text;
  for (std::size_t i = 0; i < logs[l].plan.sweep.keys.size(); ++i) {
    text +=
        (text.empty() ? "" : " ") + logs[l].plan.sweep.keys[i] + "=" + logs[l].plan.sweep.cells[c].values[i];
  }
  return text + " of " + std::filesystem::path(logs[l].path).filename().string();
}

std::string whole_file(const std::string& path, const std::string& cure) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw firmware::InputError(path + ": cannot be read; " + cure);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string hex_digest(const std::string& bytes) {
  return firmware::hex(rt::digest_bytes(bytes.data(), bytes.size()));
}

std::string digest_of_file(const std::string& path) {
  return hex_digest(whole_file(path, "give the path of a file"));
}

void write_plan(const std::string& folder, const SweepFolderPlan& plan) {
  std::filesystem::create_directories(folder);
  firmware::Json logs = firmware::Json::array();
  for (const PlannedLog& log : plan.logs) logs.push_back(to_json(log));
  const firmware::Json json{{"format", kPlanFormat},
                            {"request", firmware::json_of(plan.request)},
                            {"program", plan.program},
                            {"logs", std::move(logs)}};
  write_shared(folder + "/plan.json", json.dump(1) + "\n");
}

SweepFolderPlan read_plan(const std::string& folder) {
  const std::string path = folder + "/plan.json";
  const std::string text =
      whole_file(path, "give the folder of a sweep with --jobs, --shard or --slurm, its --out");
  try {
    const firmware::Json json = firmware::Json::parse(text);
    if (json.at("format").get<int>() != kPlanFormat)
      throw firmware::InputError(path + ": is of another version; start the sweep again");
    SweepFolderPlan plan;
    plan.request = struct_from_json<SweepRequest>(json.at("request"));
    json.at("program").get_to(plan.program);
    for (const firmware::Json& log : json.at("logs")) plan.logs.push_back(log_from_json(log));
    return plan;
  } catch (const firmware::JsonError& error) {
    throw firmware::InputError(path + ": is damaged (" + error.what() + "); start the sweep again");
  }
}

}  // namespace sortie::toolchain
