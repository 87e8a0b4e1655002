#include "rig_agent/drivers/comedi.hpp"

#include <algorithm>
#include <cmath>
#include <comedilib.h>
#include <spdlog/fmt/fmt.h>
#include <time.h>

namespace tonus::drivers {
namespace {

std::int64_t monotonic_ns() noexcept {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
}

}  // namespace

void Comedi::Close::operator()(comedi_t_struct* card) const noexcept { comedi_close(card); }

Comedi::Comedi(const ComediConfig& config, const RigGeometry& geometry,
               std::vector<AuxiliaryChannel> auxiliary)
    : config_(config), auxiliary_(std::move(auxiliary)), geometry_(geometry) {}

Comedi::~Comedi() { Comedi::deactivate(); }

Error Comedi::refuse(const char* what, const ComediChannel& channel) const {
  return fail(
      ErrorCode::kInvalidArgument,
      fmt::format("comedi {}: {} (subdevice {}, channel {}, range {}): {}", config_.device, what,
                  channel.subdevice, channel.channel, channel.range, comedi_strerror(comedi_errno())));
}

Result<void> Comedi::configure(double period) {
  if (is_active_)
    return fail(ErrorCode::kUnavailable,
                "comedi: configure() while active is not allowed; expected an inactive driver");
  is_configured_ = false;
  if (!(period >= 1e-4 && period <= 0.02)) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("comedi: period: {} s is not allowed; expected 0.0001 s to 0.02 s", period));
  }
  comedi_loglevel(0);  // Its errors are ours to tell.
  if (!card_) card_.reset(comedi_open(config_.device.c_str()));
  if (!card_) {
    return fail(ErrorCode::kUnavailable, fmt::format("comedi {}: cannot be opened: {}", config_.device,
                                                     comedi_strerror(comedi_errno())));
  }
  auto set_up = set_up_channels();
  if (set_up) set_up = set_up_auxiliary(period);
  if (!set_up) {
    card_.reset();
    return set_up;
  }
  is_configured_ = true;
  deactivate();  // Whatever the outputs showed before.
  return {};
}

Result<void> Comedi::set_up_channels() {
  for (std::size_t i = 0; i < 2; ++i) {
    const ComediChannel& encoder = config_.encoders[i];
    if (auto good = check("encoder", encoder, COMEDI_SUBD_COUNTER); !good) return good;
    counters_[i] = Counter{};
    counters_[i].largest = comedi_get_maxdata(card_.get(), encoder.subdevice, encoder.channel);
    if (counters_[i].largest == 0) return refuse("encoder", encoder);
    if (auto good = set_up_counter(encoder, counters_[i].largest); !good) return good;

    if (auto good = check("force", config_.force[i], COMEDI_SUBD_AI); !good) return good;
    auto input = scale_of("force", config_.force[i]);
    if (!input) return input.error();
    inputs_[i] = *input;
    if (auto good = check("motor", config_.motors[i], COMEDI_SUBD_AO); !good) return good;
    auto output = scale_of("motor", config_.motors[i]);
    if (!output) return output.error();
    outputs_[i] = *output;
    if (!(outputs_[i].low <= 0.0 && outputs_[i].high >= 0.0)) {
      return fail(
          ErrorCode::kInvalidArgument,
          fmt::format("comedi {}: the range of motor {}: {} to {} V is not allowed; expected one with 0 V",
                      config_.device, i + 1, outputs_[i].low, outputs_[i].high));
    }
  }
  // A converter at its end stop is a saturated sensor, wherever the sensor's own end is.
  for (const Scale& input : inputs_) {
    const double step = (input.high - input.low) / input.largest;
    geometry_.force_saturation_V =
        std::min(geometry_.force_saturation_V, std::min(-input.low, input.high) - 0.5 * step);
  }
  for (const auto* line : {&config_.enable, &config_.heartbeat, &config_.onset}) {
    if (!*line) continue;
    if (comedi_dio_config(card_.get(), (*line)->subdevice, (*line)->channel, COMEDI_OUTPUT) < 0 &&
        comedi_get_subdevice_type(card_.get(), (*line)->subdevice) != COMEDI_SUBD_DO)
      return refuse("digital output", **line);
  }
  if (!config_.emergency_stop) return {};
  const ComediChannel& stop = *config_.emergency_stop;
  if (comedi_dio_config(card_.get(), stop.subdevice, stop.channel, COMEDI_INPUT) < 0 &&
      comedi_get_subdevice_type(card_.get(), stop.subdevice) != COMEDI_SUBD_DI) {
    return refuse("emergency stop", stop);
  }
  return {};
}

