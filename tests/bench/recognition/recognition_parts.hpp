// SPDX-License-Identifier: BSD-3-Clause
// The parts of the recognition's benchmark; what each of them says goes into one report.
#pragma once

#include <cstdint>
#include <string>

#include "tests/bench/report/figures.hpp"

namespace sortie::bench {

/// What a run is asked for.
struct RecognitionSettings {
  int cases{};  ///< 0: as many as the part takes by itself
  std::uint64_t seed{1};
  std::string data;  ///< folder of the recorded data
  int cases_or(int usual) const { return cases > 0 ? cases : usual; }
};

/// Consistent sets beside PCL's grouping: correspondences of a drive through streets.
void measure_recognition_streets(const RecognitionSettings& settings, Report& report);
/// Consistent sets beside a dense cluster (CLIPPER) and the densest core (ROBIN), by share of wrong ones.
void measure_recognition_outliers(const RecognitionSettings& settings, Report& report);
/// Any graph: dense ones with a planted set, by units.
void measure_recognition_graphs(const RecognitionSettings& settings, Report& report);
/// What segments of two visits of made-up halls are told apart by: the 24 bytes beside the seven features.
void measure_recognition_descriptors(const RecognitionSettings& settings, Report& report);
/// What places of two visits are told apart by: segments that agree, beside SOLiD and density images.
void measure_recognition_places(const RecognitionSettings& settings, Report& report);
/// Worlds that are built to deceive: how many places are told that are none.
void measure_recognition_deceive(const RecognitionSettings& settings, Report& report);
/// Halls that are visited twice: how many are recognised, after which way, by the size of the local map.
void measure_recognition_revisits(const RecognitionSettings& settings, Report& report);
/// How long a segment must be at rest before it speaks: halls that are recognised, and false places.
void measure_recognition_rest(const RecognitionSettings& settings, Report& report);
/// What a scan has to say before it is believed: false places and right ones, by `over_unexplained`.
void measure_recognition_evidence(const RecognitionSettings& settings, Report& report);
/// A recorded lidar, cut into two visits: what the second one recognises of the first.
void measure_recognition_visits(const RecognitionSettings& settings, Report& report);
/// Long recorded drives through made-up towns: precision and recall where the way comes back.
void measure_recognition_loops(const RecognitionSettings& settings, Report& report);
/// Recall and false places over run time: units, candidates, targets, gravity and others, one at a time.
void measure_recognition_sweep(const RecognitionSettings& settings, Report& report);
/// Corridors and empty halls: what height images say of them, beside segments.
void measure_recognition_images(const RecognitionSettings& settings, Report& report);

}  // namespace sortie::bench
