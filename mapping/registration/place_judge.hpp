// SPDX-License-Identifier: BSD-3-Clause
// Which of a few places on a map a scan was taken at; or that the scan does not say.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/registration/relocate_config.hpp"
#include "mapping/registration/scan_registration.hpp"
#include "mapping/registration/unit_credit.hpp"

namespace sortie::mapping {

/// What became of a search.
enum class RelocateVerdict : std::uint8_t {
  none = 0,      ///< nothing was searched yet
  searching,     ///< it goes on
  placed,        ///< one place explains the scan, and no other one does
  ambiguous,     ///< another place does about as well, or the place is not held in some direction
  nothing_fits,  ///< no place explains the scan
  few_returns,   ///< too few returns to tell anything
};
const char* to_string(RelocateVerdict verdict);

/// What a scan says of the best place, whether or not it is believed.
struct JudgedPlace {
  RelocateVerdict verdict{RelocateVerdict::none};
  RigidPose T_map_sensor;
  double covariance[36]{};  ///< position in map, rotation in sensor, row-major, m^2 and rad^2; where placed
  double share{};           ///< of the returns where the map has seen something: that lie on a surface
  double seen{};            ///< of the returns: where the map has seen something
  double crossed{};         ///< of the rays: through surfaces
  double lead{};  ///< of the scan: what speaks for it and against the strongest other place, and the reverse
  double denied{};       ///< of the scan: what speaks against that place
  double rival{};        ///< of the scan: what speaks for it
  double unexplained{};  ///< of the scan: not explained here, where the map has seen something, or crossed
  bool sure{};           ///< so little of it that no place elsewhere that looks alike would leave as little
  SORTIE_FIELDS(verdict, T_map_sensor, covariance, share, seen, crossed, lead, denied, rival, unexplained,
                sure)
};

/// Matches places with a scan, again the best of them from where they ended, and judges. Where the places
/// are from is the caller's. All memory is taken from the arena; no heap; no step costs more than four
/// matches of the whole sample; begin() sorts the sample twice. The same bits whatever the budgets and the
/// order of a scan's returns; arithmetic of rt/math alone. A step of a match costs kMatchUnits units a
/// return, looking along its ray kRayUnits; a unit is the search's. Memory: 220 kB with 3,072 returns.
class PlaceJudge {
 public:
  static constexpr std::uint32_t kMatchUnits = 8;
  static constexpr std::uint32_t kRayUnits = 48;

  /// `registration` has the map, and outlives it.
  PlaceJudge(const RelocateConfig& config, ScanRegistration& registration, rt::Arena& arena);

  /// Begins with a sample and no place. `q_level_sensor`: the scan's attitude; its turn about the upright
  /// means nothing. False: too few returns to tell anything; there is nothing to run.
  [[nodiscard]] bool begin(std::span<const SamplePoint> sample, const rt::Quaternion& q_level_sensor);
  /// Adds a place, before the first run(). Its tilt is the attitude's. What is more than
  /// PlaceSearchConfig::kMostCandidates is left out. Places are compared with each other: of one that is
  /// alone `placed` says that the scan fits there, and not that it fits nowhere else.
  void add(const RigidPose& T_map_sensor);
  /// Works on for at most `units`, and takes what it used off. True: `judged` is the answer. It uses the
  /// registration's sample.
  bool run(std::uint64_t& units, JudgedPlace& judged);
  /// Of work since begin().
  std::uint64_t units() const { return units_; }
  std::span<const SamplePoint> sample() const { return sample_.first(size_); }
  const rt::Quaternion& q_level_sensor() const { return q_level_sensor_; }
  void archive(rt::Archive& archive);

 private:
  /// A place, matched.
  struct Place {
    RigidPose pose;
    std::uint32_t slot{};       ///< of its bits
    std::uint32_t explained{};  ///< returns of the sample that lie on a surface
    std::uint32_t seen{};
    std::uint32_t through{};  ///< rays, of one return in two
    bool weak{};              ///< not held in some direction
    SORTIE_FIELDS(pose, slot, explained, seen, through, weak)
  };
  static constexpr std::size_t kWeighed = 2;
  /// Of a return: the part that it has of its surface, and of its thing.
  struct Weights {
    std::uint32_t of[kWeighed];
  };
  /// What speaks for one place and against another one, of all that a scan has.
  struct Evidence {
    double speaks_for{}, against{};
  };
  /// Counted by returns, by surfaces and by things.
  struct Compared {
    Evidence by[kWeighed + 1];
  };
  enum class Step : std::uint8_t { idle, tries, retries, verdict };
  static constexpr double kFreeTilt = 0.0015;  ///< rad, against a scan's returns, which err together
  static constexpr std::uint32_t kTried = 32;  ///< of the places, again from where they ended

  /// 10 m and 10 rad about the upright: nothing is known but the attitude, to `tilt_rad`.
  PosePrior prior_at(const RigidPose& pose, double tilt_rad) const;
  bool pay(std::uint64_t cost, std::uint64_t& units);
  bool run_tries(std::uint64_t& units);
  bool run_retries(std::uint64_t& units);
  bool pay_match(std::size_t returns, std::uint64_t& units);
  bool pay_looks(std::size_t matched, std::uint64_t& units);
  void match_place(Place& place, std::size_t returns);
  void keep(const Match& match, Place& place);
  Match look_about(Place& place, const PosePrior& prior);
  void explain(Place& place);
  void look_along_rays(Place& place);
  void weigh_returns();
  void order();
  RelocateVerdict judge(JudgedPlace& judged);
  bool leads(const Place& best, JudgedPlace& judged) const;
  void unexplained(const Place& place, double (&out)[kWeighed + 1]) const;
  Compared compare(const Place& here, const Place& there) const;
  std::size_t words() const { return bits_.size() / (3 * PlaceSearchConfig::kMostCandidates); }
  /// Returns that a place explains, those whose place the map knows there, and those whose rays went through
  /// a surface.
  std::uint64_t* explained_bits(const Place& place) const { return &bits_[3 * place.slot * words()]; }
  std::uint64_t* known_bits(const Place& place) const { return explained_bits(place) + words(); }
  std::uint64_t* crossed_bits(const Place& place) const { return known_bits(place) + words(); }
  /// That are looked along.
  double rays() const { return 0.5 * (size_ + size_ % 2); }

  RelocateConfig config_;
  ScanRegistration* registration_;
  std::span<SamplePoint> sample_;   ///< of the scan
  std::span<std::uint64_t> bits_;   ///< of each place
  std::span<std::uint64_t> cubes_;  ///< of the sample's returns, sorted: scratch
  std::span<Weights> weights_;      ///< of each return
  double weight_[kWeighed]{};       ///< of all
  std::uint32_t size_{};            ///< of the sample
  rt::Quaternion q_level_sensor_;
  Step step_{Step::idle};
  std::uint32_t at_{};     ///< place that is next
  std::uint32_t count_{};  ///< of places
  Place places_[PlaceSearchConfig::kMostCandidates];
  UnitCredit credit_;
  std::uint64_t units_{};
};

}  // namespace sortie::mapping
