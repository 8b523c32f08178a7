// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/commands/parameter_client.hpp"

#include <algorithm>
#include <stdexcept>

#include "firmware_like/link/secret.hpp"

namespace sortie::toolchain {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kRepeat{300};  // a run answers within its telemetry's 100 ms
constexpr std::chrono::milliseconds kSettle{
    1000};                             // from the answer to the value in force, in telemetry's steps
constexpr std::size_t kMostRuns = 64;  // strangers must not fill the memory

}  // namespace

drivers::LcmPublisherConfig request_publisher(const std::string& url) {
  drivers::LcmPublisherConfig config;
  config.url = url;
  config.slots = 16;
  config.slot_bytes = 256;
  return config;
}

std::int64_t utc_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

std::string unheard(const std::string& url) {
  return "no run with parameters was heard on " + url +
         "; is one there (`sortie run --scene NAME`), on this computer if ttl=0?";
}

ParameterClient::ParameterClient(const std::string& url, std::optional<drivers::SipKey> key)
    : receiver_(url), publisher_(request_publisher(url)), key_(key), sender_(firmware::unguessable_number()) {
  if (!publisher_.active()) throw std::runtime_error(publisher_.problem());
}

// True when the chosen run (or, before one is chosen, any run) has said something new.
bool ParameterClient::listen(std::chrono::milliseconds most) {
  const auto end = Clock::now() + most;
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
    if (left < 0) return false;
    drivers::ReceivedMessage received;
    if (receiver_.receive(received, static_cast<int>(std::min<std::int64_t>(left + 1, 100))) != Status::ok)
      continue;
    if (received.message.channel != drivers::kChannelParameters) continue;
    drivers::ParametersMessage message;
    if (drivers::decode(received.message.payload, message) != Status::ok) continue;
    const auto known = std::find_if(heard_.begin(), heard_.end(),
                                    [&message](const auto& run) { return run.session == message.session; });
    if (known != heard_.end()) {
      *known = message;
    } else if (heard_.size() < kMostRuns) {
      heard_.push_back(message);
    }
    if (session_ != 0 && message.session != session_) continue;
    newest_ = std::move(message);
    return true;
  }
}

std::vector<std::int64_t> ParameterClient::find_runs(std::int64_t session, std::chrono::milliseconds most) {
  constexpr std::chrono::milliseconds kEveryRun{1300};  // each speaks once a second
  auto end = Clock::now() + most;
  const auto is_heard = [this](std::int64_t wanted) {
    return std::any_of(heard_.begin(), heard_.end(),
                       [wanted](const auto& run) { return run.session == wanted; });
  };
  bool first = true;
  while (Clock::now() < end && (session == 0 || !is_heard(session))) {
    if (!listen(std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()))) break;
    if (first) end = std::min(end, Clock::now() + (session == 0 ? kEveryRun : most));
    first = false;
  }
  std::vector<std::int64_t> sessions;
  for (const drivers::ParametersMessage& run : heard_) sessions.push_back(run.session);
  return sessions;
}

void ParameterClient::choose(std::int64_t session) {
  session_ = session;
  for (const drivers::ParametersMessage& run : heard_) {
    if (run.session == session) newest_ = run;
  }
}

const drivers::ParameterInForce* ParameterClient::find(const std::string& name) const {
  for (const drivers::ParameterInForce& parameter : newest_.parameters) {
    if (parameter.name == name) return &parameter;
  }
  return nullptr;
}

RequestOutcome ParameterClient::set(const std::string& name, double value, std::chrono::milliseconds most) {
  RequestOutcome outcome;
  if (const auto* now = find(name); now != nullptr) outcome.before = outcome.after = now->value;
  auto end = Clock::now() + most;
  auto next = Clock::now();
  std::int64_t counter = 0;
  bool answered = false;
  while (Clock::now() < end) {
    if (!answered && Clock::now() >= next) {
      next = Clock::now() + kRepeat;
      // The same counter again, unless somebody else's request has overtaken it.
      if (counter <= newest_.counter) counter = newest_.counter + 1;
      const drivers::SetParameter request{utc_us(), session_, sender_, counter, name, value};
      // What the network does not take is sent again.
      static_cast<void>(publisher_.publish_encoded(
          drivers::kChannelSet, [&](std::span<std::uint8_t> out, std::size_t& size) {
            return drivers::encode(request, key_ ? &*key_ : nullptr, out, size);
          }));
    }
    const auto until = answered ? end : std::min(end, next);
    if (!listen(std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now()))) continue;
    for (const drivers::ParameterAnswer& answer : newest_.answers) {
      if (answered || answer.sender != sender_ || answer.counter != counter) continue;
      answered = true;
      outcome.status = static_cast<Status>(answer.status);
      outcome.end = outcome.status == Status::ok ? RequestEnd::not_applied : RequestEnd::refused;
      end = std::min(end, Clock::now() + kSettle);
    }
    if (const auto* now = find(name); now != nullptr) outcome.after = now->value;
    if (outcome.end == RequestEnd::refused) return outcome;
    if (answered && outcome.after == value) {
      outcome.end = RequestEnd::in_force;
      return outcome;
    }
  }
  return outcome;
}

}  // namespace sortie::toolchain
