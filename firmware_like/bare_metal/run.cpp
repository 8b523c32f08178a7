// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/bare_metal/run.hpp"

#include "rt/virtual_runner.hpp"

namespace sortie::bare {
namespace {

// Without printf: it would be the larger half of the image.
void print_number(const char* name, std::uint64_t value, unsigned base) {
  char text[24];
  char* at = text + sizeof text;
  *--at = '\0';
  unsigned digits = 0;
  do {
    *--at = "0123456789abcdef"[value % base];
    value /= base;
    ++digits;
  } while (value != 0 || (base == 16 && digits < 16));
  print(name);
  print(at);
}

// Feeds every sample at the first tick at or after its arrival.
class Feed final : public rt::JobFeed {
 public:
  Feed(rt::Executive& executive, RecordSink sink) : executive_(executive), sink_(sink) { next(); }

  void before_tick(rt::Tick tick) override {
    while (more_ && record_.arrival_ns <= executive_.time_of(tick)) {
      sink_.take(sink_.self, record_);
      ++records_;
      next();
    }
  }
  bool prepare(std::uint32_t, std::uint64_t, rt::Tick, rt::JobOrder&) override { return true; }

  bool more() const { return more_; }
  bool cut_off() const { return cut_off_; }
  std::uint64_t records() const { return records_; }

 private:
  void next() {
    const std::size_t read = read_recording(&record_, sizeof record_);
    more_ = read == sizeof record_;
    cut_off_ = read != 0 && !more_;
  }

  rt::Executive& executive_;
  RecordSink sink_;
  Record record_{};
  std::uint64_t records_{};
  bool more_{};
  bool cut_off_{};
};

struct JobCounts {
  std::uint64_t all{};
  std::uint32_t most{};
  std::uint64_t jobs{};
  std::uint32_t began{};
};

void probe(void* self, const rt::TaskBase&, rt::Tick, bool entering) {
  auto& counts = *static_cast<JobCounts*>(self);
  if (entering) {
    counts.began = counter();
    return;
  }
  const std::uint32_t cost = counted(counts.began, counter());
  counts.all += cost;
  counts.most = cost > counts.most ? cost : counts.most;
  ++counts.jobs;
}

}  // namespace

void replay(rt::Executive& executive, RecordSink sink) {
  if (executive.seal() != Status::ok || executive.arena().refused() != 0) {
    print("the table cannot be built: ");
    print(executive.error() == nullptr ? "the arena is too small" : executive.error());
    print_number(", bytes needed: ", executive.arena().needed_bytes(), 10);
    print("\n");
    stop(1);
  }
  if (!open_recording()) {
    print("no recording.bin here; tests/tools/bare_recording writes one\n");
    stop(3);
  }
  JobCounts counts;
  executive.set_task_probe(&probe, &counts);
  start_counter();
  Feed feed(executive, sink);
  rt::Tick tick = 0;
  while (feed.more()) {
    rt::run_virtual(executive, feed, tick, tick);
    ++tick;
  }
  if (feed.cut_off()) {
    print("recording.bin ends within a record; write it anew\n");
    stop(3);
  }
  print_number("{\"ticks\":", tick, 10);
  print_number(",\"records\":", feed.records(), 10);
  print_number(",\"digest\":\"", executive.digest(), 16);
  print_number("\",\"arena_bytes\":", executive.arena().used_bytes(), 10);
  print_number(",\"tasks_run\":", counts.jobs, 10);
  print_number(",\"counts\":", counts.all, 10);
  print_number(",\"most_counts\":", counts.most, 10);
  print_number(",\"stack_bytes\":", stack_bytes(), 10);
  print("}\n");
  stop(0);
}

}  // namespace sortie::bare
