// SPDX-License-Identifier: BSD-3-Clause
// The one door to all importers.
#include "toolchain/import/importer.hpp"

#include "toolchain/import/kinds.hpp"

namespace sortie::toolchain {
namespace {

struct Kind {
  const char* name;
  void (*import)(RowJudge&, LogBuilder&);
};

constexpr Kind kKinds[] = {
    {"husky", import_husky}, {"plaza", import_plaza}, {"broad", import_broad}, {"rls", import_rls}};

}  // namespace

std::vector<std::string> import_kinds() {
  std::vector<std::string> names;
  for (const Kind& kind : kKinds) names.emplace_back(kind.name);
  return names;
}

ImportReport import_log(const ImportOptions& options) {
  for (const Kind& kind : kKinds) {
    if (options.kind != kind.name) continue;
    ImportReport report;
    LogBuilder builder;
    RowJudge judge(options, report);
    kind.import(judge, builder);
    builder.write(options.out, options.kind, report);
    return report;
  }
  throw firmware::InputError("unknown kind '" + options.kind + "'; use husky, plaza, broad or rls", 2);
}

}  // namespace sortie::toolchain
