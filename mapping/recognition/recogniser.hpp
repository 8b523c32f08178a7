// SPDX-License-Identifier: BSD-3-Clause
// Where the segments of a local map stand on a known one, or that they do not say.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/recognition/candidates.hpp"
#include "mapping/recognition/set_hypotheses.hpp"
#include "rt/archive.hpp"

namespace sortie::mapping {

/// Settings of a recogniser.
struct RecogniserConfig {
  static constexpr std::uint32_t kMostSegments = 256;

  std::uint32_t segments{64};            ///< of the local map that take part, at most kMostSegments
  std::uint32_t pairs{1024};             ///< correspondences, at most ConsistencySweep::kMostVertices
  std::uint32_t most_units{20'000'000};  ///< of one search; what is not known then is undecided
  CandidateConfig candidates;
  SetConfig set;

  SORTIE_KEYS(c, key) {
    key("limits.speaking", c.segments, {3, kMostSegments, "segments", "of the local map that take part"});
    key("limits.correspondences", c.pairs,
        {16, 8192, "pairs", "of segments and targets; 150 B each and half a byte for each other one"});
    key("most_units", c.most_units,
        {10'000, 1e9, "units", "of one search, what is not known then is undecided"});
    CandidateConfig::keys(c.candidates, key);
    SetConfig::keys(c.set, key);
  }
};

/// A segment of the local map that may be recognised.
struct SpeakingSegment {
  std::uint32_t id{};
  std::uint32_t version{};
  PlaceCm place;  ///< in the local map's frame
  SegmentDescriptor descriptor;
  SORTIE_FIELDS(id, version, place, descriptor)
};

/// Searches by how they ended. begun = all others and the one that goes on.
struct RecogniserCounts {
  std::uint64_t begun{};
  std::uint64_t found{};
  std::uint64_t few{};           ///< too few segments, or too few targets like them
  std::uint64_t inconsistent{};  ///< no set of correspondences that agree
  std::uint64_t bent{};          ///< sets that no pose lays
  std::uint64_t narrow{};        ///< a set in a row
  std::uint64_t ambiguous{};     ///< another place has nearly as many
  std::uint64_t undecided{};     ///< the units were spent
  SORTIE_FIELDS(begun, found, few, inconsistent, bent, narrow, ambiguous, undecided)
};

/// Asks the store for each segment's candidates and searches for sets of them that agree, a budget at a time.
/// Segments and places are copied as they are asked for; the same segments in any order, the same store and
/// any budgets give the same answer. Memory: that of SetHypotheses, 44 bytes a segment and 28 a
/// correspondence. No heap.
class Recogniser {
 public:
  Recogniser(const RecogniserConfig& config, rt::Arena& arena);

  /// Begins with segments of the local map, each id once: of more than there is room for, those with the
  /// lowest ids. `where` says which targets are asked for; its descriptor is not read.
  void begin(std::span<const SpeakingSegment> segments, const CandidateQuery& where);
  /// Goes on for at most `units` and a step, takes what it used off. True: there is an answer. `store` is the
  /// same until then, as far as its targets are asked for.
  bool run(const TargetStore& store, std::uint64_t& units);
  bool is_searching() const { return step_ != Step::done; }
  /// The best pose is not the place, somebody who looked says: searches on without it, as one that begins.
  /// Where there is none nothing changes. See SetHypotheses::refuse().
  void refuse();

  SetVerdict verdict() const { return verdict_; }
  /// Poses of the local map in the store's, the largest set first.
  std::span<const SetHypothesis> found() const { return sets_.found(); }
  /// Each of these sets is the largest that there is.
  bool proved() const { return sets_.proved(); }
  /// What a hypothesis' pairs are numbers in.
  std::span<const SweptPair> pairs() const { return pairs_.first(pair_count_); }
  std::span<const SpeakingSegment> segments() const { return segments_.first(segment_count_); }
  const RecogniserCounts& counts() const { return counts_; }
  const RecogniserConfig& config() const { return config_; }

  /// Between two calls. What goes on is kept as what it began with and what it has spent: it is begun anew
  /// and spends that again, which needs the store it was asked with.
  void archive(rt::Archive& archive, const TargetStore& store);

 private:
  enum class Step : std::uint8_t { done, ask, search };

  void begin_search();
  bool work(const TargetStore& store, std::uint64_t& units);
  bool ask(const TargetStore& store, std::uint64_t& units);
  void conclude(SetVerdict verdict);
  std::uint64_t& counter(SetVerdict verdict);

  RecogniserConfig config_;
  CandidateSearch candidates_;
  SetHypotheses sets_;
  std::span<SpeakingSegment> segments_;
  std::span<SweptPair> pairs_;
  std::uint32_t segment_count_{};
  std::uint32_t pair_count_{};
  std::uint32_t at_{};  ///< segment that is asked for
  bool asking_{};
  bool ran_{};  ///< since it began, or a pose was refused
  CandidateQuery where_;
  std::uint64_t spent_{};
  std::uint32_t refused_{};
  Step step_{Step::done};
  SetVerdict verdict_{SetVerdict::none};
  RecogniserCounts counts_;
};

}  // namespace sortie::mapping
