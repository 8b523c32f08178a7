// SPDX-License-Identifier: BSD-3-Clause
// The height images that robots have made along their ways: a store of fixed size.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/recognition/image_points.hpp"
#include "mapping/recognition/key_frame.hpp"
#include "rt/archive.hpp"
#include "rt/arena.hpp"
#include "rt/keys.hpp"
#include "rt/status.hpp"

namespace sortie::mapping {

/// Settings of a store of images.
struct ImageStoreConfig {
  static constexpr std::uint32_t kMostImages = 512;

  std::uint32_t images{128};   ///< at most kMostImages
  std::int32_t apart_cm{300};  ///< an image nearer to a kept one takes its place, or is left out

  SORTIE_KEYS(c, key) {
    key("limits.images", c.images, {1, kMostImages, "images", "that are kept to be recognised; 6.3 kB each"});
    key("apart_cm", c.apart_cm,
        {0, 10'000, "cm", "an image nearer to a kept one takes its place, or is left out"});
  }
};

/// A kept image. It is a key frame of its own: a loop closure moves `pose`, and nothing else.
struct ImageRecord {
  HeightImage image;      ///< its own `middle` is nothing
  KeyFramePose pose;      ///< of its middle on the floor, and of its axes, in the map
  std::uint32_t cells{};  ///< with structure; follows from `image`
  std::uint32_t stamp_ms{};
  std::uint8_t robot{};
};

/// What became of images that were put into a store.
struct ImageCounts {
  std::uint64_t added{};
  std::uint64_t renewed{};  ///< took the place of one nearby
  std::uint64_t known{};    ///< left out: there is one nearby that shows about as much
  std::uint64_t evicted{};  ///< made room for another one
  std::uint64_t refused{};  ///< a pose that cannot be, or no room at all
  SORTIE_FIELDS(added, renewed, known, evicted, refused)
};

/// A fixed number of images. One that lies within apart_cm of a kept one and 1.5 m of its height is that
/// place again: it takes the other one's place where it shows an eighth more structure, else it is left out.
/// A full store gives up the image that is nearest to another one or to the new one; of as many the one that
/// shows less, then the lower number. What is kept depends on what was put in alone. Cost: a look at each
/// record, two by two where one is given up. Memory: 6.3 kB an image. No heap.
class ImageStore {
 public:
  static constexpr std::int32_t kStoreyCm = 150;

  /// Without room for all of it in `arena` it takes nothing.
  ImageStore(const ImageStoreConfig& config, rt::Arena& arena);

  /// An image, and where its middle and its axes are in the map. out_of_range: a pose that is not usable.
  /// Cost: a look at each image; where all room is taken, at each pair.
  Status put(const HeightImage& image, const KeyFramePose& pose, std::uint32_t stamp_ms, std::uint8_t robot);
  /// As it was kept, behind all others. out_of_range as put(); full.
  [[nodiscard]] Status take(const HeightImage& image, const KeyFramePose& pose, std::uint32_t stamp_ms,
                            std::uint8_t robot);
  /// An image has moved. out_of_range: no such image, or a pose that is not usable.
  [[nodiscard]] Status set_pose(std::uint32_t image, const KeyFramePose& pose);

  std::span<const ImageRecord> images() const { return records_.first(kept_); }
  std::uint32_t capacity() const { return static_cast<std::uint32_t>(records_.size()); }
  const ImageCounts& counts() const { return counts_; }
  void clear();
  /// Everything. Bytes that are no store's leave it empty.
  void archive(rt::Archive& archive);

 private:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  void keep(std::uint32_t at, const HeightImage& image, const KeyFramePose& pose, std::uint32_t stamp_ms,
            std::uint8_t robot);
  std::uint32_t near_to(const PlaceCm& place) const;
  std::uint32_t evicted_for(const PlaceCm& place) const;

  ImageStoreConfig config_;
  std::span<ImageRecord> records_;
  std::uint32_t kept_{};
  ImageCounts counts_;
};

}  // namespace sortie::mapping