Result<void> Comedi::set_up_auxiliary(double period) {
  const auto refuse_channel = [&](const std::string& name, const std::string& why) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("comedi {}: auxiliary channel {}: {}", config_.device, name, why));
  };
  auxiliary_inputs_.clear();
  for (const AuxiliaryChannel& channel : auxiliary_) {
    const auto wired = std::find_if(config_.auxiliary.begin(), config_.auxiliary.end(),
                                    [&](const auto& input) { return input.name == channel.name; });
    if (wired == config_.auxiliary.end())
      return refuse_channel(channel.name, "has no input; expected [[comedi.auxiliary]] of this name");
    constexpr double kTolerance = 1e-6;
    if (channel.rate * period > 1.0 + kTolerance)
      return refuse_channel(channel.name,
                            fmt::format("rate_Hz: {} is not allowed; expected at most {:g}, one "
                                        "value in each cycle of the loop",
                                        channel.rate, 1.0 / period));
    TONUS_TRY(check("auxiliary channel", wired->input, COMEDI_SUBD_AI));
    TONUS_TRY_ASSIGN(const Scale scale, scale_of("auxiliary channel", wired->input));
    auxiliary_inputs_.push_back({wired->input, scale});
  }
  if (config_.auxiliary.size() == auxiliary_.size()) return {};
  for (const ComediAuxiliary& input : config_.auxiliary) {
    const bool is_known = std::any_of(auxiliary_.begin(), auxiliary_.end(),
                                      [&](const auto& channel) { return channel.name == input.name; });
    if (!is_known)
      return refuse_channel(input.name, "is not in the profile; expected [[auxiliary]] of this name");
  }
  return refuse_channel(config_.auxiliary.back().name, "is wired more than once");
}

Result<void> Comedi::check(const char* what, const ComediChannel& channel, int type) const {
  const int found = comedi_get_subdevice_type(card_.get(), channel.subdevice);
  if (found < 0) return refuse(what, channel);
  if (found != type) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("comedi {}: type of subdevice {} of the {}: {} is not allowed; expected {}",
                            config_.device, channel.subdevice, what, found, type));
  }
  const int channels = comedi_get_n_channels(card_.get(), channel.subdevice);
  if (channels > 0 && channel.channel < static_cast<unsigned>(channels)) return {};
  return fail(ErrorCode::kInvalidArgument,
              fmt::format("comedi {}: channel of the {}: {} is not allowed; expected 0 to {}", config_.device,
                          what, channel.channel, channels - 1));
}

Result<Comedi::Scale> Comedi::scale_of(const char* what, const ComediChannel& channel) const {
  const comedi_range* range =
      comedi_get_range(card_.get(), channel.subdevice, channel.channel, channel.range);
  const std::uint32_t largest = comedi_get_maxdata(card_.get(), channel.subdevice, channel.channel);
  if (range == nullptr || largest == 0 || !(range->max > range->min)) return refuse(what, channel);
  if (range->unit != UNIT_volt) {
    return fail(ErrorCode::kInvalidArgument, fmt::format("comedi {}: range {} of the {} is not in volts",
                                                         config_.device, channel.range, what));
  }
  return Scale{range->min, range->max, largest};
}

// From the middle of its range, so that it does not wrap at once.
Result<void> Comedi::set_up_counter(const ComediChannel& channel, std::uint32_t largest) const {
  if (!config_.counter_mode) return {};
  comedi_t* card = card_.get();
  const bool is_good =
      comedi_reset_channel(card, channel.subdevice, channel.channel) >= 0 &&
      comedi_set_counter_mode(card, channel.subdevice, channel.channel, *config_.counter_mode) >= 0 &&
      comedi_data_write(card, channel.subdevice, channel.channel, 0, 0, largest / 2 + 1) >= 0 &&
      comedi_arm_channel(card, channel.subdevice, channel.channel, NI_GPCT_ARM_IMMEDIATE) >= 0;
  if (!is_good) return refuse("encoder's counter", channel);
  return {};
}

Result<void> Comedi::activate() {
  if (!is_configured_) return fail(ErrorCode::kUnavailable, "comedi: activate() before configure()");
  if (config_.enable && !write_line(config_.enable, true)) return refuse("enable", *config_.enable);
  is_active_ = true;
  return {};
}

bool Comedi::write_line(const std::optional<ComediChannel>& line, bool is_high) noexcept {
  return !line || comedi_dio_write(card_.get(), line->subdevice, line->channel, is_high ? 1 : 0) >= 0;
}

void Comedi::heartbeat(bool level) noexcept {
  if (is_active_) (void)write_line(config_.heartbeat, level);
}

bool Comedi::set_onset(bool is_on) noexcept {
  return is_active_ && config_.onset && write_line(config_.onset, is_on);
}

void Comedi::read_auxiliary(std::span<const std::uint32_t> counts, std::span<float> values) noexcept {
  if (!is_active_) return;
  std::size_t place = 0;
  for (std::size_t i = 0; i < auxiliary_inputs_.size(); ++i) {
    double volts = 0.0;
    if (counts[i] > 0 && read_volts(auxiliary_inputs_[i].channel, auxiliary_inputs_[i].scale, volts))
      values[place + counts[i] - 1] = static_cast<float>(volts);
    place += counts[i];
  }
}

