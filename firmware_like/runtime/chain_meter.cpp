// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/runtime/chain_meter.hpp"

#include <algorithm>
#include <bit>

namespace sortie::firmware {

namespace {

// A record that waits for one that never comes was followed by this many.
constexpr std::size_t kMostWaiting = 4096;
constexpr std::size_t kMostRepeats = 1 << 16;

// Of a damaged log, times may be anything: differences wrap.
rt::Nanoseconds between(rt::Nanoseconds from, rt::Nanoseconds to) {
  return static_cast<rt::Nanoseconds>(static_cast<std::uint64_t>(to) - static_cast<std::uint64_t>(from));
}

void record(rt::LatencyHistogram& histogram, rt::Nanoseconds span) {
  histogram.record(static_cast<std::uint64_t>(std::max<rt::Nanoseconds>(span, 0)));
}

}  // namespace

ChainMeter::ChainMeter(const rt::Executive& executive, const rt::Chain& chain, const Arrivals* arrivals,
                       bool on_run_clock, ChainLimits limits)
    : executive_(executive),
      chain_(chain),
      arrivals_(arrivals),
      on_run_clock_(on_run_clock),
      limits_(limits),
      legs_(chain.legs.size()),
      newest_(chain.steps.size(), kNothing) {
  for (std::uint32_t i = 0; i + 1 < chain.legs.size(); ++i) {
    // The reader's record comes a whole job of the reader later than the writer's, and some more behind the
    // disk.
    const std::uint64_t during = executive.group(chain.legs[i + 1].group).timing.period /
                                 executive.group(chain.legs[i].group).timing.period;
    legs_[i].outputs.resize(std::bit_ceil(
        static_cast<std::size_t>(std::min<std::uint64_t>(2 * during, 1u << 18)) + kMostWaiting));
  }
}

void ChainMeter::job(const rt::JobRecord& record, const JobTimes* times) {
  bool concerned = false;
  for (std::uint32_t i = 0; i < legs_.size(); ++i) {
    if (chain_.legs[i].group != record.group) continue;
    legs_[i].waiting.push_back(note_of(record, i, times));
    concerned = true;
  }
  if (!concerned) return;
  for (std::uint32_t i = 0; i < legs_.size(); ++i) {
    Leg& leg = legs_[i];
    while (!leg.waiting.empty()) {
      const Note& front = leg.waiting.front();
      if (i > 0 && front.taken > legs_[i - 1].processed && leg.waiting.size() <= kMostWaiting) break;
      process(i, front);
      leg.waiting.pop_front();
    }
  }
}

ChainMeter::Note ChainMeter::note_of(const rt::JobRecord& record, std::uint32_t leg,
                                     const JobTimes* times) const {
  Note note;
  note.job = record.job;
  note.shed = record.shed;
  note.done = record.verdict == rt::Verdict::done;
  const std::uint16_t port = chain_.legs[leg].port;
  if (leg > 0) {
    if (record.input[port].last >= record.input[port].first) note.taken = record.input[port].last;
  } else if (!chain_.from_stream) {
    note.taken = static_cast<std::int64_t>(record.job);
  } else if (const rt::StreamRange& range = record.stream[port]; range.count != 0) {
    note.taken = static_cast<std::int64_t>(range.first + range.count) - 1;
  }
  note.timed = times != nullptr || on_run_clock_;
  auto finished = static_cast<std::uint64_t>(times != nullptr ? times->started_ns : record.started_ns);
  const std::uint32_t tasks =
      times != nullptr ? static_cast<std::uint32_t>(times->duration_ns.size()) : record.tasks;
  for (std::uint32_t i = 0; i <= chain_.steps.back().task && i < tasks; ++i) {
    finished += times != nullptr ? static_cast<std::uint64_t>(times->duration_ns[i]) : record.duration_ns[i];
  }
  note.finished_ns = static_cast<rt::Nanoseconds>(finished);
  return note;
}

void ChainMeter::process(std::uint32_t index, const Note& note) {
  Leg& leg = legs_[index];
  if (note.taken != kNothing) {
    if (index == 0) {
      // What a job takes from a stream is gone with it, even if the task that wanted it was shed.
      const bool lost = chain_.from_stream && ((note.shed >> chain_.steps[0].task) & 1u) != 0;
      if (!lost) leg.entered = std::max(leg.entered, note.taken);
    } else {
      const std::vector<Known>& written = legs_[index - 1].outputs;
      const Known& known = written[static_cast<std::size_t>(note.taken) & (written.size() - 1)];
      if (known.job == note.taken) {
        leg.entered = std::max(leg.entered, known.newest);
      } else {
        ++unmeasured_;
      }
    }
  }
  // Tasks in the order of the path; a backward read sees what stood there before this job.
  std::int64_t before = kNothing;
  bool first = true;
  bool put = false;
  std::int64_t newest = kNothing;
  for (std::uint32_t i = 0; i < chain_.steps.size(); ++i) {
    const rt::ChainStep& step = chain_.steps[i];
    if (step.leg != index) continue;
    const std::int64_t was = newest_[i];
    put = ((note.shed >> step.task) & 1u) == 0;
    if (put) newest_[i] = first ? leg.entered : step.backward ? before : newest_[i - 1];
    before = was;
    newest = newest_[i];
    first = false;
  }
  leg.processed = static_cast<std::int64_t>(note.job);
  if (index + 1 < legs_.size()) {
    leg.outputs[static_cast<std::size_t>(note.job) & (leg.outputs.size() - 1)] = {leg.processed, newest};
  } else if (put && note.done) {
    put_out(newest, note);
  }
}

bool ChainMeter::arrival(std::int64_t sample, rt::Nanoseconds& ns) const {
  if (arrivals_ != nullptr) return arrivals_->find(static_cast<std::uint64_t>(sample), ns);
  const rt::GroupTiming& timing = executive_.group(chain_.legs[0].group).timing;
  ns = executive_.time_of(timing.release(static_cast<std::uint64_t>(sample)));
  return true;
}

void ChainMeter::hold_age(rt::Nanoseconds age_ns) {
  if (limits_.age_ns == 0 || age_ns <= limits_.age_ns) return;
  ++ages_over_;
  age_over_ns_ = std::max(age_over_ns_, age_ns);
}

void ChainMeter::put_out(std::int64_t newest, const Note& note) {
  if (newest == kNothing) return;
  const rt::GroupTiming& timing = executive_.group(chain_.legs.back().group).timing;
  const rt::Nanoseconds visible = executive_.time_of(timing.due(note.job));
  if (newest <= seen_) {
    // Whether more samples will come is not known yet: a source that has ended does not make outputs older.
    // While the robot runs no source may end, so there the limit holds at once.
    if (!seen_known_) return;
    if (on_run_clock_) hold_age(visible - seen_at_);
    if (repeats_.size() < kMostRepeats) repeats_.push_back(visible);
    return;
  }
  for (const rt::Nanoseconds again : repeats_) {
    record(age_, again - seen_at_);
    if (!on_run_clock_) hold_age(again - seen_at_);
  }
  repeats_.clear();
  // A chain that begins with a task has one sample a job, and jobs may have been skipped.
  std::int64_t sample = chain_.from_stream ? seen_ + 1 : newest;
  // A replay that begins at a keyframe knows of no samples before it.
  if (arrivals_ != nullptr && seen_ == kNothing)
    sample = std::max(sample, std::min(static_cast<std::int64_t>(arrivals_->first()), newest));
  for (; sample <= newest; ++sample) {
    rt::Nanoseconds arrived = 0;
    if (!arrival(sample, arrived)) {
      ++unmeasured_;
      seen_known_ = false;
      continue;
    }
    record(reaction_, visible - arrived);
    if (limits_.reaction_ns != 0 && visible - arrived > limits_.reaction_ns) {
      ++reactions_over_;
      reaction_over_ns_ = std::max(reaction_over_ns_, visible - arrived);
    }
    if (note.timed) record(finished_, between(arrived, note.finished_ns));
    if (seen_known_) source_interval_ns_ = std::max(source_interval_ns_, arrived - seen_at_);
    seen_ = sample;
    seen_at_ = arrived;
    seen_known_ = true;
  }
  if (seen_known_) {
    record(age_, visible - seen_at_);
    hold_age(visible - seen_at_);
  }
  seen_ = newest;
}

}  // namespace sortie::firmware
