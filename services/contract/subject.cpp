#include "services/contract/subject.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <spdlog/fmt/fmt.h>
#include <string>

#include "services/core/text.hpp"

namespace tonus::contract {
namespace {

using Facts = v1::SubjectFacts;
using Pair = std::array<double, 2>;
using std::string_view;

struct NumberRule {
  const char* name;
  double (Facts::*get)() const;
  void (Facts::*set)(double);
  double least;
  double most;
  const char* expected;
};
constexpr std::array kNumbers{
    NumberRule{"age", &Facts::age_years, &Facts::age_years, 0.0, kAgeMost,
               "0 to 89 years; 89 stands for 89 and more"},
    NumberRule{"height", &Facts::height_m, &Facts::height_m, 0.3, 2.6, "0.3 to 2.6 m"},
    NumberRule{"weight", &Facts::weight_kg, &Facts::weight_kg, 2.0, 400.0, "2 to 400 kg"},
};

struct PairRule {
  const char* name;
  const Pair& (Facts::*get)() const;
  void (Facts::*set)(const Pair&);
  double least;
  double most;
  const char* expected;
};
constexpr std::array kPairs{
    PairRule{"link-lengths", &Facts::link_lengths_m, &Facts::link_lengths_m, 0.05, 1.0,
             "0.05 to 1 m for the upper arm and for the forearm with the hand"},
    PairRule{"circumferences", &Facts::circumferences_m, &Facts::circumferences_m, 0.05, 1.0,
             "0.05 to 1 m for the upper arm and for the forearm"},
    PairRule{"shoulder", &Facts::shoulder_m, &Facts::shoulder_m, -5.0, 5.0, "-5 to 5 m for x and for y"},
};

constexpr std::array<string_view, 3> kSexes{"male", "female", "other"};
constexpr std::array<string_view, 3> kHandedness{"right", "left", "ambidextrous"};
constexpr std::array<string_view, 2> kArms{"right", "left"};

struct TextRule {
  const char* name;
  const std::string& (Facts::*get)() const;
  void (Facts::*set)(const std::string&);
  std::span<const string_view> allowed;
  const char* expected;
};
constexpr std::array kTexts{
    TextRule{"sex", &Facts::sex, &Facts::sex, kSexes, "male, female or other"},
    TextRule{"handedness", &Facts::handedness, &Facts::handedness, kHandedness,
             "right, left or ambidextrous"},
    TextRule{"arm", &Facts::measured_arm, &Facts::measured_arm, kArms, "right or left"},
};

Error refuse(string_view what, const std::string& value, string_view expected) {
  return fail(ErrorCode::kInvalidArgument,
              fmt::format("{}: {} is not allowed; expected {}", what, value, expected));
}

/// A text as it is shown in a message: quoted, and not longer than a line.
std::string quoted(string_view text) {
  constexpr std::size_t kShown = 40;
  return text.size() <= kShown
             ? fmt::format("'{}'", shown(text))
             : fmt::format("'{}...' ({} bytes)", shown(text.substr(0, kShown)), text.size());
}

bool is_one_line(string_view text) { return shown(text) == text; }

}  // namespace

Facts unknown_subject() {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  Facts facts;
  for (const NumberRule& rule : kNumbers) (facts.*rule.set)(kUnknown);
  for (const PairRule& rule : kPairs) (facts.*rule.set)({kUnknown, kUnknown});
  return facts;
}

Result<void> check_subject_name(string_view name) {
  constexpr string_view kPrefix = "sub-";
  const string_view own = name.starts_with(kPrefix) ? name.substr(kPrefix.size()) : name;
  if (!own.empty() && own.size() <= kNameMost && is_one_line(own)) return {};
  return refuse("subject", quoted(name),
                fmt::format("a name of 1 to {} bytes on one line, after 'sub-' if it begins so", kNameMost));
}

Result<void> check_subject_facts(const Facts& facts) {
  for (const NumberRule& rule : kNumbers) {
    const double value = (facts.*rule.get)();
    if (std::isinf(value) || value < rule.least || value > rule.most)
      return refuse(rule.name, fmt::format("{}", value), rule.expected);
  }
  for (const PairRule& rule : kPairs) {
    const Pair& pair = (facts.*rule.get)();
    for (const double value : pair) {
      if (std::isinf(value) || value < rule.least || value > rule.most)
        return refuse(rule.name, fmt::format("{}", value), rule.expected);
    }
  }
  for (const TextRule& rule : kTexts) {
    const std::string& text = (facts.*rule.get)();
    if (!text.empty() && std::ranges::find(rule.allowed, text) == rule.allowed.end())
      return refuse(rule.name, quoted(text), rule.expected);
  }
  return {};
}

Result<void> check_name(string_view what, string_view name) {
  if (name.size() <= kNameMost && is_one_line(name)) return {};
  return refuse(what, quoted(name), fmt::format("at most {} bytes on one line", kNameMost));
}

Result<void> check_people(const v1::SessionCommand& start) {
  TONUS_TRY(check_subject_name(start.subject()));
  TONUS_TRY(check_subject_facts(start.subject_facts()));
  TONUS_TRY(check_name("operator", start.requested_by()));
  return check_name("study", start.study());
}

void update_facts(Facts& facts, const Facts& newer) {
  for (const NumberRule& rule : kNumbers) {
    if (std::isfinite((newer.*rule.get)())) (facts.*rule.set)((newer.*rule.get)());
  }
  for (const PairRule& rule : kPairs) {
    Pair pair = (facts.*rule.get)();
    for (std::size_t i = 0; i < pair.size(); ++i) {
      if (std::isfinite((newer.*rule.get)()[i])) pair[i] = (newer.*rule.get)()[i];
    }
    (facts.*rule.set)(pair);
  }
  for (const TextRule& rule : kTexts) {
    if (!(newer.*rule.get)().empty()) (facts.*rule.set)((newer.*rule.get)());
  }
}

bool is_anything_known(const Facts& facts) {
  return std::ranges::any_of(kNumbers, [&](const auto& r) { return std::isfinite((facts.*r.get)()); }) ||
         std::ranges::any_of(kTexts, [&](const auto& r) { return !(facts.*r.get)().empty(); }) ||
         std::ranges::any_of(kPairs, [&](const auto& r) {
           return std::ranges::any_of((facts.*r.get)(), [](double value) { return std::isfinite(value); });
         });
}

}  // namespace tonus::contract
