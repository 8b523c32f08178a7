// SPDX-License-Identifier: BSD-3-Clause
// Finds the voxel of a cell: a hash table with a fixed worst case, in the caller's memory.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace sortie::mapping {

/// Mixes 64 bits so that every input bit reaches every output bit (MurmurHash3's finaliser, constants of
/// Stafford's variant 13). A bijection: different inputs give different outputs.
constexpr std::uint64_t mix64(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

inline constexpr std::uint32_t kNoVoxel = 0xffffffffu;

/// One cache line of the table: up to eight entries, packed from the front.
struct alignas(64) VoxelBucket {
  static constexpr std::uint32_t kEntries = 8;
  struct Entry {
    std::uint32_t tag{};            ///< 32 bits of the key's hash: spares most looks at the voxel itself
    std::uint32_t voxel{kNoVoxel};  ///< index in the pool
  };
  std::array<Entry, kEntries> entries{};
};

/// Maps keys to pool indices. Every key has two buckets and lives in one of them, so each operation touches
/// 16 entries at most, whatever was inserted before, and removal leaves no tombstones. At half load no key
/// was ever refused in tests of 2^22 keys. The pool holds the keys; the caller gives them back through
/// `key_of`.
class VoxelTable {
 public:
  /// Buckets for a pool of `voxels`: a power of two, half load when the pool is full.
  static constexpr std::uint32_t buckets_for(std::uint32_t voxels) {
    std::uint32_t buckets = 2;
    while (buckets < voxels / (VoxelBucket::kEntries / 2) && buckets < (1u << 28)) buckets *= 2;
    return buckets;
  }

  /// `buckets` is empty (value-initialised) memory, a power of two of at least 2; other sizes lose their
  /// tail.
  explicit VoxelTable(std::span<VoxelBucket> buckets) : buckets_(buckets) {
    std::uint32_t size = 1;
    while (size <= buckets.size() / 2 && size < (1u << 28)) size *= 2;
    mask_ = buckets.empty() ? 0 : size - 1;
  }

  /// Where a key may live.
  struct Place {
    std::uint32_t first{};
    std::uint32_t second{};
    std::uint32_t tag{};
  };
  Place place(std::uint64_t key) const {
    const std::uint64_t h = mix64(key);
    const std::uint64_t g = mix64(h + 0x9e3779b97f4a7c15ull);
    return {static_cast<std::uint32_t>(h) & mask_, static_cast<std::uint32_t>(g) & mask_,
            static_cast<std::uint32_t>(h >> 32)};
  }

  /// Pool index of `key`, or kNoVoxel. `key_of(index)` tells the key of a voxel.
  template <class KeyOf>
  std::uint32_t find(std::uint64_t key, const Place& place, KeyOf key_of) const {
    for (const std::uint32_t bucket : {place.first, place.second}) {
      for (const VoxelBucket::Entry& entry : buckets_[bucket].entries) {
        if (entry.voxel == kNoVoxel) break;
        if (entry.tag == place.tag && key_of(entry.voxel) == key) return entry.voxel;
      }
    }
    return kNoVoxel;
  }

  /// True when add() would succeed.
  bool has_room(const Place& place) const {
    return used(place.first) < VoxelBucket::kEntries || used(place.second) < VoxelBucket::kEntries;
  }

  /// Hints the processor to fetch the first bucket.
  void prefetch(const Place& place) const { __builtin_prefetch(&buckets_[place.first]); }

  /// Adds a key that is not in the table, to the emptier of its buckets. False when both are full.
  bool add(const Place& place, std::uint32_t voxel) {
    const std::uint32_t used_first = used(place.first);
    const std::uint32_t used_second = used(place.second);
    const bool second = used_second < used_first && used_first >= kSpill;
    const std::uint32_t at = second ? used_second : used_first;
    if (at >= VoxelBucket::kEntries) return false;
    buckets_[second ? place.second : place.first].entries[at] = {place.tag, voxel};
    return true;
  }

  /// Forgets all entries.
  void clear() {
    for (VoxelBucket& bucket : buckets_) bucket = {};
  }
  /// True when a voxel of the table lives in the second of its buckets. Which of the two it is depends on
  /// what was there before it, and decides whether later keys find room: it belongs to the state of a map.
  bool in_second(const Place& place, std::uint32_t voxel) const {
    for (const VoxelBucket::Entry& entry : buckets_[place.first].entries) {
      if (entry.voxel == voxel) return false;
    }
    return true;
  }
  /// As add(), but to the bucket that is given. False when it is full.
  bool add_to(const Place& place, std::uint32_t voxel, bool second) {
    const std::uint32_t bucket = second ? place.second : place.first;
    const std::uint32_t at = used(bucket);
    if (at >= VoxelBucket::kEntries) return false;
    buckets_[bucket].entries[at] = {place.tag, voxel};
    return true;
  }

  /// Removes the entry of a voxel; true when it was there.
  bool remove(const Place& place, std::uint32_t voxel) {
    for (const std::uint32_t bucket : {place.first, place.second}) {
      auto& entries = buckets_[bucket].entries;
      const std::uint32_t size = used(bucket);
      for (std::uint32_t i = 0; i < size; ++i) {
        if (entries[i].voxel != voxel) continue;
        entries[i] = entries[size - 1];
        entries[size - 1] = {};
        return true;
      }
    }
    return false;
  }

 private:
  static constexpr std::uint32_t kSpill =
      5;  // below it a key stays in its first bucket: one cache line a look-up

  std::uint32_t used(std::uint32_t bucket) const {
    std::uint32_t n = 0;
    while (n < VoxelBucket::kEntries && buckets_[bucket].entries[n].voxel != kNoVoxel) ++n;
    return n;
  }

  std::span<VoxelBucket> buckets_;
  std::uint32_t mask_{};
};

}  // namespace sortie::mapping
