// SPDX-License-Identifier: BSD-3-Clause
// Random streams of segments and key frames, a store that takes them, and a twin that computes all from
// nothing.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>
#include <tuple>
#include <vector>

#include "mapping/grid/mix64.hpp"
#include "mapping/recognition/target_store.hpp"
#include "tests/mapping/registration_world.hpp"

namespace sortie::testing {

/// A store with its memory.
struct OwnedTargets {
  explicit OwnedTargets(const mapping::TargetStoreConfig& config)
      : memory(std::size_t{config.targets} * 200 + std::size_t{config.key_frames} * 64 + 4096),
        arena(memory),
        store(config, arena) {}
  std::vector<std::byte> memory;
  rt::Arena arena;
  mapping::TargetStore store;
};

/// One thing that happens to a store.
struct TargetEvent {
  enum Kind { key_frame, sighting, removal } kind{};
  std::uint16_t frame{};
  mapping::KeyFramePose pose;
  mapping::TargetSighting seen;
  std::uint32_t victim{};  ///< removed, where it is there
};

/// Draws events so that there are few ids, few looks and few places: everything meets everything.
class TargetDraws {
 public:
  explicit TargetDraws(std::uint64_t seed) : draws(seed) {}

  std::int32_t whole(std::int32_t low, std::int32_t high) {
    return static_cast<std::int32_t>(std::floor(draws.uniform(low, high + 1.0)));
  }
  std::uint8_t byte(std::int32_t low, std::int32_t high) {
    return static_cast<std::uint8_t>(whole(low, high));
  }
  mapping::SegmentDescriptor look() {
    mapping::SegmentDescriptor one{};
    const int kind = whole(0, 9);
    // Some are alike to the bit, some to a few steps, a few have nothing to do with any other.
    for (int i = 0; i < 24; ++i)
      one.step[i] = kind < 7 ? static_cast<std::uint8_t>(20 * kind + 3 * i) : byte(0, 255);
    if (whole(0, 2) > 0) {
      for (int i = 0; i < 24; ++i)
        one.step[i] = static_cast<std::uint8_t>(std::clamp(one.step[i] + whole(-3, 3), 0, 255));
    }
    return one;
  }
  mapping::PlaceCm place(std::int32_t within) {
    return {whole(-within, within), whole(-within, within), whole(-300, 300)};
  }
  mapping::KeyFramePose pose() {
    mapping::KeyFramePose one;
    one.place = place(1500);
    // Of the same bits everywhere: no sine. (0, 0), of all directions, leaves the heading as it is.
    const double x = draws.uniform(-1, 1), y = draws.uniform(-1, 1);
    mapping::heading_of(x, y, one.heading);
    return one;
  }
  TargetEvent event(const mapping::TargetStoreConfig& config, std::uint32_t stamp_ms) {
    TargetEvent one;
    const int kind = whole(0, 99);
    one.kind = kind < 6 ? TargetEvent::key_frame : kind < 94 ? TargetEvent::sighting : TargetEvent::removal;
    one.frame = static_cast<std::uint16_t>(whole(0, static_cast<std::int32_t>(config.key_frames) - 1));
    one.pose = pose();
    one.victim = static_cast<std::uint32_t>(whole(0, static_cast<std::int32_t>(config.targets) - 1));
    one.seen.id = static_cast<std::uint32_t>(whole(0, static_cast<std::int32_t>(2 * config.targets)));
    one.seen.robot = byte(0, 1);
    one.seen.stamp_ms = stamp_ms;
    one.seen.voxels = static_cast<std::uint32_t>(whole(100, 5000));
    one.seen.version = static_cast<std::uint16_t>(whole(0, 65535));
    one.seen.key_frame =
        static_cast<std::uint16_t>(whole(0, static_cast<std::int32_t>(config.key_frames)));  // one too many
    one.seen.offset = place(600);
    one.seen.descriptor = look();
    return one;
  }
  std::vector<TargetEvent> stream(const mapping::TargetStoreConfig& config, int events) {
    std::vector<TargetEvent> all;
    for (int i = 0; i < events; ++i)
      all.push_back(event(config, 0xfffff000u + 97u * static_cast<std::uint32_t>(i)));
    return all;
  }

