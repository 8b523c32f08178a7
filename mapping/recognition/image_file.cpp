// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/recognition/image_file.hpp"

#include "rt/digest.hpp"

namespace sortie::mapping {
namespace {

constexpr std::size_t kImageHeadBytes = rt::canonical_size<ImageFileHead>();
constexpr std::size_t kImageBytes = rt::canonical_size<KeptImage>();
constexpr std::size_t kImageCheckBytes = 8;
static_assert(kImageHeadBytes == 24 && kImageBytes == 6169);

/// No sum overflows: a count has 32 bits.
std::uint64_t bytes_of(const ImageFileHead& head) {
  return kImageHeadBytes + std::uint64_t{kImageBytes} * head.images + kImageCheckBytes;
}

ImageFileHead head_of(const ImageStore& store) {
  ImageFileHead head;
  head.images = static_cast<std::uint32_t>(store.images().size());
  return head;
}

}  // namespace

const char* to_string(ImageFileFault fault) {
  switch (fault) {
    case ImageFileFault::none:
      return "none";
    case ImageFileFault::no_images:
      return "not a file of images";
    case ImageFileFault::version:
      return "of another version";
    case ImageFileFault::length:
      return "cut off, or too long";
    case ImageFileFault::checksum:
      return "damaged";
    case ImageFileFault::image:
      return "an image whose pose cannot be";
    case ImageFileFault::room:
      return "more images than there is room for";
  }
  return "unknown fault";
}

std::uint64_t image_file_bytes(const ImageStore& store) { return bytes_of(head_of(store)); }

Status write_images(const ImageStore& store, std::span<std::uint8_t> out) {
  ImageFileHead head = head_of(store);
  if (out.size() < bytes_of(head)) return Status::full;
  rt::Archive archive = rt::Archive::writing(out);
  archive.value(head);
  for (const ImageRecord& record : store.images()) {
    KeptImage one{record.pose,        record.stamp_ms,  record.robot,
                  record.image.floor, record.image.low, record.image.high};
    archive.value(one);
  }
  std::uint64_t check = rt::digest_bytes(out.data(), static_cast<std::size_t>(archive.bytes()));
  archive.value(check);
  return archive.status();
}

ImageFileResult read_image_head(std::span<const std::uint8_t> bytes) {
  ImageFileResult result;
  rt::Archive archive = rt::Archive::reading(bytes);
  archive.value(result.head);
  const ImageFileHead& head = result.head;
  const ImageFileHead own;
  const auto refused = [&result](ImageFileFault fault) {
    result.fault = fault;
    return result;
  };
  if (head.magic != own.magic) return refused(ImageFileFault::no_images);
  if (archive.status() != Status::ok) return refused(ImageFileFault::length);
  if (head.version != own.version || head.cells != own.cells || head.cell_cm != own.cell_cm)
    return refused(ImageFileFault::version);
  if (bytes_of(head) != bytes.size()) return refused(ImageFileFault::length);
  const std::size_t body = bytes.size() - kImageCheckBytes;
  rt::Archive tail = rt::Archive::reading(bytes.subspan(body));
  std::uint64_t check = 0;
  tail.value(check);
  if (check != rt::digest_bytes(bytes.data(), body)) return refused(ImageFileFault::checksum);
  return result;
}

ImageFileResult load_images(std::span<const std::uint8_t> bytes, ImageStore& store) {
  store.clear();
  ImageFileResult result = read_image_head(bytes);
  if (result.fault != ImageFileFault::none) return result;
  if (result.head.images > store.capacity()) {
    result.fault = ImageFileFault::room;
    return result;
  }
  rt::Archive archive = rt::Archive::reading(bytes.subspan(kImageHeadBytes));
  HeightImage image;
  for (std::uint32_t i = 0; i < result.head.images; ++i) {
    KeptImage one;
    result.byte = kImageHeadBytes + archive.bytes();
    archive.value(one);
    image.floor = one.floor;
    image.low = one.low;
    image.high = one.high;
    if (store.take(image, one.pose, one.stamp_ms, one.robot) == Status::ok) continue;
    result.fault = ImageFileFault::image;
    store.clear();
    return result;
  }
  result.byte = 0;
  return result;
}

}  // namespace sortie::mapping
