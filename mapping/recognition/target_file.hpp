// SPDX-License-Identifier: BSD-3-Clause
// Targets as bytes that are kept from one run to another.
//
// Little endian: head, key frames by rising number (KeyFrameRecord), targets (KeptTarget), xxhash64 of all
// before it.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/recognition/target_store.hpp"
#include "rt/describe.hpp"

namespace sortie::mapping {

/// What stands before the key frames. 24 bytes.
struct TargetFileHead {
  static constexpr std::uint64_t kMagic = 0x5445475241544f53;  ///< "SOTARGET"
  static constexpr std::uint32_t kVersion = 1;
  std::uint64_t magic{kMagic};
  std::uint32_t version{kVersion};
  std::uint32_t steps{SegmentDescriptor::kSteps};  ///< bytes of a descriptor
  std::uint32_t key_frames{};
  std::uint32_t targets{};
  SORTIE_FIELDS(magic, version, steps, key_frames, targets)
};

/// A key frame. 22 bytes.
struct KeyFrameRecord {
  std::uint16_t number{};
  KeyFramePose pose;
  SORTIE_FIELDS(number, pose)
};

/// What is kept of a TargetRecord; the rest belongs to a store. 56 bytes.
struct KeptTarget {
  SegmentDescriptor descriptor;
  std::uint32_t id{};
  std::uint32_t voxels{};
  std::uint32_t last_seen_ms{};
  PlaceCm offset;
  std::uint16_t key_frame{};
  std::uint16_t version{};
  std::uint16_t views{};
  std::uint8_t robot{};
  std::uint8_t uniqueness{};
  SORTIE_FIELDS(descriptor, id, voxels, last_seen_ms, offset, key_frame, version, views, robot, uniqueness)
};

/// Why targets cannot be taken.
enum class TargetFileFault : std::uint8_t {
  none = 0,
  no_targets,       ///< other bytes
  version,          ///< of another version of the format, or with other descriptors
  length,           ///< cut off, or something behind it
  checksum,         ///< damaged
  key_frame,        ///< one whose pose cannot be
  order,            ///< a key frame that is there twice, or out of order
  target,           ///< one that cannot be, or hangs on no key frame
  twice,            ///< a robot's segment that is there already
  key_frames_room,  ///< `needed` key frames, and there is no room for so many
  targets_room,     ///< `needed` targets, and there is no room for so many
};

/// The fault in a few words.
const char* to_string(TargetFileFault fault);

/// What became of loading targets.
struct TargetFileResult {
  TargetFileFault fault{TargetFileFault::none};
  std::uint64_t byte{};    ///< where, of a key frame or a target
  std::uint32_t needed{};  ///< by the two kinds of room; of read_target_head(): key frames
  TargetFileHead head;     ///< as far as it was read
};

/// Bytes of a store's targets.
std::uint64_t target_file_bytes(const TargetStore& store);
/// Writes targets with the latest poses of all key frames; full where `out` is shorter than
/// target_file_bytes(). The same targets in the same order, the same bytes.
Status write_targets(const TargetStore& store, std::span<std::uint8_t> out);

/// Whether bytes are a whole file of targets, and what it takes: `head.targets`, and `needed` key frames.
TargetFileResult read_target_head(std::span<const std::uint8_t> bytes);
/// Puts kept targets in the place of the store's, or leaves that empty and says why not. Nothing in the bytes
/// is trusted. Uniqueness is what was kept until TargetStore::run() has told it anew. For set-up: each target
/// is looked for among those before it. No heap.
TargetFileResult load_targets(std::span<const std::uint8_t> bytes, TargetStore& store);

}  // namespace sortie::mapping
