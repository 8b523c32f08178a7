// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/bench/wcet_report.hpp"

#include <algorithm>
#include <map>
#include <ostream>
#include <sstream>

#include "firmware_like/scene/input_error.hpp"
#include "firmware_like/scene/json_reader.hpp"
#include "firmware_like/scene/text_format.hpp"
#include "rt/describe.hpp"

namespace sortie::toolchain {

namespace {

// One task in one line.
struct WcetRow {
  std::string task;
  std::string group;
  std::uint64_t jobs{};
  std::uint64_t median{};
  std::uint64_t p99{};
  std::uint64_t worst{};
  std::uint64_t worst_tick{};  ///< the first job that cost the worst
  std::uint64_t total{};       ///< of all jobs: no change of any job leaves it as it was
  double ratio{};              ///< worst over median
  SORTIE_FIELDS(jobs, median, p99, worst, worst_tick, total, ratio)
};

constexpr const char* kBuiltBy = "# built by ";

// Element of rank ceil(share * n), exact.
std::uint64_t rank_of(const std::vector<std::uint64_t>& sorted, std::uint64_t percent) {
  const std::uint64_t rank = (sorted.size() * percent + 99) / 100;
  return sorted[static_cast<std::size_t>(rank == 0 ? 0 : rank - 1)];
}

std::string figures(const WcetRow& row) {
  std::ostringstream out;
  out << row.task << " jobs " << row.jobs << " median " << row.median << " p99 " << row.p99 << " worst "
      << row.worst << " tick " << row.worst_tick << " total " << row.total;
  return out.str();
}

std::string difference(std::uint64_t was, std::uint64_t is) {
  if (was == 0) return {};
  const double percent =
      100.0 * (static_cast<double>(is) - static_cast<double>(was)) / static_cast<double>(was);
  return " (" + std::string(percent < 0 ? "" : "+") + firmware::format_fixed(percent, 2) + " %)";
}

// All tasks that ran, in order of the table.
std::vector<WcetRow> rows_of(const Wcet& wcet) {
  std::vector<WcetRow> rows;
  for (const WcetTask& task : wcet.tasks) {
    if (task.jobs.empty()) continue;
    WcetRow row;
    row.task = task.name;
    row.group = task.group;
    row.jobs = task.jobs.size();
    std::vector<std::uint64_t> sorted;
    for (const CountedJob& job : task.jobs) {
      sorted.push_back(job.instructions);
      row.total += job.instructions;
      if (job.instructions > row.worst) {
        row.worst = job.instructions;
        row.worst_tick = job.tick;
      }
    }
    std::sort(sorted.begin(), sorted.end());
    row.median = rank_of(sorted, 50);
    row.p99 = rank_of(sorted, 99);
    row.ratio = row.median == 0 ? 0 : static_cast<double>(row.worst) / static_cast<double>(row.median);
    rows.push_back(row);
  }
  return rows;
}

}  // namespace

void print_wcet(std::ostream& out, const Wcet& wcet) {
  out << "scene     " << wcet.scene << "\n"
      << firmware::pad_right("task [instructions]", 20) << firmware::pad_right("group", 9);
  for (const char* title : {"jobs", "median", "p99", "worst", "at tick", "worst/median"})
    out << firmware::pad_left(title, 13);
  out << "\n";
  for (const WcetRow& row : rows_of(wcet)) {
    out << firmware::pad_right(firmware::shorten(row.task, 19), 20)
        << firmware::pad_right(firmware::shorten(row.group, 8), 9);
    for (const std::uint64_t value : {row.jobs, row.median, row.p99, row.worst, row.worst_tick})
      out << firmware::pad_left(firmware::group_digits(value), 13);
    out << firmware::pad_left(firmware::format_fixed(row.ratio, 2), 13) << "\n";
  }
  out << "built by  " << wcet.built_by << "\n";
}

firmware::Json to_json(const Wcet& wcet) {
  firmware::Json tasks = firmware::Json::array();
  for (const WcetRow& row : rows_of(wcet)) {
    tasks.push_back({{"name", row.task}, {"group", row.group}});
    tasks.back().update(firmware::json_of(row));
  }
  return {{"scene", wcet.scene}, {"built_by", wcet.built_by}, {"tasks", std::move(tasks)}};
}

void write_wcet_csv(std::ostream& out, const Wcet& wcet) {
  out << "tick,task,instructions\n";
  for (const WcetTask& task : wcet.tasks) {
    for (const CountedJob& job : task.jobs)
      out << job.tick << "," << task.name << "," << job.instructions << "\n";
  }
}

std::string gate_text(const Wcet& wcet, const std::string& command) {
  std::string text = "# Instructions of each task's jobs, exact. " + command + "\n";
  text += kBuiltBy + wcet.built_by + "\n";
  for (const WcetRow& row : rows_of(wcet)) text += figures(row) + "\n";
  return text;
}

WcetVerdict compare_wcet(const Wcet& wcet, const std::string& committed, const std::string& name) {
  std::map<std::string, WcetRow> was;
  std::string built_by;
  std::istringstream text(committed);
  int number = 0;
  for (std::string line; std::getline(text, line);) {
    ++number;
    if (line.rfind(kBuiltBy, 0) == 0) built_by = line.substr(std::string(kBuiltBy).size());
    if (line.empty() || line[0] == '#') continue;
    WcetRow row;
    std::istringstream words(line);
    std::string word[6];
    words >> row.task >> word[0] >> row.jobs >> word[1] >> row.median >> word[2] >> row.p99 >> word[3] >>
        row.worst >> word[4] >> row.worst_tick >> word[5] >> row.total;
    if (!words || figures(row) != line) {
      throw firmware::InputError(name + ":" + std::to_string(number) +
                                 ": not a line of counted instructions; write the file anew with --out");
    }
    was[row.task] = row;
  }
  WcetVerdict verdict;
  if (built_by.empty())
    throw firmware::InputError(name + ": does not say what built the program; write it anew with --out");
  if (built_by != wcet.built_by) {
    verdict.skipped = "counted with " + built_by + ", this is " + wcet.built_by;
    return verdict;
  }
  for (const WcetRow& now : rows_of(wcet)) {
    const auto found = was.find(now.task);
    if (found == was.end()) {
      verdict.failures.push_back("task " + now.task + " is new");
      continue;
    }
    const auto compare = [&](const char* what, std::uint64_t before, std::uint64_t after,
                             const std::string& where) {
      if (before == after) return;
      verdict.failures.push_back("task " + now.task + ": " + what + " was " + std::to_string(before) +
                                 ", is " + std::to_string(after) + difference(before, after) + where);
    };
    compare("jobs", found->second.jobs, now.jobs, "");
    compare("median", found->second.median, now.median, "");
    compare("p99", found->second.p99, now.p99, "");
    compare("total", found->second.total, now.total, "");
    compare("worst", found->second.worst, now.worst, " at tick " + std::to_string(now.worst_tick));
    if (found->second.worst == now.worst)
      compare("tick of the worst", found->second.worst_tick, now.worst_tick, "");
    was.erase(found);
  }
  for (const auto& [task, row] : was) verdict.failures.push_back("task " + task + " is gone");
  return verdict;
}

}  // namespace sortie::toolchain
