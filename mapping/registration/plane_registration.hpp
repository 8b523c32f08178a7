// SPDX-License-Identifier: BSD-3-Clause
// Where one map of planes lies in another: the air's in the ground's, today's in last week's. Says where,
// how sure, in which directions not at all, and refuses what it cannot tell from another place.
#pragma once

#include <cstdint>

#include "mapping/registration/plane_consensus.hpp"
#include "mapping/registration/plane_turns.hpp"
#include "mapping/registration/unit_credit.hpp"
#include "rt/describe.hpp"
#include "rt/status.hpp"

namespace sortie::mapping {

/// What became of a registration.
enum class PlaneVerdict : std::uint8_t {
  none,           ///< not begun
  working,        ///< units ran out; run() goes on
  placed,         ///< every direction is observed
  placed_partly,  ///< some directions keep the estimate's values: see PlaneFit
  refused,        ///< no place is good enough: see PlaneRefusal
  ambiguous,      ///< there are two places, neither much likelier than the other
};

/// Why.
enum class PlaneRefusal : std::uint8_t {
  none,
  no_planes,        ///< one of the sets is empty
  few_matches,      ///< fewer than least_matches
  little_share,     ///< too few of the planes that both should see
  little_evidence,  ///< chance may have done it
  unobserved,       ///< a direction that neither planes nor estimate know, or one pair of unlike areas alone
  runner_up,        ///< another place is nearly as likely
  mirrored,         ///< a mirror image would fit better: another wing, another building
};

/// The names as they are shown.
const char* to_string(PlaneVerdict verdict);
const char* to_string(PlaneRefusal refusal);

/// What a registration found. Good to use where placed() is true.
struct PlaneRegistrationResult {
  PlaneVerdict verdict{PlaneVerdict::none};
  PlaneRefusal refusal{PlaneRefusal::none};
  PlaneFit fit;                 ///< of the best place, also where it is refused
  std::uint32_t matched{};      ///< planes of the target with a partner
  double share{};               ///< PlaneConsensus::share()
  double evidence{};            ///< ln of how much likelier than chance, all places looked at
  double runner_up_evidence{};  ///< of the place in another basin that comes nearest to it; 0: none
  double rivalry{};  ///< its evidence over the best place's, without the pairs that both have in common
  PlanePose T_runner_up;
  std::uint32_t turns{};       ///< rotations tried
  std::uint32_t hypotheses{};  ///< places looked at
  std::uint32_t fits{};        ///< of them fitted
  std::uint32_t dropped{};     ///< pairs of planes that there was no room for, and hypotheses beyond the most
  std::uint64_t units{};       ///< of work done
  SORTIE_FIELDS(verdict, refusal, fit, matched, share, evidence, runner_up_evidence, rivalry, mirror_rivalry,
                T_runner_up, turns, hypotheses, fits, dropped, units)

  double mirror_rivalry{};  ///< as rivalry, of the best place of a mirror image; 0: none
  bool placed() const { return verdict == PlaneVerdict::placed || verdict == PlaneVerdict::placed_partly; }
};

/// Rotations from normals; under each (and under each scale, where that is asked for) shifts that parallel
/// planes agree on; at each combination of shifts the consensus of overlapping planes; of the best ones a
/// weighted fit, a second look with tight gates, and a fit again. Source and target in any order of planes
/// give the same bits. 2.3 MB, nothing on the heap, stack below 64 kB. Unit of work: one look at a pair of
/// planes, about 5 ns.
class PlaneRegistration {
 public:
  explicit PlaneRegistration(const PlaneRegistrationConfig& config);

  /// Starts anew. `not_finite` or `out_of_range` where a plane or the estimate is not good (`bad_plane()`
  /// says which): nothing is done and the verdict is `none`. Cost: sorting both sets.
  Status begin(const PlaneSet& source, const PlaneSet& target, const PlaneEstimate& estimate);

