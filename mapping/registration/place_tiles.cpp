// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/place_tiles.hpp"

#include <algorithm>
#include <bit>

namespace sortie::mapping {
namespace {
using Word = std::uint64_t;

constexpr std::int32_t poses(std::int32_t voxels, std::int32_t stride) {
  return (voxels + stride - 1) / stride;
}
/// One more before the first pose.
constexpr std::int32_t tiles(std::int32_t voxels, std::int32_t stride) {
  return (poses(voxels, stride) + 3) / 4 + 1;
}

/// Division of whole numbers that rounds down; `stride` is a power of two.
constexpr std::int32_t down(std::int32_t at, std::int32_t stride) {
  return at >> std::countr_zero(static_cast<std::uint32_t>(stride));
}

/// Three bits of one weight make one of it and one of twice the weight.
void add3(Word& high, Word& low, Word a, Word b, Word c) {
  const Word both = a ^ b;
  high = (a & b) | (both & c);
  low = both ^ c;
}

/// Counts of 64 lanes, a bit plane for each power of two.
struct Planes {
  Word plane[8]{};

  void add8(const Word (&w)[8]) {
    Word twos[2], fours[2], carry;
    add3(twos[0], plane[0], plane[0], w[0], w[1]);
    add3(twos[1], plane[0], plane[0], w[2], w[3]);
    add3(fours[0], plane[1], plane[1], twos[0], twos[1]);
    add3(twos[0], plane[0], plane[0], w[4], w[5]);
    add3(twos[1], plane[0], plane[0], w[6], w[7]);
    add3(fours[1], plane[1], plane[1], twos[0], twos[1]);
    add3(carry, plane[2], plane[2], fours[0], fours[1]);
    for (int i = 3; i < 8; ++i) {
      const Word next = plane[i] & carry;
      plane[i] ^= carry;
      carry = next;
    }
  }

