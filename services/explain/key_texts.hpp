#pragma once

#include <span>
#include <string_view>

namespace tonus::explain {

/// What a key of a TOML file means. Type, range and default are the reader's to say (config::Key).
struct KeyText {
  std::string_view name;  ///< As config::Key has it: "perturbation.amplitude_m", "posture[].name".
  std::string_view what;  ///< A phrase, without a full stop.
};

[[nodiscard]] std::span<const KeyText> protocol_key_texts();
[[nodiscard]] std::span<const KeyText> profile_key_texts();
[[nodiscard]] std::span<const KeyText> cohort_key_texts();
[[nodiscard]] std::span<const KeyText> comedi_key_texts();

}  // namespace tonus::explain
