// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/event_desk.hpp"

#include <string>
#include <vector>

#include "firmware_like/live_events.hpp"

namespace sortie::firmware {

void EventDesk::take(rt::posix::LiveRunner& runner) {
  rt::posix::LiveEvent event;
  for (int i = 0; i < 1024 && runner.poll_event(event); ++i) {
    drivers::EventRecord record = to_record(event, runtime_.executive(), utc_minus_run_ns_);
    const std::size_t bytes = 256 + record.kind.size() + record.subject.size() + record.text.size();
    std::vector<std::uint8_t> message(bytes);
    std::size_t size = 0;
    if (drivers::encode(record, message, size) == Status::ok) {
      recorder_.sample(std::string(drivers::kChannelEvent), runtime_.executive().time_of(event.tick),
                       {message.data(), size});
    }
    telemetry_.tell(record);
    ring_.event(runtime_.executive().time_of(event.tick), event.tick, record.text);
    ++count;
  }
}

}  // namespace sortie::firmware