  /// Eight lanes at a time: each bit of a byte of a plane goes to a byte of its own.
  void write(std::uint8_t (&counts)[64]) const {
    for (int byte = 0; byte < 8; ++byte) {
      Word sum = 0;
      for (int i = 0; i < 8; ++i) {
        const Word spread = ((plane[i] >> (8 * byte) & 0xff) * 0x0101010101010101u) & 0x8040201008040201u;
        sum += ((spread + 0x7f7f7f7f7f7f7f7fu) >> 7 & 0x0101010101010101u) << i;
      }
      for (int k = 0; k < 8; ++k) counts[8 * byte + k] = static_cast<std::uint8_t>(sum >> (8 * k));
    }
  }
};

}  // namespace

std::size_t PlaceTiles::words(const std::int32_t (&voxels)[3], std::int32_t stride) {
  const auto size = [](std::int32_t n) { return static_cast<std::size_t>(n); };
  return kKinds * size(stride * stride * stride) * size(tiles(voxels[0], stride)) *
         size(tiles(voxels[1], stride)) * size(poses(voxels[2], stride));
}

bool PlaceTiles::begin(const std::int32_t (&voxels)[3]) {
  const std::size_t needed = words(voxels, stride_);
  if (needed > words_.size()) return false;
  for (int i = 0; i < 2; ++i) tiles_[i] = tiles(voxels[i], stride_);
  high_ = poses(voxels[2], stride_);
  std::fill_n(words_.begin(), needed, Word{0});
  return true;
}

PlaceTiles::Look PlaceTiles::look(const PlaceOffset& offset) const {
  std::int32_t first[3], rest[3];
  for (int i = 0; i < 3; ++i) {
    const std::int32_t at = kMargin + offset.at[i];
    first[i] = down(at, stride_);
    rest[i] = at - first[i] * stride_;
  }
  Look look;
  const std::int32_t of_class = (rest[2] * stride_ + rest[1]) * stride_ + rest[0];
  look.base = static_cast<std::uint32_t>(kKinds * of_class * tiles_[0] * tiles_[1] * high_);
  for (int i = 0; i < 2; ++i) look.tile[i] = static_cast<std::int16_t>(down(first[i], 4) + 1);
  look.tile[2] = static_cast<std::int16_t>(first[2]);
  look.shift = static_cast<std::uint8_t>((first[1] & 3) * 8 + (first[0] & 3));
  return look;
}

void PlaceTiles::set(int kind, std::int32_t x, std::int32_t y, std::int32_t z) {
  const std::int32_t at[3] = {x, y, z};
  std::int32_t pose[3], rest[3];
  for (int i = 0; i < 3; ++i) {
    pose[i] = down(at[i], stride_);
    rest[i] = at[i] - pose[i] * stride_;
  }
  const std::int32_t of_class = (rest[2] * stride_ + rest[1]) * stride_ + rest[0];
  // In the tile that begins at or before it, and in the one before that.
  for (std::int32_t ty = down(pose[1], 4); ty <= down(pose[1], 4) + 1; ++ty) {
    for (std::int32_t tx = down(pose[0], 4); tx <= down(pose[0], 4) + 1; ++tx) {
      const std::int32_t i = pose[0] - 4 * (tx - 1);
      const std::int32_t k = pose[1] - 4 * (ty - 1);
      const std::int32_t word = ((of_class * tiles_[1] + ty) * tiles_[0] + tx) * high_ + pose[2];
      words_[static_cast<std::size_t>(kKinds * word + kind)] |= Word{1} << (8 * k + i);
    }
  }
}

/// The bits of the block's 64 poses, of both kinds. They lie in one line of the cache.
void PlaceTiles::bits(const Look& look, const std::int32_t (&block)[3], Word& near, Word& on) const {
  const std::int32_t tx = look.tile[0] + block[0];
  const std::int32_t ty = look.tile[1] + block[1];
  const std::int32_t z = look.tile[2] + 4 * block[2];
  near = on = 0;
  if (static_cast<std::uint32_t>(tx) >= static_cast<std::uint32_t>(tiles_[0]) ||
      static_cast<std::uint32_t>(ty) >= static_cast<std::uint32_t>(tiles_[1]))
    return;
  constexpr Word kFour = 0x0f0f0f0f;
  const Word* const column =
      words_.data() + look.base + static_cast<std::ptrdiff_t>(kKinds * (ty * tiles_[0] + tx) * high_);
  const auto four = [&](const Word* w, int i) { return w[kKinds * i] >> look.shift & kFour; };
  if (z >= 0 && z + 3 < high_) {
    const Word* const w = column + static_cast<std::ptrdiff_t>(kKinds * z);
    near = four(w, 0) | four(w, 1) << 4 | (four(w, 2) | four(w, 3) << 4) << 32;
    on = four(w + 1, 0) | four(w + 1, 1) << 4 | (four(w + 1, 2) | four(w + 1, 3) << 4) << 32;
    return;
  }
  constexpr int kAt[4] = {0, 4, 32, 36};
  for (int i = 0; i < 4; ++i) {
    if (z + i < 0 || z + i >= high_) continue;
    near |= four(column, z + i) << kAt[i];
    on |= four(column + 1, z + i) << kAt[i];
  }
}

void PlaceTiles::count(std::span<const Look> looks, const std::int32_t (&block)[3],
                       std::uint8_t (&counts)[kLanes]) const {
  Planes planes;
  Word w[8];
  std::size_t at = 0;
  for (; at + 4 <= looks.size(); at += 4) {
    for (std::size_t i = 0; i < 4; ++i) bits(looks[at + i], block, w[2 * i], w[2 * i + 1]);
    planes.add8(w);
  }
  for (std::size_t i = 0; i < 4; ++i) {
    w[2 * i] = w[2 * i + 1] = 0;
    if (at + i < looks.size()) bits(looks[at + i], block, w[2 * i], w[2 * i + 1]);
  }
  planes.add8(w);
  planes.write(counts);
}

}  // namespace sortie::mapping
