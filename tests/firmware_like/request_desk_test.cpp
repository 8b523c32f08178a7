// SPDX-License-Identifier: BSD-3-Clause
// The desk: age when a request is taken, room for the newest and for stops, and who gets which answer.
#include "firmware_like/link/request_desk.hpp"

#include <catch2/catch.hpp>
#include <limits>

#include "tests/firmware_like/lone_robot.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::testing;

namespace {

constexpr rt::Nanoseconds kSecond = rt::kNanosecondsPerSecond;
constexpr rt::Nanoseconds kUs = rt::kNanosecondsPerMicrosecond;  // senders date requests in these
constexpr rt::Nanoseconds kUtc = 1'790'000'000 * kSecond;
constexpr drivers::SipKey kSecret{1, 2, 3};

// Taken `waited_ns` after it came in, at `now_ns` of the run's clock.
RequestContext taken(rt::Nanoseconds now_ns, rt::Nanoseconds waited_ns,
                     rt::Nanoseconds most_ns = 2 * kSecond) {
  return {&kSecret, 0, now_ns, {kUtc + now_ns - waited_ns, kUtc + now_ns, most_ns}};
}

template <class Message>
Message numbered(Message message, std::int64_t counter, rt::Nanoseconds sent_ns, std::int64_t sender = 1) {
  message.counter = counter;
  message.sender = sender;
  message.utime = (kUtc + sent_ns) / 1000;
  return message;
}

template <class Desk, class Message>
void put(Desk& desk, const Message& message, const RequestContext& context) {
  desk.take(bytes_of(message, &kSecret), context);
}

Status status_of(const std::optional<drivers::RequestAnswer>& answer) {
  REQUIRE(answer);
  return static_cast<Status>(answer->status);
}

}  // namespace

TEST_CASE("what waited in the queue while the process was stopped is not obeyed, but a halt is") {
  LoneDrive robot;
  DriveRequestDesk& desk = robot.lone.desk;
  put(desk, numbered(LoneDrive::stop(), 1, 0), taken(0, 0));
  robot.job(1);
  REQUIRE(robot.is_stopped());
  const rt::Nanoseconds late = 12 * kSecond;
  // Sent soon after it was stopped; the process finds them 12 s later.
  put(desk, numbered(LoneDrive::release(), 2, kSecond), taken(late, late - kSecond));
  put(desk, numbered(LoneDrive::move(), 3, kSecond), taken(late, late - kSecond));
  CHECK(desk.counters().wrong_time == 2);
  // A sender's clock says what it likes: the wait on this computer is judged for itself.
  put(desk, numbered(LoneDrive::release(), 4, late), taken(late, late - kSecond));
  put(desk, numbered(LoneDrive::release(), 5, kSecond), taken(late, late - kSecond, 0));
  CHECK(desk.counters().held_back == 2);
  CHECK(status_of(answer_to(desk, 1)) == Status::stale);
  robot.job(late);
  CHECK(robot.is_stopped());
  CHECK(desk.counters().admitted == 1);
  // The same of now is taken; and an old halt is.
  put(desk, numbered(LoneDrive::release(), 6, late), taken(late, 0));
  robot.job(late + 1);
  CHECK_FALSE(robot.is_stopped());
  put(desk, numbered(LoneDrive::stop(), 7, kSecond), taken(late + 1, late - kSecond));
  robot.job(late + 2);
  CHECK(robot.is_stopped());
}

TEST_CASE("what waited between desk and job while the process was stopped is not obeyed, but a halt is") {
  LoneDrive robot;
  DriveRequestDesk& desk = robot.lone.desk;
  put(desk, numbered(LoneDrive::stop(), 1, 0), taken(0, 0));
  robot.job(1);
  put(desk, numbered(LoneDrive::release(), 2, 1000), taken(1000, 0));
  REQUIRE(desk.counters().admitted == 2);
  robot.job(12 * kSecond);
  CHECK(robot.is_stopped());
  CHECK(robot.drive->output().requests.held_back == 1);
  put(desk, numbered(LoneDrive::release(), 3, 12 * kSecond), taken(12 * kSecond, 0));
  robot.job(12 * kSecond + 1);
  REQUIRE_FALSE(robot.is_stopped());
  put(desk, numbered(LoneDrive::stop(), 4, 12 * kSecond), taken(12 * kSecond, 0));
  robot.job(24 * kSecond);
  CHECK(robot.is_stopped());
}

