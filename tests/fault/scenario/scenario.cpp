#include "tests/fault/scenario/scenario.hpp"

#include <algorithm>
#include <array>
#include <random>
#include <spdlog/fmt/fmt.h>
#include <sstream>
#include <utility>

namespace tonus::testing {
namespace {

constexpr std::array kPrograms{"rig-agent", "scheduler", "identification", "archive"};

bool is_program(const std::string& name) {
  return std::find(kPrograms.begin(), kPrograms.end(), name) != kPrograms.end();
}

/// What a step is written as: its word, and which of the other parts it has.
struct Form {
  Step::Act act;
  const char* word;
  bool has_program;
  const char* last;  ///< "for": lasts, positive; "by": lasts, of either sign; "at": count; "": nothing.
};
constexpr std::array kForms{Form{Step::Act::kKill, "kill", true, ""},
                            Form{Step::Act::kPause, "pause", true, "for"},
                            Form{Step::Act::kRestart, "restart", false, ""},
                            Form{Step::Act::kStop, "stop", false, ""},
                            Form{Step::Act::kTear, "tear", true, "at"},
                            Form{Step::Act::kCut, "cut", true, "for"},
                            Form{Step::Act::kFillDisk, "fill-disk", true, "for"},
                            Form{Step::Act::kStepClock, "step-clock", false, "by"},
                            Form{Step::Act::kPauseSession, "pause-session", false, ""},
                            Form{Step::Act::kAbortSession, "abort-session", false, ""}};

std::string to_text(const Step& step) {
  const Form& form =
      *std::find_if(kForms.begin(), kForms.end(), [&step](const Form& each) { return each.act == step.act; });
  std::string text = form.word;
  if (form.has_program) text += ' ' + step.program;
  text += fmt::format(" after {:.2f}", step.after);
  const std::string_view last = form.last;
  if (last == "at") return text + fmt::format(" at {}", step.count);
  return last.empty() ? text : text + fmt::format(" {} {:.2f}", last, step.lasts);
}

bool read_last(std::istringstream& words, const std::string_view last, Step& step) {
  if (last.empty()) return true;
  std::string word;
  if (!(words >> word) || word != last) return false;
  if (last == "at") return (words >> step.count) && step.count > 0;
  return (words >> step.lasts) && (last == "by" || step.lasts > 0.0);
}

Result<Step> parse_step(const std::string& text) {
  std::istringstream words(text);
  std::string act;
  std::string word;
  words >> act;
  const auto form =
      std::find_if(kForms.begin(), kForms.end(), [&act](const Form& each) { return each.word == act; });
  Step step;
  const bool is_good = form != kForms.end() &&
                       (!form->has_program || ((words >> step.program) && is_program(step.program))) &&
                       (words >> word >> step.after) && word == "after" && step.after >= 0.0 &&
                       read_last(words, form->last, step) && !(words >> word);
  if (!is_good) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("step '{}' is not allowed; expected 'kill PROGRAM after S', 'pause PROGRAM after "
                            "S for S', 'restart after S', 'stop after S', 'tear PROGRAM after S at N', 'cut "
                            "PROGRAM after S for S', 'fill-disk PROGRAM after S for S', 'step-clock after S "
                            "by S', 'pause-session after S' or 'abort-session after S', PROGRAM one of {}",
                            text, fmt::join(kPrograms, ", ")));
  }
  step.act = form->act;
  return step;
}

/// Without the steps from `first` to below `end`; what follows them keeps its time.
Scenario without(const Scenario& scenario, std::size_t first, std::size_t end) {
  Scenario shorter;
  double left_out = 0.0;
  for (std::size_t i = 0; i < scenario.size(); ++i) {
    if (i >= first && i < end) {
      left_out += scenario[i].after;
      continue;
    }
    shorter.push_back(scenario[i]);
    shorter.back().after += std::exchange(left_out, 0.0);
  }
  return shorter;
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

Scenario draw_simulated_scenario(std::uint64_t seed, unsigned steps) {
  using Act = Step::Act;
  // As often as it stands there.
  constexpr std::array kActs{Act::kKill,      Act::kKill, Act::kTear,        Act::kTear,     Act::kTear,
                             Act::kPause,     Act::kStop, Act::kCut,         Act::kFillDisk, Act::kRestart,
                             Act::kStepClock, Act::kCut,  Act::kPauseSession};
  std::mt19937_64 random(seed);
  const auto below = [&random](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  const auto between = [&random](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1.0p-53;
  };
  Scenario scenario;
  for (unsigned i = 0; i < steps; ++i) {
    Step step;
    step.act = below(100) == 0 ? Act::kAbortSession : kActs[below(kActs.size())];
    step.program = kPrograms[below(kPrograms.size())];
    step.after = between(0.0, 6.0);
    step.lasts = step.act == Act::kStepClock ? between(-30.0, 30.0) : between(0.1, 8.0);
    step.count = 1 + static_cast<unsigned>(below(60));
    scenario.push_back(*parse_step(to_text(step)));  // as it reads back
  }
  return scenario;
}

Scenario shrink(Scenario scenario, const std::function<bool(const Scenario&)>& breaks, unsigned tries) {
  for (std::size_t part = std::max<std::size_t>(1, scenario.size() / 2); tries > 0; part /= 2) {
    for (std::size_t i = 0; i < scenario.size() && tries > 0; --tries) {
      Scenario shorter = without(scenario, i, std::min(i + part, scenario.size()));
      if (breaks(shorter)) {
        scenario = std::move(shorter);
      } else {
        i += part;
      }
    }
    if (part <= 1) break;
  }
  return scenario;
}

}  // namespace tonus::testing
