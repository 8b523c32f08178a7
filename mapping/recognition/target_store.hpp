// SPDX-License-Identifier: BSD-3-Clause
// The segments that robots have seen, as targets of recognition: a store of fixed size.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/recognition/target_places.hpp"
#include "mapping/recognition/target_record.hpp"
#include "mapping/recognition/target_sizes.hpp"
#include "mapping/recognition/target_uniqueness.hpp"
#include "rt/archive.hpp"
#include "rt/arena.hpp"
#include "rt/keys.hpp"
#include "rt/status.hpp"

namespace sortie::mapping {

/// Settings of a store of targets.
struct TargetStoreConfig {
  static constexpr std::uint32_t kMostTargets = 32'768;
  static constexpr std::uint32_t kMostKeyFrames = 65'535;

  std::uint32_t targets{4'096};     ///< at most kMostTargets
  std::uint32_t key_frames{1'024};  ///< at most kMostKeyFrames
  std::int32_t same_cm{200};  ///< a segment with a new id so near a target that looks alike is that target
  std::uint32_t same_steps{120};  ///< most distance of descriptors that look alike
  std::int32_t apart_cm{500};     ///< uniqueness is told from targets that are farther away

  SORTIE_KEYS(c, key) {
    key("limits.targets", c.targets, {1, kMostTargets, "targets", "segments that are kept to be recognised"});
    key("limits.key_frames", c.key_frames, {1, kMostKeyFrames, "frames", "that targets hang on"});
    key("same_cm", c.same_cm,
        {0, 10'000, "cm", "a segment with a new id so near one that looks alike is that"});
    key("same_steps", c.same_steps, {0, 9'690, "steps", "most difference of descriptors that look alike"});
    key("apart_cm", c.apart_cm, {0, 100'000, "cm", "uniqueness is told from targets that are farther away"});
  }
};

/// What became of segments that were put into a store.
struct TargetCounts {
  std::uint64_t added{};    ///< new records
  std::uint64_t renewed{};  ///< seen again under their id
  std::uint64_t adopted{};  ///< seen again under a new id
  std::uint64_t evicted{};  ///< records that made room for new ones
  std::uint64_t removed{};
  std::uint64_t refused{};
  SORTIE_FIELDS(added, renewed, adopted, evicted, removed, refused)
};

/// A fixed number of targets, their key frames and their places in the map (the target map of R. Dube et al.,
/// An Online Multi-Robot SLAM System for 3D LiDARs, IROS 2017, IV-B2, with a bound on its size). A segment
/// that its own robot sees again renews its record: by its id, or else the nearest record of that robot
/// within same_cm that looks alike. The latest view stays.
///
/// A full store gives up a target that was seldom seen and is near another: of those with the fewest views
/// (by the power of two) eight are drawn, by a number that depends on how many were given up before; the one
/// of them that is nearest to any other target, or to the new one, goes; of as many the one seen longest ago,
/// then the lowest number. Which records are kept depends on what was put in and on the latest poses of key
/// frames alone, never on budgets.
///
/// Places follow a correction of key frames, and uniqueness follows changes, in run(). Cost: put() looks at
/// each record once, and twice more where one is given up (3 and 58 us of a desk's core at 4,096). Memory: 64
/// bytes a record and 28.25 beside it, and 61 a key frame. No heap.
class TargetStore {
 public:
  /// What became of a sighting.
  struct Put {
    Status status{Status::ok};  ///< out_of_range: no such key frame, or too far from it; full: no room at all
    TargetIndex target{kNoTarget};
    bool added{};  ///< a new record, in place of one that was given up where that was counted
  };

  /// Without room for all of it in `arena` it takes nothing.
  TargetStore(const TargetStoreConfig& config, rt::Arena& arena);

  /// A key frame that is new or has moved: see TargetPlaces::set().
  [[nodiscard]] Status set_key_frame(std::uint16_t key_frame, const KeyFramePose& pose) {
    return places_.set(key_frame, pose);
  }
  /// A segment that was seen whole.
  Put put(const TargetSighting& sighting);
  /// A record as it was kept, with its views and its uniqueness, into the lowest free place. `edition`,
  /// `nearest` and `state` are the store's own. out_of_range as put(); full.
  [[nodiscard]] Status take(const TargetRecord& record);
  /// False: there is no such target.
  bool remove(TargetIndex target);
  /// The target of a robot's segment, or kNoTarget. One look a record.
  TargetIndex find(std::uint8_t robot, std::uint32_t id) const;

  /// First places, then uniqueness, for at most `units` and a step of each; takes what it used off. True:
  /// both are exact.
  bool run(std::uint64_t& units);
  bool current() const { return places_.current() && uniqueness_.current(); }

  /// Records 0 .. records().size() - 1; of them some are free. Never shorter than it was, but by clear().
  std::span<const TargetRecord> records() const { return records_.first(used_); }
  /// Where they are: one for each record, all from the same poses of key frames.
  std::span<const PlaceCm> places() const { return places_.places().first(used_); }
  const TargetPlaces& key_frames() const { return places_; }
  const TargetSizes& sizes() const { return sizes_; }
  const TargetUniqueness& uniqueness() const { return uniqueness_; }
  std::uint32_t kept() const { return kept_; }
  std::uint32_t capacity() const { return static_cast<std::uint32_t>(records_.size()); }
  const TargetStoreConfig& config() const { return config_; }
  const TargetCounts& counts() const { return counts_; }

  /// Empty, as after construction.
  void clear();
  /// Everything, between two calls, at any step of the work. Bytes that are no store's leave it empty.
  void archive(rt::Archive& archive);

 private:
  TargetIndex same_as(const TargetSighting& sighting, const PlaceCm& place, bool& by_id) const;
  TargetIndex lowest_free() const;
  TargetIndex evicted_for(const PlaceCm& place, std::uint32_t stamp_ms) const;
  PlaceCm latest_place(const TargetRecord& record) const {
    return place_of(places_.latest(record.key_frame), record.offset);
  }
  void keep(TargetIndex target);
  bool is_usable(const TargetRecord& record) const;

  TargetStoreConfig config_;
  std::span<TargetRecord> records_;
  TargetSizes sizes_;
  TargetPlaces places_;
  TargetUniqueness uniqueness_;
  std::uint32_t used_{};  ///< records that were ever in use
  std::uint32_t kept_{};
  TargetCounts counts_;
};

}  // namespace sortie::mapping
