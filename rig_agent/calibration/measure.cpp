#include "rig_agent/calibration/measure.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <spdlog/fmt/fmt.h>

#include "rig_agent/control/validation.hpp"

namespace tonus::calibration {
namespace {

constexpr double kStillCounts = 2.0;  // To either side of the mean.
constexpr double kBefore = 0.3;       // s before the onset.
constexpr double kAtEnd = 1.0;        // s at the end of the hold.

// Of values that are far from zero, and few enough for two passes.
double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double deviation(const std::vector<double>& values) {
  const double middle = mean(values);
  double sum = 0.0;
  for (const double value : values) sum += (value - middle) * (value - middle);
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(values.size() - 1, 1)));
}

Error not_at_rest(std::size_t joint, double range) {
  return fail(
      ErrorCode::kUnavailable,
      fmt::format("the encoder of joint {} moved over {} counts; expected at most {}: the rig is not at rest",
                  joint + 1, range, 2.0 * kStillCounts));
}

struct Channels {
  std::vector<double> count;
  std::vector<double> volts;
};

Result<void> collect(drivers::Driver& driver, Cycles& cycles, double time,
                     std::array<Channels, 2>& channels) {
  const auto n = static_cast<std::size_t>(std::ceil(time / cycles.period()));
  for (std::size_t k = 0; k < n; ++k) {
    (void)cycles.next();
    drivers::Reading reading;
    if (driver.read(reading) != drivers::DriverStatus::kOk)
      return fail(ErrorCode::kUnavailable,
                  "the driver gives no reading: a sensor or the card does not answer");
    (void)driver.write(Eigen::Vector2d::Zero());
    for (std::size_t i = 0; i < 2; ++i) {
      if (!(std::abs(reading.raw.force_V[i]) < driver.geometry().force_saturation_V)) {
        return fail(ErrorCode::kUnavailable,
                    fmt::format("force channel {}: {} V is not allowed; expected less than {} V", i + 1,
                                reading.raw.force_V[i], driver.geometry().force_saturation_V));
      }
      channels[i].count.push_back(reading.raw.encoder_count[i]);
      channels[i].volts.push_back(reading.raw.force_V[i]);
    }
  }
  return {};
}

// Means of place and force in R over a stretch of samples.
struct Mean {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  Eigen::Vector2d force = Eigen::Vector2d::Zero();
};

Mean mean_of_last(const std::vector<EndpointSample>& samples, std::size_t wanted) {
  Mean m;
  const std::size_t n = std::min(wanted, samples.size());
  for (std::size_t i = samples.size() - n; i < samples.size(); ++i) {
    m.place += samples[i].p_SE / static_cast<double>(n);
    m.force += samples[i].f_S / static_cast<double>(n);
  }
  return m;
}

// One trial from its command to its result.
Result<SpringStep> step(control::RigLoop& loop, const RigGeometry& geometry, Cycles& cycles,
                        const control::TrialProgram& program) {
  control::Command command;
  command.request = program.number;
  command.kind = control::CommandKind::kStartTrial;
  command.program = program;
  if (!loop.post(command)) return fail(ErrorCode::kInternal, "the loop takes no command");
  std::vector<EndpointSample> before;
  std::vector<EndpointSample> held;
  control::TrialResult result;
  while (!loop.next_result(result)) {
    const control::CycleStart cycle = cycles.next();
    loop.keep_alive();
    loop.step(cycle.now_ns, cycle.missed_periods);
    control::CommandReply reply;
    while (loop.next_reply(reply)) {
      if (reply.result != control::CommandResult::kDone)
        return fail(ErrorCode::kUnavailable, "the loop does not start a trial: a fault is latched");
    }
    control::SampleRecord sample;
    while (loop.next_sample(sample)) {
      // S laid upon R.
      const EndpointSample endpoint = convert(geometry, ShoulderPose{}, sample.raw);
      if (sample.phase == control::Phase::kWaiting) before.push_back(endpoint);
      if (sample.phase == control::Phase::kPerturbing) held.push_back(endpoint);
    }
  }
  if (result.outcome != control::TrialOutcome::kCompleted) {
    std::string why = control::outcome_name(result.outcome);
    for (const auto fault : control::kAllFaults) {
      if ((result.faults & control::bit(fault)) != 0) why += fmt::format(" ({})", control::fault_name(fault));
    }
    return fail(ErrorCode::kUnavailable, "a step against the spring was not completed: " + why);
  }
  const double rate = loop.config().rate / loop.config().sample_divider;
  const auto samples_in = [rate](double time) { return static_cast<std::size_t>(std::lround(time * rate)); };
  const Mean rest = mean_of_last(before, samples_in(kBefore));
  const Mean end = mean_of_last(held, samples_in(kAtEnd));
  return SpringStep{end.place - rest.place, end.force - rest.force};
}

}  // namespace

Cycles::Cycles(const drivers::Driver& driver, double period)
    : has_own_clock_(driver.capabilities().has_own_clock),
      period_(period),
      pacer_(clock_, std::llround(1e9 * period)) {
  pacer_.start();
}

control::CycleStart Cycles::next() noexcept {
  if (!has_own_clock_) return pacer_.wait();
  control::CycleStart start;
  start.now_ns = now_ns_ += std::llround(1e9 * period_);
  return start;
}

Result<RestReading> read_at_rest(drivers::Driver& driver, Cycles& cycles, double time) {
  std::array<Channels, 2> channels;
  if (auto collected = collect(driver, cycles, time, channels); !collected) return collected.error();
  RestReading reading;
  reading.samples = channels[0].count.size();
  for (std::size_t i = 0; i < 2; ++i) {
    const auto [low, high] = std::minmax_element(channels[i].count.begin(), channels[i].count.end());
    if (!(*high - *low <= 2.0 * kStillCounts)) return not_at_rest(i, *high - *low);
    reading.encoder_count[i] = mean(channels[i].count);
    reading.volts[static_cast<Eigen::Index>(i)] = mean(channels[i].volts);
    reading.volts_deviation[static_cast<Eigen::Index>(i)] = deviation(channels[i].volts);
  }
  return reading;
}

Result<std::vector<SpringStep>> step_against_spring(control::RigLoop& loop, const RigGeometry& geometry,
                                                    Cycles& cycles, const SpringPlan& plan) {
  std::vector<SpringStep> steps;
  for (unsigned k = 0; k < plan.directions; ++k) {
    control::TrialProgram program;
    program.number = k + 1;
    program.shoulder.origin = plan.place;
    program.wait = 1.0;
    program.direction = 2.0 * std::numbers::pi * k / plan.directions;
    program.amplitude = plan.amplitude;
    program.hold = plan.hold;
    if (auto valid = control::validate(program, loop.config().limits, true); !valid) return valid.error();
    auto made = step(loop, geometry, cycles, program);
    if (!made) return made.error();
    steps.push_back(*made);
  }
  return steps;
}

}  // namespace tonus::calibration