bool Comedi::disable(const ComediConfig& config) noexcept {
  const std::unique_ptr<comedi_t, Close> card(comedi_open(config.device.c_str()));
  if (!card) return false;
  bool is_done = !config.enable ||
                 comedi_dio_write(card.get(), config.enable->subdevice, config.enable->channel, 0) >= 0;
  for (const ComediChannel& motor : config.motors) {
    const comedi_range* range = comedi_get_range(card.get(), motor.subdevice, motor.channel, motor.range);
    const std::uint32_t largest = comedi_get_maxdata(card.get(), motor.subdevice, motor.channel);
    if (range == nullptr || largest == 0) return false;
    const double share = std::clamp(-range->min / (range->max - range->min), 0.0, 1.0);
    const auto zero = static_cast<lsampl_t>(std::lround(share * largest));
    is_done = comedi_data_write(card.get(), motor.subdevice, motor.channel, motor.range, motor.reference,
                                zero) >= 0 &&
              is_done;
  }
  return is_done;
}

void Comedi::deactivate() noexcept {
  is_active_ = false;
  if (!card_ || !is_configured_) return;
  (void)write_line(config_.enable, false);
  for (std::size_t i = 0; i < 2; ++i) (void)write_volts(i, 0.0);
}

DriverStatus Comedi::read(Reading& reading) noexcept {
  if (!is_active_) return DriverStatus::kFailed;
  Reading taken;
  last_ns_ = std::max(last_ns_ + 1, monotonic_ns());
  taken.raw.acquisition_ns = last_ns_;
  for (std::size_t i = 0; i < 2; ++i) {
    if (!read_counter(i, taken.raw.encoder_count[i]) ||
        !read_volts(config_.force[i], inputs_[i], taken.raw.force_V[i]))
      return DriverStatus::kDisconnected;
  }
  if (config_.emergency_stop) {
    unsigned bit = 0;
    if (comedi_dio_read(card_.get(), config_.emergency_stop->subdevice, config_.emergency_stop->channel,
                        &bit) < 0)
      return DriverStatus::kDisconnected;
    taken.is_emergency_stop_pressed = (bit != 0) == config_.is_pressed_when_high;
  }
  reading = taken;
  return DriverStatus::kOk;
}

// The shorter way around the counter's circle is the way it went.
bool Comedi::read_counter(std::size_t i, double& count) noexcept {
  const ComediChannel& channel = config_.encoders[i];
  Counter& counter = counters_[i];
  lsampl_t now = 0;
  if (comedi_data_read(card_.get(), channel.subdevice, channel.channel, 0, 0, &now) < 0) return false;
  const std::int64_t circle = static_cast<std::int64_t>(counter.largest) + 1;
  if (!counter.has_last) {
    counter.count = config_.counter_mode ? static_cast<std::int64_t>(now) - (counter.largest / 2 + 1)
                                         : static_cast<std::int64_t>(now);
    counter.has_last = true;
  } else {
    std::int64_t way = (static_cast<std::int64_t>(now) - counter.last) % circle;
    if (way > circle / 2) way -= circle;
    if (way < -circle / 2) way += circle;
    counter.count += way;
  }
  counter.last = now;
  count = static_cast<double>(counter.count);
  return true;
}

bool Comedi::read_volts(const ComediChannel& channel, const Scale& scale, double& volts) noexcept {
  lsampl_t value = 0;
  if (comedi_data_read(card_.get(), channel.subdevice, channel.channel, channel.range, channel.reference,
                       &value) < 0)
    return false;
  volts = scale.low + (scale.high - scale.low) * value / scale.largest;
  return true;
}

bool Comedi::write_volts(std::size_t i, double volts) noexcept {
  const ComediChannel& channel = config_.motors[i];
  const Scale& scale = outputs_[i];
  const double share = (std::clamp(volts, scale.low, scale.high) - scale.low) / (scale.high - scale.low);
  const auto value = static_cast<lsampl_t>(std::lround(share * scale.largest));
  return comedi_data_write(card_.get(), channel.subdevice, channel.channel, channel.range, channel.reference,
                           value) >= 0;
}

DriverStatus Comedi::write(const Eigen::Vector2d& torque) noexcept {
  if (!is_active_) return DriverStatus::kFailed;
  const bool is_finite = torque.allFinite();
  bool is_written = true;
  for (std::size_t i = 0; i < 2; ++i) {
    const double volts = is_finite ? torque[static_cast<Eigen::Index>(i)] / config_.torque_per_volt[i] : 0.0;
    is_written = write_volts(i, volts) && is_written;
  }
  return is_finite && is_written ? DriverStatus::kOk : DriverStatus::kFailed;
}

}  // namespace tonus::drivers
