// SPDX-License-Identifier: BSD-3-Clause
// How a command shows its result. The table that ends a run is what a person wants to know first, in one
// screen.
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>

#include "firmware_like/result/results.hpp"
#include "firmware_like/scene/json.hpp"
#include "firmware_like/scene/text_format.hpp"

namespace sortie::firmware {
namespace {

constexpr std::size_t kWidth = 100;
constexpr std::size_t kMostCounters = 12;
constexpr std::size_t kMostWarnings = 3;

/// Pieces of text joined by `gap`, broken before column 100, continued under the first piece.
class Wrapped {
 public:
  Wrapped(std::ostream& out, const std::string& title, const char* gap = "   ")
      : out_(out), gap_(gap), column_(kIndent) {
    out_ << title << std::string(kIndent > title.size() ? kIndent - title.size() : 1, ' ');
  }
  void add(const std::string& piece, std::size_t visible) {
    if (column_ > kIndent && column_ + gap_.size() + visible > kWidth) {
      out_ << '\n' << std::string(kIndent, ' ');
      column_ = kIndent;
    }
    if (column_ > kIndent) {
      out_ << gap_;
      column_ += gap_.size();
    }
    out_ << piece;
    column_ += visible;
  }
  void add(const std::string& piece) { add(piece, piece.size()); }
  void end() { out_ << '\n'; }

 private:
  static constexpr std::size_t kIndent = 10;
  std::ostream& out_;
  std::string gap_;
  std::size_t column_;
};

struct Paint {
  bool on;
  std::string red(const std::string& text) const { return on ? "\033[31m" + text + "\033[0m" : text; }
  std::string bold(const std::string& text) const { return on ? "\033[1m" + text + "\033[0m" : text; }
};

/// A sentence broken between words.
void print_words(std::ostream& out, const std::string& title, const std::string& text, const Paint& paint) {
  Wrapped line(out, title, " ");
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    if (end > begin) line.add(paint.red(text.substr(begin, end - begin)), end - begin);
    begin = end + 1;
  }
  line.end();
}

void print_tasks(std::ostream& out, const Results& results, const Paint& paint) {
  std::size_t name_width = 9;
  std::size_t group_width = 5;
  for (const TaskResult& task : results.tasks) {
    name_width = std::max(name_width, std::min<std::size_t>(task.name.size(), 18));
    group_width = std::max(group_width, std::min<std::size_t>(task.group.size(), 8));
  }
  const auto row = [&](const std::string& name, const std::string& group, const auto&... cells) {
    out << pad_right(shorten(name, name_width), name_width) << "  "
        << pad_right(shorten(group, group_width), group_width);
    ((out << "  " << pad_left(cells, 7)), ...);
  };
  row("task [us]", "group", "period", "budget", "p50", "p99", "p99.9", "max");
  out << pad_left("jobs", 10) << pad_left("missed", 8) << '\n';
  for (const TaskResult& task : results.tasks) {
    const std::string most = pad_left(format_short(task.max_us), 7);
    const bool over = task.budget_us > 0.0 && task.max_us > task.budget_us;
    row(task.name, task.group, format_short(task.period_us),
        task.budget_us > 0.0 ? format_short(task.budget_us) : "-", format_short(task.p50_us),
        format_short(task.p99_us), format_short(task.p999_us));
    out << "  " << (over ? paint.red(most) : most) << pad_left(std::to_string(task.count), 10);
    const std::string missed = pad_left(std::to_string(task.missed), 8);
    out << (task.missed > 0 ? paint.red(missed) : missed) << '\n';
  }
}

// "start: 3 run queue (0.5 ms), 1 stolen (7.8 ms), clean max 12 us"
std::string causes_in_words(const char* kind, const DelayTableResult& table) {
  std::string text = std::string(kind) + ":";
  const char* gap = " ";
  for (const auto& [name, cause] : table.causes) {
    if (cause.count == 0) continue;
    text +=
        gap + group_digits(cause.count) + " " + name + " (" + format_short(cause.total_us * 1e-3) + " ms)";
    gap = ", ";
  }
  return text + ", max without what lies outside " + format_short(table.clean_max_us) + " us";
}

void print_causes(std::ostream& out, const Results& results) {
  for (const GroupResult& group : results.groups) {
    if (group.delays.start.outliers + group.delays.execution.outliers == 0) continue;
    Wrapped line(out, "causes");
    line.add(group.name);
    if (group.delays.start.outliers > 0) line.add(causes_in_words("start", group.delays.start));
    if (group.delays.execution.outliers > 0) line.add(causes_in_words("execution", group.delays.execution));
    line.end();
  }
}

// The table of tasks is of the machine that runs this command; where that replays, these are the robot's.
void print_live(std::ostream& out, const Results& results) {
  bool same = true;
  for (std::size_t i = 0; i < results.live.tasks.size() && i < results.tasks.size(); ++i)
    same = same && results.live.tasks[i].max_us == results.tasks[i].max_us;
  if (!results.live.known || same) return;
  Wrapped line(out, "on robot");
  for (const LiveTask& task : results.live.tasks) {
    line.add(task.name + " [us] p50 " + format_short(task.p50_us) + "  p99 " + format_short(task.p99_us) +
             "  max " + format_short(task.max_us));
  }
  line.end();
}

void print_releases(std::ostream& out, const Results& results, const Paint& paint) {
  for (const GroupResult& group : results.groups) {
    if (group.lateness.empty()) continue;
    Wrapped line(out, "release");
    line.add(group.name + " late [us] p50 " + format_short(group.late_p50_us) + "  p99 " +
             format_short(group.late_p99_us) + "  max " + format_short(group.late_max_us));
    if (group.wake_known) line.add("spinning " + format_fixed(100 * group.spinning, 1) + " %");
    if (group.skipped > 0) {
      const std::string text = "left out " + group_digits(group.skipped);
      line.add(paint.red(text), text.size());
    }
    if (group.worst_in_row > 1) line.add("worst in a row " + group_digits(group.worst_in_row));
    line.end();
  }
}

void print_pools(std::ostream& out, const Results& results, const Paint& paint) {
  Wrapped line(out, "pools");
  for (const PoolResult& pool : results.pools) {
    const double share =
        pool.capacity > 0 ? 100.0 * static_cast<double>(pool.high_water) / static_cast<double>(pool.capacity)
                          : 0.0;
    std::string text = pool.name + " " + group_digits(pool.high_water) + "/" + group_digits(pool.capacity) +
                       " (" + format_fixed(share, 0) + " %)";
    std::size_t visible = text.size();
    if (pool.refused > 0) {
      const std::string refused = ", refused " + group_digits(pool.refused);
      visible += refused.size();
      text += paint.red(refused);
    }
    line.add(text, visible);
  }
  line.end();
}

}  // namespace

