// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/recognition/set_hypotheses.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::mapping {
namespace {
constexpr std::uint32_t kGates = ConsistencyGates::kCount;
constexpr double kGateShare[kGates] = {0.5, 1.0, 2.0};  // of eps
/// What a pose explains: all that lies within so many eps of where it is laid.
constexpr double kExplained = 2.0;
/// What a place is compared with: poses that so many segments speak for, and more than that part of the best
/// one's; by one gate.
constexpr std::uint32_t kLeastOther = 3;
constexpr double kOfOther = 0.3;
constexpr std::uint32_t kOthersGate = 1;

ConsistencyGates gates_of(const SetConfig& config) {
  ConsistencyGates gates;
  for (std::uint32_t g = 0; g < kGates; ++g)
    gates.eps_cm[g] = static_cast<std::int32_t>(100.0 * kGateShare[g] * config.eps_m + 0.5);
  gates.tilt_permille = static_cast<std::int32_t>(config.tilt_deg * 17.4533 + 0.5);
  gates.gravity = config.gravity;
  return gates;
}
}  // namespace

SetHypotheses::SetHypotheses(std::uint32_t pairs, rt::Arena& arena)
    : sweep_(pairs, arena),
      set_({pairs, std::min(pairs, 1024u), SetHypothesis::kMostPairs}, arena),
      core_(pairs, arena),
      in_core_(arena.make_array<BitGraph::Word>("recognition core", BitGraph::words_of(pairs))),
      members_(arena.make_array<BitGraph::Word>("recognition alive", BitGraph::words_of(pairs))) {}

Status SetHypotheses::begin(const SetConfig& config, std::span<const SweptPair> pairs) {
  config_ = config;
  step_ = Step::done;
  bent_ = 0;
  refused_ = 0;
  found_count_ = 0;
  others_ = false;
  proved_ = true;
  verdict_ = SetVerdict::none;
  if (members_.size() < BitGraph::words_of(static_cast<std::uint32_t>(pairs.size()))) return Status::full;
  const Status status = sweep_.begin(gates_of(config), pairs);
  if (status != Status::ok) return status;
  if (pairs.size() < config.least) {
    verdict_ = SetVerdict::few;
  } else {
    step_ = Step::sweep;
  }
  return Status::ok;
}

/// Segments that a set must have to be of interest: behind the best one only such as come near it; of others
/// to compare with fewer.
std::uint32_t SetHypotheses::least() const {
  if (found_count_ == 0) return config_.least;
  std::uint32_t most = 0;
  for (std::uint32_t i = 0; i < found_count_; ++i) most = std::max(most, found_[i].count);
  const double share = others_ ? kOfOther : config_.of_rival;
  return std::max(others_ ? kLeastOther : config_.least, static_cast<std::uint32_t>(share * most) + 1);
}

/// A set of `size` lies within the core of size - 1.
void SetHypotheses::keep_core(std::uint32_t size) {
  std::fill(in_core_.begin(), in_core_.end(), BitGraph::Word{0});
  for (const std::uint16_t v : core_.order()) {
    if (core_.core(v) + 1u >= size) BitGraph::put(in_core_, v);
  }
  std::copy(in_core_.begin(), in_core_.end(), members_.begin());
}

void SetHypotheses::begin_round() {
  gate_ = 0;
  round_count_ = 0;
  step_ = Step::next;
}

/// The gate's set, where it is larger than those of narrower gates.
void SetHypotheses::take_set() {
  const auto set = set_.found();
  proved_ = proved_ && (others_ || set_.proved());
  if (set.empty()) return;
  round_count_ = static_cast<std::uint32_t>(set.size());
  std::copy(set.begin(), set.end(), round_set_);
}

/// Every segment's nearest correspondence within eps of the pose, of each target the nearest one's.
void SetHypotheses::refine(SetHypothesis& h) const {
  struct Near {
    double miss;
    std::uint16_t vertex;
  };
  Near near[SetHypothesis::kMostPairs];
  std::uint32_t count = 0;
  const auto pair = [&](const Near& one) { return sweep_.pairs()[one.vertex].pair; };
  const double most = config_.eps_m * config_.eps_m;
  BitGraph::each(in_core_, [&](std::uint32_t v) {
    const Near one{squared_miss(h.fit.place, sweep_.pairs()[v]), static_cast<std::uint16_t>(v)};
    if (one.miss > most) return;
    std::uint32_t k = 0;
    while (k < count && pair(near[k]).segment != pair(one).segment) ++k;
    if (k == SetHypothesis::kMostPairs || (k < count && near[k].miss <= one.miss)) return;
    near[k] = one;
    count = std::max(count, k + 1);
  });
  const auto is_nearer = [&](const Near& a, const Near& b) {
    return a.miss != b.miss ? a.miss < b.miss : pair(a) < pair(b);
  };
  for (std::uint32_t k = 0; k < count;) {
    const bool is_nearest = std::none_of(near, near + count, [&](const Near& other) {
      return pair(other).target == pair(near[k]).target && is_nearer(other, near[k]);
    });
    if (is_nearest) {
      ++k;
    } else {
      near[k] = near[--count];
    }
  }
  std::sort(near, near + count, [&](const Near& a, const Near& b) { return pair(a) < pair(b); });
  h.count = count;
  for (std::uint32_t i = 0; i < count; ++i) h.pairs[i] = near[i].vertex;
}

/// What the pose explains speaks for no other one.
void SetHypotheses::remove(const SetHypothesis& h) {
  const double explained = kExplained * config_.eps_m, most = explained * explained;
  BitGraph::each(members_, [&](std::uint32_t v) {
    if (squared_miss(h.fit.place, sweep_.pairs()[v]) <= most) BitGraph::take(members_, v);
  });
}

