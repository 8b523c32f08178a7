// SPDX-License-Identifier: BSD-3-Clause
#include "planner/uav_path/corners.hpp"

#include <algorithm>
#include <limits>

#include "planner/uav_path/sight.hpp"

namespace sortie::planner {
namespace {

std::int32_t sign(std::int32_t d) { return d > 0 ? 1 : d < 0 ? -1 : 0; }

// On from b to c is the way that led from a to b: one of 26 directions, in whole steps.
bool goes_on(const Voxel3& a, const Voxel3& b, const Voxel3& c) {
  const std::int32_t span = std::max({std::abs(b.x - a.x), std::abs(b.y - a.y), std::abs(b.z - a.z)});
  return b.x - a.x == span * sign(c.x - b.x) && b.y - a.y == span * sign(c.y - b.y) &&
         b.z - a.z == span * sign(c.z - b.z);
}

}  // namespace

void Corners::begin() {
  source_ = 0;
  rounds_ = 0;
  sampled_ = false;
  last_length_ = std::numeric_limits<float>::infinity();
}

// A voxel behind the last; a straight run keeps its two ends alone.
bool Corners::append(const Voxel3& v) {
  auto& points = memory_.points;
  if (count_ >= 2 && goes_on(points[count_ - 2], points[count_ - 1], v)) {
    points[count_ - 1] = v;
    return true;
  }
  if (count_ == points.size()) return false;
  points[count_++] = v;
  return true;
}

Status Corners::take(const FineSearch& fine) {
  begin();
  count_ = 0;
  for (std::uint32_t slot = fine.first(); slot != kNoNode; slot = fine.before(slot)) {
    if (!append(fine.voxel(slot))) return Status::full;
  }
  const auto known = memory_.points.first(count_);
  std::reverse(known.begin(), known.end());
  return Status::ok;
}

Status Corners::crawl(const FlightMap& map, const CoarseSearch& coarse, const Voxel3& start,
                      const Voxel3& goal) {
  begin();
  count_ = 0;
  BrickMask waves[64];  // a part has 64 voxels at the most
  Voxel3 at = start;
  if (!append(at)) return Status::full;
  for (std::uint32_t n = coarse.node_of(map, start); n != kNoNode; n = coarse.node(n).next) {
    const PathNode& part = coarse.node(n);
    const std::uint32_t next = part.next;
    int dx = 0;
    int dy = 0;
    int dz = 0;
    BrickMask aim = brick_bit(goal);
    if (next != kNoNode) {
      const Voxel3 here = map.corner_of(part.brick);
      const Voxel3 there = map.corner_of(coarse.node(next).brick);
      dx = (there.x - here.x) / 4;
      dy = (there.y - here.y) / 4;
      dz = (there.z - here.z) / 4;
      aim = brick_reach(coarse.node(next).voxels, -dx, -dy, -dz) & part.voxels;  // one step leads over
    }
    // Waves from where we are until one touches the aim, then back along them.
    int last = 0;
    waves[0] = brick_bit(at);
    BrickMask seen = waves[0];
    while ((seen & aim) == 0 && last < 63) {
      const BrickMask grown = brick_reach(waves[last], 0, 0, 0) & part.voxels & ~seen;
      if (grown == 0) return Status::malformed;
      seen |= grown;
      waves[++last] = grown;
    }
    BrickMask chain[64];
    chain[last] = lowest_voxel(waves[last] & aim);
    for (int i = last; i > 0; --i) chain[i - 1] = lowest_voxel(brick_reach(chain[i], 0, 0, 0) & waves[i - 1]);
    const auto put = [&](BrickMask bit, std::uint32_t brick) {
      at = brick_voxel(map.corner_of(brick), std::countr_zero(bit));
      return append(at);
    };
    for (int i = 1; i <= last; ++i) {
      if (!put(chain[i], part.brick)) return Status::full;
    }
    if (next == kNoNode) break;
    const BrickMask over = brick_reach(chain[last], dx, dy, dz) & coarse.node(next).voxels;
    if (!put(lowest_voxel(over), coarse.node(next).brick)) return Status::full;
  }
  return Status::ok;
}

float Corners::length() const {
  float sum = 0.0f;
  for (std::uint32_t i = 1; i < count_; ++i)
    sum += distance(to_point(memory_.points[i - 1]), to_point(memory_.points[i]));
  return sum;
}

bool Corners::shorten(const FlightMap& map, std::uint64_t& units) {
  while (rounds_ < kMostRounds && units > 0) {
    if (source_ == 0) {
      if (!sampled_ && rounds_ > 0) resample(map, units);
      sampled_ = true;
      std::fill_n(memory_.lengths.begin(), count_, std::numeric_limits<float>::infinity());
      memory_.lengths[0] = 0.0f;
    }
    while (source_ + 1 < count_ && units > 0) connect(map, source_++, units);
    if (source_ + 1 < count_) return false;
    keep_chain();
    source_ = 0;
    sampled_ = false;
    ++rounds_;
    const float now = length();
    if (rounds_ > 1 && !(now < last_length_ * 0.9995f)) rounds_ = kMostRounds;
    last_length_ = now;
  }
  return rounds_ >= kMostRounds;
}

// Lines from point i to later ones: to each of the next 16, then with growing gaps.
void Corners::connect(const FlightMap& map, std::uint32_t i, std::uint64_t& units) {
  const Voxel3& from = memory_.points[i];
  std::uint32_t gap = 1;
  for (std::uint32_t j = i + 1; j < count_; j += gap) {
    if (j - i > 16) gap = std::max(1u, (j - i) / 8);
    const Voxel3& to = memory_.points[j];
    const float sum = memory_.lengths[i] + distance(to_point(from), to_point(to));
    if (!(sum < memory_.lengths[j])) continue;
    if (j > i + 1) {
      const std::uint64_t steps = line_steps(from, to);
      units -= std::min(units, steps);
      if (!line_is_free(map, from, to)) continue;
    }
    memory_.lengths[j] = sum;
    memory_.before[j] = i;
  }
}

// The shortest chain that was found takes the place of the points.
void Corners::keep_chain() {
  std::uint32_t kept = 0;
  for (std::uint32_t i = count_ - 1;; i = memory_.before[i]) {
    memory_.lengths[kept++] = static_cast<float>(i);  // indices, last first; exact below 2^24
    if (i == 0) break;
  }
  for (std::uint32_t k = 0; k < kept; ++k)
    memory_.points[k] = memory_.points[static_cast<std::uint32_t>(memory_.lengths[kept - 1 - k])];
  count_ = kept;
}

// New points on the lines, where they see both ends.
void Corners::resample(const FlightMap& map, std::uint64_t& units) {
  auto& points = memory_.points;
  const std::uint32_t corners = count_;
  if (2 * corners + kResampled > points.size()) return;
  // The corners move to the end of the memory, and come back one by one with new points between.
  const auto tail = static_cast<std::uint32_t>(points.size()) - corners;
  const auto first = points.first(corners);
  std::copy_backward(first.begin(), first.end(), points.end());
  const float step = std::max(
      1.0f, last_length_ / static_cast<float>(kResampled - corners / 2 > 64 ? kResampled - corners / 2 : 64));
  count_ = 0;
  for (std::uint32_t k = 0; k + 1 < corners; ++k) {
    const Voxel3 a = points[tail + k];
    const Voxel3 b = points[tail + k + 1];
    points[count_++] = a;
    const auto pieces = static_cast<std::int32_t>(distance(to_point(a), to_point(b)) / step);
    for (std::int32_t i = 1; i < pieces; ++i) {
      const auto between = [i, pieces](std::int32_t from, std::int32_t to) {  // rounded to the nearest
        const std::int32_t twice = 2 * i * (to - from) + pieces;
        return from + (twice >= 0 ? twice / (2 * pieces) : -((-twice + 2 * pieces - 1) / (2 * pieces)));
      };
      const Voxel3 c{between(a.x, b.x), between(a.y, b.y), between(a.z, b.z)};
      const bool room = count_ + (corners - k) < tail + k;
      if (room) units -= std::min<std::uint64_t>(units, line_steps(points[count_ - 1], c) + line_steps(c, b));
      if (room && line_is_free(map, points[count_ - 1], c) && line_is_free(map, c, b)) points[count_++] = c;
    }
  }
  points[count_++] = points[tail + corners - 1];
}

}  // namespace sortie::planner
