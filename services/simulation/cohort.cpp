#include "services/simulation/cohort.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>
#include <sstream>
#include <toml++/toml.h>

#include "services/core/text_file.hpp"
#include "services/core/toml_depth.hpp"
#include "services/simulation/toml_section.hpp"

namespace tonus::simulation {
namespace {

constexpr const char* kDampingKey = "joint_damping_Nms_per_rad";
constexpr double kLongestTime = 1.0;  // s

void read(TomlSection s, JointImpedance& joints, double high) {
  s.number("shoulder", joints.shoulder, 0.0, high);
  s.number("elbow", joints.elbow, 0.0, high);
  s.number("two_joint", joints.two_joint, 0.0, high);
  s.finish();
}

/// Damping of the muscle groups from the time constants of the matrices' elements.
JointImpedance damping_of(const JointImpedance& stiffness, const JointImpedance& time) {
  const double two_joint = time.two_joint * stiffness.two_joint;
  return {time.shoulder * (stiffness.shoulder + stiffness.two_joint) - two_joint,
          time.elbow * (stiffness.elbow + stiffness.two_joint) - two_joint, two_joint};
}

toml::table table_of(const JointImpedance& joints) {
  return toml::table{{"shoulder", joints.shoulder}, {"elbow", joints.elbow}, {"two_joint", joints.two_joint}};
}

/// The profile of `common` with the keys of `subject` in its [subject].
toml::table merged(const toml::table& common, const toml::table& subject) {
  toml::table profile = common;
  if (!profile.contains("subject")) profile.insert("subject", toml::table{});
  toml::table& target = *profile["subject"].as_table();
  for (const auto& [key, node] : subject) {
    if (key == "name" || key == "damping_time_s") continue;
    target.insert_or_assign(key, node);
  }
  return profile;
}

std::string text_of(const toml::table& table) {
  std::ostringstream text;
  text << table << "\n";
  return text.str();
}

Result<CohortSubject> subject_of(const toml::table& common, const toml::table& table, std::size_t number,
                                 std::string_view source) {
  CohortSubject subject;
  subject.name = table["name"].value_or(std::string());
  if (subject.name.empty()) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("{}: subject {} has no name, allowed is a text", source, number));
  }
  const std::string who = fmt::format("{}, subject '{}'", source, subject.name);
  toml::table profile = merged(common, table);
  auto parsed = parse_profile(text_of(profile), who);
  if (!parsed) return parsed.error();
  if (table.contains("damping_time_s")) {
    FirstProblem problem(who);
    JointImpedance time{0.0, 0.0, 0.0};
    read(TomlSection(table["damping_time_s"].as_table(), "damping_time_s", problem), time, kLongestTime);
    if (!problem.result()) return problem.result().error();
    profile["subject"].as_table()->insert_or_assign(kDampingKey,
                                                    table_of(damping_of(parsed->subject.stiffness, time)));
    parsed = parse_profile(text_of(profile), who);
    if (!parsed) return parsed.error();
  }
  subject.profile = *parsed;
  subject.profile_toml = text_of(profile);
  return subject;
}

}  // namespace

Result<std::vector<CohortSubject>> parse_cohort(std::string_view text, std::string_view source) {
  TONUS_TRY(check_toml_depth(text, std::string(source)));
  toml::table root;
  try {
    root = toml::parse(text, source);
  } catch (const toml::parse_error& error) {
    return fail(ErrorCode::kInvalidArgument, fmt::format("{}:{}: {}", source, error.source().begin.line,
                                                         std::string(error.description())));
  }
  const toml::table* common = root["common"].as_table();
  const toml::array* subjects = root["subject"].as_array();
  if (subjects == nullptr || subjects->empty() || !subjects->is_array_of_tables()) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("{}: no [[subject]], allowed is one or more", source));
  }
  std::vector<CohortSubject> cohort;
  for (const toml::node& node : *subjects) {
    auto subject =
        subject_of(common == nullptr ? toml::table{} : *common, *node.as_table(), cohort.size() + 1, source);
    if (!subject) return subject.error();
    const auto is_same = [&](const CohortSubject& other) { return other.name == subject->name; };
    if (std::any_of(cohort.begin(), cohort.end(), is_same)) {
      return fail(ErrorCode::kInvalidArgument,
                  fmt::format("{}: subject '{}' is there twice, allowed is once", source, subject->name));
    }
    cohort.push_back(std::move(*subject));
  }
  return cohort;
}

Result<std::vector<CohortSubject>> load_cohort(const std::filesystem::path& file) {
  auto text = read_text_file(file);
  if (!text) return text.error();
  return parse_cohort(*text, file.string());
}

}  // namespace tonus::simulation
