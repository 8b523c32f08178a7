// SPDX-License-Identifier: BSD-3-Clause
// From correspondences to the few poses of the local map on the known one that sets of them speak for.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/recognition/consistency_sweep.hpp"
#include "mapping/recognition/consistent_set.hpp"
#include "mapping/recognition/level_fit.hpp"
#include "rt/keys.hpp"

namespace sortie::mapping {

/// What a set has to be.
struct SetConfig {
  double eps_m{0.4};       ///< distances of segments and of their targets differ by less
  double tilt_deg{0.5};    ///< of the local map, and of the known one
  bool gravity{true};      ///< false: distances in space alone, as published
  std::uint32_t least{6};  ///< segments of a set
  double spread_m{1.0};    ///< standard deviation of their places where it is least
  double of_rival{0.6};    ///< most segments of another pose's set, of the best one's

  SORTIE_KEYS(c, key) {
    key("eps_m", c.eps_m,
        {0.02, 2.5, "m", "most that distances of two segments and of their targets may differ"});
    key("tilt_deg", c.tilt_deg, {0, 10, "deg", "that the map may be off the upright"});
    key("gravity", c.gravity, {"compare horizontal distances and heights apart, false: distances in space"});
    key("least", c.least, {3, 64, "segments", "in a consistent set"});
    key("spread_m", c.spread_m,
        {0, 50, "m", "least spread of the set's places, across their longest line too"});
    key("of_rival", c.of_rival, {0, 1, "", "most segments of another place's set, of the best one's"});
  }
};

/// What a search for sets came to.
enum class SetVerdict : std::uint8_t {
  none,          ///< nothing was searched, or the search goes on
  found,         ///< one pose, and no other one comes near it
  few,           ///< fewer correspondences than a set needs
  inconsistent,  ///< no set of `least`
  bent,          ///< sets, but no pose lays one of them: a mirror image, or places that agree by chance
  narrow,        ///< all of the set stand in a row, or in one place
  ambiguous,     ///< another pose has a set of nearly as many
  undecided      ///< the units were spent before that was known
};

/// A pose, and the pairs that speak for it.
struct SetHypothesis {
  static constexpr std::uint32_t kMostPairs = 128;

  LevelFit fit;
  std::uint32_t count{};
  std::uint16_t pairs[kMostPairs]{};  ///< numbers in the list that was searched, by segment
  SORTIE_FIELDS(fit, count, pairs)
};

/// Searches in steps. All pairs are swept with half of eps, eps and twice that: the graphs are nested, and a
/// set of one is the least that the next one's must exceed (after Z. Qiao et al., G3Reg,
/// 2024). Of what lies in no core of the widest graph nothing more is asked. The largest set gives a pose,
/// which is fitted to it, without those that it lays worst where it does not lay all, then twice more to
/// every segment's nearest correspondence within eps. Then the same without what that pose explains, for sets
/// that come near the first one's size, until there is none; where no pose lays any of kMostBent sets, no
/// more are asked for. Where that leaves one place, sets of three segments and more than 0.3 of its own are
/// sought, too: they do not make it ambiguous, but whoever holds a scan against it has to compare it with
/// them. refuse() goes on without the first. The same list gives the same answer in whatever order it comes,
/// and a budget only says when. Memory: that of ConsistencySweep and ConsistentSet. No heap.
class SetHypotheses {
 public:
  static constexpr std::uint32_t kMost = 8;
  static constexpr std::uint32_t kMostRivals = 3;  ///< poses, after which a place is ambiguous enough
  /// Sets that no pose lays, where there is none that one does.
  static constexpr std::uint32_t kMostBent = 6;

  /// Room for `pairs` correspondences.
  SetHypotheses(std::uint32_t pairs, rt::Arena& arena);

  /// Begins; nothing of `pairs` is read later. Errors as of ConsistencySweep::begin().
  [[nodiscard]] Status begin(const SetConfig& config, std::span<const SweptPair> pairs);
  /// Goes on for at most `units` and a step, takes what it used off. True: the verdict is there.
  bool run(std::uint64_t& units);
  /// No more units: what is not known by now is `undecided`; a place that is found has fewer to compare with.
  void stop();
  /// The best pose is not the place, somebody who looked says: the next run() searches on without what speaks
  /// for it. At most kMost - 1 times; then there is none any more, and the verdict is `inconsistent`.
  void refuse();

  SetVerdict verdict() const { return verdict_; }
  /// Poses, the largest set first; those that are rigid alone, whatever their spread. Behind a place that is
  /// `found` those that it has to be compared with.
  std::span<const SetHypothesis> found() const { return {found_, found_count_}; }
  /// Each of these sets, but for what is compared with, is the largest that there is, and the search for them
  /// was not stopped.
  bool proved() const { return proved_; }

 private:
  enum class Step : std::uint8_t { done, sweep, peel, next, search };

  std::uint32_t least() const;
  bool is_full() const { return found_count_ == kMost; }
  bool has_enough() const;
  void keep_core(std::uint32_t size);
  void begin_round();
  void take_set();
  void fit_round();
  bool lay(SetHypothesis& hypothesis) const;
  void refine(SetHypothesis& hypothesis) const;
  void remove(const SetHypothesis& hypothesis);
  void begin_others();
  void judge();
  void conclude();

  SetConfig config_;
  ConsistencySweep sweep_;
  ConsistentSet set_;
  CoreOrder core_;
  Step step_{Step::done};
  std::uint32_t gate_{};     ///< of a round
  std::uint32_t refused_{};  ///< poses
  std::uint32_t bent_{};     ///< sets that no pose lays
  bool others_{};            ///< the verdict is known, what it is compared with is not
  bool proved_{};
  SetVerdict verdict_{SetVerdict::none};
  std::span<BitGraph::Word> in_core_;
  std::span<BitGraph::Word> members_;  ///< of the core, what no pose explains yet
  std::uint16_t round_set_[SetHypothesis::kMostPairs]{};
  std::uint32_t round_count_{};
  SetHypothesis found_[kMost];
  std::uint32_t found_count_{};
};

}  // namespace sortie::mapping
