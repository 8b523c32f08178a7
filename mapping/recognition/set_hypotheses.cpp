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
  round_ = 0;
  refused_ = 0;
  found_count_ = 0;
  bent_ = false;
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

/// Segments that a set must have to be of interest: behind the best one only such as come near it.
std::uint32_t SetHypotheses::least() const {
  if (found_count_ == 0) return config_.least;
  std::uint32_t most = 0;
  for (std::uint32_t i = 0; i < found_count_; ++i) most = std::max(most, found_[i].count);
  return std::max(config_.least, static_cast<std::uint32_t>(config_.of_rival * most) + 1);
}

/// A set of `least` lies within the core of least - 1.
void SetHypotheses::keep_core() {
  std::fill(in_core_.begin(), in_core_.end(), BitGraph::Word{0});
  for (const std::uint16_t v : core_.order()) {
    if (core_.core(v) + 1u >= config_.least) BitGraph::put(in_core_, v);
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
  proved_ = proved_ && set_.proved();
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
  const double most = config_.eps_m * config_.eps_m;
  BitGraph::each(in_core_, [&](std::uint32_t v) {
    const double miss = squared_miss(h.fit.place, sweep_.pairs()[v]);
    if (miss > most) return;
    const Correspondence& pair = sweep_.pairs()[v].pair;
    bool is_nearest = true;
    for (std::uint32_t k = 0; k < count;) {
      const Correspondence& other = sweep_.pairs()[near[k].vertex].pair;
      const bool same = other.segment == pair.segment || other.target == pair.target;
      if (same && near[k].miss <= miss) is_nearest = false;
      if (same && near[k].miss > miss) {
        near[k] = near[--count];
      } else {
        ++k;
      }
    }
    if (is_nearest && count < SetHypothesis::kMostPairs)
      near[count++] = {miss, static_cast<std::uint16_t>(v)};
  });
  std::sort(near, near + count, [&](const Near& a, const Near& b) {
    return sweep_.pairs()[a.vertex].pair < sweep_.pairs()[b.vertex].pair;
  });
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

/// The round's set becomes a pose, or goes.
void SetHypotheses::fit_round() {
  ++round_;
  SetHypothesis h;
  bool rigid = fit_level(sweep_.pairs(), {round_set_, round_count_}, h.fit) && h.fit.rms_m <= config_.eps_m;
  for (int again = 0; rigid && again < 2; ++again) {
    refine(h);
    rigid = h.count >= config_.least && fit_level(sweep_.pairs(), {h.pairs, h.count}, h.fit);
  }
  if (!rigid) {
    bent_ = true;
    for (std::uint32_t i = 0; i < round_count_; ++i) BitGraph::take(members_, round_set_[i]);
    return;
  }
  remove(h);
  for (std::uint32_t i = 0; i < h.count; ++i) h.pairs[i] = sweep_.number(h.pairs[i]);
  std::uint32_t at = found_count_++;
  for (; at > 0 && found_[at - 1].count < h.count; --at) found_[at] = found_[at - 1];
  found_[at] = h;
}

void SetHypotheses::judge() {
  step_ = Step::done;
  if (found_count_ == 0) {
    verdict_ = bent_ ? SetVerdict::bent : SetVerdict::inconsistent;
    if (!proved_) verdict_ = SetVerdict::undecided;
  } else if (found_count_ > 1 && found_[1].count > config_.of_rival * found_[0].count) {
    verdict_ = SetVerdict::ambiguous;
  } else if (found_[0].fit.spread_m < config_.spread_m) {
    verdict_ = SetVerdict::narrow;
  } else {
    verdict_ = proved_ ? SetVerdict::found : SetVerdict::undecided;
  }
}

void SetHypotheses::stop() {
  if (step_ != Step::done) verdict_ = SetVerdict::undecided;
  step_ = Step::done;
}

void SetHypotheses::refuse() {
  if (step_ != Step::done || found_count_ == 0) return;
  std::copy(found_ + 1, found_ + found_count_, found_);
  --found_count_;
  verdict_ = SetVerdict::inconsistent;
  if (++refused_ == kMost) return;
  round_ = 0;
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
        keep_core();
        begin_round();
        break;
      case Step::next:
        if (found_count_ == kMost || round_ == kMostRounds || BitGraph::count(members_) < least()) {
          judge();
          break;
        }
        set_.begin(sweep_.graph(gate_), members_, std::max(least(), round_count_ + 1));
        step_ = Step::search;
        break;
      case Step::search:
        if (!set_.run(units)) return false;
        take_set();
        step_ = Step::next;
        if (++gate_ < kGates) break;
        if (round_count_ == 0) {
          judge();
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