  /// Works on for at most `units`, and takes what it used off; what is too little for the next step is kept
  /// for it. True when there is nothing left to do.
  bool run(std::uint64_t& units);

  const PlaneRegistrationResult& result() const { return result_; }
  /// Pairs of the best place, as indices into the sets that were given.
  const PlanePairs& pairs() const { return best_pairs_; }
  /// Places that were fitted, apart from each other, and one of them: most evidence first, whatever the
  /// verdict.
  std::uint32_t places() const { return fitted_count_; }
  const PlanePose& place(std::uint32_t k) const { return fitted_[order_[k]].fit.T_target_source; }
  /// The first plane that begin() refused; the target's are counted from 1000.
  std::uint32_t bad_plane() const { return bad_plane_; }

 private:
  enum class Stage : std::uint8_t { done, turns, pair, scale, look, fit, mirror, judge };
  /// A place worth fitting.
  struct Place {
    rt::Vector3 t_m;
    double gain{};            ///< less the cost of planes that must be missed
    double of_axis[3]{};      ///< ShiftLook::of_axis
    std::uint32_t peak[3]{};  ///< of each axis
    std::uint32_t matched{};
  };
  static constexpr std::uint32_t kMostPlaces = 4;  ///< of one rotation and scale

  std::uint64_t next_cost() const;
  void step();
  void begin_turn();
  void begin_scale();
  void look();
  void look_at_place(double least);
  std::uint32_t hopeless_axes(double least);
  void fit_next();
  /// A place that was fitted.
  struct Fitted {
    PlaneFit fit;
    PlaneConsensus consensus;
    double evidence{};
    PlanePairs pairs;
    double gain[kMostPlanes]{};  ///< of each pair
    std::uint32_t search{};      ///< number of the rotation and scale that it was found under
    std::uint32_t peak[3]{};     ///< of each axis there
    double of_axis[3]{};         ///< gain of its pairs by the axis of their target
  };
  static constexpr std::uint32_t kMostFitted = 12;

  const PlaneSide& side() const { return in_mirror_ ? image_ : source_; }
  void begin_mirror();
  void keep();
  void keep_place(const Place& place);
  double harmless() const;
  bool harmless(const Place& place) const;
  double rivalry(const Fitted& best, const Fitted& other, double least_margin) const;
  double alone_ratio(const Fitted& best) const;
  void finish();
  double least_gain() const;

  PlaneRegistrationConfig config_;
  PlaneEstimate estimate_;
  Stage stage_{Stage::done};
  UnitCredit credit_;
  std::uint32_t bad_plane_{};
  std::uint32_t turn_{};
  std::uint32_t scale_{};
  std::uint32_t at_[3]{};  ///< the combination of peaks that is next
  double best_look_{};     ///< most gain that any place had
  double miss_cost_{};     ///< -ln(1 - share_matched)
  double log_places_{};    ///< ln of the places that could have been
  PlaneTurns turns_;
  rt::FixedVector<double, 8> scales_;
  rt::FixedVector<Place, kMostPlaces> places_;
  std::uint32_t place_{};
  PlaneSide source_;
  PlaneSide target_;
  PlaneCandidates candidates_;
  NearCandidates near_;
  Fitted fresh_;
  Fitted fitted_[kMostFitted];         ///< places apart from each other
  std::uint8_t order_[kMostFitted]{};  ///< of them, most evidence first
  std::uint32_t fitted_count_{};
  std::uint32_t search_{};  ///< rotations and scales begun
  std::uint32_t mirror_{};  ///< mirror images begun
  bool in_mirror_{};
  bool best_scale_{};  ///< rotations are gone through with the best place's scale
  rt::FixedVector<rt::Vector3, 2> mirrors_;
  double mirror_rivalry_{};
  PlaneSide image_;
  PlanePairs best_pairs_;
  PlaneRegistrationResult result_;
};

}  // namespace sortie::mapping
