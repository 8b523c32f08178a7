// SPDX-License-Identifier: BSD-3-Clause
// Greedy choice of rays and its certificate, word by word: every ray is written down, every choice looks at
// all of them, and the table of coverage is a set of numbers. Shares the voxel walk and the probabilities of
// cells with the scheduler, and nothing else.
#pragma once

#include <algorithm>
#include <cstdint>
#include <set>
#include <vector>

#include "planner/ray_scheduler.hpp"

namespace sortie::tests {

/// A task with all its rays. Rows: position * N + ray.
class RayTwin {
 public:
  RayTwin(const planner::RayScheduler& scheduler, const mapping::OccupancyView& map,
          const std::vector<mapping::SensorPose>& poses)
      : positions_(scheduler.plan().positions),
        rays_(scheduler.config().sensor.rays()),
        per_position_(std::min(scheduler.config().rays, rays_)),
        cells_(static_cast<std::size_t>(map.cell_count())) {
    const planner::RayModel& model = scheduler.model();
    row_.resize(std::size_t{positions_} * rays_);
    for (std::uint32_t p = 0; p < positions_; ++p) {
      if (!map.contains(map.to_window(poses[p].p_world_sensor_m))) continue;
      for (std::uint32_t j = 0; j < rays_; ++j) {
        mapping::VoxelWalk walk = scheduler.walk(p, j);
        double visible = 1;
        do {
          const std::uint32_t code = mapping::cell_code(map.cells[walk.index]);
          row_[p * rays_ + j].push_back({walk.index, visible * model.probability(code), model.entropy(code)});
          visible *= model.passes(code);
        } while (visible >= model.config().least_visible && walk.step());
      }
    }
  }

  std::size_t size() const { return row_.size(); }

  /// What rows are worth together, in double.
  double worth(const std::vector<std::size_t>& rows) const {
    std::vector<double> left(cells_, 1.0);
    double sum = 0;
    for (const std::size_t row : rows) sum += enter(row, left);
    return sum;
  }

  /// A choice, and whether a table of so many lines ended it.
  struct Choice {
    std::vector<std::size_t> rows;
    bool refused{};
  };
  /// The ray that adds most as a float, ties to the lower row, until nothing adds anything or there is no
  /// room for the best: 16 cells are a line, and a ray asks for one wherever it comes into one that is not
  /// there.
  Choice greedy(std::size_t lines) const {
    Choice choice;
    std::vector<float> left(cells_, 1.0f);
    std::set<std::uint32_t> taken;
    std::vector<bool> chosen(row_.size());
    std::vector<std::uint32_t> room(positions_, per_position_);
    for (;;) {
      float best = 0;
      std::size_t which = row_.size();
      for (std::size_t row = 0; row < row_.size(); ++row) {
        if (chosen[row] || room[row / rays_] == 0) continue;
        const float adds = added(row, left);
        if (adds > best) {
          best = adds;
          which = row;
        }
      }
      if (which == row_.size()) return choice;
      std::size_t asked = 0;
      std::uint32_t before = UINT32_MAX;
      for (const Seen& seen : row_[which]) {
        if (seen.cell / 16 != before && taken.count(seen.cell / 16) == 0) ++asked;
        before = seen.cell / 16;
      }
      if (taken.size() + asked > lines) {
        choice.refused = true;
        return choice;
      }
      double shown = 0;
      for (std::size_t i = row_[which].size(); i-- > 0;) {
        const Seen& seen = row_[which][i];
        shown += seen.ends_here;
        if (!(shown > 1e-8)) continue;
        taken.insert(seen.cell / 16);
        left[seen.cell] = static_cast<float>(static_cast<double>(left[seen.cell]) * (1.0 - shown));
      }
      chosen[which] = true;
      --room[which / rays_];
      choice.rows.push_back(which);
    }
  }

  /// No plan is worth more: what rows are worth, and the K most that others add beside them, by position.
  double bound(const std::vector<std::size_t>& rows) const {
    std::vector<double> left(cells_, 1.0);
    double sum = 0;
    for (const std::size_t row : rows) sum += enter(row, left);
    for (std::uint32_t p = 0; p < positions_; ++p) {
      std::vector<double> adds;
      for (std::size_t row = std::size_t{p} * rays_; row < std::size_t{p + 1} * rays_; ++row) {
        const bool is_in = std::find(rows.begin(), rows.end(), row) != rows.end();
        adds.push_back(is_in ? 0.0 : beside(row, left));
      }
      std::sort(adds.rbegin(), adds.rend());
      for (std::uint32_t i = 0; i < per_position_; ++i) sum += adds[i];
    }
    return sum;
  }

  /// The worth of the best plan of all; 0 where there are more than some thousand.
  double best_of_all() const {
    if (rays_ > 7) return 0;
    std::vector<std::uint32_t> subsets;
    for (std::uint32_t mask = 0; mask < (1u << rays_); ++mask) {
      if (static_cast<std::uint32_t>(__builtin_popcount(mask)) == per_position_) subsets.push_back(mask);
    }
    std::size_t plans = 1;
    for (std::uint32_t p = 0; p < positions_; ++p) plans *= subsets.size();
    if (plans > 2000) return 0;
    double best = 0;
    for (std::size_t plan = 0; plan < plans; ++plan) {
      std::vector<std::size_t> rows;
      std::size_t rest = plan;
      for (std::uint32_t p = 0; p < positions_; ++p, rest /= subsets.size()) {
        for (std::uint32_t j = 0; j < rays_; ++j) {
          if ((subsets[rest % subsets.size()] >> j & 1u) != 0) rows.push_back(std::size_t{p} * rays_ + j);
        }
      }
      best = std::max(best, worth(rows));
    }
    return best;
  }

 private:
  struct Seen {
    std::uint32_t cell;
    double ends_here;
    double entropy;
  };

  // What a row adds: it shows each cell with the probability that the ray ends in it or behind.
  double beside(std::size_t row, const std::vector<double>& left) const {
    double shown = 0;
    double sum = 0;
    for (std::size_t i = row_[row].size(); i-- > 0;) {
      shown += row_[row][i].ends_here;
      sum += row_[row][i].entropy * left[row_[row][i].cell] * shown;
    }
    return sum;
  }
  // The same, and it is entered.
  double enter(std::size_t row, std::vector<double>& left) const {
    const double sum = beside(row, left);
    double shown = 0;
    for (std::size_t i = row_[row].size(); i-- > 0;) {
      shown += row_[row][i].ends_here;
      left[row_[row][i].cell] *= 1 - shown;
    }
    return sum;
  }

  // The scheduler's order of operations: where rays are alike, the last bit decides.
  float added(std::size_t row, const std::vector<float>& left) const {
    double entropy = 0;
    double sum = 0;
    for (const Seen& seen : row_[row]) {
      entropy += seen.entropy * static_cast<double>(left[seen.cell]);
      sum += seen.ends_here * entropy;
    }
    return static_cast<float>(sum);
  }

  std::uint32_t positions_;
  std::uint32_t rays_;
  std::uint32_t per_position_;
  std::size_t cells_;
  std::vector<std::vector<Seen>> row_;
};

}  // namespace sortie::tests
