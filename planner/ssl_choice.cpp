// SPDX-License-Identifier: BSD-3-Clause
#include "planner/ssl_choice.hpp"

#include <algorithm>
#include <array>

#include "mapping/grid/mix64.hpp"

namespace sortie::planner {

namespace {

// splitmix64: one number from the next counter.
std::uint64_t next_random(std::uint64_t& counter) { return mapping::mix64(counter += 0x9e3779b97f4a7c15); }

bool fits_the_device(const SslChoiceConfig& config) {
  const RaySensor& sensor = config.scheduler.sensor;
  return sensor.columns == rt::kSslColumns && sensor.rows == rt::kSslRows;
}

}  // namespace

std::uint64_t SslChoice::memory_bytes(const SslChoiceConfig& config) {
  if (config.policy != SslPolicy::scheduled || !fits_the_device(config)) return 0;
  return RayScheduler::memory_bytes(config.scheduler);
}

SslChoice::SslChoice(const SslChoiceConfig& config, std::span<std::byte> memory) : config_(config) {
  if (!fits_the_device(config)) return;
  config_.scheduler.rays = rays_ = std::min(config.scheduler.rays, rt::kSslMaxRays);
  usable_ = true;
  if (config.policy != SslPolicy::scheduled) return;
  scheduler_.emplace(config_.scheduler, memory);
  usable_ = scheduler_->usable();
}

Status SslChoice::begin(const mapping::OccupancyView& map, std::span<const mapping::SensorPose> poses,
                        std::uint32_t passed) {
  planning_ = false;
  if (config_.policy != SslPolicy::scheduled) return Status::ok;
  planned_ -= std::min(planned_, passed);
  if (!usable_) return Status::out_of_range;
  const Status status = scheduler_->begin(map, poses, passed);
  planning_ = status == Status::ok;
  return status;
}

std::uint64_t SslChoice::step(std::uint64_t units) { return planning_ ? scheduler_->step(units) : 0; }

void SslChoice::choose(rt::Nanoseconds stamp_ns, rt::SslCommand& command) {
  command = {};
  command.stamp_ns = stamp_ns;
  command.rays = rays_;
  ++number_;
  command.number = number_;
  if (planning_) planned_ = std::max(planned_, scheduler_->plan().planned);
  const bool chosen = planning_ && planned_ > 0;
  planning_ = false;
  if (chosen) {
    const std::span<const std::uint16_t> rays = scheduler_->rays(0);
    std::copy(rays.begin(), rays.end(), command.direction);
    return;
  }
  if (config_.policy == SslPolicy::grid) {
    fill_grid(command);
  } else if (config_.policy == SslPolicy::random) {
    fill_random(command);
  } else {
    if (config_.policy == SslPolicy::scheduled) ++unplanned_;
    stride_.next(rays_, stamp_ns, command);  // which counts for itself
  }
  command.number = number_;
}

// Cells of equal size, as square as they can be, and their middles. There are never more than 256.
void SslChoice::fill_grid(rt::SslCommand& command) const {
  constexpr std::uint32_t kColumns = rt::kSslColumns;
  constexpr std::uint32_t kRows = rt::kSslRows;
  std::uint32_t down = 1;
  while ((down + 1) * (down + 1) * kColumns <= rays_ * kRows) ++down;
  const std::uint32_t across = (rays_ + down - 1) / down;
  for (std::uint32_t i = 0; i < rays_; ++i) {
    const std::uint32_t cell = i * across * down / rays_;
    const std::uint32_t x = (2 * (cell % across) + 1) * kColumns / (2 * across);
    const std::uint32_t y = (2 * (cell / across) + 1) * kRows / (2 * down);
    command.direction[i] = static_cast<std::uint16_t>(y * kColumns + x);
  }
}

// The first directions of a shuffle: Floyd's way needs no list of all. Bounded by the rays.
void SslChoice::fill_random(rt::SslCommand& command) const {
  std::array<std::uint32_t, RayBits::words(rt::kSslDirections)> bits{};
  RayBits taken(bits);
  std::uint64_t counter = config_.seed * 0xd1342543de82ef95 + number_;
  for (std::uint32_t i = 0; i < rays_; ++i) {
    const std::uint32_t last = rt::kSslDirections - rays_ + i;
    const auto drawn =
        static_cast<std::uint32_t>((next_random(counter) >> 32) * (std::uint64_t{last} + 1) >> 32);
    const std::uint32_t ray = taken.has(drawn) ? last : drawn;
    taken.set(ray);
    command.direction[i] = static_cast<std::uint16_t>(ray);
  }
}

void SslChoice::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "ssl choice")
      .fixed(config_, rays_, usable_)
      .state(stride_, number_, planned_, unplanned_)
      .by_hand(scheduler_)
      .scratch(planning_);
  archive.expect(scheduler_.has_value() ? 1 : 0, "rays are chosen in another way");
  if (scheduler_) archive.value(*scheduler_);
  if (archive.is_reading()) planning_ = false;
}

}  // namespace sortie::planner
