// SPDX-License-Identifier: BSD-3-Clause
// From the best shifts of all images to places in the map, and what is believed of them.
#include <algorithm>

#include "mapping/recognition/image_search.hpp"

namespace sortie::mapping {

/// Whether two turns that are as good or better say the same place.
bool ImageSearch::is_tried(const ImageStore& store, const Turn& turn) const {
  const auto place_of_turn = [&](const Turn& one) {
    const ImagePlace place{static_cast<std::uint16_t>(one.turn), static_cast<std::int16_t>(2 * one.x),
                           static_cast<std::int16_t>(2 * one.y)};
    return place_at(store, one.image, place);
  };
  const ImageHypothesis own = place_of_turn(turn);
  int same = 0;
  for (const Turn* one = tasks_; one != tasks_ + task_count_ && one->hits >= turn.hits && same < 2; ++one)
    same += is_same(place_of_turn(*one), own) ? 1 : 0;
  return same == 2;
}

/// The best shifts of one turn among those of all; a place in the map that is there already stays where it is
/// better.
void ImageSearch::take_peaks(const ImageStore& store) {
  for (const ImagePeak& peak : shifts_.peaks()) {
    const ImageHypothesis own = place_at(store, peak.image, peak.place);
    const auto is_own = [&](const ImagePeak& other) {
      return is_same(place_at(store, other.image, other.place), own);
    };
    const auto is_better = [&](const ImagePeak& other) { return other.score >= peak.score && is_own(other); };
    if (std::any_of(peaks_, peaks_ + peak_count_, is_better)) continue;
    peak_count_ = static_cast<std::uint32_t>(std::remove_if(peaks_, peaks_ + peak_count_, is_own) - peaks_);
    if (peak_count_ == ImagePeak::kMost) {
      if (peaks_[peak_count_ - 1].score >= peak.score) continue;
      --peak_count_;
    }
    std::uint32_t at = peak_count_++;
    for (; at > 0 && peaks_[at - 1].score < peak.score; --at) peaks_[at] = peaks_[at - 1];
    peaks_[at] = peak;
  }
}

/// By one cell or one turn, where that is better. False: nowhere is.
bool ImageSearch::polish(ImagePeak& peak) {
  constexpr std::int32_t kMoves[6][3] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  if (part_ == 0) peak.score = view_.score(points_, turns_, peak.place).total();
  ImagePlace best = peak.place;
  std::int32_t most = peak.score;
  for (const auto& move : kMoves) {
    ImagePlace place = peak.place;
    place.turn = static_cast<std::uint16_t>(ImageTurns::next(place.turn, move[0]));
    place.x = static_cast<std::int16_t>(place.x + move[1]);
    place.y = static_cast<std::int16_t>(place.y + move[2]);
    const std::int32_t score = view_.score(points_, turns_, place).total();
    if (score <= most) continue;
    most = score;
    best = place;
  }
  if (most == peak.score) return false;
  peak.score = most;
  peak.place = best;
  return true;
}

/// All places are as good as they get.
void ImageSearch::conclude() {
  std::sort(peaks_, peaks_ + peak_count_, [](const ImagePeak& a, const ImagePeak& b) {
    if (a.score != b.score) return a.score > b.score;
    if (a.image != b.image) return a.image < b.image;
    if (a.place.turn != b.place.turn) return a.place.turn < b.place.turn;
    return a.place.y != b.place.y ? a.place.y < b.place.y : a.place.x < b.place.x;
  });
  found_count_ = at_ = 0;
  step_ = Step::weigh;
}

/// A place that is not there yet, with what speaks for it.
void ImageSearch::weigh(const ImageStore& store, const ImagePeak& peak) {
  ImageHypothesis one = place_at(store, peak.image, peak.place);
  const auto is_there = [&one](const ImageHypothesis& other) { return is_same(one, other); };
  if (peak.score <= 0 || std::any_of(found_, found_ + found_count_, is_there)) return;
  view_.take(store.images()[one.image].image);
  one.score = view_.score(points_, turns_, one.on_image);
  one.own = laid_on(points_.standing(), view_, turns_, one.on_image);
  kept_points_.take(store.images()[one.image].image);
  one.kept = laid_below(kept_points_.standing(), own_view_, turns_, one.on_image);
  found_[found_count_++] = one;
}

void ImageSearch::judge(const ImageStore& store) {
  if (found_count_ == 0) return end(ImageVerdict::unlike);
  const ImageHypothesis& best = found_[0];
  const double known = best.score.agree + best.score.against;
  const bool is_alike = known >= config_.least_known * static_cast<double>(points_.standing().size()) &&
                        best.score.agree >= config_.least_share * (known + best.score.floor_against) &&
                        best.own.agrees(config_.least_own) && best.kept.agrees(config_.least_kept);
  if (!is_alike) return end(ImageVerdict::unlike);
  if (is_flat(store, best)) return end(ImageVerdict::narrow);
  const bool has_rival = found_count_ > 1 && found_[1].score.total() >= config_.of_rival * best.score.total();
  // What there was no room to compare with may look as much like it.
  const bool is_crowded = std::uint64_t{left_out_} * kShare >= std::uint64_t{tasks_[0].hits} * kOfBestTurn;
  end(has_rival || is_crowded ? ImageVerdict::ambiguous : ImageVerdict::found);
}

/// Whether the place can be moved by three cells in some direction at little loss; which one is in `flat_`.
bool ImageSearch::is_flat(const ImageStore& store, const ImageHypothesis& best) {
  constexpr std::int8_t kAway[16][2] = {{3, 0},  {3, 1},  {2, 2},  {1, 3},   {0, 3},   {-1, 3},
                                        {-2, 2}, {-3, 1}, {-3, 0}, {-3, -1}, {-2, -2}, {-1, -3},
                                        {0, -3}, {1, -3}, {2, -2}, {3, -1}};
  view_.take(store.images()[best.image].image);
  std::int32_t most = 0;
  bool any = false;
  for (const auto& away : kAway) {
    ImagePlace place = best.on_image;
    place.x = static_cast<std::int16_t>(place.x + away[0]);
    place.y = static_cast<std::int16_t>(place.y + away[1]);
    const std::int32_t score = view_.score(points_, turns_, place).total();
    if (any && score <= most) continue;
    any = true;
    most = score;
    Heading direction;
    static_cast<void>(heading_of(away[0], away[1], direction));
    flat_ = after(direction, store.images()[best.image].pose.heading);
  }
  return best.score.total() - most < config_.flat * best.score.agree;
}

void ImageSearch::refuse(const ImageStore& store) {
  if (step_ != Step::done || found_count_ == 0) return;
  for (const ImageHypothesis& one : found()) {
    if (one.image >= store.images().size()) found_count_ = 0;  // not the store that was searched
  }
  std::copy(found_ + 1, found_ + found_count_, found_);
  --found_count_;
  ++refused_;
  ++counts_.begun;
  judge(store);
}

void ImageSearch::end(ImageVerdict verdict) {
  verdict_ = verdict;
  step_ = Step::done;
  std::uint64_t* const counters[] = {nullptr,         &counts_.found,     &counts_.few,      &counts_.unlike,
                                     &counts_.narrow, &counts_.ambiguous, &counts_.undecided};
  if (verdict != ImageVerdict::none) ++*counters[static_cast<std::size_t>(verdict)];
}

void ImageSearch::archive(rt::Archive& archive, const ImageStore& store) {
  rt::Members(archive, *this, "search among images")
      .fixed(config_, turns_)
      .scratch(points_, own_view_, view_, kept_points_, coarse_, left_out_, tasks_, task_count_,
               aligned_turn_, aligned_hits_, cells_, cell_count_, shifts_, peaks_, peak_count_, at_, part_)
      .scratch(step_, verdict_, found_, found_count_, flat_, credit_)
      .state(query_, refused_, spent_, counts_);
  if (!archive.is_reading()) return;
  if (spent_ > config_.most_units || refused_ > kMost) {
    archive.fail(Status::malformed, "a search that cannot be");
    spent_ = refused_ = 0;
  }
  const ImageSearchCounts counts = counts_;
  std::uint64_t again = spent_;
  const std::uint32_t refusals = refused_;
  begin(HeightImage{query_});
  if (counts.begun == 0) step_ = Step::done;
  static_cast<void>(run(store, again));
  for (std::uint32_t i = 0; i < refusals; ++i) refuse(store);
  counts_ = counts;
}

}  // namespace sortie::mapping
