// SPDX-License-Identifier: BSD-3-Clause
// Height images as bytes that are kept from one run to another.
//
// Little endian: head, images (KeptImage), xxhash64 of all before it.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/recognition/image_store.hpp"
#include "rt/describe.hpp"

namespace sortie::mapping {

/// What stands before the images. 24 bytes.
struct ImageFileHead {
  static constexpr std::uint64_t kMagic = 0x534547414d494f53;  ///< "SOIMAGES"
  static constexpr std::uint32_t kVersion = 1;
  std::uint64_t magic{kMagic};
  std::uint32_t version{kVersion};
  std::uint32_t cells{ImagePlane::kCells};  ///< of an image, along x and along y
  std::uint32_t cell_cm{HeightImage::kCellCm};
  std::uint32_t images{};
  SORTIE_FIELDS(magic, version, cells, cell_cm, images)
};

/// What is kept of an ImageRecord. 6,169 bytes.
struct KeptImage {
  KeyFramePose pose;
  std::uint32_t stamp_ms{};
  std::uint8_t robot{};
  ImagePlane floor;
  ImagePlane low;
  ImagePlane high;
  SORTIE_FIELDS(pose, stamp_ms, robot, floor, low, high)
};

/// Why images cannot be taken.
enum class ImageFileFault : std::uint8_t {
  none = 0,
  no_images,  ///< other bytes
  version,    ///< of another version of the format, or of other cells
  length,     ///< cut off, or something behind it
  checksum,   ///< damaged
  image,      ///< one whose pose cannot be
  room        ///< there is no room for `head.images`
};

/// The fault in a few words.
const char* to_string(ImageFileFault fault);

/// What became of loading images.
struct ImageFileResult {
  ImageFileFault fault{ImageFileFault::none};
  std::uint64_t byte{};  ///< where, of an image
  ImageFileHead head;    ///< as far as it was read
};

/// Bytes of a store's images.
std::uint64_t image_file_bytes(const ImageStore& store);
/// Writes images; full where `out` is shorter than image_file_bytes(). The same images in the same order, the
/// same bytes.
Status write_images(const ImageStore& store, std::span<std::uint8_t> out);

/// Whether bytes are a whole file of images, and how many it has.
ImageFileResult read_image_head(std::span<const std::uint8_t> bytes);
/// Puts kept images in the place of the store's, or leaves that empty and says why not. Nothing in the bytes
/// is trusted. For set-up. No heap.
ImageFileResult load_images(std::span<const std::uint8_t> bytes, ImageStore& store);

}  // namespace sortie::mapping
