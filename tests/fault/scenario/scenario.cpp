#include "tests/fault/scenario/scenario.hpp"

#include <algorithm>
#include <array>
#include <random>
#include <spdlog/fmt/fmt.h>
#include <sstream>

namespace tonus::testing {
namespace {

constexpr std::array kPrograms{"rig-agent", "scheduler", "identification", "archive"};

bool is_program(const std::string& name) {
  return std::find(kPrograms.begin(), kPrograms.end(), name) != kPrograms.end();
}

std::string to_text(const Step& step) {
  switch (step.act) {
    case Step::Act::kKill:
      return fmt::format("kill {} after {:.2f}", step.program, step.after);
    case Step::Act::kPause:
      return fmt::format("pause {} after {:.2f} for {:.2f}", step.program, step.after, step.lasts);
    case Step::Act::kRestart:
      return fmt::format("restart after {:.2f}", step.after);
    case Step::Act::kStop:
      return fmt::format("stop after {:.2f}", step.after);
  }
  return {};
}

Result<Step> parse_step(const std::string& text) {
  std::istringstream words(text);
  const auto refuse = [&] {
    return fail(
        ErrorCode::kInvalidArgument,
        fmt::format("step '{}' is not allowed; expected 'kill PROGRAM after S', 'pause PROGRAM after S for "
                    "S', 'restart after S' or 'stop after S', PROGRAM one of {}",
                    text, fmt::join(kPrograms, ", ")));
  };
  Step step;
  std::string act;
  std::string word;
  words >> act;
  const bool has_program = act == "kill" || act == "pause";
  if (has_program && !(words >> step.program && is_program(step.program))) return refuse();
  if (!(words >> word >> step.after) || word != "after" || !(step.after >= 0.0)) return refuse();
  if (act == "pause" && (!(words >> word >> step.lasts) || word != "for" || !(step.lasts > 0.0)))
    return refuse();
  if (act == "kill") {
    step.act = Step::Act::kKill;
  } else if (act == "pause") {
    step.act = Step::Act::kPause;
  } else if (act == "restart") {
    step.act = Step::Act::kRestart;
  } else if (act == "stop") {
    step.act = Step::Act::kStop;
  } else {
    return refuse();
  }
  if (words >> word) return refuse();
  return step;
}

}  // namespace

std::string to_text(const Scenario& scenario) {
  std::string text;
  for (const Step& step : scenario) text += (text.empty() ? "" : "; ") + to_text(step);
  return text;
}

Result<Scenario> parse_scenario(std::string_view text) {
  Scenario scenario;
  std::istringstream steps{std::string(text)};
  for (std::string step; std::getline(steps, step, ';');) {
    TONUS_TRY_ASSIGN(auto parsed, parse_step(step));
    scenario.push_back(std::move(parsed));
  }
  return scenario;
}

Scenario draw_scenario(std::uint64_t seed, unsigned steps) {
  std::mt19937_64 random(seed);
  const auto below = [&random](unsigned n) { return static_cast<unsigned>(random() % n); };
  const auto between = [&random](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1.0p-53;
  };
  Scenario scenario;
  for (unsigned i = 0; i < steps; ++i) {
    Step step;
    const unsigned what = below(10);
    step.act = what < 5   ? Step::Act::kKill
               : what < 8 ? Step::Act::kPause
               : what < 9 ? Step::Act::kRestart
                          : Step::Act::kStop;
    if (step.act == Step::Act::kKill || step.act == Step::Act::kPause) step.program = kPrograms[below(4)];
    step.after = between(0.0, 4.0);  // a trial takes about 4 s
    if (step.act == Step::Act::kPause) step.lasts = between(0.1, 8.0);
    scenario.push_back(step);
  }
  return scenario;
}

Scenario shrink(Scenario scenario, const std::string& dds, unsigned tries) {
  for (std::size_t i = 0; i < scenario.size() && tries > 0; --tries) {
    Scenario shorter = scenario;
    shorter.erase(shorter.begin() + static_cast<std::ptrdiff_t>(i));
    const auto broken = run_scenario(shorter, dds);
    if (broken && !broken->empty()) {
      scenario = std::move(shorter);
    } else {
      ++i;
    }
  }
  return scenario;
}

}  // namespace tonus::testing
