// SPDX-License-Identifier: BSD-3-Clause
// The flippers' postures, and the way from one to the other.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "rt/archive.hpp"
#include "rt/describe.hpp"
#include "rt/keys.hpp"
#include "rt/samples.hpp"
#include "rt/status.hpp"

namespace sortie::planner {

/// Four angles (rt::FlipperCommand).
struct FlipperPosture {
  double angle_rad[rt::kFlippers]{};
};

/// How fast, and what counts as there.
struct FlipperConfig {
  double rate_rad_s{0.8};      ///< of the flipper that has the longest way
  double tolerance_rad{0.05};  ///< a measured angle this near is there
  std::uint32_t initial{};     ///< posture at the start, where the flippers do not say where they are

  SORTIE_KEYS(c, key) {
    key("rate_deg_s", c.rate_rad_s, {0.1, 1000, rt::kDegSInRadS, "of the flipper that has the longest way"});
    key("tolerance_deg", c.tolerance_rad, {0, 90, rt::kDegInRad, "a measured angle this near is there"});
  }
};

/// What the flippers are asked to do, and how far they are.
struct FlipperOutput {
  rt::Nanoseconds stamp_ns{};
  double angle_rad[rt::kFlippers]{};
  std::int32_t posture{};                ///< that is gone to
  std::uint32_t flags{};                 ///< bits of FlipperFlags
  std::uint32_t refused{};               ///< postures asked for that do not exist
  double measured_rad[rt::kFlippers]{};  ///< of the newest measurement
  SORTIE_FIELDS(stamp_ns, angle_rad, posture, flags, refused, measured_rad)
};

/// Bits of FlipperOutput::flags.
enum FlipperFlags : std::uint32_t {
  kFlippersEnabled = 1u,   ///< the drives shall follow the angles
  kFlippersArrived = 2u,   ///< asked angles are the posture's
  kFlippersThere = 4u,     ///< and so are the measured ones, within the tolerance
  kFlippersMeasured = 8u,  ///< at least one measurement has come
  kFlippersHeld = 16u,     ///< told to stand still
};

/// Leads four angles from posture to posture at a limited rate; all of them arrive together. The first
/// measurement, if one comes before the first move, is where they start from. About 700 bytes, no heap.
class FlipperPostures {
 public:
  static constexpr std::uint32_t kMaxPostures = 16;

  /// `full` beyond 16, `empty` without any, out_of_range where config.initial is none of them or the rate is
  /// not above 0; not_finite. Set-up only.
  Status set_up(std::span<const FlipperPosture> postures, const FlipperConfig& config);

  /// Takes a measurement; what is not finite is ignored, and said so.
  Status observe(const rt::FlipperSample& sample);

  /// One step to `now_ns` toward posture number `wanted` (-1: as before), or none where `hold`. Status: ok;
  /// out_of_range for a posture that does not exist (the one before stays); time_repeated, time_backwards
  /// (nothing changes).
  Status update(std::int32_t wanted, bool hold, rt::Nanoseconds now_ns);

  const FlipperOutput& output() const { return output_; }
  std::int32_t size() const { return static_cast<std::int32_t>(size_); }

  void archive(rt::Archive& archive) {
    rt::Members(archive, *this, "flipper postures").fixed(config_, postures_, size_).state(output_, started_);
    if (archive.is_reading() && output_.posture != 0 && (output_.posture < 0 || output_.posture >= size())) {
      archive.fail(Status::malformed, "a posture that does not exist");
      output_.posture = 0;
    }
  }

 private:
  FlipperConfig config_;
  std::array<FlipperPosture, kMaxPostures> postures_{};
  std::uint32_t size_{};
  FlipperOutput output_;
  bool started_{};
};

}  // namespace sortie::planner
