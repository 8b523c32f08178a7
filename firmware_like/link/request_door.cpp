// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/link/request_door.hpp"

#include <unistd.h>

#include "drivers/datagram_filter.hpp"
#include "firmware_like/result/results.hpp"
#include "rt/posix/clock.hpp"

namespace sortie::firmware {

namespace {

std::string computer_name() {
  char name[65] = {};  // HOST_NAME_MAX and its end
  return ::gethostname(name, sizeof name - 1) == 0 && *name != '\0' ? name : "robot";
}

}  // namespace

std::string RequestDoor::open(const std::string& url) {
  const RequestAccess& access = runtime_.request_access();
  std::string what;
  std::string section;
  bool moves = false;
  for_each_desk([&](const auto& desk) {
    if (!desk.wanted()) return;
    const RequestTopic& topic = std::decay_t<decltype(desk)>::Kind::kTopic;
    what += (what.empty() ? "" : " and ") + std::string(topic.verb) + " " + std::string(topic.object);
    if (section.empty()) section = topic.section;
    moves = moves || topic.has_task();
  });
  if (what.empty()) return {};
  if (url == "none" || url.empty()) return "[" + section + "] remote has no effect without an LCM address";
  robot_ = access.robot.empty() ? computer_name() : access.robot;
  if (!access.secret_file.empty()) key_ = read_secret(access.secret_file);
  if (!key_ && !access.without_secret)
    return "no requests are taken, for there is no secret: head -c 16 /dev/urandom | xxd -p > robot.secret "
           "&& chmod 600 robot.secret, then [parameters] secret_file = \"robot.secret\"; on a bench "
           "of your own without_secret = true lets anybody " +
           what;
  try {
    const std::int64_t session = unguessable_number();  // without one nobody could be told from a recording
    receiver_ = std::make_unique<drivers::LcmReceiver>(url);
    session_ = session;
  } catch (const std::exception& error) {
    return std::string("no requests are taken: ") + error.what();
  }
  std::string note;
  if (!key_) note = "anybody who reaches " + url + " can " + what + "; [parameters] secret_file closes that";
  try {
    if (moves) stops_ = std::make_unique<drivers::LcmReceiver>(url, drivers::stop_filter());
  } catch (const std::exception& error) {
    note += (note.empty() ? "" : "; ") + std::string("stops share the queue of all traffic: ") + error.what();
  }
  return note;
}

void RequestDoor::run_script(rt::Nanoseconds now_ns) {
  const std::vector<ScriptLine>& script = runtime_.script();
  while (next_line_ < script.size() && script[next_line_].at_s * 1e9 <= static_cast<double>(now_ns)) {
    const ScriptLine& line = script[next_line_];
    static_cast<void>(parameters().set(line.name, line.value, now_ns));  // counted
    ++next_line_;
  }
}

void RequestDoor::poll(rt::Nanoseconds now_ns) {
  run_script(now_ns);
  for_each_desk([now_ns](auto& desk) { desk.hand_in(now_ns); });
  if (stops_) drain(*stops_, now_ns);
  if (receiver_) drain(*receiver_, now_ns);
}

void RequestDoor::drain(drivers::LcmReceiver& receiver, rt::Nanoseconds now_ns) {
  constexpr int kMostDatagrams = 256;  // a flood must not keep the script waiting
  drivers::ReceivedMessage received;
  for (int i = 0; i < kMostDatagrams; ++i) {
    const Status status = receiver.receive(received, 0);
    if (status == Status::empty || status == Status::disconnected) return;
    if (status != Status::ok) continue;
    const RequestContext context{
        key(),
        session_,
        now_ns,
        {received.stamp_ns, rt::posix::read_clock(CLOCK_REALTIME),  // the clock that stamps datagrams
         key_ ? runtime_.request_access().most_clock_offset_ns : 0}};
    for_each_desk([&](auto& desk) {
      if (received.message.channel == std::decay_t<decltype(desk)>::Kind::kTopic.channel)
        desk.take(received.message.payload, context);
    });
  }
}

void RequestDoor::add_counters(std::map<std::string, std::uint64_t>& out) const {
  for_each_desk([&out](const auto& desk) {
    if (desk.counts()) firmware::add_counters(desk.kCounters, desk.counters(), out);
  });
  if (receiver_ == nullptr) return;
  const drivers::LcmReceiverCounters& network = receiver_->counters();
  out["network_messages"] = network.messages;
  out["network_fragments"] = network.fragments;
  out["network_malformed"] = network.malformed;
  out["network_socket_errors"] = network.socket_errors;
}

drivers::ParametersMessage RequestDoor::describe() const {
  drivers::ParametersMessage message;
  message.session = session_;
  message.scene = runtime_.profile().name();
  message.remote = listens() && parameters().wanted();
  message.keyed = key_.has_value();
  parameters().describe(message);
  return message;
}

}  // namespace sortie::firmware
