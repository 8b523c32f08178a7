// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/log/compare.hpp"

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

std::string show(const rt::StreamRange& range) {
  return std::to_string(range.count) + " from number " + std::to_string(range.first) + " of stream " +
         std::to_string(range.stream);
}

std::string show(const rt::InputRange& range) {
  return range.last < range.first ? "none"
                                  : std::to_string(range.first) + " to " + std::to_string(range.last);
}

std::string show(const rt::Group& group, std::uint16_t tasks) {
  std::string names;
  for (std::uint32_t i = 0; i < group.tasks.size(); ++i) {
    if (((tasks >> i) & 1u) != 0) names += (names.empty() ? "" : ", ") + std::string(group.tasks[i]->name());
  }
  if ((tasks >> group.tasks.size()) != 0) names += (names.empty() ? "" : ", ") + std::string("others");
  return names.empty() ? "none" : names;
}

bool is_read(const rt::Executive& executive, std::uint16_t writer) {
  for (std::uint32_t i = 0; i < executive.group_count(); ++i) {
    for (const rt::InputBase* input : executive.group(i).inputs) {
      if (input->writer_group() == writer) return true;
    }
  }
  return false;
}

}  // namespace

const char* to_string(rt::Verdict verdict) {
  return verdict == rt::Verdict::done ? "done" : verdict == rt::Verdict::missed ? "missed" : "pending";
}

std::optional<Divergence> compare_decisions(const rt::Executive& executive, const rt::JobRecord& first,
                                            const rt::JobRecord& second) {
  const rt::Group& group = executive.group(first.group);
  const auto differ = [&](const char* task, std::string what, std::string was, std::string is) {
    return Divergence{first.tick,     group.spec.name, task, std::move(what),
                      std::move(was), std::move(is),   true};
  };
  for (std::uint32_t i = 0; i < group.streams.size(); ++i) {
    const rt::StreamRange& was = first.stream[i];
    const rt::StreamRange& is = second.stream[i];
    if (was.first != is.first || was.count != is.count || was.stream != is.stream)
      return differ("", std::string("samples of stream ") + group.streams[i]->name(), show(was), show(is));
  }
  for (std::uint32_t i = 0; i < group.inputs.size(); ++i) {
    const rt::InputRange& was = first.input[i];
    const rt::InputRange& is = second.input[i];
    if (was.first != is.first || was.last != is.last)
      return differ("", std::string("jobs taken of task ") + executive.task(group.inputs[i]->task()).name(),
                    show(was), show(is));
  }
  if (first.level != second.level)
    return differ("", "level", std::to_string(first.level), std::to_string(second.level));
  if (first.shed != second.shed)
    return differ("", "tasks left out at level " + std::to_string(first.level), show(group, first.shed),
                  show(group, second.shed));
  for (std::uint32_t i = 0; i < group.tasks.size(); ++i) {
    const char* const task = group.tasks[i]->name();
    const bool was_cut = ((first.cut >> i) & 1u) != 0;
    const bool is_cut = ((second.cut >> i) & 1u) != 0;
    if (was_cut != is_cut)
      return differ(task, "cut", (was_cut ? "after " : "none, ") + std::to_string(first.units[i]) + " units",
                    (is_cut ? "after " : "none, ") + std::to_string(second.units[i]) + " units");
    if (first.units[i] != second.units[i])
      return differ(task, "units", std::to_string(first.units[i]), std::to_string(second.units[i]));
  }
  if (first.verdict != second.verdict)
    return differ("", "verdict", to_string(first.verdict), to_string(second.verdict));
  return std::nullopt;
}

std::optional<Divergence> compare_with_times(const rt::Executive& executive, const rt::JobRecord& recorded,
                                             const JobTimes& times) {
  const rt::Group& group = executive.group(recorded.group);
  rt::Nanoseconds ended = times.started_ns;
  for (const std::int64_t spent : times.duration_ns) {
    if (spent < 0 || spent >= 0xffffffff) return std::nullopt;  // longer than the log can say
    ended =
        static_cast<rt::Nanoseconds>(static_cast<std::uint64_t>(ended) + static_cast<std::uint64_t>(spent));
  }
  const rt::Nanoseconds due = executive.time_of(group.timing.due(recorded.job));
  const bool in_time = ended <= due;
  if (in_time == (recorded.verdict == rt::Verdict::done)) return std::nullopt;
  // Whoever takes its outputs or its commands may have asked between its last task and its end.
  if (in_time && (is_read(executive, recorded.group) || group.outlets.size() != 0)) return std::nullopt;
  const auto apart = static_cast<std::uint64_t>(in_time ? due - ended : ended - due) / 1000;
  return wrong_verdict(executive, recorded,
                       std::string(in_time ? "done" : "missed") + " by its times: it ended " +
                           std::to_string(apart) + (in_time ? " us before" : " us after") + " the deadline");
}

Divergence wrong_verdict(const rt::Executive& executive, const rt::JobRecord& recorded, std::string is) {
  const std::string group = executive.group(recorded.group).spec.name;
  return {recorded.tick, group, "", "verdict", to_string(recorded.verdict), std::move(is), true};
}

std::optional<Divergence> compare_outputs(const rt::Executive& executive, const rt::JobRecord& first,
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
  std::string line = "first difference: tick " + std::to_string(divergence.tick) + ", ";
  line += divergence.task.empty() ? "group " + divergence.group
                                  : "task " + divergence.task + " (group " + divergence.group + ")";
  if (divergence.field.empty()) return line + "; record with --record-fields to see the field";
  return line + (divergence.decided ? ", " : ", field ") + divergence.field + ": was " + divergence.was +
         ", is " + divergence.is;
}

}  // namespace sortie::firmware
