// SPDX-License-Identifier: BSD-3-Clause
// Where on a kept map a robot is that knows nothing of it, from one scan; or that the scan does not say.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/registration/place_search.hpp"
#include "mapping/registration/scan_registration.hpp"

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

/// Searches by verdict. begun = all others and the one that goes on.
struct RelocateCounts {
  std::uint64_t begun{};
  std::uint64_t placed{};
  std::uint64_t ambiguous{};
  std::uint64_t nothing_fits{};
  std::uint64_t few_returns{};
  SORTIE_FIELDS(begun, placed, ambiguous, nothing_fits, few_returns)
};

/// What a search found. The numbers are about the best place, whether or not it was believed.
struct Relocated {
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
  std::uint32_t hits{};  ///< in the search, of `searched` returns
  std::uint32_t searched{};
  std::uint32_t candidates{};
  std::uint64_t units{};  ///< of work
  RelocateCounts counts;
  SORTIE_FIELDS(verdict, T_map_sensor, covariance, share, seen, crossed, lead, denied, rival, unexplained,
                sure, hits, searched, candidates, units, counts)
};

/// Searches, matches what it found, and judges. All memory is taken from the arena; no heap; no step costs
/// more than four matches of the whole sample; begin() sorts the sample twice. The same bits whatever the
/// budgets and the order of a scan's returns; arithmetic of rt/math alone. A unit is one look at a return for
/// 64 poses; a step of a match costs kMatchUnits a return, looking along its ray kRayUnits. Memory beside the
/// map's bits and the search: 220 kB with 3,072 returns.
class Relocaliser {
 public:
  static constexpr std::uint32_t kMatchUnits = 8;
  static constexpr std::uint32_t kRayUnits = 48;

  /// `registration` has the map, and outlives it.
  Relocaliser(const RelocateConfig& config, const PlaceSearchConfig& search, const RegistrationMemory& memory,
              ScanRegistration& registration, rt::Arena& arena);

  /// Takes the registration's map as it is. Set-up only. False: there is none, or it has more blocks than
  /// PlaceSearchConfig::tops.
  [[nodiscard]] bool take_map() { return map_.build(registration_->layer(0)); }
  bool has_map() const { return !map_.empty(); }

  /// Begins with a sample. `q_level_sensor`: the scan's attitude; its turn about the upright means nothing.
  void begin(std::span<const SamplePoint> sample, const rt::Quaternion& q_level_sensor);
  bool is_searching() const { return result_.verdict == RelocateVerdict::searching; }
  /// Works on for at most `units`, and takes what it used off. True: there is an answer. It uses the
  /// registration's sample.
  bool run(std::uint64_t& units);
  const Relocated& result() const { return result_; }
  const PlaceSearch& search() const { return search_; }
  const PlaceMap& map() const { return map_; }
  /// The map is the same: it is built anew from the registration's, which is archived before.
  void archive(rt::Archive& archive);

 private:
  /// A place that the search found, matched.
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
  enum class Step : std::uint8_t { idle, search, tries, retries, verdict };
  static constexpr double kFreeTilt = 0.0015;  ///< rad, against a scan's returns, which err together
  static constexpr std::uint32_t kTried = 32;  ///< of the candidates, again from where they ended

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
  RelocateVerdict judge();
  bool leads(const Place& best);
  void unexplained(const Place& place, double (&out)[kWeighed + 1]) const;
  Compared compare(const Place& here, const Place& there) const;
  void conclude(RelocateVerdict verdict);
  std::size_t words() const { return bits_.size() / (3 * PlaceSearchConfig::kMostCandidates); }
  /// Returns that a place explains, those whose place the map knows there, and those whose rays went through
  /// a surface.
  std::uint64_t* explained_bits(const Place& place) const { return &bits_[3 * place.slot * words()]; }
  std::uint64_t* known_bits(const Place& place) const { return explained_bits(place) + words(); }
  std::uint64_t* crossed_bits(const Place& place) const { return known_bits(place) + words(); }
  /// That are looked along.
  double rays() const { return 0.5 * (size_ + size_ % 2); }
  std::span<const SamplePoint> sample() const { return sample_.first(size_); }

  RelocateConfig config_;
  ScanRegistration* registration_;
  PlaceMap map_;
  PlaceSearch search_;
  std::span<SamplePoint> sample_;   ///< of the scan that is searched with
  std::span<std::uint64_t> bits_;   ///< of each place
  std::span<std::uint64_t> cubes_;  ///< of the sample's returns, sorted: scratch
  std::span<Weights> weights_;      ///< of each return
  double weight_[kWeighed]{};       ///< of all
  std::uint32_t size_{};            ///< of the sample
  rt::Quaternion q_level_sensor_;
  Step step_{Step::idle};
  std::uint32_t at_{};     ///< candidate that is next
  std::uint32_t count_{};  ///< of candidates
  Place places_[PlaceSearchConfig::kMostCandidates];
  UnitCredit credit_;
  Relocated result_;
};

}  // namespace sortie::mapping
