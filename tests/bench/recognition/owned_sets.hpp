// SPDX-License-Identifier: BSD-3-Clause
// The search for sets with memory of its own, and how a run of it is timed and judged.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <vector>

#include "mapping/recognition/set_hypotheses.hpp"
#include "rt/posix/clock.hpp"
#include "tests/bench/recognition/set_peers.hpp"
#include "tests/bench/recognition/set_scenes.hpp"

namespace sortie::bench {

/// Milliseconds that this thread has had a processor.
inline double set_cpu_ms() { return 1e-6 * static_cast<double>(rt::posix::thread_cpu_now()); }

struct OwnedSets {
  std::vector<std::byte> memory;
  rt::Arena arena;
  mapping::SetHypotheses sets;

  explicit OwnedSets(std::uint32_t pairs)
      : memory(std::size_t{pairs} * (pairs / 2 + 400) + 500'000), arena(memory), sets(pairs, arena) {
    if (arena.refused() != 0) throw std::runtime_error("recognition: no room for the search");
  }

  /// Searches with at most `units`; what it chose stands in `chosen`. Gives ms.
  double search(const mapping::SetConfig& config, const SetScene& scene, std::uint64_t units,
                Chosen& chosen) {
    const double begin = set_cpu_ms();
    if (sets.begin(config, scene.pairs) != Status::ok) throw std::runtime_error("recognition: refused");
    if (!sets.run(units)) sets.stop();
    const double ms = set_cpu_ms() - begin;
    chosen.clear();
    if (!sets.found().empty()) {
      const mapping::SetHypothesis& best = sets.found()[0];
      chosen.assign(best.pairs, best.pairs + best.count);
    }
    return ms;
  }
};

/// Of what is chosen, the share that is right; of what is right, the share that is chosen.
struct ChosenShares {
  double precision{1.0};
  double recall{};
};

inline ChosenShares shares_of(const SetScene& scene, const Chosen& chosen) {
  double right = 0.0, all = 0.0;
  for (const std::uint32_t i : chosen) right += scene.right[i] ? 1.0 : 0.0;
  for (const bool is_right : scene.right) all += is_right ? 1.0 : 0.0;
  return {chosen.empty() ? 1.0 : right / static_cast<double>(chosen.size()), all > 0.0 ? right / all : 1.0};
}

}  // namespace sortie::bench
