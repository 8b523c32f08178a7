// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/surfel_map.hpp"

#include <algorithm>
#include <bit>

#include "rt/digest.hpp"

namespace sortie::mapping {
namespace {

constexpr std::size_t kHeadBytes = rt::canonical_size<SurfelMapHead>();
constexpr std::size_t kRecordBytes = rt::canonical_size<SurfelRecord>();
constexpr std::size_t kCheckBytes = 8;
constexpr std::uint32_t kMostSurfels = 1u << 24;  // of a layer: no sum of lengths overflows

SurfelMapHead head_of(const ScanRegistration& registration) {
  SurfelMapHead head;
  if (registration.config().planar) head.version = SurfelMapHead::kInPlane;
  head.cell_m = registration.config().cell_m;
  head.min_points = registration.config().min_points;
  head.memory_points = registration.config().memory_points;
  for (int level = 0; level < kSurfelLayers; ++level)
    head.surfels[level] = static_cast<std::uint32_t>(registration.layer(level).size());
  return head;
}

std::uint64_t bytes_of(const SurfelMapHead& head) {
  std::uint64_t surfels = 0;
  for (const std::uint32_t count : head.surfels) surfels += count;
  return kHeadBytes + kRecordBytes * surfels + kCheckBytes;
}

SurfelMapFault judge(const SurfelMapHead& head, const SurfelMapHead& own, std::size_t bytes) {
  if (head.magic != own.magic) return SurfelMapFault::no_map;
  const bool read = head.version == SurfelMapHead::kVersion || head.version == SurfelMapHead::kInPlane;
  if (!read || head.layers != own.layers || head.steps != own.steps) return SurfelMapFault::version;
  for (const std::uint32_t count : head.surfels) {
    if (count > kMostSurfels) return SurfelMapFault::length;
  }
  if (bytes_of(head) != bytes) return SurfelMapFault::length;
  if (head.version != own.version) return SurfelMapFault::planar;
  if (!(head.cell_m == own.cell_m)) return SurfelMapFault::cell;
  if (head.min_points != own.min_points) return SurfelMapFault::min_points;
  if (head.memory_points != own.memory_points) return SurfelMapFault::memory_points;
  return SurfelMapFault::none;
}

/// A window that holds twice `cells` of a level, in cells of the finest.
std::uint32_t window_for(std::uint32_t cells, int level) { return std::bit_ceil(2 * cells) << level; }

class Loader {
 public:
  Loader(std::span<const std::uint8_t> bytes, ScanRegistration& registration)
      : archive_(rt::Archive::reading(bytes)), bytes_(bytes), registration_(registration) {}

  SurfelMapResult load() {
    for (int level = 0; level < kSurfelLayers; ++level) registration_.layer_to_load(level).clear();
    if (is_good()) {
      for (int level = 0; level < kSurfelLayers && result_.fault == SurfelMapFault::none; ++level)
        take_layer(level);
    }
    if (result_.fault != SurfelMapFault::none) {
      for (int level = 0; level < kSurfelLayers; ++level) registration_.layer_to_load(level).clear();
    }
    return result_;
  }

 private:
  bool is_good() {
    archive_.value(result_.head);
    if (archive_.status() != Status::ok) {
      result_.fault =
          result_.head.magic == SurfelMapHead::kMagic ? SurfelMapFault::length : SurfelMapFault::no_map;
      return false;
    }
    result_.fault = judge(result_.head, head_of(registration_), bytes_.size());
    if (result_.fault != SurfelMapFault::none) return false;
    const std::size_t body = bytes_.size() - kCheckBytes;
    rt::Archive tail = rt::Archive::reading(bytes_.subspan(body));
    std::uint64_t check = 0;
    tail.value(check);
    if (check != rt::digest_bytes(bytes_.data(), body)) result_.fault = SurfelMapFault::checksum;
    for (int level = 0; level < kSurfelLayers && result_.fault == SurfelMapFault::none; ++level) {
      if (result_.head.surfels[level] <= registration_.layer(level).keys().size()) continue;
      refuse(SurfelMapFault::room, level);
      for (int i = 0; i < kSurfelLayers; ++i)
        result_.needed = std::max(result_.needed, result_.head.surfels[i] << i);
    }
    return result_.fault == SurfelMapFault::none;
  }

  void take_layer(int level) {
    SurfelLayer& layer = registration_.layer_to_load(level);
    SurfelBox box;
    // First what they are and how far they reach: then each has a place of its own in the window.
    rt::Archive ahead = archive_;
    std::uint64_t last = 0;
    for (std::uint32_t i = 0; i < result_.head.surfels[level]; ++i) {
      SurfelRecord one;
      result_.byte = ahead.bytes();
      ahead.value(one);
      result_.why = fault_of(one, layer.cell_m(), true);
      if (result_.why != nullptr) return refuse(SurfelMapFault::surfel, level);
      result_.why = "";
      if (i > 0 && one.key <= last) return refuse(SurfelMapFault::order, level);
      last = one.key;
      box.take(SurfelCell::from_key(one.key));
    }
    const std::uint32_t wide = std::max(box.cells(0), box.cells(1));
    result_.needed = window_for(wide, level);
    if (2 * wide > layer.window_xy()) return refuse(SurfelMapFault::window, level);
    result_.needed = window_for(box.cells(2), level);
    if (2 * box.cells(2) > layer.window_z()) return refuse(SurfelMapFault::height, level);
    result_.needed = 0;
    for (std::uint32_t i = 0; i < result_.head.surfels[level]; ++i) {
      SurfelRecord one;
      result_.byte = archive_.bytes();
      archive_.value(one);
      if (layer.put(one) == Status::ok) continue;
      result_.why = "the other side of a surface that is not there";
      return refuse(SurfelMapFault::surfel, level);
    }
  }

  void refuse(SurfelMapFault fault, int level) {
    result_.fault = fault;
    result_.layer = level;
  }

  rt::Archive archive_;
  std::span<const std::uint8_t> bytes_;
  ScanRegistration& registration_;
  SurfelMapResult result_;
};

}  // namespace

std::uint64_t surfel_map_bytes(const ScanRegistration& registration) {
  return bytes_of(head_of(registration));
}

Status write_surfel_map(const ScanRegistration& registration, std::span<std::uint8_t> out) {
  if (out.size() < surfel_map_bytes(registration)) return Status::full;
  rt::Archive archive = rt::Archive::writing(out);
  SurfelMapHead head = head_of(registration);
  archive.value(head);
  for (int level = 0; level < kSurfelLayers; ++level) {
    const SurfelLayer& layer = registration.layer(level);
    for (const SurfelIndex index : layer.by_key()) {
      SurfelRecord one = layer.record(index);
      archive.value(one);
    }
  }
  std::uint64_t check = rt::digest_bytes(out.data(), static_cast<std::size_t>(archive.bytes()));
  archive.value(check);
  return archive.status();
}

SurfelMapResult load_surfel_map(std::span<const std::uint8_t> bytes, ScanRegistration& registration) {
  return Loader(bytes, registration).load();
}

}  // namespace sortie::mapping
