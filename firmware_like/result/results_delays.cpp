// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/result/results_delays.hpp"

#include <algorithm>

#include "firmware_like/scene/json_reader.hpp"
#include "rt/posix/delay_statistics.hpp"

namespace sortie::firmware {

namespace {

double us(rt::Nanoseconds ns) { return static_cast<double>(ns) * 1e-3; }

DelayTableResult collect(const rt::posix::DelayTable& table) {
  DelayTableResult result;
  result.outliers = table.outliers;
  result.raw_max_us = us(static_cast<rt::Nanoseconds>(table.raw.max()));
  result.clean_max_us = us(static_cast<rt::Nanoseconds>(table.clean_max_ns));
  result.clean_count = table.clean_count;
  for (int i = 0; i < rt::posix::kDelayCauses; ++i) {
    if (table.count[i] == 0 && table.total_ns[i] == 0) continue;
    result.causes[rt::posix::to_string(static_cast<rt::posix::DelayCause>(i))] = {table.count[i],
                                                                                  us(table.total_ns[i])};
  }
  return result;
}

Json to_json(const DelayTableResult& table) {
  Json causes = Json::object();
  for (const auto& [name, cause] : table.causes) causes[name] = json_of(cause);
  Json object = json_of(table);
  object["causes"] = std::move(causes);
  return object;
}

DelayTableResult table_from(const Json& object, const std::string& place) {
  const JsonReader in(object, place);
  DelayTableResult table;
  in.read_fields(table);
  if (const Json* causes = in.find("causes")) {
    for (const auto& [name, value] : in.check(causes->is_object(), "causes", *causes, "an object").items()) {
      JsonReader(value, place + "causes: ").read_fields(table.causes[name]);
    }
  }
  return table;
}

}  // namespace

GroupDelays collect_delays(const rt::posix::DelayStatistics& statistics) {
  GroupDelays delays;
  delays.known = statistics.start.raw.count() != 0;
  if (!delays.known) return delays;
  delays.start = collect(statistics.start);
  delays.execution = collect(statistics.execution);
  constexpr std::uint64_t kLast = rt::posix::DelayStatistics::kLast;
  const std::uint64_t count = std::min<std::uint64_t>(statistics.outliers, kLast);
  for (std::uint64_t i = statistics.outliers - count; i < statistics.outliers; ++i) {
    const rt::posix::DelayOutlier& outlier = statistics.last[i % kLast];
    DelayResult delay;
    delay.tick = outlier.tick;
    delay.kind = outlier.kind == rt::posix::DelayKind::start ? "start" : "execution";
    delay.late_us = us(outlier.late_ns);
    delay.cause = rt::posix::to_string(outlier.split.main_cause());
    for (int cause = 0; cause < rt::posix::kDelayCauses; ++cause) {
      if (outlier.split.ns[cause] != 0)
        delay.split_us[rt::posix::to_string(static_cast<rt::posix::DelayCause>(cause))] =
            us(outlier.split.ns[cause]);
    }
    delays.last.push_back(std::move(delay));
  }
  return delays;
}

Json to_json(const GroupDelays& delays) {
  Json last = Json::array();
  for (const DelayResult& delay : delays.last) {
    Json split = Json::object();
    for (const auto& [name, part] : delay.split_us) split[name] = json_number(part);
    Json object = json_of(delay);
    object["split_us"] = std::move(split);
    last.push_back(std::move(object));
  }
  return Json{
      {"start", to_json(delays.start)}, {"execution", to_json(delays.execution)}, {"last", std::move(last)}};
}

GroupDelays delays_from_json(const Json& object, const std::string& place) {
  const JsonReader in(object, place);
  GroupDelays delays;
  delays.known = true;
  if (const Json* start = in.find("start")) delays.start = table_from(*start, place + "start: ");
  if (const Json* execution = in.find("execution"))
    delays.execution = table_from(*execution, place + "execution: ");
  in.list("last", [&](const Json& entry) {
    const JsonReader one(entry, place + "last: ");
    DelayResult delay;
    one.read_fields(delay);
    if (const Json* split = one.find("split_us")) {
      for (const auto& [name, part] : one.check(split->is_object(), "split_us", *split, "an object").items())
        delay.split_us[name] = one.figure(name.c_str(), part);
    }
    delays.last.push_back(std::move(delay));
  });
  return delays;
}

}  // namespace sortie::firmware
