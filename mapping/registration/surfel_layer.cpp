// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/surfel_layer.hpp"

#include <algorithm>

namespace sortie::mapping {

SurfelLayerMemory surfel_memory(rt::Arena& arena, const char* window, const char* name, unsigned bits_xy,
                                unsigned bits_z, std::size_t surfels, bool gaussians) {
  return {arena.make_array<SurfelIndex>(window, std::size_t{1} << (2 * bits_xy + bits_z)),
          arena.make_array<std::uint64_t>(name, surfels),
          arena.make_array<SurfelSums>(name, surfels),
          arena.make_array<Surfel>(name, gaussians ? surfels : 0),
          arena.make_array<SurfelIndex>(name, surfels),
          arena.make_array<std::uint32_t>(name, surfels),
          arena.make_array<SurfelIndex>(name, gaussians ? surfels : 0)};
}

SurfelLayer::SurfelLayer(double cell_m, unsigned bits_xy, unsigned bits_z, std::uint32_t min_points,
                         std::uint32_t memory_points, const SurfelLayerMemory& memory, bool planar)
    : cell_m_(cell_m),
      per_cell_(1.0 / cell_m),
      thin_m2_(kThinSurface * kThinSurface * cell_m * cell_m),
      bits_xy_(bits_xy),
      bits_z_(bits_z),
      mask_xy_((1u << bits_xy) - 1),
      mask_z_((1u << bits_z) - 1),
      min_points_(min_points),
      memory_points_(memory_points),
      planar_(planar),
      memory_(memory) {
  clear();
}

void SurfelLayer::clear() {
  std::fill(memory_.window.begin(), memory_.window.end(), kNoSurfel);
  std::fill(memory_.keys.begin(), memory_.keys.end(), kUnused);
  free_ = memory_.keys.size();
  has_middle_ = false;
  for (std::size_t i = 0; i < free_; ++i) memory_.free[i] = static_cast<SurfelIndex>(free_ - 1 - i);
}

void SurfelLayer::release(SurfelIndex index) {
  const std::uint32_t at = entry(SurfelCell::from_key(memory_.keys[index]));
  if (memory_.window[at] == index) {
    memory_.window[at] = kNoSurfel;
    if (has_gaussians() && memory_.others[index] != kNoSurfel) release(memory_.others[index]);
  } else if (memory_.window[at] != kNoSurfel) {
    memory_.others[memory_.window[at]] = kNoSurfel;
  }
  memory_.keys[index] = kUnused;
  memory_.free[free_++] = index;
  ++counts_.evicted;
}

void SurfelLayer::evict_beyond(const rt::Vector3& middle_m) {
  SurfelPlace middle;
  if (!place(middle_m.x, middle_m.y, middle_m.z, middle)) return;
  middle_ = middle.cell;
  has_middle_ = true;
  for (std::size_t i = 0; i < memory_.keys.size(); ++i) {
    if (memory_.keys[i] != kUnused && !within_window(SurfelCell::from_key(memory_.keys[i])))
      release(static_cast<SurfelIndex>(i));
  }
}

bool SurfelLayer::within_window(const SurfelCell& cell) const {
  const std::int32_t most[3] = {std::int32_t{1} << (bits_xy_ - 1), std::int32_t{1} << (bits_xy_ - 1),
                                std::int32_t{1} << (bits_z_ - 1)};
  for (int axis = 0; axis < 3; ++axis) {
    const std::int32_t away = cell.at[axis] - middle_.at[axis];
    if (away < -most[axis] || away >= most[axis]) return false;
  }
  return true;
}

/// Room for cells that are not there, in the order of their keys. Those beyond the window come last, and get
/// what is left: each of them would have the place of a near one.
void SurfelLayer::make_room(std::span<std::uint64_t> missing, std::uint32_t scan) {
  std::sort(missing.begin(), missing.end());
  for (const bool near : {true, false}) {
    std::uint64_t last = kUnused;
    for (const std::uint64_t key : missing) {
      if (key == last) continue;
      last = key;
      const SurfelCell cell = SurfelCell::from_key(key);
      if ((!has_middle_ || within_window(cell)) != near) continue;
      const std::uint32_t at = entry(cell);
      const bool other_side = (key & kOtherSide) != 0;
      if (other_side) {
        if (free_ == 0 || find(cell) == kNoSurfel) continue;
      } else if (memory_.window[at] != kNoSurfel) {
        if (!near) continue;  // counted with its points
        release(memory_.window[at]);
      }
      if (free_ == 0) continue;  // the same
      const SurfelIndex index = memory_.free[--free_];
      (other_side ? memory_.others[memory_.window[at]] : memory_.window[at]) = index;
      if (has_gaussians()) memory_.others[index] = kNoSurfel;
      memory_.keys[index] = key;
      memory_.sums[index] = {};
      if (has_gaussians()) memory_.surfels[index] = {};
      memory_.newest[index] = scan - 1;
      ++counts_.created;
    }
  }
}

std::span<const std::uint64_t> SurfelLayer::insert(std::span<const rt::Vector3> points_m,
                                                   const rt::Vector3& from_m, std::uint32_t scan,
                                                   std::span<std::uint64_t> cells) {
  std::size_t missing = 0;
  SurfelPlace at;
  const auto side_of = [&](SurfelIndex index, const rt::Vector3& p) {
    return index != kNoSurfel && has_gaussians() ? met(index, p - from_m) : index;
  };
  for (const rt::Vector3& p : points_m) {
    if (!place(p.x, p.y, p.z, at)) continue;
    const SurfelIndex index = find(at.cell);
    if (side_of(index, p) == kNoSurfel)
      cells[missing++] = at.cell.key() | (index == kNoSurfel ? 0 : kOtherSide);
  }
  make_room(cells.first(missing), scan);
  std::size_t touched = 0;
  for (const rt::Vector3& p : points_m) {
    ++counts_.in;
    if (!place(p.x, p.y, p.z, at)) {
      ++counts_.outside;
      continue;
    }
    const SurfelIndex index = side_of(find(at.cell), p);
    if (index == kNoSurfel) {
      ++counts_.pool_full;
      continue;
    }
    ++counts_.used;
    // What would not fit any more before the scan's end is left out; a cell fades between scans.
    if (memory_.sums[index].count < kMostSurfelPoints) memory_.sums[index].add(at.at);
    if (memory_.newest[index] != scan) {
      memory_.newest[index] = scan;
      cells[touched++] = index;
    }
  }
  for (const std::uint64_t entry : cells.first(touched)) {
    const auto index = static_cast<std::size_t>(entry);
    SurfelSums& sums = memory_.sums[index];
    const bool fades = sums.count >= memory_points_;
    if (has_gaussians()) {
      Surfel& surfel = memory_.surfels[index];
      const std::uint32_t known = surfel.count;
      if (fades || (sums.count >= min_points_ && sums.count > known + known / 10)) {
        const bool keeps_side = known > 0 && has_sides(surfel);
        const rt::Vector3 before = surfel.normal();
        surfel = surfel_of(sums, cell_m_, planar_);
        const rt::Vector3 seen_from =
            keeps_side ? before
                       : from_m - centre_m(SurfelCell::from_key(memory_.keys[index])) - surfel.mean();
        if (rt::dot(surfel.normal(), seen_from) < 0.0) {
          for (float& part : surfel.axis[0]) part = -part;
        }
      }
    }
    if (!fades) continue;
    sums.fade();
    if (has_gaussians()) memory_.surfels[index].count = sums.count;
  }
  return cells.first(touched);
}

/// In the unused end of the list of free ones, which has room for just as many.
std::span<const SurfelIndex> SurfelLayer::by_key() const {
  const std::span<SurfelIndex> used = memory_.free.subspan(free_);
  std::size_t count = 0;
  for (std::size_t i = 0; i < memory_.keys.size(); ++i) {
    if (memory_.keys[i] != kUnused) used[count++] = static_cast<SurfelIndex>(i);
  }
  std::sort(used.begin(), used.end(),
            [this](SurfelIndex a, SurfelIndex b) { return memory_.keys[a] < memory_.keys[b]; });
  return used;
}

Status SurfelLayer::put(const SurfelRecord& record) {
  if (fault_of(record, cell_m_, has_gaussians()) != nullptr) return Status::malformed;
  if (free_ == 0) return Status::full;
  const bool other_side = (record.key & kOtherSide) != 0;
  const SurfelIndex front = find(SurfelCell::from_key(record.key));
  if (other_side && front == kNoSurfel) return Status::malformed;
  SurfelIndex& place =
      other_side ? memory_.others[front] : memory_.window[entry(SurfelCell::from_key(record.key))];
  if (place != kNoSurfel) return Status::out_of_range;
  const SurfelIndex index = memory_.free[--free_];
  place = index;
  memory_.keys[index] = record.key;
  if (has_gaussians()) memory_.others[index] = kNoSurfel;
  memory_.sums[index] = record.sums;
  if (has_gaussians()) memory_.surfels[index] = record.surfel;
  memory_.newest[index] = 0;
  return Status::ok;
}

SurfelIndex SurfelLayer::add(const SurfelCell& cell, const SurfelSums& sums) {
  const SurfelIndex index = find(cell);
  if (index == kNoSurfel) return put({cell.key(), sums, {}}) == Status::ok ? find(cell) : kNoSurfel;
  memory_.sums[index].add(sums);
  return index;
}

void SurfelLayer::archive(rt::Archive& archive) {
  archive.expect(memory_.keys.size(), "another number of surfels than this layer's");
  if (archive.is_reading()) clear();
  rt::Members(archive, *this, "surfel layer")
      .fixed(cell_m_, per_cell_, thin_m2_, bits_xy_, bits_z_, mask_xy_, mask_z_, min_points_, memory_points_,
             planar_)
      .by_hand(memory_, free_)
      .state(middle_, has_middle_, counts_);
  for (const std::int32_t at : middle_.at) {
    if (at < -SurfelCell::kLimit || at >= SurfelCell::kLimit)
      archive.fail(Status::malformed, "a window about no cell");
  }
  auto count = static_cast<std::uint32_t>(size());
  archive.bounded(count, memory_.keys.size());
  std::span<const SurfelIndex> there;
  if (!archive.is_reading()) there = by_key();
  std::uint64_t last = 0;
  for (std::uint32_t i = 0; i < count && archive.status() == Status::ok; ++i) {
    SurfelRecord one;
    std::uint32_t newest = 0;
    if (!archive.is_reading()) {
      one = record(there[i]);
      newest = memory_.newest[there[i]];
    }
    archive.value(one.key);
    archive.value(one.sums);
    if (has_gaussians()) archive.value(one.surfel);
    archive.value(newest);
    if (!archive.is_reading() || archive.status() != Status::ok) continue;
    if ((i > 0 && one.key <= last) || put(one) != Status::ok) {
      archive.fail(Status::malformed, "a surfel that cannot be, or is there twice");
      break;
    }
    last = one.key;
    const SurfelIndex front = find(SurfelCell::from_key(one.key));
    memory_.newest[(one.key & kOtherSide) != 0 ? other_side(front) : front] = newest;
  }
  if (archive.is_reading() && archive.status() != Status::ok) clear();
}

}  // namespace sortie::mapping
