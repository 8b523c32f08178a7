// SPDX-License-Identifier: BSD-3-Clause
// The voxel grid's state to bytes and back.
#include "mapping/voxel_grid.hpp"

namespace sortie::mapping {

namespace {
constexpr std::uint64_t kSecondBucket = std::uint64_t{1} << 63;  // keys have 63 bits
}

void VoxelGrid::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "voxel grid")
      .fixed(config_, inverse_size_, usable_)
      .by_hand(pool_, table_, hand_)
      .scratch(first_touched_, sensor_m_)
      .state(output_);
  if (!usable_) return;
  archive.expect(pool_.size(), "the map has another capacity");
  archive.bounded(hand_, pool_.size() - 1);
  archive.bounded(output_.voxels, pool_.size());
  if (archive.is_reading()) table_.clear();
  for (std::uint32_t i = 0; i < output_.voxels; ++i) {
    Voxel& voxel = pool_[i];
    if (archive.is_reading()) voxel = Voxel{};
    std::uint64_t key = voxel.key;
    if (!archive.is_reading() && table_.in_second(table_.place(key), i)) key |= kSecondBucket;
    auto count = static_cast<std::uint16_t>(voxel.count);
    archive.value(key);
    archive.value(voxel.offset_sum);
    archive.value(count);
    archive.value(voxel.last_tick);
    if (!archive.is_reading()) continue;
    voxel.key = key & ~kSecondBucket;
    voxel.count = count;
    if (archive.status() != Status::ok ||
        !table_.add_to(table_.place(voxel.key), i, (key & kSecondBucket) != 0)) {
      archive.fail(Status::malformed, "voxels that cannot lie in one table");
      output_.voxels = 0;
      table_.clear();
      return;
    }
  }
}

}  // namespace sortie::mapping
