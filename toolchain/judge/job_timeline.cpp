// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/judge/job_timeline.hpp"

#include <algorithm>
#include <cmath>

#include "firmware_like/parts/odometry_state.hpp"

namespace sortie::toolchain {

void SpanMaxima::add(double time_s, double value) {
  if (!(time_s >= 0.0) || !std::isfinite(time_s)) return;
  while (time_s / length_s_ >= static_cast<double>(kMost)) {
    length_s_ *= 2.0;
    std::vector<Span> wider((spans_.size() + 1) / 2);
    for (std::size_t i = 0; i < spans_.size(); ++i) {
      if (spans_[i].count == 0) continue;
      Span& span = wider[i / 2];
      span.most = span.count == 0 ? spans_[i].most : std::max(span.most, spans_[i].most);
      span.count += spans_[i].count;
    }
    spans_ = std::move(wider);
  }
  const auto index = static_cast<std::size_t>(time_s / length_s_);
  if (index >= spans_.size()) spans_.resize(index + 1);
  Span& span = spans_[index];
  span.most = span.count == 0 ? value : std::max(span.most, value);
  ++span.count;
}

std::vector<SpanMaxima::Span> SpanMaxima::spans() const {
  std::vector<Span> result;
  for (std::size_t i = 0; i < spans_.size(); ++i) {
    if (spans_[i].count == 0) continue;
    const auto from = static_cast<double>(i);
    result.push_back({from * length_s_, (from + 1.0) * length_s_, spans_[i].most, spans_[i].count});
  }
  return result;
}

void JobTimeline::find(const firmware::Runtime& runtime) {
  runtime_ = &runtime;
  odometry_ = nullptr;
  const rt::Executive& executive = runtime.executive();
  groups_.clear();
  for (std::uint32_t g = 0; g < executive.group_count(); ++g) {
    const rt::Group& group = executive.group(g);
    groups_.push_back({group.spec.name, {}});
    for (const rt::TaskBase* task : group.tasks) {
      if (dynamic_cast<const rt::Task<firmware::OdometryState>*>(task) != nullptr) odometry_ = task;
    }
  }
}

void JobTimeline::job(const rt::JobRecord& record, const firmware::Runtime& runtime) {
  if (runtime_ != &runtime) find(runtime);
  const double time_s =
      static_cast<double>(record.tick) * static_cast<double>(runtime.executive().base_tick_ns()) * 1e-9;
  std::uint64_t total_ns = 0;
  for (std::uint32_t i = 0; i < record.tasks; ++i) total_ns += record.duration_ns[i];
  groups_[record.group].job_us.add(time_s, static_cast<double>(total_ns) * 1e-3);
  end_s_ = std::max(end_s_, time_s);
  if (odometry_ == nullptr || record.group != odometry_->group()) return;
  const std::uint32_t mode = static_cast<const rt::Task<firmware::OdometryState>*>(odometry_)->value().mode;
  if (modes_.empty() || modes_.back().mode != mode) modes_.push_back({time_s, mode});
}

}  // namespace sortie::toolchain
