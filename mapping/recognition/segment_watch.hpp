// SPDX-License-Identifier: BSD-3-Clause
// Which segments may speak: whole, large enough, at rest. And which version of them is known.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/recognition/place_cm.hpp"
#include "mapping/recognition/segment_descriptor.hpp"
#include "mapping/segments/segment_table.hpp"
#include "rt/archive.hpp"
#include "rt/arena.hpp"
#include "rt/describe.hpp"
#include "rt/keys.hpp"
#include "rt/status.hpp"
#include "rt/time.hpp"

namespace sortie::mapping {

/// When a segment may speak.
struct SegmentWatchConfig {
  std::uint32_t min_voxels{100};
  std::uint32_t drift_cm{5};
  rt::Nanoseconds rest_ns{rt::kNanosecondsPerSecond};
  rt::Nanoseconds version_ns{2 * rt::kNanosecondsPerSecond};
  std::uint32_t watched{256};

  SORTIE_KEYS(c, key) {
    key("min_voxels", c.min_voxels, {1, 1e6, "voxels", "of a segment that may be recognised"});
    key("drift_cm", c.drift_cm, {1, 1000, "cm", "that the middle of a segment at rest stays within"});
    key("rest_s", c.rest_ns, {0, 60, rt::kSInNs, "that a segment must be at rest before it is described"});
    key("version_s", c.version_ns, {0, 600, rt::kSInNs, "between two versions of a segment, at least"});
    key("limits.watched", c.watched,
        {1, 1024, "segments", "that are watched for being recognised; 128 B each"});
  }
};

/// What is seen of a segment when a labelling is done.
struct SegmentSighting {
  SegmentId id{};
  std::uint32_t voxels{};
  PlaceCm place;
  bool whole{};  ///< it does not go on beyond the border of the map
  SORTIE_FIELDS(id, voxels, place, whole)
};

/// A segment as it is watched. It speaks with the newest of its versions, also while it is incomplete or
/// moves again: what was true of it stays so until it is joined with others or cut.
struct WatchedSegment {
  SegmentId id{};
  std::uint32_t version{};    ///< 0: none yet. Counts up whenever place or descriptor are new
  bool speaks{};              ///< its version describes it
  bool wanted{};              ///< to be described
  bool seen{};                ///< in this round
  SegmentSighting now;        ///< newest sighting
  SegmentSighting described;  ///< the one that was described last
  PlaceCm rest;               ///< where it came to rest
  rt::Nanoseconds rest_since_ns{};
  rt::Nanoseconds version_at_ns{};  ///< when its newest version was made
  PlaceCm place;                    ///< of the version
  SegmentDescriptor descriptor;     ///< of the version
  SORTIE_FIELDS(id, version, speaks, wanted, seen, now, described, rest, rest_since_ns, version_at_ns, place,
                descriptor)
};
static_assert(sizeof(WatchedSegment) == 128);

/// Why segments did not speak, and what became of those that did; all since start.
struct SegmentWatchCounts {
  std::uint64_t versions{};
  std::uint64_t unchanged{};  ///< descriptions that said what the version already says
  std::uint64_t silenced{};   ///< versions that ended by a merge or a cut
  std::uint64_t forgotten{};  ///< segments that were not seen any more
  std::uint64_t refused{};    ///< sightings of segments for which the table had no room
  // Sightings that were not to be described, by the first reason:
  std::uint64_t small{};
  std::uint64_t cut_off{};   ///< not whole
  std::uint64_t restless{};  ///< not long enough at rest
  std::uint64_t known{};     ///< as many voxels at the same place as when it was described
  std::uint64_t early{};     ///< its last version is too young
  SORTIE_FIELDS(versions, unchanged, silenced, forgotten, refused, small, cut_off, restless, known, early)
};

/// A fixed table of segments by id. A round: begin() with the time; note() the events since the last round;
/// see() every segment once, in any order; end(). Then those that are wanted may be described, and their
/// descriptors told to describe().
///
/// At rest since: the middle has stayed within drift_cm of where it was then. It is measured at every round,
/// in the grid's frame, in whole cm. A merge into a segment or a cut from it silences it, and its rest begins
/// anew; its version goes on counting. An id that is renamed or gone is forgotten, and so is one that is not
/// seen in a round, should its event have been lost. Ids come in rising order when they are new; which one
/// has no room in a full table depends on the order of see(), else nothing does. One that was refused is
/// tried again in the next round. Cost: a binary search a
/// sighting, a look through the new ones for each new one, and a sort. Memory: 128 bytes a segment. No heap.
class SegmentWatch {
 public:
  SegmentWatch(const SegmentWatchConfig& config, rt::Arena& arena);

  /// time_backwards, and nothing done: `now_ns` lies before the round of before.
  Status begin(rt::Nanoseconds now_ns);
  /// Behind begin(), before the first see().
  void note(std::span<const SegmentEvent> events);
  /// A second sighting of an id in one round is passed over.
  void see(const SegmentSighting& sighting);
  /// Forgets what was not seen.
  void end();

  /// What the sighting of this round looks like. True: it is a new version. False: it is what the version
  /// already says, or nobody wanted it.
  bool describe(SegmentId id, const SegmentDescriptor& descriptor);

  /// After end(), by rising id.
  std::span<const WatchedSegment> segments() const { return segments_.first(count_); }
  const WatchedSegment* find(SegmentId id) const;
  const SegmentWatchCounts& counts() const { return counts_; }
  const SegmentWatchConfig& config() const { return config_; }

  /// The whole table to bytes and back, between two rounds. Ids that do not rise, and times to come, are
  /// malformed and leave an empty table.
  void archive(rt::Archive& archive);

 private:
  WatchedSegment* look_up(SegmentId id);
  void silence(SegmentId id);
  bool is_wanted(const WatchedSegment& segment);

  SegmentWatchConfig config_;
  std::span<WatchedSegment> segments_;
  std::uint32_t count_{};
  std::uint32_t sorted_{};  ///< those from here on are new in this round
  rt::Nanoseconds now_ns_{};
  bool begun_{};
  SegmentWatchCounts counts_;
};

}  // namespace sortie::mapping
