// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/commands/request_client.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "firmware_like/link/secret.hpp"
#include "firmware_like/scene/profile.hpp"
#include "toolchain/commands/parameter_client.hpp"

namespace sortie::toolchain {

namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kEveryRobot{350};  // each speaks ten times a second
constexpr milliseconds kEveryRun{1500};   // its parameters once a second
constexpr std::size_t kMostRobots = 64;   // strangers must not fill the memory
constexpr std::int64_t kOld_us = 5'000'000;
constexpr std::int64_t kOvertake =
    1000;  // beside a sender of 1 kHz whom the robot tells of ten times a second

// Counted on from by adding: what nobody ever reached is no counter.
bool is_believable(const drivers::AnswersMessage& said) {
  return said.counter >= 0 && said.counter <= std::numeric_limits<std::int64_t>::max() / 2;
}

milliseconds until(Clock::time_point end) {
  return std::chrono::duration_cast<milliseconds>(end - Clock::now());
}

}  // namespace

// What was heard while looking for a robot.
struct RequestClient::Search {
  std::map<std::int64_t, drivers::AnswersMessage> robots;  // by session
  bool other_secret{};
  bool needs_secret{};
  bool has_none{};     // the run is open to everybody, a secret was given
  std::string closed;  // name of a robot that takes no requests for want of a secret
  std::string scene;   // of a run that was heard at all
  bool any() const {
    return !robots.empty() || other_secret || needs_secret || has_none || !closed.empty() || !scene.empty();
  }
};

RequestClient::RequestClient(const std::string& url, std::optional<drivers::SipKey> key, RequestTopic topic)
    : url_(url),
      receiver_(url),
      publisher_(request_publisher(url)),
      key_(key),
      topic_(std::move(topic)),
      channel_(std::string(drivers::kChannelAnswers) + "_" + topic_.task),
      sender_(firmware::unguessable_number()) {
  if (!publisher_.active()) throw std::runtime_error(publisher_.problem());
}

void RequestClient::note(std::span<const std::uint8_t> payload, Search& search) const {
  drivers::AnswersMessage said;
  if (drivers::decode(payload, nullptr, said) != Status::ok || said.task != topic_.task) return;
  if (!is_believable(said)) return;
  if (said.session == 0) {
    search.closed = said.robot;
  } else if (!key_ && said.keyed) {
    search.needs_secret = true;
  } else if (key_ && !said.keyed) {
    search.has_none = true;
  } else if (key_ && drivers::decode(payload, &*key_, said) != Status::ok) {
    search.other_secret = true;
  } else {
    // Recordings of former runs must not keep the present one out: the oldest makes room.
    if (search.robots.size() >= kMostRobots && search.robots.count(said.session) == 0)
      search.robots.erase(
          std::min_element(search.robots.begin(), search.robots.end(),
                           [](const auto& a, const auto& b) { return a.second.utime < b.second.utime; }));
    drivers::AnswersMessage& known = search.robots[said.session];
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
    return "a run was heard (scene " + search.scene + "), but it takes no requests to " + topic_.verb +
           "; start it with --set " + topic_.remote_key + "=true and " + secret;
  return unheard(url_);
}

std::string RequestClient::find(const std::string& robot, milliseconds most) {
  Search search;
  auto end = Clock::now() + most;
  bool any = false;
  bool one = false;
  while (Clock::now() < end) {
    drivers::ReceivedMessage received;
    const auto left = static_cast<int>(std::clamp<std::int64_t>(until(end).count(), 0, 100));
    if (receiver_.receive(received, left) != Status::ok) continue;
    drivers::ParametersMessage run;
    if (received.message.channel == channel_) {
      note(received.message.payload, search);
    } else if (received.message.channel == drivers::kChannelParameters &&
               drivers::decode(received.message.payload, run) == Status::ok) {
      search.scene = run.scene;
    }
    if (!any && search.any()) end = std::min(end, Clock::now() + kEveryRun);
    if (!one && !search.robots.empty()) end = std::min(end, Clock::now() + kEveryRobot);
    any = search.any();
    one = !search.robots.empty();
  }
  // What is far older than what the same robot says now is a recording of a former run.
  std::string names;
  const drivers::AnswersMessage* chosen = nullptr;
  std::size_t count = 0;
  for (const auto& [session, said] : search.robots) {
    const bool old =
        std::any_of(search.robots.begin(), search.robots.end(), [&said = said](const auto& other) {
          return other.second.robot == said.robot && other.second.utime - kOld_us > said.utime;
        });
    if (old) continue;
    names += (names.empty() ? "" : ", ") + said.robot;
    if (!robot.empty() && said.robot != robot) continue;
    chosen = &said;
    ++count;
  }
  if (names.empty()) return missing(search);
  if (count == 0)
    throw firmware::ProfileError("no robot " + robot + " was heard on " + url_ + ", but: " + names);
  if (count > 1)
    throw firmware::ProfileError(std::to_string(count) + " robots were heard on " + url_ + ": " + names +
                                 "; say which with --robot NAME; runs get their names by robot.name");
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
    drivers::AnswersMessage said;
    if (drivers::decode(received.message.payload, key_ ? &*key_ : nullptr, said) != Status::ok) continue;
    // Of another run, or played again.
    if (said.session != heard_.session || said.task != topic_.task || said.utime <= heard_.utime) continue;
    if (!is_believable(said)) continue;
    heard_ = std::move(said);
    return true;
  }
}

template <class Message>
std::int64_t RequestClient::send(std::string_view channel, Message request) {
  const bool overtaken = counter_ != 0 && answer(1) == Status::time_repeated;
  counter_ = std::max(counter_, heard_.counter) + (overtaken ? kOvertake : 1);
  request.utime = utc_us();
  request.session = heard_.session;
  request.sender = sender_;
  request.counter = counter_;
  // What the network does not take is asked for again: whoever is in control repeats itself.
  static_cast<void>(publisher_.publish_encoded(channel, [&](std::span<std::uint8_t> out, std::size_t& size) {
    return drivers::encode(request, key_ ? &*key_ : nullptr, out, size);
  }));
  ++sent_;
  return counter_;
}

std::int64_t RequestClient::ask(drivers::DriveRequestMessage request) {
  return send(drivers::kChannelDrive, request);
}

std::int64_t RequestClient::ask(drivers::FlyRequestMessage request) {
  return send(drivers::kChannelFly, request);
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
  for (const drivers::NamedValue& value : heard_.state) {
    if (value.name == name) return value.value;
  }
  return 0;
}

const char* refusal_text(Status status) {
  switch (status) {
    case Status::ok:
      return "it was admitted";
    case Status::time_repeated:
      return "somebody else's request overtook it";
    case Status::malformed:
      return "its counter was too far ahead";
    case Status::time_backwards:
      return "its time is not the robot's: set both clocks (parameters.max_request_age_ms)";
    case Status::stale:
      return "it waited too long on the robot's computer, which is too busy";
    case Status::full:
      return "more requests came than the robot takes";
    case Status::not_finite:
    case Status::out_of_range:
      return "it asks for what no robot can do";
    default:
      return "the robot does not say why";
  }
}

}  // namespace sortie::toolchain
