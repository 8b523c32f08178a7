// SPDX-License-Identifier: BSD-3-Clause
// One self-contained page about one run: opens anywhere, prints well, needs no script and no network.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "firmware_like/result/results.hpp"
#include "toolchain/judge/evaluate.hpp"
#include "toolchain/judge/ray_figures.hpp"
#include "toolchain/report/recognised_places.hpp"
#include "toolchain/report/svg.hpp"

namespace sortie::toolchain {

/// A table of figures with a head line of its own.
struct FigureTable {
  std::string title;
  std::vector<FigureRow> rows;
};

/// Error over run time of one knob or several: a plot, and its figures as text, a row a cell.
struct SweepFigures {
  Plot plot;
  std::vector<std::string> head;
  std::vector<std::vector<std::string>> rows;
  std::string note;
};

/// What the page tells. Everything but `results` may be left empty; then its section is left out.
struct ReportInput {
  firmware::Results results;
  std::string command;                        ///< what was typed
  std::string source;                         ///< log or data set
  std::string alignment;                      ///< name of the alignment before errors
  std::vector<firmware::TimedPose> estimate;  ///< aligned, all samples
  std::vector<firmware::TimedPose> truth;
  std::vector<firmware::TimedPose> located;  ///< on the map that the robot made, aligned
  std::vector<ErrorSample> errors;
  std::vector<FigureTable> tables;  ///< before the plots
  std::vector<SweepFigures> sweeps;
  RecognisedReport recognised;   ///< on a known map; without answers: not shown
  Plot timeline;                 ///< run time over time; without series: not shown
  std::vector<Plot> more_plots;  ///< of any task output; shown at the end
};

/// Moves the paths of a run or a replay into `report`: aligned where there is a truth, else as they are.
template <class Outcome>
void add_paths(ReportInput& report, Outcome& outcome, Evaluation& evaluation) {
  const auto path = [](PairedTrajectories& aligned, firmware::Trajectory& plain) {
    return aligned.estimate.empty() ? std::move(plain) : std::move(aligned.estimate);
  };
  report.truth = std::move((evaluation.pairs.truth.empty() ? evaluation.located : evaluation.pairs).truth);
  report.estimate = path(evaluation.pairs, outcome.estimate);
  report.located = path(evaluation.located, outcome.located);
  report.errors = std::move(evaluation.series);
}

/// The page, as XHTML-conforming HTML 5. Cost: linear in the input; size bounded by the number of plots.
std::string render_report(const ReportInput& input);

/// The same of several runs on one page: a table of them all, one picture of where they went, then each run.
/// The picture's ground is `ground`, a map that any of them made; it may be empty.
std::string render_report(const std::vector<ReportInput>& inputs, const Plot& ground);

}  // namespace sortie::toolchain
