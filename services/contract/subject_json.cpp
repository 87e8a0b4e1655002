#include "services/contract/subject_json.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>
#include <string>
#include <string_view>

#include "services/contract/subject.hpp"
#include "services/core/text.hpp"

namespace tonus::contract {
namespace {

using nlohmann::json;
using Pair = std::array<double, 2>;

constexpr std::size_t kLongestText = 32;

struct NumberField {
  std::string_view name;
  double (v1::SubjectFacts::*get)() const;
  void (v1::SubjectFacts::*set)(double);
};
struct TextField {
  std::string_view name;
  const std::string& (v1::SubjectFacts::*get)() const;
  void (v1::SubjectFacts::*set)(const std::string&);
};
struct PairField {
  std::string_view name;
  const Pair& (v1::SubjectFacts::*get)() const;
  void (v1::SubjectFacts::*set)(const Pair&);
};

using Facts = v1::SubjectFacts;
constexpr std::array<NumberField, 3> kNumbers{{{"age_years", &Facts::age_years, &Facts::age_years},
                                               {"height_m", &Facts::height_m, &Facts::height_m},
                                               {"weight_kg", &Facts::weight_kg, &Facts::weight_kg}}};
constexpr std::array<TextField, 3> kTexts{{{"sex", &Facts::sex, &Facts::sex},
                                           {"handedness", &Facts::handedness, &Facts::handedness},
                                           {"measured_arm", &Facts::measured_arm, &Facts::measured_arm}}};
constexpr std::array<PairField, 3> kPairs{
    {{"link_lengths_m", &Facts::link_lengths_m, &Facts::link_lengths_m},
     {"circumferences_m", &Facts::circumferences_m, &Facts::circumferences_m},
     {"shoulder_m", &Facts::shoulder_m, &Facts::shoulder_m}}};

json known_or_null(double value) { return std::isfinite(value) ? json(value) : json(nullptr); }

Error refuse(std::string_view name, const std::string& expected) {
  return fail(ErrorCode::kInvalidArgument,
              fmt::format("subject_facts: {:.40}: expected {}", shown(name), expected));
}

bool is_number(const json& value) { return value.is_number() || value.is_null(); }

double number_of(const json& value) { return value.is_null() ? std::nan("") : value.get<double>(); }

bool is_pair(const json& value) {
  return value.is_null() ||
         (value.is_array() && value.size() == 2 && is_number(value[0]) && is_number(value[1]));
}

template <typename List>
auto* find(const List& list, std::string_view name) {
  const auto found =
      std::find_if(list.begin(), list.end(), [&](const auto& one) { return one.name == name; });
  return found == list.end() ? nullptr : &*found;
}

Result<void> set(v1::SubjectFacts& facts, const std::string& name, const json& value) {
  if (const auto* number = find(kNumbers, name)) {
    if (!is_number(value)) return refuse(name, "a number, or null where it is not known");
    (facts.*number->set)(number_of(value));
  } else if (const auto* text = find(kTexts, name)) {
    if (!value.is_null() && (!value.is_string() || value.get_ref<const std::string&>().size() > kLongestText))
      return refuse(name, fmt::format("a text of at most {} bytes", kLongestText));
    (facts.*text->set)(value.is_null() ? std::string() : value.get<std::string>());
  } else if (const auto* pair = find(kPairs, name)) {
    if (!is_pair(value)) return refuse(name, "a list of two numbers, null where one is not known");
    if (!value.is_null()) (facts.*pair->set)({number_of(value[0]), number_of(value[1])});
  } else {
    return refuse(name, "no such key");
  }
  return {};
}

}  // namespace

json message_json(const v1::SubjectFacts& facts) {
  json object;
  for (const auto& field : kNumbers) object[std::string(field.name)] = known_or_null((facts.*field.get)());
  for (const auto& field : kTexts) object[std::string(field.name)] = (facts.*field.get)();
  for (const auto& field : kPairs) {
    const Pair& pair = (facts.*field.get)();
    object[std::string(field.name)] = {known_or_null(pair[0]), known_or_null(pair[1])};
  }
  return object;
}

Result<v1::SubjectFacts> subject_facts_of(const json& object) {
  if (!object.is_object()) return fail(ErrorCode::kInvalidArgument, "subject_facts: expected an object");
  v1::SubjectFacts facts = unknown_subject();
  for (const auto& [name, value] : object.items()) TONUS_TRY(set(facts, name, value));
  return facts;
}

}  // namespace tonus::contract
