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
constexpr const char* kTimeKey = "damping_time_s";
constexpr double kLongestTime = 1.0;  // s

void read(config::CheckedTable s, JointImpedance& joints, double high) {
  s.number("shoulder", joints.shoulder, 0.0, high);
  s.number("elbow", joints.elbow, 0.0, high);
  s.number("two_joint", joints.two_joint, 0.0, high);
  s.finish();
}

/// The keys of a [[subject]] beside those of a profile's [subject]; the time constants, where it has them.
void read(config::CheckedTable& s, std::string& name, std::optional<JointImpedance>& time) {
  name = s.text("name", 1, 40);
  if (s.has(kTimeKey)) read(s.table(kTimeKey), time.emplace(), kLongestTime);
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
    if (key == "name" || key == kTimeKey) continue;
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
  config::Findings findings{std::string(source), {}, {}};
  config::CheckedTable own(table, fmt::format("subject[{}]", number), 0, findings);
  std::optional<JointImpedance> time;
  read(own, subject.name, time);
  if (findings.problem) return fail(ErrorCode::kInvalidArgument, *findings.problem);
  const std::string who = fmt::format("{}, subject '{}'", source, subject.name);
  toml::table profile = merged(common, table);
  auto parsed = read_profile(profile, who);
  if (!parsed) return parsed.error();
  if (time) {
    profile["subject"].as_table()->insert_or_assign(kDampingKey,
                                                    table_of(damping_of(parsed->subject.stiffness, *time)));
    parsed = read_profile(profile, who);
    if (!parsed) return parsed.error();
  }
  subject.profile = *parsed;
  subject.profile_toml = text_of(profile);
  return subject;
}

}  // namespace

namespace {

constexpr int kCohortSchema = 1;

/// The root's keys; `common` and `subject` have readers of their own.
void read_root(config::CheckedTable root) {
  (void)root.whole("schema", kCohortSchema, kCohortSchema, kCohortSchema);
  (void)root.has("common");
  (void)root.has("subject");
  root.finish();
}

}  // namespace

std::vector<config::Key> cohort_keys() {
  return config::keys_of([](config::CheckedTable root, config::Findings&) {
    read_root(root);
    auto subjects = root.tables("subject", 1, 1000);
    std::string name;
    std::optional<JointImpedance> time;
    read(subjects.front(), name, time);
  });
}

Result<std::vector<CohortSubject>> parse_cohort(std::string_view text, std::string_view source) {
  TONUS_TRY_ASSIGN(const toml::table root, config::parse_toml(text, std::string(source)));
  config::Findings findings{std::string(source), {}, {}};
  read_root(config::CheckedTable(root, "", 0, findings));
  if (findings.problem) return fail(ErrorCode::kInvalidArgument, *findings.problem);
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
