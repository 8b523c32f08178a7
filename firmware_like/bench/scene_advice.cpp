// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/bench/scene_advice.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "firmware_like/evaluation/evaluate.hpp"
#include "firmware_like/scene_parts.hpp"
#include "firmware_like/text_format.hpp"

namespace sortie::firmware {

namespace {

// What nobody would see: of the pose, and of an error as a share of it.
constexpr double kUnseen_m = 1e-3;
constexpr double kUnseenShare = 0.01;
constexpr double kDegrees = 57.29577951308232;

// What works on the robot shows in a drive alone.
bool only_acts(const ScenePart& part) {
  for (const std::string_view name : {"drive", "flippers", "canopen", "pilot", "path", "sensed_map", "ssl",
                                      "ray_scheduler", "parameters"}) {
    if (name == part.name) return true;
  }
  return false;
}

double us_per_tick(const ReplayOutcome& outcome) {
  const rt::Executive& executive = outcome.runtime->executive();
  double ns = 0;
  for (std::uint32_t t = 0; t < executive.task_count(); ++t)
    ns += static_cast<double>(executive.task(t).wall_time().sum());
  return 1e-3 * ns / static_cast<double>(std::max<std::uint64_t>(outcome.results.ticks, 1));
}

// Both are in order of their stamps.
double most_apart_m(const Trajectory& a, const Trajectory& b) {
  double most = 0;
  auto other = b.begin();
  for (const TimedPose& pose : a) {
    while (other != b.end() && other->stamp_ns < pose.stamp_ns) ++other;
    if (other == b.end()) break;
    if (other->stamp_ns != pose.stamp_ns) continue;
    most =
        std::max(most, std::hypot(pose.p[0] - other->p[0], pose.p[1] - other->p[1], pose.p[2] - other->p[2]));
  }
  return most;
}

double most_inclined_deg(const Trajectory& path) {
  double least = 1;
  for (const TimedPose& pose : path)
    least = std::min(least, 1 - 2 * (pose.q[1] * pose.q[1] + pose.q[2] * pose.q[2]));
  return kDegrees * std::acos(std::clamp(least, -1.0, 1.0));
}

// Tasks of both whose outputs are not the same.
std::vector<std::string> changed_tasks(const Results& a, const Results& b, std::size_t& common) {
  std::vector<std::string> names;
  common = 0;
  for (const TaskResult& task : a.tasks) {
    for (const TaskResult& other : b.tasks) {
      if (task.name != other.name) continue;
      ++common;
      if (task.digest != other.digest) names.push_back(task.name);
    }
  }
  return names;
}

std::string figure_of(double value) { return format_short(value); }

class Adviser {
 public:
  Adviser(const LogFile& log, const VehicleRegistry& vehicles, const ReplayOptions& options)
      : log_(log), vehicles_(vehicles), options_(options) {}

  Advice run() {
    whole_ = again({});
    advice_.scene = whole_.results.scene;
    advice_.log = log_.path();
    advice_.ticks = whole_.results.ticks;
    for (const char* name : {"ate_rmse_m", "inclination_rmse_deg"}) {
      if (advice_.judged_by.empty() && whole_.results.errors.count(name) != 0) advice_.judged_by = name;
    }
    advice_.most_inclined_deg = most_inclined_deg(whole_.estimate);
    present_ = parts_of(whole_.runtime->profile());
    for (const ScenePart& part : scene_parts()) {
      if (*part.vehicle != '\0' && part.vehicle != whole_.results.vehicle) continue;
      const bool is_there = std::find(present_.begin(), present_.end(), &part) != present_.end();
      is_there ? judge_present(part) : judge_absent(part);
    }
    return std::move(advice_);
  }

 private:
  AdviceLine& line(const ScenePart& part, PartVerdict verdict, const std::string& figure) {
    AdviceLine& added = advice_.lines.emplace_back();
    added.part = part.name;
    added.verdict = verdict;
    added.figure = figure;
    return added;
  }

  std::size_t samples(const ScenePart& part) const { return log_.channel(part.input).size(); }

  std::optional<double> error(const ReplayOutcome& outcome) const {
    const auto found = outcome.results.errors.find(advice_.judged_by);
    if (found == outcome.results.errors.end()) return {};
    return found->second;
  }

  ReplayOutcome again(const std::vector<std::string>& overrides) const {
    ReplayOptions options = options_;
    options.overrides.insert(options.overrides.end(), overrides.begin(), overrides.end());
    ReplayOutcome outcome = replay(log_, vehicles_, options);
    judge(outcome);
    return outcome;
  }

  // "ate_rmse_m 0.12 as it is, 0.35 without; the pose moves by up to 0.4 m"
  void compare(AdviceLine& judged, const ReplayOutcome& other, const char* how) {
    judged.pose_moved_m = most_apart_m(whole_.estimate, other.estimate);
    judged.error = error(whole_);
    judged.changed = error(other);
    if (judged.error && judged.changed) {
      judged.figure += advice_.judged_by + " " + figure_of(*judged.error) + " as it is, " +
                       figure_of(*judged.changed) + " " + how + "; ";
    }
    judged.figure += "the pose moves by up to " + figure_of(judged.pose_moved_m) + " m";
  }