  Draws draws;
};

/// What happens to the store.
inline void happens(mapping::TargetStore& store, const TargetEvent& event) {
  if (event.kind == TargetEvent::key_frame) {
    CHECK(store.set_key_frame(event.frame, event.pose) == Status::ok);
  } else if (event.kind == TargetEvent::sighting) {
    (void)store.put(event.seen);
  } else {
    store.remove(static_cast<mapping::TargetIndex>(event.victim));
  }
}

/// Steps by which two looks differ.
inline int steps_between(const mapping::SegmentDescriptor& a, const mapping::SegmentDescriptor& b) {
  int sum = 0;
  for (int i = 0; i < 24; ++i) sum += (i < 2 ? 8 : 1) * std::abs(int{a.step[i]} - int{b.step[i]});
  return sum;
}

/// The same rules in double precision, with sorted lists in the place of clever loops.
struct TargetTwin {
  struct Place {
    double x, y, z;
  };
  struct Kept {
    mapping::TargetSighting seen;
    int views{};
  };
  mapping::TargetStoreConfig config;
  std::map<int, mapping::KeyFramePose> frames;
  std::vector<std::optional<Kept>> kept;
  std::uint64_t evicted{};

  explicit TargetTwin(const mapping::TargetStoreConfig& settings)
      : config(settings), kept(settings.targets) {}

  /// Exact: the products are whole and below 2^53.
  static Place place_of(const mapping::KeyFramePose& frame, const mapping::PlaceCm& o) {
    const double c = frame.heading.cosine, s = frame.heading.sine;
    return {frame.place.x + std::floor((c * o.x - s * o.y) / 0x1p30 + 0.5),
            frame.place.y + std::floor((s * o.x + c * o.y) / 0x1p30 + 0.5), double(frame.place.z + o.z)};
  }
  Place place(const Kept& one) const { return place_of(frames.at(one.seen.key_frame), one.seen.offset); }
  static double square(const Place& a, const Place& b) {
    return (a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y) + (a.z - b.z) * (a.z - b.z);
  }

  void happens(const TargetEvent& event) {
    if (event.kind == TargetEvent::key_frame) {
      frames[event.frame] = event.pose;
    } else if (event.kind == TargetEvent::removal) {
      kept[event.victim].reset();
    } else if (frames.count(event.seen.key_frame) != 0) {
      take(event.seen);
    }
  }
  void take(const mapping::TargetSighting& seen) {
    const Place at = place_of(frames.at(seen.key_frame), seen.offset);
    std::vector<std::pair<double, std::size_t>> same;
    std::optional<std::size_t> where;
    for (std::size_t i = 0; i < kept.size(); ++i) {
      if (!kept[i] || kept[i]->seen.robot != seen.robot) continue;
      if (kept[i]->seen.id == seen.id) where = i;
      const double apart = square(place(*kept[i]), at);
      const bool alike =
          steps_between(kept[i]->seen.descriptor, seen.descriptor) <= static_cast<int>(config.same_steps);
      if (alike && apart < double(config.same_cm) * config.same_cm) same.push_back({apart, i});
    }
    std::sort(same.begin(), same.end());
    if (!where && !same.empty()) where = same.front().second;
    if (where) {
      kept[*where] = Kept{seen, kept[*where]->views + 1};
      return;
    }
    for (std::size_t i = 0; i < kept.size() && !where; ++i) {
      if (!kept[i]) where = i;
    }
    if (!where) where = given_up(at, seen.stamp_ms);
    kept[*where] = Kept{seen, 1};
  }
  std::size_t given_up(const Place& at, std::uint32_t stamp_ms) {
    using Draw = std::tuple<int, std::uint64_t, std::size_t>;
    std::vector<Draw> all;
    for (std::size_t i = 0; i < kept.size(); ++i)
      all.push_back({std::ilogb(kept[i]->views), mapping::mix64(mapping::mix64(evicted + 1) ^ i), i});
    std::sort(all.begin(), all.end());
    ++evicted;
    std::vector<std::tuple<double, double, std::size_t>> judged;
    for (std::size_t k = 0; k < all.size() && k < 8; ++k) {
      const auto& [seldom, draw, i] = all[k];
      if (seldom != std::get<0>(all[0])) break;
      double least = square(place(*kept[i]), at);
      for (std::size_t j = 0; j < kept.size(); ++j) {
        if (j != i) least = std::min(least, square(place(*kept[i]), place(*kept[j])));
      }
      judged.push_back({least, -double(stamp_ms - kept[i]->seen.stamp_ms), i});
    }
    return std::get<2>(*std::min_element(judged.begin(), judged.end()));
  }

  /// Uniqueness of one, and who is nearest to it.
  std::pair<int, int> uniqueness(std::size_t i) const {
    std::pair<int, int> least{255, mapping::kNoTarget};
    for (std::size_t j = 0; j < kept.size(); ++j) {
      if (j == i || !kept[j] ||
          square(place(*kept[i]), place(*kept[j])) <= double(config.apart_cm) * config.apart_cm)
        continue;
      const int steps = steps_between(kept[i]->seen.descriptor, kept[j]->seen.descriptor);
      if (steps < least.first) least = {steps, static_cast<int>(j)};
    }
    return least;
  }
};

}  // namespace sortie::testing
