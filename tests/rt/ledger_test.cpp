// SPDX-License-Identifier: BSD-3-Clause
// The verdict of a job: every interleaving of one writer and two readers agrees, and torn values are never
// used.
#include "rt/ledger.hpp"

#include <atomic>
#include <catch2/catch.hpp>
#include <thread>
#include <vector>

#include "rt/let_channel.hpp"

using namespace sortie::rt;

namespace {

// One step each of a writer (begin, finish) and of two readers (decide), in every order that keeps the
// writer's own.
struct Outcome {
  bool opened{};
  Verdict finished{};
  Verdict read[2]{};
};

Outcome play(const std::vector<int>& order, bool in_time) {
  std::vector<std::atomic<std::uint32_t>> words(4);
  JobLedger ledger(words.data(), 4);
  Outcome outcome;
  int writer_step = 0;
  for (const int actor : order) {
    if (actor == 0 && writer_step++ == 0) {
      outcome.opened = ledger.begin(9);
    } else if (actor == 0) {
      outcome.finished = outcome.opened ? ledger.finish(9, in_time) : Verdict::missed;
    } else {
      outcome.read[actor - 1] = ledger.decide(9);
    }
  }
  return outcome;
}

}  // namespace

TEST_CASE("writer and readers obey one verdict in every order of their steps") {
  const int actors[4] = {0, 0, 1, 2};
  std::vector<int> order(actors, actors + 4);
  int orders = 0;
  int done = 0;
  do {
    for (const bool in_time : {true, false}) {
      const Outcome outcome = play(order, in_time);
      CAPTURE(order, in_time);
      CHECK(outcome.read[0] == outcome.finished);
      CHECK(outcome.read[1] == outcome.finished);
      CHECK((outcome.finished == Verdict::done || outcome.finished == Verdict::missed));
      if (!in_time) CHECK(outcome.finished == Verdict::missed);
      done += outcome.finished == Verdict::done ? 1 : 0;
    }
    ++orders;
  } while (std::next_permutation(order.begin(), order.end()));
  CHECK(orders == 12);
  CHECK(done == 2);  // only where both steps of the writer come before both readers
}

TEST_CASE("a reader that comes a ring too late gets missed, not another job's verdict") {
  std::vector<std::atomic<std::uint32_t>> words(4);
  JobLedger ledger(words.data(), 4);
  REQUIRE(ledger.begin(1));
  REQUIRE(ledger.finish(1, true) == Verdict::done);
  CHECK(ledger.still_done(1));
  REQUIRE(ledger.begin(5));
  CHECK_FALSE(ledger.still_done(1));
  CHECK(ledger.decide(1) == Verdict::missed);
  CHECK(ledger.finish(5, true) == Verdict::done);
}

TEST_CASE("a channel under a racing writer gives whole values or none") {
  struct Big {
    std::uint64_t words[40];
  };
  std::vector<std::atomic<std::uint32_t>> verdicts(8);
  JobLedger ledger(verdicts.data(), 8);
  std::vector<std::atomic<std::uint32_t>> memory(8 * LetChannel<Big>::kWords);
  LetChannel<Big> channel(ledger, memory.data());
  std::atomic<std::uint64_t> newest{0};
  std::atomic<bool> stop{false};
  std::thread writer([&] {
    for (std::uint64_t job = 1; !stop.load(); ++job) {
      Big value;
      for (std::uint64_t& word : value.words) word = job;
      if (ledger.begin(job)) {
        channel.write(job, job, value);
        static_cast<void>(ledger.finish(job, true));
      }
      newest.store(job);
    }
  });
  std::uint64_t whole = 0;
  std::uint64_t overtaken = 0;
  while (whole + overtaken < 20'000) {
    const std::uint64_t job = newest.load();
    if (job == 0 || ledger.decide(job) != Verdict::done) continue;
    Big value;
    std::uint64_t made_by = 0;
    if (!channel.read(job, value, made_by)) {
      ++overtaken;
      continue;
    }
    ++whole;
    REQUIRE(made_by == job);
    for (const std::uint64_t word : value.words) REQUIRE(word == job);
  }
  stop.store(true);
  writer.join();
  CHECK(whole > 0);
}
