#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis_service/service/judge_options.hpp"
#include "analysis_service/service/service.hpp"
#include "services/core/result.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace tonus::identification {

/// What tonus-identification is told beyond the common options.
class CommandLine {
 public:
  void add_to(CLI::App& app);

  /// kInvalidArgument names the option, its value and what is allowed.
  [[nodiscard]] Result<ServiceSettings> settings(const std::string& rig) const;

 private:
  [[nodiscard]] Result<std::vector<impedance::Options>> analyses_by_method() const;

  std::vector<std::string> methods_{std::string(impedance::kAutomatic)};
  std::vector<std::string> models_{"linear"};
  std::optional<double> natural_frequency_;
  impedance::Options options_;
  JudgeOptions judge_;
  int force_sign_ = 1;
};

}  // namespace tonus::identification
