#include "services/mechanics/auxiliary_channel.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>
#include <spdlog/fmt/fmt.h>

namespace tonus {
namespace {

constexpr std::size_t kLongestName = 32;
constexpr std::size_t kLongestUnit = 16;
constexpr double kRateTolerance = 1e-6;  // of a multiple

bool is_letter_or_digit(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; }

Error refuse(const AuxiliaryChannel& channel, const char* what, const std::string& value,
             const std::string& expected) {
  return fail(ErrorCode::kInvalidArgument,
              fmt::format("auxiliary channel {}: {}: {} is not allowed; expected {}", channel.name, what,
                          value, expected));
}

Result<void> validate(const AuxiliaryChannel& channel, double sample_rate) {
  if (const std::string fault = fault_of_auxiliary_name(channel.name); !fault.empty())
    return fail(ErrorCode::kInvalidArgument, "auxiliary channel: name: " + fault);
  const auto& types = auxiliary_types();
  if (std::find(types.begin(), types.end(), channel.type) == types.end())
    return refuse(channel, "type", channel.type, fmt::format("{}", fmt::join(types, ", ")));
  const bool has_control = std::any_of(channel.unit.begin(), channel.unit.end(), [](char c) {
    return std::iscntrl(static_cast<unsigned char>(c)) != 0;
  });
  if (channel.unit.empty() || channel.unit.size() > kLongestUnit || has_control)
    return refuse(channel, "unit", "'" + channel.unit + "'", fmt::format("1 to {} bytes", kLongestUnit));
  if (!std::isfinite(channel.unit_per_value) || channel.unit_per_value == 0.0)
    return refuse(channel, "unit_per_value", fmt::format("{}", channel.unit_per_value),
                  "a number that is not 0");
  if (!(channel.rate <= kMostAuxiliaryRate) || values_per_sample(channel, sample_rate) == 0)
    return refuse(channel, "rate_Hz", fmt::format("{}", channel.rate),
                  fmt::format("a whole multiple of the sample rate, {:.9g} Hz, up to {:g} Hz", sample_rate,
                              kMostAuxiliaryRate));
  return {};
}

}  // namespace

const std::vector<std::string>& auxiliary_types() {
  static const std::vector<std::string> types{"EMG",   "ECG",  "EOG",  "EYEGAZE", "GSR", "PPG",
                                              "PUPIL", "RESP", "TEMP", "TRIG",    "MISC"};
  return types;
}

std::string fault_of_auxiliary_name(const std::string& name) {
  const bool is_good = !name.empty() && name.size() <= kLongestName &&
                       std::all_of(name.begin(), name.end(), is_letter_or_digit);
  if (is_good) return {};
  return fmt::format("'{}' is not allowed; expected 1 to {} letters and digits", name, kLongestName);
}

std::uint32_t values_per_sample(const AuxiliaryChannel& channel, double sample_rate) {
  const double ratio = channel.rate / sample_rate;
  const double whole = std::round(ratio);
  if (!(whole >= 1.0 && whole <= 1e6 && std::abs(ratio - whole) <= kRateTolerance * whole)) return 0;
  return static_cast<std::uint32_t>(whole);
}

std::size_t values_per_sample(std::span<const AuxiliaryChannel> channels, double sample_rate) {
  std::size_t sum = 0;
  for (const auto& channel : channels) sum += values_per_sample(channel, sample_rate);
  return sum;
}

Result<void> validate(std::span<const AuxiliaryChannel> channels, double sample_rate) {
  if (channels.size() > kMostAuxiliaryChannels)
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("auxiliary channels: {} are not allowed; expected at most {}", channels.size(),
                            kMostAuxiliaryChannels));
  std::set<std::string> names;
  for (const auto& channel : channels) {
    TONUS_TRY(validate(channel, sample_rate));
    if (!names.insert(channel.name).second) return refuse(channel, "name", channel.name, "every name once");
  }
  const std::size_t values = values_per_sample(channels, sample_rate);
  if (values <= kMostAuxiliaryValues) return {};
  return fail(ErrorCode::kInvalidArgument,
              fmt::format("auxiliary channels: {} values with a sample are not allowed; expected at most {}",
                          values, kMostAuxiliaryValues));
}

}  // namespace tonus
