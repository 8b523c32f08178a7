// SPDX-License-Identifier: BSD-3-Clause
// The one door to all importers.
#include "toolchain/import/importer.hpp"

#include <cmath>
#include <iterator>

#include "toolchain/import/kinds.hpp"

namespace sortie::toolchain {
namespace {

struct Kind {
  const char* name;
  void (*import)(RowJudge&, LogBuilder&);
};

constexpr Kind kKinds[] = {{"husky", import_husky}, {"plaza", import_plaza},   {"broad", import_broad},
                           {"rls", import_rls},     {"carmen", import_carmen}, {"swp", import_swp}};

void check_options(const ImportOptions& options) {
  if (options.no_poses && options.kind != "rls")
    throw firmware::InputError("--no-poses is for kind rls; a log of kind " + options.kind +
                                   " holds no scan with a pose: leave it out",
                               2);
  if (options.max_range_m != 0.0 && options.kind != "carmen")
    throw firmware::InputError("--max-range is for kind carmen; for kind " + options.kind + " leave it out",
                               2);
  if (!(options.max_range_m >= 0.0 && std::isfinite(options.max_range_m)))
    throw firmware::InputError("--max-range must be a range in m above 0", 2);
}

std::string listed_kinds() {
  std::string list;
  for (const Kind& kind : kKinds) {
    if (!list.empty()) list += &kind == std::end(kKinds) - 1 ? " or " : ", ";
    list += kind.name;
  }
  return list;
}

}  // namespace

void ReturnCounts::add(const ReturnCounts& scan) {
  in += scan.in;
  used += scan.used;
  no_return += scan.no_return;
  out_of_range += scan.out_of_range;
  not_finite += scan.not_finite;
  time_negative += scan.time_negative;
  time_unsorted += scan.time_unsorted;
  time_beyond += scan.time_beyond;
}

std::vector<std::string> import_kinds() {
  std::vector<std::string> names;
  for (const Kind& kind : kKinds) names.emplace_back(kind.name);
  return names;
}

ImportReport import_log(const ImportOptions& options) {
  for (const Kind& kind : kKinds) {
    if (options.kind != kind.name) continue;
    check_options(options);
    ImportReport report;
    LogBuilder builder;
    RowJudge judge(options, report);
    kind.import(judge, builder);
    builder.write(options.out, options.kind, report);
    return report;
  }
  throw firmware::InputError("unknown kind '" + options.kind + "'; use " + listed_kinds(), 2);
}

}  // namespace sortie::toolchain
