// SPDX-License-Identifier: BSD-3-Clause
// Who flies the multirotor: takes off, asks for ways, goes along them, waits, lands; obeys a mission and
// requests.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "planner/request_gate.hpp"
#include "planner/uav_control/uav_control.hpp"
#include "planner/uav_way.hpp"
#include "rt/archive.hpp"
#include "rt/keys.hpp"

namespace sortie::planner {

/// What the pilot is at.
enum class PilotStep : std::uint32_t {
  waiting,   ///< rotors stand: no goal yet, or no position
  take_off,  ///< straight up
  resting,   ///< comes to rest, to ask for a way from there
  asking,    ///< hovers until there is a way
  no_way,    ///< hovers, and asks again after a while
  under_way,
  arrived,
  blinded,  ///< no fixes: hovers by dead reckoning
  landing,
  landed,
  stopped,  ///< rotors stand by request, wherever the vehicle was
};

/// How long a request to fly may have waited when it is taken, unless a setting says otherwise.
inline constexpr rt::Nanoseconds kMostFlyRequestAge_ns = rt::kNanosecondsPerSecond;

/// Settings of the pilot.
struct UavPilotConfig {
  UavControlConfig control;
  bool plans{};          ///< goals are reached by ways that are asked for; else straight
  double take_off_m{1};  ///< height over the start that comes before everything else
  double reach_m{0.05};  ///< so near to a goal counts as there
  rt::Nanoseconds start_wait_ns{};
  rt::Nanoseconds ask_again_ns{rt::kNanosecondsPerSecond};
  std::uint32_t look_rounds{10};                              ///< then a vehicle that seeks its place lands
  bool lands{};                                               ///< after the mission's last goal
  rt::Nanoseconds max_command_age_ns{kMostFlyRequestAge_ns};  ///< a request that waited longer is refused

  SORTIE_KEYS(c, key) {
    UavControlConfig::keys(c.control, key);
    key("take_off_m", c.take_off_m, {0.3, 50, "m", "straight up, before all else"});
    key("reach_m", c.reach_m, {0.005, 5, "m", "so near to a goal counts as there"},
        [](auto& pilot, double value) { return pilot.set_reach(value); });
    key("ask_again_s", c.ask_again_ns, {0.1, 1000, rt::kSInNs, "after there was no way to a goal"});
    key("mission.start_s", c.start_wait_ns, {0, 3600, rt::kSInNs, "the vehicle stands this long"});
    key("mission.look_rounds", c.look_rounds,
        {1, 1000, "", "of mission.looks without its place found; then it lands where it is"});
    key("mission.land", c.lands, {"after the last goal it lands where it is"});
  }
};

/// What the pilot decides. For telemetry, digest, the rotors and the planner.
struct UavPilotOutput {
  rt::Nanoseconds stamp_ns{};
  std::uint32_t step{};     ///< PilotStep
  std::uint32_t phase{};    ///< UavPhase of the controller
  std::uint32_t verdict{};  ///< rt::UavVerdict that it flew by
  std::uint32_t remote{};   ///< 1: requests are in control
  std::uint32_t mission{};  ///< goals of the mission that are behind it
  std::uint32_t leg{};      ///< point of the way that it flies to
  std::uint32_t reached{};  ///< goals reached
  std::uint32_t no_way{};   ///< questions without a way
  std::uint32_t replans{};  ///< ways given up because the map changed or the wind was too strong
  std::uint32_t blinded{};  ///< times without fixes
  std::int64_t request_counter{};
  WayQuestion question;
  double goal_m[3]{};
  double setpoint_m[3]{};
  double setpoint_v_m_s[3]{};
  double setpoint_yaw_rad{};
  double error_m{};  ///< from the setpoint
  rt::RotorCommand command;
  UavControlCounters control;
  RequestCounters requests;

  template <class Self, class Visitor>
  static constexpr void fields(Self& self, Visitor&& visit) {
    SORTIE_VISIT(stamp_ns, step, phase, verdict, remote, mission, leg, reached, no_way, replans, blinded,
                 request_counter)
    visit("question", self.question.number);
    visit("from_m", self.question.from_m);
    visit("to_m", self.question.to_m);
    SORTIE_VISIT(goal_m, setpoint_m, setpoint_v_m_s, setpoint_yaw_rad, error_m)
    visit("command_stamp_ns", self.command.stamp_ns);
    visit("speed_rad_s", self.command.speed_rad_s);
    visit("rotors", self.command.rotors);
    visit("command_flags", self.command.flags);
    UavControlCounters::fields(self.control, visit);
    visit("requests_taken", self.requests.taken);
    visit("requests_not_finite", self.requests.not_finite);
    visit("requests_out_of_range", self.requests.out_of_range);
    visit("requests_repeated", self.requests.repeated);
    visit("requests_jumped", self.requests.jumped);
  }
};

/// The pilot and its controller. A way is flown from point to point along straight lines, at rest in each:
/// the reference never leaves the lines that the planner has proved. About 30 kB, no heap, fixed cost.
class UavPilot {
 public:
  static constexpr std::uint32_t kMostGoals = 64;
  static constexpr std::uint32_t kMostLooks = 16;
  static constexpr std::uint32_t kRotorsEnabled = 1u;

