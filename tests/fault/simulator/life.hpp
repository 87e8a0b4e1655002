#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "services/bus/notifier.hpp"
#include "services/core/clock.hpp"
#include "services/core/result.hpp"

namespace tonus::simulator {

using Time = Clock::TimePoint;

inline constexpr Time kNever = Time::max();

/// Thrown where a program dies in the middle of what it does.
struct Died {};

/// A program's clock: the world's, and what the program has waited for within its step.
class LifeClock final : public Clock {
 public:
  LifeClock(const Time& world, const Duration& utc_step) : world_(world), utc_step_(utc_step) {}
  [[nodiscard]] TimePoint now() const override { return world_ + waited_; }
  [[nodiscard]] std::uint64_t utc_ns() const override {
    constexpr std::chrono::nanoseconds kStart{1'790'000'000'000'000'000};
    return static_cast<std::uint64_t>((kStart + now().time_since_epoch() + utc_step_).count());
  }
  void wait(Duration duration) { waited_ += duration; }
  void begin_step() { waited_ = {}; }

 private:
  const Time& world_;
  const Duration& utc_step_;  // of the machine's UTC, as steps of its clock have left it
  Duration waited_{};
};

/// What would be a thread: called when it is due, or when its notifier is told.
struct Task {
  std::string name;
  std::shared_ptr<bus::Notifier> notifier;
  std::function<Result<Time>()> step;  ///< Returns when to call again at the latest; an error ends the life.
  Time due{};
  Time busy_until{};
};

/// One run of a program, from its start to its end or death.
struct Life {
  Life(std::string name, const Time& world, const Clock::Duration& utc_step)
      : program(std::move(name)), clock(world, utc_step) {}

  const std::string program;
  LifeClock clock;
  std::vector<Task> tasks;
  bool is_dead = false;               ///< What it still writes, to disk or bus, goes nowhere.
  bool is_taken_down = false;         ///< In its destructors, which nothing may be thrown out of.
  std::optional<unsigned> acts_left;  ///< Writes until it dies in one.

  /// Before each write: true where the program dies in this one.
  [[nodiscard]] bool dies_now() {
    if (!acts_left || is_dead) return false;
    if (*acts_left > 0) --*acts_left;
    if (*acts_left > 0) return false;
    is_dead = is_taken_down;
    return !is_taken_down;
  }
};

}  // namespace tonus::simulator
