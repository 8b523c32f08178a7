// SPDX-License-Identifier: BSD-3-Clause
// How much unlike all others a target looks: kept while targets come, change and go, in slices.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/recognition/target_record.hpp"
#include "mapping/registration/unit_credit.hpp"
#include "rt/archive.hpp"
#include "rt/arena.hpp"

namespace sortie::mapping {

/// Keeps `uniqueness` and `nearest` of all records: the least distance to another target's descriptor, of
/// those that are farther away than a given distance, and who that is; the lowest number of as many. One that
/// is nearer may be the same thing, or a part of it.
///
/// A target that came, changed or went is compared with all others in one pass, which renews it and them. Who
/// had it as nearest, and now may have another, asks again: a pass of its own. When no pass is left all is as
/// if it were computed from nothing: whoever waits for no pass has been compared with all that wait for none.
/// The work: one pass a change, and one for each that asks again, which is one or two as a rule. Until then a
/// value is that of the last pass. Cost of a pass: 2 units a record, 64 at a time. Memory: 2 bits a target.
/// No heap.
class TargetUniqueness {
 public:
  static constexpr std::uint32_t kBlock = 64;  ///< records that are compared at a time

  /// `apart_cm`: targets whose places are farther apart are compared.
  TargetUniqueness(std::int32_t apart_cm, std::uint32_t targets, rt::Arena& arena);

  /// This one came, changed, moved or went.
  void changed(TargetIndex target);
  /// Passes for at most `units`, takes what it used off. `places`: one a record. True: none is left.
  bool run(std::span<TargetRecord> records, std::span<const PlaceCm> places, std::uint64_t& units);
  /// Whether all values are exact.
  bool current() const { return waiting_ == 0; }
  /// Passes that were made so far.
  std::uint64_t passes() const { return passes_; }

  void clear();
  /// `records` were read before.
  void archive(rt::Archive& archive, std::span<const TargetRecord> records);

 private:
  using Bits = std::span<std::uint64_t>;
  static bool has(Bits bits, std::uint32_t at) { return (bits[at / 64] >> (at % 64) & 1u) != 0; }
  bool waits(std::uint32_t target) const { return has(changed_, target) || has(asks_, target); }
  void ask(std::uint32_t target);
  void begin();
  void compare(std::span<TargetRecord> records, std::span<const PlaceCm> places, std::uint32_t end);
  void finish(std::span<TargetRecord> records);

  std::int64_t apart2_;
  Bits changed_;  ///< waits for a pass that renews others, too
  Bits asks_;     ///< waits for a pass of its own
  std::uint32_t waiting_{};
  std::uint32_t at_{};              ///< record that is compared next
  std::uint16_t target_{};          ///< of the pass, or where the next one is looked for
  std::uint16_t least_{};           ///< distance so far
  TargetIndex nearest_{kNoTarget};  ///< at that distance
  bool under_way_{};
  bool renews_others_{};
  std::uint64_t passes_{};
  UnitCredit credit_;
};

}  // namespace sortie::mapping