  /// Designs the controller: some ms.
  explicit UavPilot(const UavPilotConfig& config);
  /// ok, or why this vehicle cannot fly.
  Status status() const { return control_.status(); }

  /// Set-up. full beyond kMostGoals; not_finite; out_of_range.
  [[nodiscard]] Status set_mission(std::span<const UavGoal> goals);

  /// Set-up, for a vehicle that has to find its place before its mission: what it does meanwhile, over and
  /// over. Heights over the place that it took off from, and yaws; x and y count nothing: it has no map yet,
  /// and flies straight up and down alone. From the first of them the mission begins. Errors as
  /// set_mission(); full beyond kMostLooks.
  [[nodiscard]] Status set_looks(std::span<const UavGoal> looks);
  /// The mission's goals are in a frame that lies in the vehicle's own so: x_own = R(q) x + p. From now on
  /// they are flown to. not_finite; then nothing changes. Requests stay in the own frame.
  Status place(const rt::Vector3& p_own_map_m, const rt::Quaternion& q_own_map);
  /// It looks for its place, and has not been told it.
  bool wants_place() const { return look_count_ > 0 && !placed_; }

  /// From the next update on. out_of_range: not above 0.
  Status set_reach(double m);

  /// Takes or refuses what somebody outside asks, at `now_ns` (RequestGate); refusals are counted in the
  /// output. A request to stop the rotors holds until a release: a stream of goals that goes on does not end
  /// it.
  Status request(const rt::FlyRequest& request, rt::Nanoseconds now_ns);

  /// One period. `way`: newest answer of the planner, or null.
  void update(const rt::UavState& state, const UavWay* way, rt::Nanoseconds now_ns);

  const UavPilotOutput& output() const { return output_; }
  double mean_thrust_m_s2() const { return control_.mean_thrust_m_s2(); }

  /// State to bytes and back, into a pilot of the same configuration.
  void archive(rt::Archive& archive);

 private:
  void choose_goal(const rt::UavState& state, rt::Nanoseconds now_ns);
  void choose_look(const rt::UavState& state);
  UavGoal on_own(const UavGoal& goal) const;
  void begin_goal(const UavGoal& goal);
  void forced();
  void decide(const rt::UavState& state, const UavWay* way, rt::Nanoseconds now_ns);
  void start(const rt::UavState& state);
  void ask();
  void take_way(const UavWay& way, rt::Nanoseconds now_ns);
  void follow(const rt::UavState& state, const UavWay* way);
  void next_leg();
  void stay(const rt::UavState& state, rt::Nanoseconds now_ns);
  void rest();
  bool rests_at(const rt::Vector3& p_m) const;
  bool rests() const;
  void put_out(const rt::UavState& state, rt::Nanoseconds now_ns);

  UavPilotConfig config_;
  UavControl control_;
  double reach_m_;
  std::array<UavGoal, kMostGoals> mission_{};
  std::uint32_t goals_{};
  std::array<UavGoal, kMostLooks> looks_{};
  std::uint32_t look_count_{};
  RequestGate gate_;
  PilotStep step_{PilotStep::waiting};
  bool started_{};
  bool has_goal_{};
  bool remote_{};
  bool held_{};  ///< by request: the mission does not go on
  std::uint32_t next_goal_{};
  std::uint32_t next_look_{};
  std::uint32_t rounds_{};  ///< of looks
  bool looking_{};          ///< the goal is a look
  rt::Vector3 base_m_;      ///< where it stood before it took off
  bool placed_{};
  bool ready_{};  ///< placed, and back at the first look
  rt::Vector3 p_own_map_m_;
  rt::Quaternion q_own_map_;
  UavGoal goal_;
  rt::Vector3 target_m_;  ///< end of the present leg
  std::array<rt::Vector3, UavWay::kMostPoints> points_{};
  std::uint32_t point_count_{};
  std::uint32_t leg_{};
  bool whole_{};
  bool counted_{};  ///< the goal is among those reached
  std::uint64_t seen_replanned_{};
  rt::Nanoseconds start_ns_{};
  rt::Nanoseconds since_ns_{};  ///< of the present wait
  UavPilotOutput output_;
};

}  // namespace sortie::planner