TEST_CASE("a full desk keeps the newest request, and a halt before all others") {
  LoneDrive robot;
  DriveRequestDesk& desk = robot.lone.desk;
  for (std::int64_t i = 1; i <= 40; ++i)
    put(desk, numbered(LoneDrive::move(), i, i * kUs, i), taken(i * kUs, 0));
  CHECK(desk.counters().admitted == 16);
  CHECK(desk.counters().full == 23);
  CHECK(status_of(answer_to(desk, 39)) == Status::full);
  CHECK_FALSE(answer_to(desk, 40));  // it waits
  for (int i = 0; i < 3; ++i) {
    robot.job((50 + i) * kUs);
    desk.hand_in((50 + i) * kUs);
  }
  CHECK(robot.newest() == 40);
  CHECK(status_of(answer_to(desk, 40)) == Status::ok);
  CHECK(robot.lone.stream.refused() == 0);
  // A halt takes the waiting place of anything else, and nothing takes it from the halt.
  for (std::int64_t i = 41; i <= 60; ++i)
    put(desk, numbered(LoneDrive::move(), i, i * kUs, i), taken(i * kUs, 0));
  put(desk, numbered(LoneDrive::stop(), 61, 61 * kUs, 5), taken(61 * kUs, 0));
  for (std::int64_t i = 62; i <= 80; ++i)
    put(desk, numbered(LoneDrive::release(), i, i * kUs, i), taken(i * kUs, 0));
  CHECK(status_of(answer_to(desk, 80)) == Status::full);
  put(desk, numbered(LoneDrive::stop(), 63, 81 * kUs, 6), taken(81 * kUs, 0));
  CHECK(status_of(answer_to(desk, 5)) == Status::ok);  // the other halt stands for it
  for (int i = 0; i < 4; ++i) {
    robot.job((100 + i) * kUs);
    desk.hand_in((100 + i) * kUs);
  }
  CHECK(robot.is_stopped());
  CHECK(status_of(answer_to(desk, 6)) == Status::ok);
}

TEST_CASE("a pilot that is put back knows what it held back") {
  LonePilot robot, again;
  put(robot.lone.desk, numbered(LonePilot::move(), 1, 0), taken(0, 0));
  robot.job(60 * kSecond);
  REQUIRE(robot.pilot->output().requests.held_back == 1);
  rt::Archive measure = rt::Archive::measuring();
  robot.pilot->archive(measure);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(measure.bytes()));
  rt::Archive out = rt::Archive::writing(bytes);
  robot.pilot->archive(out);
  rt::Archive in = rt::Archive::reading(bytes);
  again.pilot->archive(in);
  REQUIRE(in.status() == Status::ok);
  CHECK(again.pilot->output().requests.held_back == 1);
}

TEST_CASE("a request that finds room only when it is old is not handed in") {
  LoneDrive robot;
  DriveRequestDesk& desk = robot.lone.desk;
  for (std::int64_t i = 1; i <= 17; ++i) put(desk, numbered(LoneDrive::move(), i, 0), taken(0, 0));
  for (int i = 0; i < 3; ++i) robot.job(kSecond + i);
  desk.hand_in(kSecond);
  CHECK(desk.counters().held_back == 1);
  CHECK(robot.lone.stream.waiting() == 0);
}

TEST_CASE("a halt needs no counter, no clock and nothing beside its mode, and a release needs all of them") {
  LoneDrive robot;
  DriveRequestDesk& desk = robot.lone.desk;
  put(desk, numbered(LoneDrive::move(), 1000, 0), taken(0, 0));
  robot.job(1);
  auto halt = numbered(LoneDrive::stop(), 3, -3600 * kSecond, 2);
  halt.speed_m_s = std::numeric_limits<double>::quiet_NaN();
  halt.posture = 77;
  halt.flags = 0xffffffff;
  put(desk, halt, taken(1, 0));
  robot.job(2);
  CHECK(robot.is_stopped());
  CHECK(robot.newest() == 1000);  // an old counter moves nobody else's
  CHECK(status_of(answer_to(desk, 2)) == Status::ok);
  const auto released_by = [&](drivers::DriveRequestMessage release, const RequestContext& context) {
    put(desk, release, context);
    robot.job(context.now_ns + 1);
    return !robot.is_stopped();
  };
  CHECK_FALSE(released_by(numbered(LoneDrive::release(), 1000, 2), taken(2, 0)));
  CHECK_FALSE(released_by(numbered(LoneDrive::release(), 1001, -3600 * kSecond), taken(3, 0)));
  auto odd = numbered(LoneDrive::release(), 1001, 4);
  odd.posture = 77;
  CHECK_FALSE(released_by(odd, taken(4, 0)));
  // A counter far ahead halts, too, and shuts nobody out.
  put(desk, numbered(LoneDrive::stop(), std::numeric_limits<std::int64_t>::max(), 5000), taken(5000, 0));
  CHECK(released_by(numbered(LoneDrive::release(), 1001, 9000), taken(9000, 0)));
}