/// Without those that it lays worst, as long as the pose does not lay the others: a set may hold the whole of
/// a place, and some more that agree with it two by two.
bool SetHypotheses::lay(SetHypothesis& h) const {
  const auto pairs = sweep_.pairs();
  const std::uint32_t fewest = others_ ? kLeastOther : config_.least;
  const auto fits = [&] { return h.count >= fewest && fit_level(pairs, {h.pairs, h.count}, h.fit); };
  if (!fits()) return false;
  while (h.fit.rms_m > config_.eps_m) {
    std::uint16_t* const end = h.pairs + h.count;
    std::uint16_t* const worst = std::max_element(h.pairs, end, [&](std::uint16_t a, std::uint16_t b) {
      return squared_miss(h.fit.place, pairs[a]) < squared_miss(h.fit.place, pairs[b]);
    });
    std::copy(worst + 1, end, worst);
    --h.count;
    if (!fits()) return false;
  }
  for (int again = 0; again < 2; ++again) {
    refine(h);
    if (!fits()) return false;
  }
  return true;
}

/// The round's set becomes a pose, or goes; both where the pose comes near no other one.
void SetHypotheses::fit_round() {
  SetHypothesis h;
  h.count = round_count_;
  std::copy(round_set_, round_set_ + round_count_, h.pairs);
  const bool rigid = lay(h);
  if (!rigid || h.count < least()) {
    for (std::uint32_t i = 0; i < round_count_; ++i) BitGraph::take(members_, round_set_[i]);
  }
  if (!rigid) {
    bent_ += others_ ? 0 : 1;
    return;
  }
  remove(h);
  for (std::uint32_t i = 0; i < h.count; ++i) h.pairs[i] = sweep_.number(h.pairs[i]);
  if (is_full() && found_[kMost - 1].count >= h.count) return;
  std::uint32_t at = is_full() ? kMost - 1 : found_count_++;
  const std::uint32_t first = others_ ? 1 : 0;
  for (; at > first && found_[at - 1].count < h.count; --at) found_[at] = found_[at - 1];
  found_[at] = h;
}

/// There is one place: what else segments speak for, if fewer of them.
void SetHypotheses::begin_others() {
  others_ = true;
  keep_core(kLeastOther);
  for (std::uint32_t i = 0; i < found_count_; ++i) remove(found_[i]);
  begin_round();
}

void SetHypotheses::judge() {
  step_ = Step::done;
  if (found_count_ > 0 && found_[0].count < config_.least)
    found_count_ = 0;  // what another was compared with
  const auto is_rival = [&](const SetHypothesis& other) {
    return other.count >= config_.least && other.count > config_.of_rival * found_[0].count;
  };
  if (found_count_ == 0) {
    verdict_ = bent_ > 0 ? SetVerdict::bent : SetVerdict::inconsistent;
    if (!proved_) verdict_ = SetVerdict::undecided;
  } else if (found_count_ > 1 && is_rival(found_[1])) {
    verdict_ = SetVerdict::ambiguous;
  } else if (found_[0].fit.spread_m < config_.spread_m) {
    verdict_ = SetVerdict::narrow;
  } else {
    verdict_ = proved_ ? SetVerdict::found : SetVerdict::undecided;
    if (proved_) begin_others();
  }
}

/// No more sets are asked for.
bool SetHypotheses::has_enough() const {
  if (others_) return is_full();
  if (found_count_ == 0) return bent_ >= kMostBent;
  return found_count_ >= kMostRivals && found_[kMostRivals - 1].count >= least();
}

void SetHypotheses::conclude() {
  if (others_) {
    step_ = Step::done;
  } else {
    judge();
  }
}

void SetHypotheses::stop() {
  if (step_ == Step::done) return;
  step_ = Step::done;
  if (others_) return;
  proved_ = false;
  verdict_ = SetVerdict::undecided;
}

void SetHypotheses::refuse() {
  if (step_ != Step::done || found_count_ == 0) return;
  std::copy(found_ + 1, found_ + found_count_, found_);
  --found_count_;
  verdict_ = SetVerdict::inconsistent;
  if (++refused_ == kMost) {
    found_count_ = 0;
    return;
  }
  bent_ = std::min(bent_, 1u);
  others_ = false;
  begin_round();
}

bool SetHypotheses::run(std::uint64_t& units) {
  while (step_ != Step::done) {
    switch (step_) {
      case Step::sweep:
        if (!sweep_.run(units)) return false;
        BitGraph::fill(members_, static_cast<std::uint32_t>(sweep_.pairs().size()));
        core_.begin(sweep_.graph(kGates - 1), members_);
        step_ = Step::peel;
        break;
      case Step::peel:
        if (!core_.run(units)) return false;
        keep_core(config_.least);
        begin_round();
        break;
      case Step::next:
        if (has_enough() || BitGraph::count(members_) < least()) {
          conclude();
          break;
        }
        set_.begin(sweep_.graph(others_ ? kOthersGate : gate_), members_,
                   std::max(least(), round_count_ + 1));
        step_ = Step::search;
        break;
      case Step::search:
        if (!set_.run(units)) return false;
        take_set();
        step_ = Step::next;
        if (!others_ && ++gate_ < kGates) break;
        if (round_count_ == 0) {
          conclude();
        } else {
          fit_round();
          begin_round();
        }
        break;
      case Step::done:
        break;
    }
  }
  return true;
}

}  // namespace sortie::mapping
