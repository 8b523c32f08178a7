// SPDX-License-Identifier: BSD-3-Clause
// Depth camera: the instants of frames, their pixels, and which of them have a point.
#include "hil/depth_camera.hpp"

#include <bit>
#include <cmath>

#include "hil/requirement.hpp"

namespace sortie::hil {
namespace {

constexpr std::uint64_t kCameraFaults = 0x646366;
constexpr std::uint64_t kCameraNoise = 0x64636e;
constexpr std::uint64_t kCameraClumps = 0x646363;
constexpr std::uint64_t kCameraTexture = 0x646374;
constexpr double kTextureTile_m = 4.0;
constexpr double kNearestClump = 0.4;  // of the true range
constexpr double kFarthestClump = 0.9;
constexpr double kClumpScatter_m = 0.15;

const DepthCameraConfig& checked(const DepthCameraConfig& c) {
  const auto lies = [](double value, double low, double high) { return value >= low && value <= high; };
  require("camera", c.columns >= 2 && c.columns <= DepthCamera::kMaxColumns, "columns must lie in 2..320");
  require("camera", c.rows >= 2 && c.rows <= DepthCamera::kMaxRows, "rows must lie in 2..240");
  require("camera", c.rate_hz <= DepthCamera::kMaxRate_hz, "rate_hz must lie in 0..30");
  require("camera", lies(c.width_rad, 0.05, 2.7), "width_rad must lie in 0.05..2.7");
  require("camera", lies(c.height_rad, 0.05, 2.7), "height_rad must lie in 0.05..2.7");
  require("camera", lies(c.texture, 0.0, 1.0), "texture must lie in 0..1");
  require("camera", lies(c.most_gap_m, 0.001, 1000.0), "most_gap_m must lie in 0.001..1000");
  require("camera", lies(c.clumps, 0.0, 1.0), "clumps must lie in 0..1");
  return c;
}

std::uint64_t stirred(std::uint64_t hash, std::uint64_t value) {
  hash ^= value;
  return splitmix64(hash);
}

std::uint64_t stirred(std::uint64_t hash, double value) {
  return stirred(hash, std::bit_cast<std::uint64_t>(value + 0.0));  // one zero, not two
}

std::uint64_t stirred_tile(std::uint64_t hash, double place_m) {
  return stirred(hash, rt::floor(place_m / kTextureTile_m));
}

// A normal along the solid's own axes.
Vec3 along_axes(const Solid& solid, const Vec3& n) {
  if (is_tilted(solid)) return {dot(solid.axes.x, n), dot(solid.axes.y, n), dot(solid.axes.z, n)};
  return {solid.cos_yaw * n.x + solid.sin_yaw * n.y, solid.cos_yaw * n.y - solid.sin_yaw * n.x, n.z};
}

// Which of six sides: the axis that a normal has most of, and its sign.
std::uint64_t side_of(const Vec3& n) {
  const double x = std::fabs(n.x), y = std::fabs(n.y), z = std::fabs(n.z);
  if (x >= y && x >= z) return n.x > 0.0 ? 1 : 0;
  if (y >= z) return n.y > 0.0 ? 3 : 2;
  return n.z > 0.0 ? 5 : 4;
}

std::uint64_t stirred_solid(std::uint64_t hash, const Solid& solid) {
  for (const double value :
       {solid.center_x_m, solid.center_y_m, solid.bottom_m, solid.top_m, solid.half_x_m, solid.half_y_m})
    hash = stirred(hash, value);
  return hash;
}

}  // namespace

DepthCamera::DepthCamera(const DepthCameraConfig& config, const FaultConfig& faults, std::uint64_t seed,
                         rt::Nanoseconds start_ns)
    : ScanSensor(checked(config), config.rows * config.columns, config.rate_hz != 0, "camera",
                 {faults, seed, kCameraFaults}, seed, start_ns),
      config_(config) {
  const double half_width = rt::tan(0.5 * config_.width_rad);
  const double half_height = rt::tan(0.5 * config_.height_rad);
  const double columns = config_.columns;
  const double rows = config_.rows;
  for (std::uint32_t c = 0; c < config_.columns; ++c)
    left_[c] = half_width * (1.0 - 2.0 * (c + 0.5) / columns);
  for (std::uint32_t r = 0; r < config_.rows; ++r) up_[r] = half_height * (1.0 - 2.0 * (r + 0.5) / rows);
  step_rad_ = std::fmax(2.0 * half_width / columns, 2.0 * half_height / rows);
}

Vec3 DepthCamera::direction(std::uint32_t column, std::uint32_t row) const {
  const double y = left_[column];
  const double z = up_[row];
  const double scale = 1.0 / std::sqrt(1.0 + y * y + z * z);
  return {scale, scale * y, scale * z};
}

void DepthCamera::advance(const RayCaster& caster, const SensorStep& step, drivers::ScanSink& sink) {
  if (config_.rate_hz == 0) return;
  const auto rate = static_cast<rt::Nanoseconds>(config_.rate_hz);
  for (;;) {
    // From the start: no rounding adds up for rates that do not divide a second.
    const auto number = static_cast<rt::Nanoseconds>(frame_ + 1);
    const rt::Nanoseconds at = start_ns_ + number * rt::kNanosecondsPerSecond / rate;
    if (at > step.after.stamp_ns) return;
    if (at > step.before.stamp_ns) take_frame(caster, step, at, sink);
    ++frame_;
  }
}

void DepthCamera::take_frame(const RayCaster& caster, const SensorStep& step, rt::Nanoseconds at,
                             drivers::ScanSink& sink) {
  const Fault fault = faults_.next(at - start_ns_);
  writer_.begin(sink, fault.drop);
  if (!writer_.open()) return;
  noise_.begin(seed_, kCameraNoise + (frame_ << 24u));
  begin_clumps();
  RayCaster::Aim from;
  const bool placed = aim(caster, step, at, from);
  for (std::uint32_t r = 0; r < config_.rows; ++r) {
    if (r == 0 || (r + shift_rows_) % kPatch == 0) draw_patches();
    for (std::uint32_t c = 0; c < config_.columns; ++c) {
      writer_.count_ray();
      if (placed)
        take_pixel(caster, from, c, r);
      else
        static_cast<void>(noise_.fire_nowhere());
    }
  }
  writer_.end(sink, at + fault.stamp_offset_ns + noise_.stamp_error_ns());
}

void DepthCamera::take_pixel(const RayCaster& caster, const RayCaster::Aim& aim, std::uint32_t column,
                             std::uint32_t row) {
  const Vec3 ray = direction(column, row);
  RangeHit hit;
  RangeReading reading = noise_.fire(caster, aim, ray, &hit);
  const bool clump = misplaced(column, reading);
  if (reading.fate != RayFate::returned) return;
  const Vec3 point_m = aim.p_world_sensor_m + hit.range_m * rotate(aim.q_world_sensor, ray);
  if (hit.range_m * step_rad_ > config_.most_gap_m * hit.cos_incidence) {
    ++pixels_.sparse;
  } else if (!textured(caster, hit, point_m)) {
    ++pixels_.bare;
  } else {
    if (clump) ++pixels_.clumped;
    writer_.add(reading, ray, 0);
  }
}

void DepthCamera::begin_clumps() {
  clumps_ = Random(seed_, kCameraClumps + (frame_ << 24u));
  shift_columns_ = static_cast<std::uint32_t>(clumps_.bits() % kPatch);
  shift_rows_ = static_cast<std::uint32_t>(clumps_.bits() % kPatch);
}

void DepthCamera::draw_patches() {
  const std::uint32_t patches = (config_.columns - 1 + shift_columns_) / kPatch + 1;
  for (std::uint32_t p = 0; p < patches; ++p) {
    const bool clump = clumps_.chance(config_.clumps);
    const double share = clumps_.uniform(kNearestClump, kFarthestClump);
    nearer_[p] = clump ? share : 0.0;
  }
}

// True where the pixel is one of a clump: the reading is then a mismatch. Draws never depend on what was met.
bool DepthCamera::misplaced(std::uint32_t column, RangeReading& reading) {
  const double share = nearer_[(column + shift_columns_) / kPatch];
  if (!(share > 0.0)) return false;
  const double scatter_m = kClumpScatter_m * clumps_.normal();
  if (reading.fate != RayFate::returned) return true;
  reading.range_m = share * reading.truth.range_m + scatter_m;
  if (reading.range_m < config_.min_range_m) reading.fate = RayFate::too_near;
  if (reading.range_m > config_.max_range_m) reading.fate = RayFate::too_far;
  return true;
}

bool DepthCamera::textured(const RayCaster& caster, const RangeHit& hit, const Vec3& point_m) const {
  std::uint64_t hash = stirred(kCameraTexture, seed_);
  Vec3 normal = hit.normal;
  if (hit.own()) {
    hash = stirred(hash, static_cast<double>(hit.solid));
  } else if (hit.solid >= 0 && caster.world() != nullptr) {
    const Solid& solid = caster.world()->solid(static_cast<std::size_t>(hit.solid));
    hash = stirred_solid(hash, solid);
    normal = along_axes(solid, normal);
  } else {
    hash = stirred_tile(stirred_tile(hash, point_m.x), point_m.y);
    if (hit.solid != Hit::kGround) hash = stirred_tile(hash, point_m.z);
  }
  const std::uint64_t drawn = stirred(hash, side_of(normal));
  return static_cast<double>(drawn >> 11u) * 0x1.0p-53 < config_.texture;
}

}  // namespace sortie::hil
