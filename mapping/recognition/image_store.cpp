// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/recognition/image_store.hpp"

#include <algorithm>
#include <bit>
#include <limits>

#include "mapping/recognition/image_planes.hpp"

namespace sortie::mapping {
namespace {

std::int64_t square_beside(const PlaceCm& a, const PlaceCm& b) {
  const std::int64_t x = std::int64_t{a.x} - b.x, y = std::int64_t{a.y} - b.y;
  return x * x + y * y;
}

std::uint32_t structure_of(const HeightImage& image) {
  std::uint32_t sum = 0;
  for (const ImagePlane::Word word : either(image.low, image.high).words)
    sum += static_cast<std::uint32_t>(std::popcount(word));
  return sum;
}

}  // namespace

ImageStore::ImageStore(const ImageStoreConfig& config, rt::Arena& arena)
    : config_(config),
      records_(arena.make_array<ImageRecord>("height images",
                                             std::min(config.images, ImageStoreConfig::kMostImages))) {}

void ImageStore::keep(std::uint32_t at, const HeightImage& image, const KeyFramePose& pose,
                      std::uint32_t stamp_ms, std::uint8_t robot) {
  ImageRecord& record = records_[at];
  record.image = image;
  record.image.middle = {};
  record.pose = pose;
  record.cells = structure_of(image);
  record.stamp_ms = stamp_ms;
  record.robot = robot;
}

/// The nearest one of the same storey that is the same place; of as near ones the first.
std::uint32_t ImageStore::near_to(const PlaceCm& place) const {
  std::int64_t least = std::int64_t{config_.apart_cm} * config_.apart_cm;
  std::uint32_t found = kNone;
  for (std::uint32_t i = 0; i < kept_; ++i) {
    const PlaceCm& other = records_[i].pose.place;
    const std::int64_t rise = std::int64_t{other.z} - place.z;
    const std::int64_t square = square_beside(other, place);
    if (rise > kStoreyCm || rise < -kStoreyCm || square >= least) continue;
    least = square;
    found = i;
  }
  return found;
}

std::uint32_t ImageStore::evicted_for(const PlaceCm& place) const {
  std::uint32_t found = 0;
  std::int64_t least = std::numeric_limits<std::int64_t>::max();
  for (std::uint32_t i = 0; i < kept_; ++i) {
    std::int64_t nearest = square_apart(records_[i].pose.place, place);
    for (std::uint32_t k = 0; k < kept_; ++k) {
      if (k != i) nearest = std::min(nearest, square_apart(records_[i].pose.place, records_[k].pose.place));
    }
    if (nearest > least || (nearest == least && records_[i].cells >= records_[found].cells)) continue;
    least = nearest;
    found = i;
  }
  return found;
}

Status ImageStore::put(const HeightImage& image, const KeyFramePose& pose, std::uint32_t stamp_ms,
                       std::uint8_t robot) {
  if (!pose.usable() || records_.empty()) {
    ++counts_.refused;
    return pose.usable() ? Status::full : Status::out_of_range;
  }
  const std::uint32_t near = near_to(pose.place);
  if (near != kNone) {
    const bool shows_more = std::uint64_t{structure_of(image)} * 8 > std::uint64_t{records_[near].cells} * 9;
    ++(shows_more ? counts_.renewed : counts_.known);
    if (shows_more) keep(near, image, pose, stamp_ms, robot);
    return Status::ok;
  }
  const bool is_full = kept_ == capacity();
  counts_.evicted += is_full ? 1 : 0;
  ++counts_.added;
  const std::uint32_t at = is_full ? evicted_for(pose.place) : kept_++;
  keep(at, image, pose, stamp_ms, robot);
  return Status::ok;
}

Status ImageStore::take(const HeightImage& image, const KeyFramePose& pose, std::uint32_t stamp_ms,
                        std::uint8_t robot) {
  if (!pose.usable() || kept_ == capacity()) {
    ++counts_.refused;
    return pose.usable() ? Status::full : Status::out_of_range;
  }
  ++counts_.added;
  keep(kept_++, image, pose, stamp_ms, robot);
  return Status::ok;
}

Status ImageStore::set_pose(std::uint32_t image, const KeyFramePose& pose) {
  if (image >= kept_ || !pose.usable()) return Status::out_of_range;
  records_[image].pose = pose;
  return Status::ok;
}

void ImageStore::clear() {
  kept_ = 0;
  counts_ = {};
}

void ImageStore::archive(rt::Archive& archive) {
  archive.expect(capacity(), "another number of images than this store's");
  if (archive.is_reading()) clear();
  rt::Members(archive, *this, "store of images").fixed(config_).by_hand(records_, kept_).state(counts_);
  archive.bounded(kept_, capacity());
  for (std::uint32_t i = 0; i < kept_ && archive.status() == Status::ok; ++i) {
    ImageRecord& one = records_[i];
    archive.value(one.image);
    archive.value(one.pose);
    archive.value(one.stamp_ms);
    archive.value(one.robot);
    if (!archive.is_reading() || archive.status() != Status::ok) continue;
    if (!one.pose.usable()) archive.fail(Status::malformed, "an image that cannot be");
    keep(i, HeightImage{one.image}, one.pose, one.stamp_ms, one.robot);
  }
  if (archive.is_reading() && archive.status() != Status::ok) clear();
}

}  // namespace sortie::mapping
