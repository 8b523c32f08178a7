// SPDX-License-Identifier: BSD-3-Clause
// Where the height image of a local map lies on kept ones, or that it does not say.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/recognition/image_hypothesis.hpp"
#include "mapping/recognition/image_peaks.hpp"
#include "mapping/recognition/image_store.hpp"
#include "mapping/registration/unit_credit.hpp"
#include "rt/archive.hpp"

namespace sortie::mapping {

/// Compares an image with all kept ones. First at 64 turns and all shifts
/// of 0.4 m, by how many of its cells lie near structure; then at the best turns of all images, each to 0.7
/// degrees, at all shifts of 0.2 m, and cells that lie on free floor count twice against. The best places of
/// these, each a metre or 10 degrees from the others, are moved by single cells and turns as long as they
/// get better, now with the floor that is free here and not there and with low and high structure apart.
/// Where the best one lies, the structure of either image has to agree wherever the other one shows anything,
/// and no other place of any image may score about as much.
///
/// Whole numbers; the same image and the same store give the same answer, and a budget only says when. Needs
/// neither a guess nor training. A unit is some 0.5 ns; no step costs more than kMostStep units. Memory: 85
/// kB. No heap.
class ImageSearch {
 public:
  static constexpr std::uint32_t kMost = 8;  ///< places in found()
  static constexpr std::uint32_t kMostStep = 270'000;

  explicit ImageSearch(const ImageSearchConfig& config);

  /// Begins a search; what was found before is gone.
  void begin(const HeightImage& image);
  /// Goes on for at most `units` and a step, takes what it used off. True: there is an answer. The same store
  /// until then.
  bool run(const ImageStore& store, std::uint64_t& units);
  bool is_searching() const { return step_ != Step::done; }
  /// The best place is not it, somebody who looked says: what is left is judged without it, which is a
  /// step of kMostStep.
  void refuse(const ImageStore& store);

  ImageVerdict verdict() const { return verdict_; }
  /// Places, the best one first; none while it goes on.
  std::span<const ImageHypothesis> found() const { return {found_, is_searching() ? 0 : found_count_}; }
  /// Where narrow: along which direction of the known map the place can be moved.
  const Heading& flat() const { return flat_; }
  /// Cells with structure that were searched with.
  std::uint32_t cells() const { return static_cast<std::uint32_t>(points_.standing().size()); }
  const ImageSearchCounts& counts() const { return counts_; }
  const ImageSearchConfig& config() const { return config_; }

  /// Between two calls. A search is kept as what it began with and what it has spent: it is begun anew and
  /// spends that again, which needs the store it was asked with. On one that has changed since it may end
  /// otherwise.
  void archive(rt::Archive& archive, const ImageStore& store);

 private:
  enum class Step : std::uint8_t { done, ask, coarse, align, shifts, polish, weigh, judge };
  static constexpr std::uint32_t kShare = 4096;
  static constexpr std::uint32_t kOfBestTurn = 3072;  ///< least hits of a turn, of the best one's, of kShare
  static constexpr std::uint32_t kShiftRows = 8;      ///< of one step
  static constexpr std::int32_t kAlign = 5;           ///< fine turns about a coarse one
  static constexpr std::uint32_t kRounds = 12;        ///< of moves by single cells
  static constexpr std::uint32_t kMostShifted = 500;

  /// A turn of an image; first coarse, then as it was aligned.
  struct Turn {
    std::uint32_t image{}, turn{};
    std::uint32_t hits{};   ///< of the turned cells, parts of 4,096
    std::int32_t x{}, y{};  ///< shift where these are, of 0.4 m
  };

  bool work(const ImageStore& store, std::uint64_t& units);
  void coarse_turn(std::uint32_t turn);
  void choose_turns(const ImageStore& store, std::uint32_t image);
  bool is_tried(const ImageStore& store, const Turn& turn) const;
  ImageHypothesis place_at(const ImageStore& store, std::uint32_t image, const ImagePlace& place) const {
    return hypothesis_of(store, turns_, query_.middle, image, place);
  }
  void turn_cells(std::uint32_t turn);
  void align(const Turn& task, std::int32_t by);
  void count_shifts(std::uint32_t image);
  void take_peaks(const ImageStore& store);
  bool polish(ImagePeak& peak);
  void conclude();
  void weigh(const ImageStore& store, const ImagePeak& peak);
  void judge(const ImageStore& store);
  bool is_flat(const ImageStore& store, const ImageHypothesis& best);
  void end(ImageVerdict verdict);
  std::uint64_t step_cost() const;
  std::span<const ImageTurns::Cell> shifted() const { return {cells_, cell_count_}; }

  ImageSearchConfig config_;
  ImageTurns turns_;
  HeightImage query_;
  ImagePoints points_;
  ImageView own_view_;                         ///< of the image that is looked for
  ImageView view_;                             ///< of the one that it is compared with
  ImagePoints kept_points_;                    ///< of that
  Turn coarse_[ImageTurns::kCoarse];           ///< of one image
  Turn tasks_[ImageSearchConfig::kMostTurns];  ///< most hits first
  std::uint32_t task_count_{};
  std::uint32_t left_out_{};  ///< most hits of a turn that there was no room for
  std::uint32_t aligned_turn_{}, aligned_hits_{};
  ImageTurns::Cell cells_[kMostShifted];  ///< of one turn, counted from the corner of the image
  std::uint32_t cell_count_{};
  ImagePeaks<6> shifts_;  ///< of one turn
  ImagePeak peaks_[ImagePeak::kMost];
  std::uint32_t peak_count_{};
  std::uint32_t at_{};    ///< image, turn or peak that is next
  std::uint32_t part_{};  ///< and what of it
  Step step_{Step::done};
  ImageVerdict verdict_{ImageVerdict::none};
  ImageHypothesis found_[kMost];
  std::uint32_t found_count_{};
  Heading flat_;
  std::uint32_t refused_{};
  std::uint64_t spent_{};
  UnitCredit credit_;
  ImageSearchCounts counts_;
};

}  // namespace sortie::mapping