void print_table(std::ostream& out, const Results& results, bool colour) {
  const Paint paint{colour};
  Wrapped head(out, "scene");
  head.add(paint.bold(results.scene.empty() ? "-" : results.scene), results.scene.size());
  if (!results.vehicle.empty()) head.add("vehicle " + results.vehicle);
  head.add(group_digits(results.ticks) + " ticks");
  if (results.duration_s > 0.0) head.add(format_short(results.duration_s) + " s");
  if (results.speed > 0.0) head.add(format_short(results.speed) + " x real time");
  head.end();
  if (!results.errors.empty()) {
    Wrapped line(out, "errors");
    for (const auto& [name, value] : results.errors) line.add(name + " " + format_short(value));
    line.end();
  }
  if (!results.tasks.empty()) print_tasks(out, results, paint);
  print_live(out, results);
  print_releases(out, results, paint);
  print_causes(out, results);
  print_chains(out, results.chains);
  if (!results.pools.empty()) print_pools(out, results, paint);
  std::size_t shown = 0;
  std::size_t more = 0;
  for (const auto& [name, value] : results.counters) (value > 0 && ++shown > kMostCounters) ? ++more : more;
  if (shown > 0) {
    Wrapped line(out, "counters");
    // The one counter whose zero is a result.
    const auto heap = results.counters.find("heap_calls");
    if (heap != results.counters.end()) line.add("heap_calls " + group_digits(heap->second));
    std::size_t left = kMostCounters;
    for (const auto& [name, value] : results.counters) {
      if (value > 0 && left > 0 && name != "heap_calls") {
        line.add(name + " " + group_digits(value));
        --left;
      }
    }
    if (more > 0) line.add("and " + std::to_string(more) + " more (--json shows all)");
    line.end();
  }
  if (results.doctor.present) {
    const bool bad = results.doctor.verdict() == Health::bad;
    print_words(out, "doctor", results.doctor.summary() + (bad ? " (sortie doctor: why, and the cure)" : ""),
                Paint{paint.on && bad});
  }
  for (std::size_t i = 0; i < std::min(results.warnings.size(), kMostWarnings); ++i) {
    print_words(out, "warning", results.warnings[i], paint);
  }
  if (results.warnings.size() > kMostWarnings) {
    out << "warning   and " << results.warnings.size() - kMostWarnings << " more (--json shows all)\n";
  }
  if (!results.digest.empty()) out << "digest    " << paint.bold(results.digest) << '\n';
}

void print_results(const Results& results, bool json, const std::vector<std::string>* judged) {
  if (!json) return print_table(std::cout, results, wants_colour(STDOUT_FILENO));
  Json object = to_json(results);
  if (judged != nullptr) {
    object["passed"] = judged->empty();
    object["failures"] = *judged;
  }
  std::cout << object.dump(2) << "\n";
}

void print_failures(const std::vector<std::string>& failures, bool json) {
  for (const std::string& failure : failures) (json ? std::cerr : std::cout) << "FAILED  " << failure << "\n";
}

bool wants_colour(int fd) {
  const char* no_colour = std::getenv("NO_COLOR");
  return isatty(fd) == 1 && (no_colour == nullptr || *no_colour == '\0');
}

}  // namespace sortie::firmware
