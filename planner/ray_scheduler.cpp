// SPDX-License-Identifier: BSD-3-Clause
// Memory, tasks and slices of the ray scheduler, and what it carries from one task to the next.
#include "planner/ray_scheduler.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "planner/ray_units.hpp"
#include "rt/arena.hpp"
#include "rt/digest.hpp"

namespace sortie::planner {

namespace {

bool is_share(double value) { return value >= 0.0 && value < 1.0; }

bool is_good(const RaySchedulerConfig& config) {
  const RaySensor& s = config.sensor;
  const RayModelConfig& m = config.model;
  const bool numbers = s.columns >= 1 && s.rows >= 1 && s.columns <= 65536 && s.rows <= 65536 &&
                       static_cast<std::uint64_t>(s.columns) * s.rows <= 65536 && config.positions >= 1 &&
                       config.positions <= RayScheduler::kMostPositions && config.map_cells >= 1 &&
                       config.map_cells <= (1u << 24) && config.coarse_log2 <= 6 && config.tries >= 1 &&
                       config.table_lines <= 65535;
  const bool sizes = config.voxel_size_m > 0.0 && s.range_m > 0.0 &&
                     s.range_m / config.voxel_size_m <= mapping::VoxelWalk::kMostVoxels &&
                     std::isfinite(s.width_rad) && std::isfinite(s.height_rad);
  const bool shares = m.prior > 0.0 && m.prior < 1.0 && m.solid > 0.5 && m.solid <= 1.0 &&
                      is_share(m.least_visible) && is_share(config.slack) && config.optimism >= 1.0 &&
                      std::isfinite(config.optimism);
  return numbers && sizes && shares;
}

// Cells that a ray passes at most: its length along the three axes, and one more for each start.
std::uint32_t cells_of_a_ray(const RaySchedulerConfig& config) {
  const double length = config.sensor.range_m / config.voxel_size_m * 1.7320508075688774;
  return static_cast<std::uint32_t>(length) + 5;
}

// Lines of the table, the one for all other cells included.
std::uint32_t table_lines(const RaySchedulerConfig& config) {
  if (config.table_lines > 0) return config.table_lines + 1;
  const std::uint64_t rays = std::uint64_t{RaySizes::of(config).per_position} * config.positions;
  const std::uint64_t most = CoverageTable::directory_size(config.map_cells);
  return static_cast<std::uint32_t>(std::min({rays * 52, most, std::uint64_t{32768}})) + 1;
}

// Enough for all directions of a street, or, for one position, for those that the guided stages look at.
std::uint32_t path_words(const RaySchedulerConfig& config) {
  if (config.path_words > 0) return config.path_words;
  const std::uint32_t all = config.positions * config.sensor.rays();
  return config.positions == 1 ? all * 3 / 2 : all * 7 / 2;
}

}  // namespace

std::uint64_t RayScheduler::memory_bytes(const RaySchedulerConfig& config) {
  if (!is_good(config)) return 0;
  const std::uint64_t all = std::uint64_t{config.positions} * config.sensor.rays();
  const std::uint64_t plans =
      2 * std::uint64_t{config.positions} * RaySizes::of(config).per_position * sizeof(std::uint16_t);
  return sizeof(rt::SinCos) * (config.sensor.columns + config.sensor.rows) +
         sizeof(rt::Vector3) * config.positions * config.sensor.columns +
         all * (sizeof(float) + sizeof(std::uint64_t) + sizeof(std::uint32_t)) +
         2 * sizeof(std::uint32_t) * RayBits::words(all) + plans +
         sizeof(RayModel::Passed) * cells_of_a_ray(config) +
         (sizeof(CoverageLine) + sizeof(std::uint32_t)) * table_lines(config) +
         sizeof(std::uint16_t) * CoverageTable::directory_size(config.map_cells) + sizeof(CoverageLine) +
         sizeof(std::uint32_t) * path_words(config) + 15 * alignof(std::max_align_t);
}

RayScheduler::RayScheduler(const RaySchedulerConfig& config, std::span<std::byte> memory)
    : config_(config),
      looks_(config),
      exploration_(config_, sizes_, heap_, looks_),
      selection_(config_, sizes_, heap_, looks_, cover_, use_),
      weighing_(sizes_, looks_, use_),
      certificate_(sizes_, heap_, looks_) {
  if (config_.explored == 0) config_.explored = config.positions == 1 ? 4000 : 7000;
  const std::uint64_t needed = memory_bytes(config);
  if (needed == 0 || memory.size() < needed) return;
  sizes_ = RaySizes::of(config);
  largest_step_ = ray_units::dearest(
      {cells_of_a_ray(config), sizes_.per_position, config.positions, sizes_.all_rays, config.coarse_log2});
  lay_out(memory);
  usable_ = true;
}

void RayScheduler::lay_out(std::span<std::byte> memory) {
  rt::Arena arena(memory);
  const std::size_t all = std::size_t{config_.positions} * sizes_.all_rays;
  const std::size_t plan = std::size_t{config_.positions} * sizes_.per_position;
  CoverageMemory table;
  table.lines = arena.make_array<CoverageLine>("coverage", table_lines(config_), sizeof(CoverageLine));
  table.owners = arena.make_array<std::uint32_t>("owners", table_lines(config_));
  table.directory = arena.make_array<std::uint16_t>(
      "directory", static_cast<std::size_t>(CoverageTable::directory_size(config_.map_cells)));
  RayLooksMemory looks;
  looks.columns = arena.make_array<rt::SinCos>("columns", config_.sensor.columns);
  looks.rows = arena.make_array<rt::SinCos>("rows", config_.sensor.rows);
  looks.across =
      arena.make_array<rt::Vector3>("across", std::size_t{config_.positions} * config_.sensor.columns);
  heap_ = RayHeap(arena.make_array<std::uint64_t>("heap", all));
  looks.fresh = arena.make_array<float>("fresh worths", all);
  looks.traced = arena.make_array<std::uint32_t>("traced", RayBits::words(all));
  const auto held = arena.make_array<std::uint32_t>("held", RayBits::words(all));
  best_rays_ = arena.make_array<std::uint16_t>("best plan", plan);
  selection_.lay_out(arena.make_array<std::uint16_t>("candidate plan", plan));
  looks.path = arena.make_array<std::uint32_t>("paths of directions", all);
  looks.words = arena.make_array<std::uint32_t>("paths", path_words(config_));
  looks_.lay_out(looks, cells_of_a_ray(config_));
  cover_ = RayCover(table, held, arena.make_array<RayModel::Passed>("one ray", cells_of_a_ray(config_)));
}

Status RayScheduler::begin(const mapping::OccupancyView& map, std::span<const mapping::SensorPose> poses,
                           std::uint32_t passed) {
  if (!usable_ || map.cells == nullptr || map.cell_count() > config_.map_cells || map.cell_count() == 0 ||
      !(map.voxel_size_m >= config_.voxel_size_m) || poses.empty() || poses.size() > config_.positions)
    return Status::out_of_range;
  for (const mapping::SensorPose& pose : poses) {
    if (!rt::is_finite(pose.p_world_sensor_m) || !rt::is_finite(pose.q_world_sensor))
      return Status::not_finite;
  }
  const std::uint32_t previous = plan_.positions;
  plan_ = {};
  plan_.positions = static_cast<std::uint32_t>(poses.size());
  plan_.rays = sizes_.per_position;
  plan_.best_bound = kUnknownBound;
  looks_.begin(map, poses);
  make_seed(passed, previous);
  (void)cover_.clear_some(UINT32_MAX);
  heap_.note_none();
  use_ = {};
  credit_ = 0;
  best_ = {0.0, kUnknownBound, false};
  work_ = {};
  all_traced_ = false;
  cursor_ = 0;
  for (double& bound : seed_bound_) bound = 0.0;
  coarse_ = 0;
  phase_ = Phase::seed_bound;
  stage_ = RayStage::seed;
  if (sizes_.per_position == 0) {
    phase_ = Phase::done;
    plan_.exact_worth = true;
    plan_.best_bound = 0.0;
    plan_.certificate = 1.0;
    plan_.done = true;
  }
  return Status::ok;
}

// What the previous task planned for a place is the seed for that place; beyond its end, the pattern.
void RayScheduler::make_seed(std::uint32_t passed, std::uint32_t previous_positions) {
  for (std::uint32_t p = 0; p < plan_.positions; ++p) {
    const std::span<std::uint16_t> to =
        best_rays_.subspan(std::size_t{p} * sizes_.per_position, sizes_.per_position);
    if (passed < previous_positions && p < previous_positions - passed) {
      const auto from =
          best_rays_.subspan(std::size_t{p + passed} * sizes_.per_position, sizes_.per_position);
      std::copy(from.begin(), from.end(), to.begin());
      continue;
    }
    for (std::uint32_t i = 0; i < sizes_.per_position; ++i) to[i] = static_cast<std::uint16_t>(pattern(i));
  }
  selection_.begin(best_rays_);
  plan_.digest = rt::digest_bytes(best_rays_.data(), std::size_t{plan_.positions} * sizes_.per_position * 2);
}

// A permutation of the directions whose beginnings are spread over the field of view: steps of the golden
// section. The step has no factor in common with the number of directions.
std::uint32_t RayScheduler::pattern(std::uint32_t i) const {
  auto step = static_cast<std::uint32_t>(0.6180339887498949 * sizes_.all_rays);
  while (step > 1 && std::gcd(step, sizes_.all_rays) != 1) --step;
  return static_cast<std::uint32_t>(std::uint64_t{i} * (step > 0 ? step : 1u) % sizes_.all_rays);
}

// Neither sum nor difference wraps: all the units there are may be given twice, and a step that cost more
// than the dearest would overdraw by the difference, and not by 2^64.
std::uint64_t RayScheduler::step(std::uint64_t units) {
  credit_ += std::min(units, UINT64_MAX - credit_);
  std::uint64_t spent = 0;
  while (phase_ != Phase::done && credit_ >= largest_step_) {
    const std::uint64_t cost = advance();
    credit_ -= std::min(cost, credit_);
    spent += cost;
  }
  if (phase_ == Phase::done) credit_ = 0;
  if (spent > 0) note_parts();
  plan_.units += spent;
  plan_.done = phase_ == Phase::done;
  return spent;
}

// What the parts counted in this task.
void RayScheduler::note_parts() {
  plan_.traced = looks_.traced();
  plan_.evaluations = looks_.evaluations();
  plan_.table_used = use_.most_lines;
  plan_.table_full = use_.refused;
  plan_.heap_full = heap_.refused();
}

std::span<const std::uint16_t> RayScheduler::rays(std::uint32_t position) const {
  if (position >= plan_.positions) return {};
  return best_rays_.subspan(std::size_t{position} * sizes_.per_position, sizes_.per_position);
}

// The candidate becomes the plan.
void RayScheduler::adopt() {
  const std::span<const std::uint16_t> rays = selection_.rays();
  std::copy(rays.begin(), rays.end(), best_rays_.begin());
  best_ = work_;
  plan_.stage = stage_;
  plan_.planned = std::max(plan_.planned, last_);
  plan_.worth = best_.lower;
  plan_.exact_worth = best_.is_exact();
  plan_.digest = rt::digest_bytes(best_rays_.data(), std::size_t{plan_.positions} * sizes_.per_position * 2);
  if (std::isfinite(plan_.best_bound)) finish_certificate();
}

// The plan alone: begin() makes everything else anew.
void RayScheduler::archive(rt::Archive& archive) {
  archive.expect(usable_ ? sizes_.all_rays : 0, "the scheduler has other directions");
  archive.expect(sizes_.per_position, "the scheduler plans another number of rays");
  archive.expect(config_.positions, "the scheduler plans another number of positions");
  RayPlan plan = plan_;
  archive.value(plan);
  for (std::uint16_t& ray : best_rays_) {
    archive.value(ray);
    if (ray < sizes_.all_rays) continue;
    archive.fail(Status::malformed, "a direction that the sensor does not have");
    ray = 0;
  }
  if (!archive.is_reading()) return;
  if (plan.positions > config_.positions || static_cast<std::uint32_t>(plan.stage) > 3) {
    archive.fail(Status::malformed, "a plan that the scheduler cannot have made");
    plan = {};
  }
  plan_ = plan;
  phase_ = Phase::done;
  credit_ = 0;
}

}  // namespace sortie::planner
