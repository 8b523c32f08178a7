// SPDX-License-Identifier: BSD-3-Clause
// Learns the decision trees of estimators/obstacle_tree_table.hpp from drives of the plant.
#pragma once

#include <cstdint>
#include <vector>

#include "hil/random.hpp"
#include "tests/bench/modes/course_drive.hpp"
#include "tests/bench/modes/tree_growth.hpp"

namespace sortie::bench {

/// Takes drives, then grows the trees.
class Trainer {
 public:
  explicit Trainer(std::uint64_t seed) : random_(seed, 0x747265) {}

  /// Adds a drive that crossed its scene, as it was and with disturbed sensors and a geometry that is off.
  void add(const CourseScene& scene, const std::vector<CourseSample>& drive, double speed_m_s);

  /// Grows all trees and writes their files into the current folder.
  void finish();

  std::size_t steps() const { return set_.steps.size(); }

 private:
  void collect(const std::vector<CourseSample>& drive, double direction, bool disturbed, std::size_t thinned);

  hil::Random random_;
  TrainingSet set_;
};

/// Drives the scenes of these seeds and writes the tables into the current folder. Some minutes a seed and
/// some GB.
void train_modes(const std::vector<std::uint64_t>& seeds);

}  // namespace sortie::bench
