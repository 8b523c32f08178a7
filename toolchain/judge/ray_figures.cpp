// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/judge/ray_figures.hpp"

#include <algorithm>

#include "firmware_like/parts/ugv_ssl.hpp"
#include "firmware_like/scene/text_format.hpp"

namespace sortie::toolchain {

namespace {

// In order; empty: nothing.
template <class T>
T middle_of(const std::vector<T>& sorted) {
  return sorted.empty() ? T{} : sorted[sorted.size() / 2];
}

}  // namespace

void RayFigures::find(const firmware::Runtime& runtime) {
  runtime_ = &runtime;
  task_ = nullptr;
  const rt::Executive& executive = runtime.executive();
  for (std::uint32_t g = 0; g < executive.group_count(); ++g) {
    const auto& tasks = executive.group(g).tasks;
    for (std::uint32_t i = 0; i < tasks.size(); ++i) {
      if (dynamic_cast<const rt::Task<firmware::SslOutput>*>(tasks[i]) == nullptr) continue;
      task_ = tasks[i];
      place_ = i;
    }
  }
}

void RayFigures::job(const rt::JobRecord& record, const firmware::Runtime& runtime) {
  if (runtime_ != &runtime) find(runtime);
  if (task_ == nullptr || record.group != task_->group()) return;
  const firmware::SslOutput& output = static_cast<const rt::Task<firmware::SslOutput>*>(task_)->value();
  Plan plan;
  plan.tick = record.tick;
  plan.units = record.units[place_];
  plan.late = record.verdict == rt::Verdict::missed;
  plan.cut = (static_cast<unsigned>(record.cut) >> place_ & 1u) != 0;
  plan.shed = (static_cast<unsigned>(record.shed) >> place_ & 1u) != 0;
  if (!plan.shed) {
    plan.unplanned = output.unplanned != unplanned_;
    plan.stage = static_cast<std::uint8_t>(output.stage);
    plan.certificate = output.plan.certificate;
    unplanned_ = output.unplanned;
  }
  plans_.push_back(plan);
}

std::vector<FigureRow> RayFigures::rows(rt::Tick first) const {
  std::vector<std::uint32_t> units;
  std::vector<double> certificates;
  std::uint64_t commands = 0;
  std::uint64_t late = 0;
  std::uint64_t cut = 0;
  std::uint64_t shed = 0;
  std::uint64_t unplanned = 0;
  std::uint64_t stages[4]{};
  for (const Plan& plan : plans_) {
    if (plan.tick < first) continue;
    shed += plan.shed ? 1 : 0;
    if (plan.shed) continue;
    ++commands;
    late += plan.late ? 1 : 0;
    cut += plan.cut ? 1 : 0;
    unplanned += plan.unplanned ? 1 : 0;
    if (plan.unplanned || plan.units == 0) continue;
    units.push_back(plan.units);
    ++stages[std::min<std::size_t>(plan.stage, 3)];
    if (plan.certificate > 0.0) certificates.push_back(plan.certificate);
  }
  if (commands + shed == 0) return {};
  std::sort(units.begin(), units.end());
  std::sort(certificates.begin(), certificates.end());
  std::vector<FigureRow> rows;
  const auto count = [&rows](const char* name, std::uint64_t value, const char* unit = "") {
    rows.push_back({name, firmware::group_digits(value), unit});
  };
  count("commands", commands);
  count("late plans, whose command was dropped", late);
  count("plans that the clock cut", cut);
  count("releases that the ladder left out", shed);
  count("commands without a plan (strides)", unplanned);
  count("plans", units.size());
  count("that end with their positions one by one", stages[1]);
  count("that end with all positions together", stages[2]);
  count("that end with all directions", stages[3]);
  count("units that a plan may spend", task_->spec().units, "units");
  count("units spent, median", middle_of(units), "units");
  count("units spent, most", units.empty() ? 0 : units.back(), "units");
  count("plans with a certificate", certificates.size());
  if (!certificates.empty()) {
    rows.push_back({"gain certificate, median", firmware::format_fixed(100.0 * middle_of(certificates), 1),
                    "% of the best"});
    rows.push_back({"gain certificate, least", firmware::format_fixed(100.0 * certificates.front(), 1),
                    "% of the best"});
  }
  return rows;
}

}  // namespace sortie::toolchain
