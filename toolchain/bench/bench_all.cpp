// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/bench/bench_all.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "firmware_like/doctor/doctor.hpp"
#include "firmware_like/result/results.hpp"
#include "firmware_like/scene/json.hpp"
#include "firmware_like/scene/text_format.hpp"
#include "rt/posix/clock.hpp"
#include "toolchain/bench/child_process.hpp"
#include "toolchain/bench/figure_table.hpp"

namespace sortie::toolchain {

namespace {

double since(rt::Nanoseconds begin) { return rt::to_seconds(rt::posix::monotonic_now() - begin); }

double load_average() {
  double load[1] = {0};
  return getloadavg(load, 1) == 1 ? load[0] : 0.0;
}

// Goals of a part's figures: how many, how many are met, which are not.
void count_goals(const firmware::Json& result, firmware::Json& part) {
  std::uint64_t goals = 0;
  std::uint64_t met = 0;
  firmware::Json missed = firmware::Json::array();
  for (const firmware::Json& figure : result.value("figures", firmware::Json::array())) {
    if (!figure.contains("met") || !figure["met"].is_boolean()) continue;
    ++goals;
    if (figure["met"].get<bool>()) {
      ++met;
    } else {
      missed.push_back(figure.value("group", "") + ": " + figure.value("what", "") +
                       (figure.value("goal", "").empty() ? "" : ", " + figure.value("goal", "")));
    }
  }
  part["goals"] = goals;
  part["met"] = met;
  part["missed"] = std::move(missed);
  part["unsteady"] = result.value("unsteady", firmware::Json::array());
  part["skipped"] =
      result.contains("skipped") ? firmware::Json(figure_skips(result)) : firmware::Json::array();
}

firmware::Json run_part(BenchPart part, const BenchAllOptions& options) {
  const std::string& folder = options.folder;
  if (part.has_passes && options.passes > 1)
    part.arguments.insert(part.arguments.end(), {"--passes", std::to_string(options.passes)});
  const std::string place = folder + "/" + part.name;
  // What an earlier run left must not pass for this one's.
  std::error_code ignored;
  std::filesystem::remove(place + "/" + part.json_file, ignored);
  ChildCommand child;
  child.arguments = {own_program_path(), "bench"};
  child.arguments.insert(child.arguments.end(), part.arguments.begin(), part.arguments.end());
  child.arguments.insert(child.arguments.end(), {"--out", place});
  std::string command = "sortie bench";
  for (const std::string& word : part.arguments) command += " " + word;
  firmware::Json row{{"name", part.name}, {"command", command}, {"load_before", load_average()}};
  const rt::Nanoseconds begin = rt::posix::monotonic_now();
  row["exit_code"] = run_child(child, [](std::string_view) {}).exit_code;
  row["took_s"] = since(begin);
  row["json"] = part.name + "/" + part.json_file;
  std::ifstream in(place + "/" + part.json_file, std::ios::binary);
  const firmware::Json result = firmware::Json::parse_or_null(in);
  row["written"] = result.is_object();
  count_goals(result.is_object() ? result : firmware::Json::object(), row);
  return row;
}

}  // namespace

const std::vector<BenchPart>& bench_parts() {
  static const std::vector<BenchPart> parts{
      {"stability", {"stability"}, "bench-stability.json"},
      {"rt", {"rt"}, "bench-rt.json", true},
      {"mapping", {"mapping", "--every", "35"}, "bench-local-map.json", true},
      {"registration", {"registration"}, "bench-registration.json"},
      {"recognition", {"recognition"}, "bench-recognition.json", true},
      {"elevation", {"elevation"}, "bench-elevation.json", true},
      {"odometry", {"odometry", "--quiet"}, "bench-odometry.json"},
      {"knobs",
       {"--sweep", "knobs", "--scene", "ugv_hall", "--scene", "ugv_stairs", "--scene", "uav_gusts",
        "--seconds", "20", "--repeat", "2", "--quiet"},
       "sweep.json"},
      {"plant", {"plant"}, "bench-plant.json", true},
      {"rays", {"rays"}, "bench-rays.json", true},
      {"posture", {"posture"}, "bench-posture.json", true},
      {"courses", {"courses"}, "bench-courses.json"},
      {"flippers", {"flippers"}, "bench-flippers.json", true},
      {"ground-path", {"ground-path"}, "bench-ground-path.json", true},
      {"uav", {"uav"}, "bench-uav.json", true},
  };
  return parts;
}

firmware::Json run_bench_all(const BenchAllOptions& options) {
  std::vector<BenchPart> parts;
  for (const BenchPart& part : bench_parts()) {
    const auto asked = std::find(options.only.begin(), options.only.end(), part.name);
    if (options.only.empty() || asked != options.only.end()) parts.push_back(part);
  }
  std::filesystem::create_directories(options.folder);
  const firmware::Doctor doctor({"/", -1});
  firmware::Json index{{"machine", firmware::machine_description()},
                       {"compiler", firmware::compiler_description()},
                       {"load_before", load_average()},
                       {"parts", firmware::Json::array()}};
  const rt::Nanoseconds begin = rt::posix::monotonic_now();
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (options.on_part) options.on_part(i, parts.size(), parts[i].name, since(begin));
    index["parts"].push_back(run_part(parts[i], options));
  }
  index["load_after"] = load_average();
  index["took_s"] = since(begin);
  index["doctor"] = to_json(doctor.report());
  return index;
}

std::string bench_all_page(const firmware::Json& index, const std::string& command) {
  const auto number = [](const firmware::Json& object, const char* key, int decimals) {
    return firmware::format_fixed(object.value(key, 0.0), decimals);
  };
  std::string text = "# All benchmarks\n\nWritten by `" + command + "`.\n\n```\n";
  text += "machine   " + index.value("machine", "") + "; " + index.value("compiler", "") + "\n";
  text += "load      average " + number(index, "load_before", 2) + " before, " +
          number(index, "load_after", 2) + " after\n";
  text += "took      " + number(index, "took_s", 0) + " s\n";
  if (index.contains("doctor")) text += "doctor    " + index["doctor"].value("summary", "") + "\n";
  text += "```\n\n| part | goals met | took | load before | command |\n|---|---:|---:|---:|---|\n";
  std::string missed;
  for (const firmware::Json& part : index.value("parts", firmware::Json::array())) {
    const std::string name = part.value("name", "");
    const bool ran = part.value("written", false);
    const std::string goals = !ran ? "did not run: exit code " + std::to_string(part.value("exit_code", 0))
                              : part.value("goals", 0) == 0 ? "none stated"
                                                            : std::to_string(part.value("met", 0)) + " of " +
                                                                  std::to_string(part.value("goals", 0));
    text += "| " + (ran ? "[" + name + "](" + name + "/)" : name) + " | " + goals + " | " +
            number(part, "took_s", 0) + " s | " + number(part, "load_before", 2) + " | `" +
            part.value("command", "") + "` |\n";
    for (const firmware::Json& line : part.value("missed", firmware::Json::array()))
      missed += "- " + name + ": " + line.get<std::string>() + "\n";
    for (const firmware::Json& line : part.value("unsteady", firmware::Json::array()))
      missed += "- " + name + ", not the same in every pass: " + line.get<std::string>() + "\n";
    for (const firmware::Json& line : part.value("skipped", firmware::Json::array()))
      missed += "- " + name + ", left out: " + line.get<std::string>() + "\n";
  }
  if (!missed.empty()) text += "\n## Missed or left out\n\n" + missed;
  return text;
}

}  // namespace sortie::toolchain
