// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/log/log_event.hpp"

#include <string>
#include <vector>

namespace sortie::firmware {

void log_event(SampleSink& log, drivers::EventRecord event, rt::Nanoseconds run_time_ns,
               rt::Nanoseconds utc_minus_run_ns) {
  event.utime = (run_time_ns + utc_minus_run_ns) / rt::kNanosecondsPerMicrosecond;
  std::vector<std::uint8_t> message(256 + event.kind.size() + event.subject.size() + event.text.size());
  std::size_t size = 0;
  if (drivers::encode(event, message, size) == Status::ok)
    log.sample(std::string(drivers::kChannelEvent), run_time_ns, {message.data(), size});
}

}  // namespace sortie::firmware
