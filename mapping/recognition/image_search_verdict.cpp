// SPDX-License-Identifier: BSD-3-Clause
// From the best shifts of all images to places in the map, and what is believed of them.
#include <algorithm>

#include "mapping/recognition/image_search.hpp"

namespace sortie::mapping {
namespace {

constexpr std::int64_t kSameCm = 100;
constexpr double kSameCosine = 0.985;  ///< 10 degrees

Heading after(const Heading& first, const Heading& then) {
  const std::int64_t c = then.cosine, s = then.sine;
  return {detail::from_parts(c * first.cosine - s * first.sine),
          detail::from_parts(s * first.cosine + c * first.sine)};
}

double number(std::int32_t parts) { return static_cast<double>(parts) / Heading::kOne; }

ImageHypothesis hypothesis_of(const ImageStore& store, const ImageTurns& turns, const HeightImage& query,
                              const ImagePeak& peak) {
  ImageHypothesis out;
  const KeyFramePose& pose = store.images()[peak.image].pose;
  out.image = peak.image;
  out.on_image = peak.place;
  out.middle = place_of(pose, {HeightImage::kCellCm * peak.place.x, HeightImage::kCellCm * peak.place.y, 0});
  out.heading = after(turns.heading(peak.place.turn), pose.heading);
  const double c = number(out.heading.cosine), s = number(out.heading.sine);
  const PlaceCm& own = query.middle;
  out.place = {c, s, 0.01 * (out.middle.x - (c * own.x - s * own.y)),
               0.01 * (out.middle.y - (s * own.x + c * own.y)), 0.01 * (out.middle.z - own.z)};
  return out;
}

bool is_same(const ImageHypothesis& a, const ImageHypothesis& b) {
  const double cosine =
      number(a.heading.cosine) * number(b.heading.cosine) + number(a.heading.sine) * number(b.heading.sine);
  return square_apart(a.middle, b.middle) <= kSameCm * kSameCm && cosine >= kSameCosine;
}

}  // namespace

/// The best shifts of one turn among those of all; a place in the map that is there already stays where it is
/// better.
void ImageSearch::take_peaks(const ImageStore& store) {
  for (const ImagePeak& peak : shifts_.peaks()) {
    const ImageHypothesis own = hypothesis_of(store, turns_, query_, peak);
    const auto is_own = [&](const ImagePeak& other) {
      return is_same(hypothesis_of(store, turns_, query_, other), own);
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

void ImageSearch::conclude(const ImageStore& store) {
  std::sort(peaks_, peaks_ + peak_count_, [](const ImagePeak& a, const ImagePeak& b) {
    if (a.score != b.score) return a.score > b.score;
    if (a.image != b.image) return a.image < b.image;
    if (a.place.turn != b.place.turn) return a.place.turn < b.place.turn;
    return a.place.y != b.place.y ? a.place.y < b.place.y : a.place.x < b.place.x;
  });
  found_count_ = 0;
  for (std::uint32_t i = 0; i < peak_count_ && found_count_ < kMost; ++i) {
    ImageHypothesis one = hypothesis_of(store, turns_, query_, peaks_[i]);
    const auto is_there = [&one](const ImageHypothesis& other) { return is_same(one, other); };
    if (peaks_[i].score <= 0 || std::any_of(found_, found_ + found_count_, is_there)) continue;
    view_.take(store.images()[one.image].image);
    one.score = view_.score(points_, turns_, one.on_image);
    found_[found_count_++] = one;
  }
  judge(store);
}

void ImageSearch::judge(const ImageStore& store) {
  if (found_count_ == 0) return end(ImageVerdict::unlike);
  const ImageScore& best = found_[0].score;
  const double known = best.agree + best.against;
  const bool is_alike = known >= config_.least_known * static_cast<double>(points_.standing().size()) &&
                        best.agree >= config_.least_share * (known + best.floor_against);
  if (!is_alike) return end(ImageVerdict::unlike);
  if (is_flat(store, found_[0])) return end(ImageVerdict::narrow);
  const bool has_rival = found_count_ > 1 && found_[1].score.total() >= config_.of_rival * best.total();
  end(has_rival ? ImageVerdict::ambiguous : ImageVerdict::found);
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
      .scratch(points_, view_, candidates_, candidate_count_, coarse_, tasks_, task_count_, aligned_turn_,
               aligned_hits_, cells_, cell_count_, shifts_, peaks_, peak_count_, at_, part_)
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
