// SPDX-License-Identifier: BSD-3-Clause
// Which targets a segment may be: those whose descriptors are nearest to its own.
#pragma once

#include <cstdint>

#include "mapping/recognition/target_store.hpp"
#include "mapping/registration/unit_credit.hpp"
#include "rt/describe.hpp"
#include "rt/keys.hpp"

namespace sortie::mapping {

/// Settings of a search for candidates.
struct CandidateConfig {
  static constexpr std::uint32_t kMost = 64;

  std::uint32_t most{16};        ///< candidates of a segment, 1 to kMost
  std::uint32_t size_steps{16};  ///< each of the three sizes agrees within so many steps; 16: a factor of two

  SORTIE_KEYS(c, key) {
    key("candidates", c.most, {1, kMost, "targets", "that a segment is compared with", rt::kKnob});
    key("size_steps", c.size_steps,
        {0, 255, "steps", "within which sizes agree, 16 to a factor of two", rt::kKnob});
  }
};

/// What is looked for, and where.
struct CandidateQuery {
  SegmentDescriptor descriptor;
  bool has_prior{};          ///< only targets near `prior`
  PlaceCm prior{};           ///< in the map
  std::int32_t radius_cm{};  ///< of a ball around it, its surface too; below 0 there is nothing in it
  bool leaves_out{};         ///< not what `robot` itself saw after or at `since_ms`
  std::uint8_t robot{};
  std::uint32_t since_ms{};  ///< stamps wrap: what is up to 24 days newer is after it
  SORTIE_FIELDS(descriptor, has_prior, prior, radius_cm, leaves_out, robot, since_ms)
};

/// A target, and how unlike the segment it is.
struct Candidate {
  TargetIndex target{kNoTarget};
  std::uint16_t distance{};   ///< of descriptors (L1)
  std::uint8_t uniqueness{};  ///< of the target
  bool operator==(const Candidate&) const = default;
};

/// Finds the candidates of one segment after another. The best come first: by distance, then the more unique
/// one, then the lower number; what is found is what a look at every target finds. A target that changes
/// while a search goes on is found as it was when it was looked at; its edition tells. Cost: 2 units a
/// record, 64 at a time. Memory: 0.6 kB. No heap.
class CandidateSearch {
 public:
  static constexpr std::uint32_t kUnitsADescriptor = 2;

  explicit CandidateSearch(const CandidateConfig& config);

  /// Begins a search; what was found before is gone.
  void begin(const CandidateQuery& query);
  /// Searches on for at most `units`, takes what it used off. True: it is done. The same store until then.
  bool run(const TargetStore& store, std::uint64_t& units);

  /// Candidates so far; all when run() said so.
  std::uint32_t size() const { return found_; }
  /// The i-th best, i < size().
  Candidate operator[](std::uint32_t i) const;
  /// Targets that passed all gates in this search, and were compared.
  std::uint32_t compared() const { return compared_; }
  const CandidateConfig& config() const { return config_; }

 private:
  bool is_wanted(const TargetRecord& record, const PlaceCm& place) const;
  void look(const TargetStore& store, std::uint32_t first);
  void insert(std::uint64_t rank);

  CandidateConfig config_;
  CandidateQuery query_;
  std::uint64_t ranks_[CandidateConfig::kMost]{};  ///< least first: distance, uniqueness turned round, number
  std::uint32_t found_{};
  std::uint32_t compared_{};
  std::uint32_t at_{};  ///< target that is next: the first of a block
  UnitCredit credit_;
};

}  // namespace sortie::mapping
