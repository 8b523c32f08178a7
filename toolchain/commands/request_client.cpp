// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/commands/request_client.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <stdexcept>

#include "firmware_like/link/secret.hpp"
#include "firmware_like/scene/profile.hpp"
#include "firmware_like/scene/text_format.hpp"

namespace sortie::toolchain {

namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kEveryRobot{350};        // each speaks ten times a second
constexpr milliseconds kEveryParameters{1300};  // once a second
constexpr milliseconds kEveryRun{1500};
constexpr std::size_t kMostRobots = 64;  // strangers must not fill the memory
constexpr std::int64_t kOld_us = 5'000'000;
constexpr std::int64_t kOvertake =
    1000;  // beside a sender of 1 kHz whom the robot tells of ten times a second
// Counted on from by adding: what nobody ever reached is no counter.
constexpr std::int64_t kMostCounter = std::numeric_limits<std::int64_t>::max() / 2;

milliseconds until(Clock::time_point end) {
  return std::chrono::duration_cast<milliseconds>(end - Clock::now());
}

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

// What was heard while looking for a robot.
struct RequestClient::Search {
  std::map<std::int64_t, Heard> robots;  // by session
  bool other_secret{};
  bool needs_secret{};
  bool has_none{};     // the run is open to everybody, a secret was given
  std::string closed;  // name of a robot that takes no requests for want of a secret
  std::string scene;   // of a run that was heard at all
  bool any() const {
    return !robots.empty() || other_secret || needs_secret || has_none || !closed.empty() || !scene.empty();
  }
};

RequestClient::RequestClient(const std::string& url, std::optional<drivers::SipKey> key,
                             const firmware::RequestTopic& topic)
    : url_(url),
      receiver_(url),
      publisher_(request_publisher(url)),
      key_(key),
      topic_(topic),
      channel_(topic.has_task() ? std::string(drivers::kChannelAnswers) + "_" + std::string(topic.task)
                                : std::string(drivers::kChannelParameters)),
      sender_(firmware::unguessable_number()) {
  if (!publisher_.active()) throw std::runtime_error(publisher_.problem());
}

// What a run says of the task, or of its parameters: then its session is its name. Status: as the codec's;
// `malformed` also for what cannot be believed or is of another task.
Status RequestClient::read(std::span<const std::uint8_t> payload, const drivers::SipKey* key,
                           Heard& heard) const {
  if (topic_.has_task()) {
    if (const Status form = drivers::decode(payload, key, static_cast<drivers::AnswersMessage&>(heard));
        form != Status::ok)
      return form;
    const bool fits = heard.task == topic_.task && heard.counter >= 0 && heard.counter <= kMostCounter;
    return fits ? Status::ok : Status::malformed;
  }
  if (const Status form = drivers::decode(payload, heard); form != Status::ok) return form;
  heard.robot = firmware::hex(static_cast<std::uint64_t>(heard.session));
  heard.counter = std::clamp<std::int64_t>(heard.counter, 0, kMostCounter);
  return Status::ok;
}

void RequestClient::note(const drivers::Lc02Message& message, Search& search) const {
  drivers::ParametersMessage run;
  if (topic_.has_task() && message.channel == drivers::kChannelParameters &&
      drivers::decode(message.payload, run) == Status::ok)
    search.scene = run.scene;
  Heard said;
  if (message.channel != channel_ || read(message.payload, nullptr, said) != Status::ok) return;
  if (topic_.has_task() && said.session == 0) {
    search.closed = said.robot;
  } else if (topic_.has_task() && !key_ && said.keyed) {
    search.needs_secret = true;
  } else if (topic_.has_task() && key_ && !said.keyed) {
    search.has_none = true;
  } else if (topic_.has_task() && key_ && read(message.payload, key(), said) != Status::ok) {
    search.other_secret = true;
  } else {
    // Recordings of former runs must not keep the present one out: the oldest makes room.
    if (search.robots.size() >= kMostRobots && search.robots.count(said.session) == 0)
      search.robots.erase(
          std::min_element(search.robots.begin(), search.robots.end(),
                           [](const auto& a, const auto& b) { return a.second.utime < b.second.utime; }));
    Heard& known = search.robots[said.session];
    if (known.utime <= said.utime) known = std::move(said);
  }
}

std::string RequestClient::missing(const Search& search) const {
  const std::string secret = "--set parameters.secret_file=FILE";
  if (search.needs_secret)
    throw firmware::ProfileError(
        "the run takes requests only from those who know its secret; give --secret FILE");
  if (search.other_secret)
    throw firmware::ProfileError(
        "the run has another secret than the one given; take the file that it was started with");
  if (search.has_none)
    throw firmware::ProfileError(
        "the run has no secret, so nothing proves that its answers are its own; leave out --secret, or start "
        "it "
        "with " +
        secret);
  if (!search.closed.empty())
    return search.closed + " takes no requests, for it has no secret: head -c 16 /dev/urandom | xxd -p > " +
           "robot.secret && chmod 600 robot.secret, start it with --set parameters.secret_file=robot.secret, "
           "and " +
           "give --secret robot.secret";
  if (!search.scene.empty())
    return "a run was heard (scene " + search.scene + "), but it takes no requests to " +
           std::string(topic_.verb) + "; start it with --set " + std::string(topic_.section) +
           ".remote=true and " + secret;
  return "no run with parameters was heard on " + url_ +
         "; is one there (`sortie run --scene NAME`), on this computer if ttl=0?";
}

// Until all that are there must have been heard once.
void RequestClient::listen_around(Search& search, milliseconds most) {
  auto end = Clock::now() + most;
  bool any = false;
  bool one = false;
  while (Clock::now() < end) {
    drivers::ReceivedMessage received;
    const auto left = static_cast<int>(std::clamp<std::int64_t>(until(end).count(), 0, 100));
    if (receiver_.receive(received, left) != Status::ok) continue;
    note(received.message, search);
    if (!any && search.any()) end = std::min(end, Clock::now() + kEveryRun);
    if (!one && !search.robots.empty())
      end = std::min(end, Clock::now() + (topic_.has_task() ? kEveryRobot : kEveryParameters));
    any = search.any();
    one = !search.robots.empty();
  }
}

std::string RequestClient::find(const std::string& whom, milliseconds most) {
  Search search;
  listen_around(search, most);
  std::string names;
  const Heard* chosen = nullptr;
  std::size_t count = 0;
  for (const auto& [session, said] : search.robots) {
    // What is far older than what the same robot says now is a recording of a former run.
    const bool old =
        std::any_of(search.robots.begin(), search.robots.end(), [&said = said](const auto& other) {
          return other.second.robot == said.robot && other.second.utime - kOld_us > said.utime;
        });
    if (old) continue;
    names += (names.empty() ? "" : ", ") + said.robot;
    if (!whom.empty() && said.robot != whom) continue;
    chosen = &said;
    ++count;
  }
  if (names.empty()) return missing(search);
  if (count == 0)
    throw firmware::ProfileError(topic_.has_task()
                                     ? "no robot " + whom + " was heard on " + url_ + ", but: " + names
                                     : "--session " + whom + " was not heard; heard: " + names);
  if (count > 1)
    throw firmware::ProfileError(
        std::to_string(count) +
        (topic_.has_task() ? " robots were heard on " + url_ + ": " + names +
                                 "; say which with --robot NAME; runs get their names by robot.name"
                           : " runs were heard on " + url_ + "; choose one with --session: " + names));
  heard_ = *chosen;
  return {};
}

bool RequestClient::listen(milliseconds most) {
  const auto end = Clock::now() + most;
  while (true) {
    const std::int64_t left = until(end).count();
    if (left < 0) return false;
    drivers::ReceivedMessage received;
    const auto wait = static_cast<int>(std::min<std::int64_t>(left + 1, 100));
    if (receiver_.receive(received, wait) != Status::ok || received.message.channel != channel_) continue;
    Heard said;
    if (read(received.message.payload, key(), said) != Status::ok || said.session != heard_.session) continue;
    if (topic_.has_task() && said.utime <= heard_.utime) continue;  // played again
    heard_ = std::move(said);
    return true;
  }
}

void RequestClient::count_on() {
  const bool overtaken = counter_ != 0 && answer(1) == Status::time_repeated;
  counter_ = std::max(counter_, heard_.counter) + (overtaken ? kOvertake : 1);
}

template <class Message>
std::int64_t RequestClient::ask(Message request) {
  if (topic_.has_task() || counter_ <= heard_.counter) count_on();
  request.utime = utc_us();
  request.session = heard_.session;
  request.sender = sender_;
  request.counter = counter_;
  // What the network does not take is asked for again: whoever asks repeats itself.
  static_cast<void>(publisher_.publish_encoded(firmware::RequestKind<Message>::kTopic.channel,
                                               [&](std::span<std::uint8_t> out, std::size_t& size) {
                                                 return drivers::encode(request, key(), out, size);
                                               }));
  ++sent_;
  return counter_;
}

template <class Message>
std::int64_t RequestClient::repeat(const Message& request, milliseconds pause, milliseconds most,
                                   const std::function<bool(std::int64_t first)>& enough) {
  const auto end = Clock::now() + most;
  const std::int64_t first = ask(request);
  while (true) {
    const auto next = std::min(end, Clock::now() + pause);
    while (Clock::now() < next) {
      static_cast<void>(listen(until(next)));
      if (enough(first)) return first;
    }
    if (Clock::now() >= end) return first;
    ask(request);
  }
}

template std::int64_t RequestClient::ask(drivers::DriveRequestMessage);
template std::int64_t RequestClient::ask(drivers::FlyRequestMessage);
template std::int64_t RequestClient::ask(drivers::SetParameter);
template std::int64_t RequestClient::repeat(const drivers::DriveRequestMessage&, milliseconds, milliseconds,
                                            const std::function<bool(std::int64_t)>&);
template std::int64_t RequestClient::repeat(const drivers::FlyRequestMessage&, milliseconds, milliseconds,
                                            const std::function<bool(std::int64_t)>&);
template std::int64_t RequestClient::repeat(const drivers::SetParameter&, milliseconds, milliseconds,
                                            const std::function<bool(std::int64_t)>&);

bool RequestClient::listen_until(Clock::time_point end, const std::function<bool()>& enough) {
  while (!enough()) {
    if (Clock::now() >= end) return false;
    static_cast<void>(listen(until(end)));
  }
  return true;
}

std::optional<Status> RequestClient::answer(std::int64_t first) const {
  std::optional<Status> found;
  std::int64_t newest = first - 1;
  for (const drivers::RequestAnswer& answer : heard_.answers) {
    if (answer.sender != sender_ || answer.counter <= newest) continue;
    newest = answer.counter;
    found = static_cast<Status>(answer.status);
  }
  return found;
}

double RequestClient::value(const std::string& name) const {
  const auto of = [&name](const auto& rows) {
    const auto row =
        std::find_if(rows.begin(), rows.end(), [&name](const auto& one) { return one.name == name; });
    return row == rows.end() ? 0.0 : row->value;
  };
  return topic_.has_task() ? of(heard_.state) : of(heard_.parameters);
}

}  // namespace sortie::toolchain
