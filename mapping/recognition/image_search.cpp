// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/recognition/image_search.hpp"

#include <algorithm>

#include "mapping/recognition/shift_counts.hpp"

namespace sortie::mapping {
namespace {

constexpr std::uint32_t kMostCoarsePoints = 160;
constexpr std::int32_t kTurnsApart = 3;  ///< coarse ones
constexpr std::uint32_t kTurnsOfImage = 6;
constexpr std::int32_t kCoarseHalf = ImageView::kCoarseCells / 2;

std::size_t stride_of(std::size_t points, std::size_t most) {
  return std::max<std::size_t>((points + most - 1) / most, 1);
}

}  // namespace

ImageSearch::ImageSearch(const ImageSearchConfig& config) : config_(config) {
  config_.turns = std::clamp(config.turns, 1u, ImageSearchConfig::kMostTurns);
}

void ImageSearch::begin(const HeightImage& image) {
  query_ = image;
  points_.take(query_);
  ++counts_.begun;
  refused_ = 0;
  spent_ = 0;
  left_out_ = found_count_ = task_count_ = peak_count_ = at_ = part_ = 0;
  verdict_ = ImageVerdict::none;
  credit_.clear();
  step_ = Step::ask;
}

/// All shifts of 0.4 m at one coarse turn.
void ImageSearch::coarse_turn(std::uint32_t turn) {
  // What comes to lie in the same cell counts once.
  ImageView::Word cells[ImageView::kCoarseCells]{};
  std::uint32_t count = 0;
  for (const ImagePoint& point : points_.standing()) {
    const ImageTurns::Cell cell = turns_.turned(turn * ImageTurns::kFineOfCoarse, point.half_x, point.half_y);
    const std::int32_t x = (cell.x >> 1) + kCoarseHalf, y = (cell.y >> 1) + kCoarseHalf;
    if (x < 0 || y < 0 || x >= ImageView::kCoarseCells || y >= ImageView::kCoarseCells) continue;
    const ImageView::Word bit = ImageView::Word{1} << x;
    count += (cells[y] & bit) == 0 ? 1u : 0u;
    cells[y] |= bit;
  }
  struct {
    std::int8_t x, y;
  } points[kMostCoarsePoints];
  const auto stride = static_cast<std::uint32_t>(stride_of(count, kMostCoarsePoints));
  std::uint32_t taken = 0, seen = 0;
  for (std::int32_t y = 0; y < ImageView::kCoarseCells; ++y) {
    for (ImageView::Word rest = cells[y]; rest != 0; rest &= rest - 1) {
      if (seen++ % stride == 0)
        points[taken++] = {static_cast<std::int8_t>(std::countr_zero(rest)), static_cast<std::int8_t>(y)};
    }
  }
  Turn& best = coarse_[turn];
  best = {0, turn * ImageTurns::kFineOfCoarse, 0, 0, 0};
  if (taken == 0) return;
  std::uint32_t most = 0;
  for (std::int32_t shift = -kCoarseHalf; shift < kCoarseHalf; ++shift) {
    ShiftCounts<1> counts;
    for (std::uint32_t i = 0; i < taken; ++i) {
      const std::int32_t y = points[i].y + shift;
      if (y < 0 || y >= ImageView::kCoarseCells) continue;
      const ImageView::Word row[1] = {view_.coarse_row(points[i].x, y)};
      counts.add(row);
    }
    counts.flush();
    ImageView::Word which = 0;
    const std::uint32_t value = counts.most(0, which);
    if (value <= most) continue;
    most = value;
    best.x = static_cast<std::int32_t>(std::countr_zero(which)) - kCoarseHalf;
    best.y = shift;
  }
  best.hits = kShare * most / taken;
}

/// The best turns of an image that was compared, well apart, among those of the others.
void ImageSearch::choose_turns(const ImageStore& store, std::uint32_t image) {
  std::uint32_t chosen[kTurnsOfImage];
  std::uint32_t count = 0, most = 0;
  for (; count < kTurnsOfImage; ++count) {
    std::uint32_t best = ImageTurns::kCoarse;
    for (std::uint32_t turn = 0; turn < ImageTurns::kCoarse; ++turn) {
      const bool is_apart = std::all_of(chosen, chosen + count, [turn](std::uint32_t other) {
        const auto by = static_cast<std::int32_t>((turn + ImageTurns::kCoarse - other) % ImageTurns::kCoarse);
        return by > kTurnsApart && by < static_cast<std::int32_t>(ImageTurns::kCoarse) - kTurnsApart;
      });
      if (is_apart && (best == ImageTurns::kCoarse || coarse_[turn].hits > coarse_[best].hits)) best = turn;
    }
    if (best == ImageTurns::kCoarse) break;
    most = std::max(most, coarse_[best].hits);
    if (coarse_[best].hits * std::uint64_t{kShare} < std::uint64_t{most} * kOfBestTurn) break;
    chosen[count] = best;
    Turn one = coarse_[best];
    one.image = image;
    if (is_tried(store, one)) continue;
    std::uint32_t at = task_count_;
    while (at > 0 && tasks_[at - 1].hits < one.hits) --at;
    if (task_count_ == config_.turns)
      left_out_ = std::max(left_out_, at == config_.turns ? one.hits : tasks_[task_count_ - 1].hits);
    if (at == config_.turns) continue;
    task_count_ = std::min(task_count_ + 1, config_.turns);
    std::copy_backward(tasks_ + at, tasks_ + task_count_ - 1, tasks_ + task_count_);
    tasks_[at] = one;
  }
}

/// Turns the cells that are shifted, as many as take part, into `cells_`.
void ImageSearch::turn_cells(std::uint32_t turn) {
  const auto points = points_.standing();
  const std::size_t stride = stride_of(points.size(), kMostShifted);
  cell_count_ = 0;
  for (std::size_t i = 0; i < points.size(); i += stride) {
    const ImageTurns::Cell cell = turns_.turned(turn, points[i].half_x, points[i].half_y);
    const std::int32_t x = cell.x + ImagePlane::kHalf;
    if (x >= 0 && x < ImagePlane::kCells) cells_[cell_count_++] = {x, cell.y + ImagePlane::kHalf};
  }
}

/// The turn `by` fine ones beside a coarse one, near its best shift.
void ImageSearch::align(const Turn& task, std::int32_t by) {
  const std::uint32_t turn = ImageTurns::next(task.turn, by);
  turn_cells(turn);
  for (std::int32_t shift = 2 * task.y - 3; shift <= 2 * task.y + 4; ++shift) {
    ShiftCounts<2> counts;
    for (const ImageTurns::Cell& cell : shifted()) {
      const std::int32_t y = cell.y + shift;
      if (y < 0 || y >= ImagePlane::kCells) continue;
      ImageView::Word row[2];
      view_.near_row(cell.x, y, row);
      counts.add(row);
    }
    counts.flush();
    ImageView::Word which = 0;
    const std::uint32_t hits = std::max(counts.most(0, which), counts.most(1, which));
    if (hits <= aligned_hits_) continue;
    aligned_hits_ = hits;
    aligned_turn_ = turn;
  }
}

/// kShiftRows rows of shifts of 0.2 m at one turn.
void ImageSearch::count_shifts(std::uint32_t image) {
  turn_cells(aligned_turn_);
  const auto least = static_cast<std::uint32_t>(config_.least_known * config_.least_share * cell_count_);
  const std::int32_t begin = static_cast<std::int32_t>(part_ * kShiftRows) - ImagePlane::kHalf;
  for (std::int32_t shift = begin; shift < begin + static_cast<std::int32_t>(kShiftRows); ++shift) {
    ShiftCounts<2> agree, against;
    for (const ImageTurns::Cell& cell : shifted()) {
      const std::int32_t y = cell.y + shift;
      if (y < 0 || y >= ImagePlane::kCells) continue;
      ImageView::Word row[2];
      view_.near_row(cell.x, y, row);
      agree.add(row);
      view_.free_row(cell.x, y, row);
      against.add(row);
    }
    agree.flush();
    against.flush();
    for (int word = 0; word < 2; ++word) {
      for (ImageView::Word rest = agree.at_least(word, least); rest != 0; rest &= rest - 1) {
        const auto bit = static_cast<unsigned>(std::countr_zero(rest));
        const auto score = static_cast<std::int32_t>(agree.count(word, bit)) -
                           ImageScore::kAgainst * static_cast<std::int32_t>(against.count(word, bit));
        const std::int32_t x = 64 * word + static_cast<std::int32_t>(bit) - ImagePlane::kHalf;
        shifts_.offer({image,
                       {static_cast<std::uint16_t>(aligned_turn_), static_cast<std::int16_t>(x),
                        static_cast<std::int16_t>(shift)},
                       score});
      }
    }
  }
}

bool ImageSearch::run(const ImageStore& store, std::uint64_t& units) {
  if (step_ == Step::done) return true;
  std::uint64_t allowed = std::min(units, config_.most_units - spent_);
  const std::uint64_t given = allowed;
  const bool done = work(store, allowed);
  spent_ += given - allowed;
  units -= given - allowed;
  if (!done && spent_ == config_.most_units) {
    found_count_ = 0;
    end(ImageVerdict::undecided);
    return true;
  }
  return done;
}

/// Of the next step, in units.
std::uint64_t ImageSearch::step_cost() const {
  const std::uint64_t points = points_.standing().size();
  const std::uint64_t shifted = std::min<std::uint64_t>(points, kMostShifted);
  switch (step_) {
    case Step::ask:
      return 50'000;
    case Step::coarse:
      return 2'000 + 4 * points + 200 * std::min<std::uint64_t>(points, kMostCoarsePoints);
    case Step::align:
      return 2'000 + 50 * shifted;
    case Step::shifts:
      return 2'000 + 100 * shifted;
    case Step::polish:
      return 2'000 + 8 * 3 * (points + points_.floor().size());
    case Step::weigh:
      return 10'000 + 8 * 3 * (2 * points + points_.floor().size());
    case Step::judge:
      return 10'000 + 8 * 16 * (points + points_.floor().size());
    case Step::done:
      break;
  }
  return 0;
}

bool ImageSearch::work(const ImageStore& store, std::uint64_t& units) {
  while (step_ != Step::done) {
    if (!credit_.pay(step_cost(), units)) return false;
    switch (step_) {
      case Step::ask:
        own_view_.take(query_);
        if (store.images().empty() || points_.standing().size() < config_.least_cells) {
          end(ImageVerdict::few);
        } else {
          step_ = Step::coarse;
        }
        break;
      case Step::coarse:
        if (part_ == 0) view_.take(store.images()[at_].image);
        coarse_turn(part_);
        if (++part_ < ImageTurns::kCoarse) break;
        part_ = 0;
        choose_turns(store, at_);
        if (++at_ < store.images().size()) break;
        at_ = 0;
        step_ = Step::align;
        break;
      case Step::align:
        if (part_ == 0) {
          view_.take(store.images()[tasks_[at_].image].image);
          aligned_hits_ = 0;
          aligned_turn_ = tasks_[at_].turn;
        }
        align(tasks_[at_], static_cast<std::int32_t>(part_) - kAlign);
        if (++part_ < 2 * kAlign + 1) break;
        part_ = 0;
        shifts_.clear();
        step_ = Step::shifts;
        break;
      case Step::shifts:
        count_shifts(tasks_[at_].image);
        if (++part_ < ImagePlane::kCells / kShiftRows) break;
        part_ = 0;
        take_peaks(store);
        step_ = Step::align;
        if (++at_ < task_count_) break;
        at_ = 0;
        step_ = Step::polish;
        if (peak_count_ == 0) conclude();
        break;
      case Step::polish:
        if (part_ == 0) view_.take(store.images()[peaks_[at_].image].image);
        if (polish(peaks_[at_]) && ++part_ < kRounds) break;
        part_ = 0;
        if (++at_ == peak_count_) conclude();
        break;
      case Step::weigh:
        if (at_ < peak_count_ && found_count_ < kMost) {
          weigh(store, peaks_[at_++]);
        } else {
          step_ = Step::judge;
        }
        break;
      case Step::judge:
        judge(store);
        break;
      case Step::done:
        break;
    }
  }
  return true;
}

}  // namespace sortie::mapping
