// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/recognition/recogniser.hpp"

#include <algorithm>

namespace sortie::mapping {

Recogniser::Recogniser(const RecogniserConfig& config, rt::Arena& arena)
    : config_(config),
      candidates_(config.candidates),
      sets_(config.pairs, arena),
      segments_(arena.make_array<SpeakingSegment>("recognition segments", config.segments)),
      pairs_(arena.make_array<SweptPair>("recognition correspondences", config.pairs)) {}

void Recogniser::begin(std::span<const SpeakingSegment> segments, const CandidateQuery& where) {
  // The lowest ids, in their order: sorted as they come in.
  segment_count_ = 0;
  for (const SpeakingSegment& segment : segments) {
    const auto end = segments_.begin() + segment_count_;
    const auto at =
        std::lower_bound(segments_.begin(), end, segment,
                         [](const SpeakingSegment& a, const SpeakingSegment& b) { return a.id < b.id; });
    if (segment_count_ < segments_.size()) {
      ++segment_count_;
    } else if (at == end) {
      continue;
    }
    std::copy_backward(at, segments_.begin() + segment_count_ - 1, segments_.begin() + segment_count_);
    *at = segment;
  }
  where_ = where;
  refused_ = 0;
  spent_ = 0;
  ++counts_.begun;
  begin_search();
}

void Recogniser::begin_search() {
  static_cast<void>(sets_.begin(config_.set, {}));  // nothing of the search before
  pair_count_ = 0;
  at_ = 0;
  asking_ = false;
  verdict_ = SetVerdict::none;
  ran_ = false;
  step_ = Step::ask;
}

/// Each segment's candidates, as long as there is room for correspondences; one that is too far away to be
/// compared has none.
bool Recogniser::ask(const TargetStore& store, std::uint64_t& units) {
  for (; at_ < segment_count_; ++at_) {
    if (!ConsistencySweep::is_near(segments_[at_].place)) continue;
    if (!asking_) {
      CandidateQuery query = where_;
      query.descriptor = segments_[at_].descriptor;
      candidates_.begin(query);
      asking_ = true;
    }
    if (!candidates_.run(store, units)) return false;
    asking_ = false;
    for (std::uint32_t i = 0; i < candidates_.size() && pair_count_ < pairs_.size(); ++i) {
      const TargetIndex target = candidates_[i].target;
      pairs_[pair_count_++] = {
          {static_cast<std::uint16_t>(at_), target}, segments_[at_].place, store.places()[target]};
    }
  }
  return true;
}

bool Recogniser::work(const TargetStore& store, std::uint64_t& units) {
  if (step_ == Step::ask) {
    if (!ask(store, units)) return false;
    if (sets_.begin(config_.set, pairs()) != Status::ok) {
      conclude(SetVerdict::inconsistent);  // gates that are not usable
      return true;
    }
    step_ = Step::search;
  }
  if (step_ == Step::search) {
    if (!sets_.run(units)) return false;
    conclude(sets_.verdict());
  }
  return true;
}

bool Recogniser::run(const TargetStore& store, std::uint64_t& units) {
  if (step_ == Step::done) return true;
  ran_ = true;
  std::uint64_t allowed = std::min(units, config_.most_units - spent_);
  const std::uint64_t given = allowed;
  const bool done = work(store, allowed);
  spent_ += given - allowed;
  units -= given - allowed;
  if (!done && spent_ == config_.most_units) {
    sets_.stop();
    conclude(step_ == Step::search ? sets_.verdict() : SetVerdict::undecided);
    return true;
  }
  return done;
}

std::uint64_t& Recogniser::counter(SetVerdict verdict) {
  switch (verdict) {
    case SetVerdict::found:
      return counts_.found;
    case SetVerdict::few:
      return counts_.few;
    case SetVerdict::bent:
      return counts_.bent;
    case SetVerdict::narrow:
      return counts_.narrow;
    case SetVerdict::ambiguous:
      return counts_.ambiguous;
    case SetVerdict::undecided:
      return counts_.undecided;
    default:
      return counts_.inconsistent;
  }
}

void Recogniser::conclude(SetVerdict verdict) {
  verdict_ = verdict;
  step_ = Step::done;
  ++counter(verdict);
}

void Recogniser::refuse() {
  if (step_ != Step::done || sets_.found().empty()) return;
  ++refused_;
  ++counts_.begun;
  sets_.refuse();
  verdict_ = SetVerdict::none;
  ran_ = false;
  step_ = Step::search;
}

void Recogniser::archive(rt::Archive& archive, const TargetStore& store) {
  rt::Members(archive, *this, "recogniser")
      .fixed(config_, candidates_, sets_, pairs_)
      .scratch(pair_count_, at_, asking_, step_, verdict_)
      .by_hand(segments_)
      .state(ran_, segment_count_, where_, spent_, refused_, counts_);
  if (archive.is_reading() &&
      (segment_count_ > segments_.size() || spent_ > config_.most_units || refused_ > SetHypotheses::kMost)) {
    archive.fail(Status::malformed, "a search that cannot be");
    segment_count_ = refused_ = 0;
    spent_ = 0;
  }
  for (SpeakingSegment& segment : segments_.first(segment_count_)) archive.value(segment);
  if (!archive.is_reading()) return;
  const RecogniserCounts counts = counts_;
  std::uint64_t again = spent_;
  const std::uint32_t refusals = refused_;
  const bool ran = ran_;
  spent_ = 0;
  refused_ = 0;
  step_ = Step::done;
  verdict_ = SetVerdict::none;
  begin_search();
  if (counts.begun == 0) step_ = Step::done;
  while (refused_ < refusals && run(store, again) && !sets_.found().empty()) refuse();
  if (ran) (void)run(store, again);
  counts_ = counts;
}

}  // namespace sortie::mapping