TEST_CASE(
    "a halt that is played again halts again, and a release that was held back behind it releases nothing") {
  LoneDrive robot;
  DriveRequestDesk& desk = robot.lone.desk;
  const auto halt = bytes_of(numbered(LoneDrive::stop(), 1, 0, 9), &kSecret);
  desk.take(halt, taken(0, 0));
  // Sent before the next halt, with a counter above its; somebody lets it through only after that.
  const auto held = bytes_of(numbered(LoneDrive::release(), 900, kSecond, 3), &kSecret);
  put(desk, numbered(LoneDrive::release(), 2, kSecond / 2, 2), taken(kSecond / 2, 0));
  robot.job(kSecond / 2 + 1);
  REQUIRE_FALSE(robot.is_stopped());
  put(desk, numbered(LoneDrive::stop(), 3, 2 * kSecond, 9), taken(2 * kSecond, 0));
  desk.take(held, taken(2 * kSecond + 1000, 0));
  robot.job(2 * kSecond + 2000);
  CHECK(robot.is_stopped());
  CHECK(desk.counters().repeated == 1);
  put(desk, numbered(LoneDrive::release(), 4, 3 * kSecond, 2), taken(3 * kSecond, 0));
  robot.job(3 * kSecond + 1);
  REQUIRE_FALSE(robot.is_stopped());
  desk.take(halt, taken(10 * kSecond, 0));
  robot.job(10 * kSecond + 1);
  CHECK(robot.is_stopped());
  CHECK(status_of(answer_to(desk, 9)) == Status::ok);  // and its sender's newest answer stays
}

TEST_CASE("a stop in the air must be of now, and the more final one wins") {
  LonePilot robot;
  FlyRequestDesk& desk = robot.lone.desk;
  put(desk, numbered(LonePilot::move(), 1000, 0), taken(0, 0));
  robot.job(1);
  const auto old = numbered(LonePilot::stop(), 2000, -3 * kSecond, 2);
  put(desk, old, taken(1, 0));
  CHECK(desk.counters().wrong_time == 1);
  robot.job(2);
  CHECK_FALSE(robot.is_stopped());
  put(desk, numbered(LonePilot::stop(), 3, 2, 2), taken(2, 0));  // out of order
  robot.job(3);
  CHECK(robot.is_stopped());
  const auto after_it = [&](rt::FlyMode mode, std::int64_t counter) {
    put(desk, numbered(LonePilot::with_mode(mode), counter, 4000, counter), taken(4000, 0));
    robot.job(4001 + counter);
    return status_of(answer_to(desk, counter));
  };
  CHECK(after_it(rt::FlyMode::hover, 999) == Status::time_repeated);  // less final, and not in its turn
  CHECK(after_it(rt::FlyMode::go, 1001) == Status::ok);
  CHECK(robot.is_stopped());  // a stream of goals does not end it
  // Where no clock is judged a stop may be a recording: then it needs its turn.
  put(desk, numbered(LonePilot::stop(), 1, 0, 7), taken(5000, 0, 0));
  CHECK(status_of(answer_to(desk, 7)) == Status::time_repeated);
  put(desk, numbered(LonePilot::stop(), 1002, 0, 7), taken(5000, 0, 0));
  CHECK(status_of(answer_to(desk, 7)) == Status::ok);
}

TEST_CASE("answers are kept one a sender, stops apart, and strangers get none") {
  LoneDrive robot;
  DriveRequestDesk& desk = robot.lone.desk;
  put(desk, numbered(LoneDrive::stop(), 1, 0, 77), taken(0, 0));
  desk.take(bytes_of(numbered(LoneDrive::move(), 2, 0, 78), nullptr), taken(0, 0));
  CHECK_FALSE(answer_to(desk, 78));
  for (std::int64_t i = 100; i < 200; ++i) {
    put(desk, numbered(LoneDrive::move(), i, i * kUs, i), taken(i * kUs, 0));
    robot.job(i * kUs);
  }
  CHECK(status_of(answer_to(desk, 77)) == Status::ok);
  CHECK(status_of(answer_to(desk, 199)) == Status::ok);
  CHECK_FALSE(answer_to(desk, 100));
  drivers::AnswersMessage message;
  desk.describe(message);
  CHECK(message.answers.size() == 17);
  CHECK(message.counter == 199);
  CHECK(message.task == "drive");
  // A request that is played again does not turn its sender's answer into a refusal.
  put(desk, numbered(LoneDrive::move(), 199, 199 * kUs, 199), taken(200 * kUs, 0));
  CHECK(status_of(answer_to(desk, 199)) == Status::ok);
}
