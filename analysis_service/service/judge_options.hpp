#pragma once

#include <string>

#include "analysis_service/identification/trial_judge.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace tonus::identification {

/// What a person says of the limits that trials are judged by: the same options for the service and for the
/// commands that judge without it.
class JudgeOptions {
 public:
  void add_to(CLI::App& app);

  [[nodiscard]] JudgeChoice choice() const;

 private:
  JudgeChoice choice_;
  std::string preset_ = "posture";
};

}  // namespace tonus::identification