  void judge_present(const ScenePart& part) {
    if (*part.input != '\0' && samples(part) == 0 && log_.channel("CAN").empty()) {
      line(part, PartVerdict::no_input, std::string("the log has 0 samples on ") + part.input);
      return;
    }
    if (part.code == rt::Part::recorder || part.code == rt::Part::telemetry) {
      line(part, PartVerdict::not_judged, "no replay knows who reads what leaves the robot");
      return;
    }
    if (only_acts(part)) {
      line(part, PartVerdict::not_judged, "it acts on the robot: `sortie scenes --cost` drives without it");
      return;
    }
    if (const std::string user = why_needed(part, present_); !user.empty()) {
      line(part, PartVerdict::not_judged, user);
      return;
    }
    try {
      const ReplayOutcome other = again(overrides_without(part));
      AdviceLine& judged = line(part, PartVerdict::mattered, "");
      judged.bytes = static_cast<std::int64_t>(whole_.runtime->memory_bytes()) -
                     static_cast<std::int64_t>(other.runtime->memory_bytes());
      judged.us_per_tick = us_per_tick(whole_) - us_per_tick(other);
      std::size_t common = 0;
      const auto changed = changed_tasks(whole_.results, other.results, common);
      const bool estimates = !other.estimate.empty() || whole_.estimate.empty();
      if (common > 0 && changed.empty() && estimates) {
        judged.verdict = PartVerdict::never_mattered;
        judged.figure = "0 of the " + std::to_string(common) + " other tasks put out anything else in " +
                        std::to_string(advice_.ticks) + " ticks";
        return;
      }
      // Where all change, the table of groups did, and samples come a tick earlier or later.
      if (changed.size() < common) {
        for (const std::string& task : changed) judged.figure += (judged.figure.empty() ? "" : ", ") + task;
        if (!changed.empty()) judged.figure += " put out something else; ";
      }
      compare(judged, other, "without");
      if (!judged.error || !judged.changed) {
        if (estimates && judged.pose_moved_m < kUnseen_m) judged.verdict = PartVerdict::never_mattered;
        return;
      }
      const double gain = *judged.changed - *judged.error;
      if (judged.pose_moved_m < kUnseen_m && std::fabs(gain) <= kUnseenShare * *judged.error) {
        judged.verdict = PartVerdict::never_mattered;
      } else if (gain <= kUnseenShare * *judged.error) {
        judged.verdict = PartVerdict::did_not_help;
      }
    } catch (const ProfileError& refused) {
      line(part, PartVerdict::not_judged, refused.what());
    }
  }

  void judge_absent(const ScenePart& part) {
    const bool has_parent =
        *part.parent == '\0' || std::any_of(present_.begin(), present_.end(), [&](const auto* p) {
          return std::string_view(p->name) == part.parent;
        });
    if (*part.input != '\0' && samples(part) > 0 && has_parent && *part.with == '\0') {
      line(part, PartVerdict::not_judged,
           std::to_string(samples(part)) + " samples on " + part.input +
               " that nobody reads; the part needs more keys than one");
      return;
    }
    const bool is_outlet = part.code == rt::Part::recorder || part.code == rt::Part::telemetry;
    if (!has_parent || *part.with == '\0' || is_outlet || only_acts(part)) return;
    if (*part.input != '\0' && samples(part) == 0) return;
    try {
      const ReplayOutcome other = again(overrides_with(part));
      AdviceLine& judged = line(part, PartVerdict::would_not, "");
      judged.bytes = static_cast<std::int64_t>(other.runtime->memory_bytes()) -
                     static_cast<std::int64_t>(whole_.runtime->memory_bytes());
      judged.us_per_tick = us_per_tick(other) - us_per_tick(whole_);
      if (*part.input != '\0') {
        judged.figure = std::to_string(samples(part)) + " samples on " + part.input + " that nobody reads; ";
      } else if (std::string_view(part.name) == "obstacles") {
        judged.figure = "inclined by up to " + figure_of(advice_.most_inclined_deg) + " deg; ";
      }
      compare(judged, other, "with it");
      const bool better =
          judged.error && judged.changed && *judged.changed < (1 - kUnseenShare) * *judged.error;
      const bool moves = judged.pose_moved_m >= kUnseen_m;
      if (judged.error && judged.changed ? better && moves : moves)
        judged.verdict = PartVerdict::would_matter;
    } catch (const ProfileError& refused) {
      line(part, PartVerdict::not_judged, refused.what());
    }
  }

  const LogFile& log_;
  const VehicleRegistry& vehicles_;
  const ReplayOptions& options_;
  ReplayOutcome whole_;
  std::vector<const ScenePart*> present_;
  Advice advice_;
};

}  // namespace

Advice advise(const LogFile& log, const VehicleRegistry& vehicles, const ReplayOptions& options) {
  return Adviser(log, vehicles, options).run();
}

}  // namespace sortie::firmware
