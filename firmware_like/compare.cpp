// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/compare.hpp"

#include <cstdio>
#include <vector>

namespace sortie::firmware {

namespace {

struct Scalar {
  std::string name;
  double value;
  std::uint64_t bits;
};

std::vector<Scalar> scalars_of(const rt::TaskBase& task, const std::uint8_t* canonical) {
  std::vector<Scalar> scalars;
  task.describe(canonical, {&scalars, [](void* self, const char* name, int index, double value,
                                         std::uint64_t bits, std::uint32_t) {
                              std::string full = name;
                              if (index >= 0) full += "[" + std::to_string(index) + "]";
                              static_cast<std::vector<Scalar>*>(self)->push_back({full, value, bits});
                            }});
  return scalars;
}

std::string show(const Scalar& scalar) {
  char text[80];
  std::snprintf(text, sizeof text, "%.17g (0x%llx)", scalar.value,
                static_cast<unsigned long long>(scalar.bits));
  return text;
}

}  // namespace

std::optional<Divergence> compare_jobs(const rt::Executive& executive, const rt::JobRecord& first,
                                       const rt::JobRecord& second) {
  const rt::Group& group = executive.group(first.group);
  std::uint32_t offset = 0;
  for (std::uint32_t i = 0; i < group.tasks.size(); ++i) {
    const rt::TaskBase& task = *group.tasks[i];
    const std::uint32_t bytes = task.output_bytes();
    if (first.digest[i] == second.digest[i]) {
      offset += bytes;
      continue;
    }
    Divergence divergence{first.tick, group.spec.name, task.name(), "", "", ""};
    if (first.field_bytes >= offset + bytes && second.field_bytes >= offset + bytes) {
      const auto was = scalars_of(task, first.fields + offset);
      const auto is = scalars_of(task, second.fields + offset);
      for (std::size_t k = 0; k < was.size() && k < is.size(); ++k) {
        if (was[k].bits == is[k].bits) continue;
        divergence.field = was[k].name;
        divergence.was = show(was[k]);
        divergence.is = show(is[k]);
        break;
      }
    }
    return divergence;
  }
  return std::nullopt;
}

std::string describe(const Divergence& divergence) {
  std::string line = "first difference: tick " + std::to_string(divergence.tick) + ", task " +
                     divergence.task + " (group " + divergence.group + ")";
  if (divergence.field.empty()) return line + "; record with --record-fields to see the field";
  return line + ", field " + divergence.field + ": was " + divergence.was + ", is " + divergence.is;
}

}  // namespace sortie::firmware
