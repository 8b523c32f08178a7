// SPDX-License-Identifier: BSD-3-Clause
// Where the targets are, by where their key frames are: a table that is made anew in slices when these move.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/recognition/target_record.hpp"
#include "mapping/registration/unit_credit.hpp"
#include "rt/archive.hpp"
#include "rt/arena.hpp"
#include "rt/status.hpp"

namespace sortie::mapping {

/// Key frames and the places of all targets. Readers see one table that is whole: all of it from the same
/// poses. A second one is made behind it, from the poses as they were when that began, and then takes its
/// place; what was corrected meanwhile comes with the next one, so corrections that keep coming do not keep
/// it from being shown. Memory: 60 bytes a key frame and one, 24 bytes a target. No heap.
class TargetPlaces {
 public:
  static constexpr std::uint32_t kBlock = 64;  ///< targets that are placed at a time

  TargetPlaces(std::uint32_t key_frames, std::uint32_t targets, rt::Arena& arena);

  /// A key frame that is new, or has moved. out_of_range: no such number, or a pose that is not usable(). A
  /// new one is there at once, since nothing hangs on it; a moved one is shown with the next whole table.
  [[nodiscard]] Status set(std::uint16_t key_frame, const KeyFramePose& pose);
  bool knows(std::uint16_t key_frame) const { return key_frame < known_.size() && known_[key_frame]; }
  /// How many key frames there is room for.
  std::uint32_t key_frames() const { return static_cast<std::uint32_t>(known_.size()); }

  /// The pose that was set last, of a key frame that is known.
  const KeyFramePose& latest(std::uint16_t key_frame) const { return latest_[key_frame]; }
  /// The pose that the shown places have.
  const KeyFramePose& shown(std::uint16_t key_frame) const { return tables_[shown_].poses[key_frame]; }
  /// Places of the shown table, one a target, cm in the map. Those of free records mean nothing.
  std::span<const PlaceCm> places() const { return tables_[shown_].places; }
  /// Counts tables that were shown after the first.
  std::uint32_t tables_shown() const { return tables_shown_; }
  /// Nothing has moved since the poses of the shown table.
  bool current() const { return !building_ && !moved_; }

  /// A record that is new or changed.
  void place(TargetIndex target, const TargetRecord& record);
  /// Makes the next table, if one is due, for at most `units` and takes what it used off; 1 unit a record and
  /// an eighth of one a key frame. Calls moved(target) for each that it puts elsewhere, before it is shown.
  /// True: the shown table is current.
  template <class Moved>
  bool run(std::span<const TargetRecord> records, std::uint64_t& units, Moved&& moved) {
    while (!current()) {
      const bool begins = !building_;
      const std::uint64_t cost = begins ? 1 + key_frames() / 8 : kBlock;
      if (!credit_.pay(cost, units)) return false;
      if (begins) {
        begin();
        continue;
      }
      const auto size = static_cast<std::uint32_t>(records.size());
      const std::uint32_t end = at_ + kBlock < size ? at_ + kBlock : size;
      for (; at_ < end; ++at_) {
        if (records[at_].state == TargetState::free) continue;
        if (build(static_cast<TargetIndex>(at_), records[at_])) moved(static_cast<TargetIndex>(at_));
      }
      if (at_ >= size) show();
    }
    return true;
  }

  /// Without key frames, as after construction.
  void clear();
  /// The table's own state; `records` were read before. Places follow from poses.
  void archive(rt::Archive& archive, std::span<const TargetRecord> records);

 private:
  struct Table {
    std::span<KeyFramePose> poses;
    std::span<PlaceCm> places;
  };
  void begin();
  bool build(TargetIndex target, const TargetRecord& record);
  void show();

  std::span<bool> known_;
  std::span<KeyFramePose> latest_;
  Table tables_[2];
  std::uint32_t at_{};  ///< target that is placed next
  std::uint32_t tables_shown_{};
  std::uint8_t shown_{};
  bool building_{};
  bool moved_{};  ///< since the poses of the table that is built, or else shown
  UnitCredit credit_;
};

}  // namespace sortie::mapping
