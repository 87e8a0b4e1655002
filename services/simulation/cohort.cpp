#include "services/simulation/cohort.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>
#include <sstream>
#include <toml++/toml.h>

#include "services/config/checked_table.hpp"
#include "services/config/toml_text.hpp"
#include "services/core/text_file.hpp"

namespace tonus::simulation {
namespace {

constexpr const char* kDampingKey = "joint_damping_Nms_per_rad";
constexpr double kLongestTime = 1.0;  // s

void read(config::CheckedTable s, JointImpedance& joints, double high) {
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
                fmt::format("{}: subject[{}].name is missing; expected text", source, number));
  }
  const std::string who = fmt::format("{}, subject '{}'", source, subject.name);
  toml::table profile = merged(common, table);
  auto parsed = read_profile(profile, who);
  if (!parsed) return parsed.error();
  if (table.contains("damping_time_s")) {
    config::Findings findings{who, {}, {}};
    JointImpedance time{0.0, 0.0, 0.0};
    read(config::CheckedTable(table, "", 0, findings).table("damping_time_s"), time, kLongestTime);
    if (findings.problem) return fail(ErrorCode::kInvalidArgument, *findings.problem);
    profile["subject"].as_table()->insert_or_assign(kDampingKey,
                                                    table_of(damping_of(parsed->subject.stiffness, time)));
    parsed = read_profile(profile, who);
    if (!parsed) return parsed.error();
  }
  subject.profile = *parsed;
  subject.profile_toml = text_of(profile);
  return subject;
}

}  // namespace

Result<std::vector<CohortSubject>> parse_cohort(std::string_view text, std::string_view source) {
  TONUS_TRY_ASSIGN(const toml::table root, config::parse_toml(text, std::string(source)));
  const toml::table* common = root["common"].as_table();
  const toml::array* subjects = root["subject"].as_array();
  if (subjects == nullptr || subjects->empty() || !subjects->is_array_of_tables()) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("{}: subject is missing; expected one table [[subject]] or more", source));
  }
  std::vector<CohortSubject> cohort;
  for (const toml::node& node : *subjects) {
    auto subject =
        subject_of(common == nullptr ? toml::table{} : *common, *node.as_table(), cohort.size() + 1, source);
    if (!subject) return subject.error();
    const auto is_same = [&](const CohortSubject& other) { return other.name == subject->name; };
    if (std::any_of(cohort.begin(), cohort.end(), is_same)) {
      return fail(ErrorCode::kInvalidArgument,
                  fmt::format("{}: subject[{}].name: \"{}\" is not allowed; expected each name once", source,
                              cohort.size() + 1, subject->name));
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
