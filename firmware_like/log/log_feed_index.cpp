// SPDX-License-Identifier: BSD-3-Clause
// Which jobs of a log a replay takes: as many as are whole, and in their order.
#include <algorithm>
#include <limits>

#include "firmware_like/log/log_event.hpp"
#include "firmware_like/log/log_feed.hpp"

namespace sortie::firmware {

namespace {

// A job's event, as a person finds it.
std::string place_of(const LogFile& log, const StoredEvent& event) {
  const auto number = &event - log.channel(std::string(drivers::kChannelTick)).data();
  return log.path() + ": SORTIE_TICK event " + std::to_string(number) + " (" +
         std::to_string(event.timestamp_us) + " us)";
}

}  // namespace

// A whole log of a live run says how far the run came. Releases before the first job and behind the last one
// were left out by the run, and are here.
void LogFeed::take_run_end(const LogFile& log) {
  constexpr rt::Tick kLongestTail = 1'000'000;  // what nobody has run is walked through all the same
  const auto end = run_end(log);
  const bool is_whole =
      damage_.empty() && log.damage().empty() && jobs_left_out_ == 0 && log.whole_until() == ~rt::Tick{0};
  if (!end || !is_whole || *end <= last_tick_ || *end - last_tick_ > kLongestTail) return;
  first_tick_ = 0;
  last_tick_ = *end - 1;
}

// False: a damaged event, which may say anything; no job of this table.
bool LogFeed::read_job(const StoredEvent& event) {
  if (drivers::decode(event.message, scratch_) != Status::ok || scratch_.group >= groups_.size())
    return false;
  const rt::Group& group = runtime_.executive().group(scratch_.group);
  return scratch_.level <= rt::kTopLevel && scratch_.inputs == group.inputs.size() &&
         scratch_.streams == group.streams.size() && scratch_.tasks == group.tasks.size() &&
         group.timing.is_release(scratch_.job, scratch_.tick) && scratch_.tick <= most_ticks() &&
         std::all_of(scratch_.stream, scratch_.stream + scratch_.streams, [](const rt::StreamRange& range) {
           return range.first <= std::numeric_limits<std::int64_t>::max() &&
                  range.count <= std::numeric_limits<std::int32_t>::max();
         });
}

void LogFeed::index_jobs(const LogFile& log) {
  for (const StoredEvent& event : log.channel(std::string(drivers::kChannelTick))) {
    if (!read_job(event)) {
      // The table of groups is the log's own, so this is damage inside an event, which nothing else can tell.
      damage_ = place_of(log, event) + " is damaged; everything before it is used";
      break;
    }
    GroupCursor& cursor = groups_[scratch_.group];
    if (scratch_.tick >= log.whole_until()) continue;
    const auto job = static_cast<std::int64_t>(scratch_.job);
    if (job <= cursor.newest) {
      // A group's jobs are recorded in their order. Which of the two numbers is wrong nobody can tell, and to
      // leave the later one out would make another run of it.
      damage_ = place_of(log, event) + " holds job " + std::to_string(job) + " of group " +
                runtime_.executive().group(scratch_.group).spec.name + " after job " +
                std::to_string(cursor.newest) + ", so one of them is damaged; everything before it is used";
      break;
    }
    if (cursor.jobs.empty()) cursor.first_tick = scratch_.tick;
    cursor.newest = job;
    const std::size_t inputs = scratch_.inputs;
    for (std::size_t i = 0; i < inputs; ++i) {
      const std::int64_t before = cursor.jobs.empty() ? -1 : cursor.needs[cursor.needs.size() - inputs];
      cursor.needs.push_back(std::max(before, scratch_.input[i].last));
    }
    cursor.jobs.push_back(event);
  }
}

// A log that breaks off may hold a job and not the job of another group whose output it took. Such a job
// cannot be run again, nor can those behind it; leaving them out may orphan others, so this goes on until
// nothing changes.
void LogFeed::leave_out_orphans() {
  const rt::Executive& executive = runtime_.executive();
  for (bool changed = true; changed;) {
    changed = false;
    for (std::uint32_t index = 0; index < executive.group_count(); ++index) {
      GroupCursor& cursor = groups_[index];
      const std::size_t inputs = executive.group(index).inputs.size();
      std::size_t whole = cursor.jobs.size();
      for (std::size_t i = 0; i < inputs; ++i) {
        const std::int64_t there =
            groups_[executive.group(index).inputs[static_cast<std::uint32_t>(i)]->writer_group()].newest;
        // `needs` never falls along the jobs, so the first that is not met is found by halving.
        std::size_t low = 0;
        while (low < whole) {
          const std::size_t half = low + (whole - low) / 2;
          if (cursor.needs[half * inputs + i] > there)
            whole = half;
          else
            low = half + 1;
        }
      }
      if (whole == cursor.jobs.size()) continue;
      jobs_left_out_ += cursor.jobs.size() - whole;
      cursor.jobs.resize(whole);
      cursor.newest = -1;
      if (whole > 0 && drivers::decode(cursor.jobs.back().message, scratch_) == Status::ok)
        cursor.newest = static_cast<std::int64_t>(scratch_.job);
      changed = true;
    }
  }
}

}  // namespace sortie::firmware
