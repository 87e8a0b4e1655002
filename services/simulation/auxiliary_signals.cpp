#include "services/simulation/auxiliary_signals.hpp"

#include <algorithm>
#include <cmath>
#include <spdlog/fmt/fmt.h>

namespace tonus::simulation {
namespace {

constexpr char kOnset[] = "Onset";
constexpr std::uint64_t kFirstStream =
    16;                               // of the profile's seed; the others stand in plant.cpp and subject.cpp
constexpr double kLeastRate = 100.0;  // Hz, of an EMG

std::size_t muscle_of(const std::string& name) {
  return static_cast<std::size_t>(std::find(kMuscleNames.begin(), kMuscleNames.end(), name) -
                                  kMuscleNames.begin());
}

/// 0: no unit of an EMG.
double volts_per(const std::string& unit) {
  if (unit == "V") return 1.0;
  if (unit == "mV") return 1e-3;
  return unit == "uV" ? 1e-6 : 0.0;
}

Error refuse(const AuxiliaryChannel& channel, const char* what, const std::string& value,
             const std::string& expected) {
  return fail(ErrorCode::kInvalidArgument,
              fmt::format("simulated: auxiliary channel {}: {}: {} is not allowed; expected {}", channel.name,
                          what, value, expected));
}

}  // namespace

std::vector<std::string> auxiliary_sources() {
  std::vector<std::string> names(kMuscleNames.begin(), kMuscleNames.end());
  names.emplace_back(kOnset);
  return names;
}

Result<void> validate_auxiliary(std::span<const AuxiliaryChannel> channels) {
  for (const auto& channel : channels) {
    if (channel.name == kOnset) continue;
    if (muscle_of(channel.name) == kMuscles)
      return refuse(channel, "name", channel.name, fmt::format("{}", fmt::join(auxiliary_sources(), ", ")));
    if (volts_per(channel.unit) == 0.0) return refuse(channel, "unit", channel.unit, "V, mV or uV");
    if (!(channel.rate >= kLeastRate))
      return refuse(channel, "rate_Hz", fmt::format("{}", channel.rate),
                    fmt::format("{} or more", kLeastRate));
  }
  return {};
}

AuxiliarySignals::AuxiliarySignals(std::span<const AuxiliaryChannel> channels, const MuscleProfile& muscles,
                                   std::uint64_t seed)
    : muscles_(muscles) {
  for (const auto& channel : channels) {
    Source source;
    source.unit_per_value = channel.unit_per_value;
    if (channel.name != kOnset) {
      source.muscle = muscle_of(channel.name);
      source.volts_per_unit = volts_per(channel.unit);
      source.emg.emplace(channel.rate, seed, kFirstStream + source.muscle);
    }
    sources_.push_back(source);
  }
}

void AuxiliarySignals::measure(const Activations& active, bool is_onset,
                               std::span<const std::uint32_t> counts, std::span<float> values) noexcept {
  auto place = values.begin();
  for (std::size_t i = 0; i < sources_.size(); ++i) {
    Source& source = sources_[i];
    const double factor = 1.0 / source.unit_per_value;
    const double rms =
        source.emg ? std::hypot(muscles_.emg * active[source.muscle], muscles_.noise) / source.volts_per_unit
                   : 0.0;
    for (std::uint32_t k = 0; k < counts[i]; ++k) {
      const double signal = source.emg ? source.emg->next(rms) : (is_onset ? 1.0 : 0.0);
      *place++ = static_cast<float>(factor * signal);
    }
  }
}

}  // namespace tonus::simulation
