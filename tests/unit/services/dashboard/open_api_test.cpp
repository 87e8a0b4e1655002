#include "services/dashboard/gateway/open_api.hpp"

#include <fstream>
#include <limits>
#include <regex>
#include <set>
#include <sstream>

#include "idl/topics.hpp"
#include "services/bus/typed.hpp"
#include "services/contract/names.hpp"
#include "services/contract/subject.hpp"
#include "services/dashboard/gateway/json_messages.hpp"
#include "services/dashboard/gateway/topic_table.hpp"
#include "tests/unit/services/dashboard/gateway_fixture.hpp"
#include "tests/unit/services/dashboard/json_schema.hpp"

namespace tonus::dashboard::testing {
namespace {

using nlohmann::json;

const json& document() {
  static const json parsed = json::parse(kOpenApi);
  return parsed;
}

const json& schema(const std::string& name) { return document()["components"]["schemas"][name]; }

std::set<std::string> keys_of(const json& object) {
  std::set<std::string> keys;
  for (const auto& [key, value] : object.items()) keys.insert(key);
  return keys;
}

v1::Estimate estimate(std::uint32_t axes, v1::EstimateStatus status) {
  v1::Estimate e;
  e.axes(axes);
  e.status(status);
  e.posture("reference");
  e.reasons({"lag: 9 ms"});
  e.mass_kg().has_ellipse(true);
  e.displacement_unit(axes == 1 ? "rad" : "m");
  e.force_unit(axes == 1 ? "N m" : "N");
  v1::FitCheck check;
  check.test(v1::FIT_WIDTH);
  check.value(std::numeric_limits<double>::quiet_NaN());
  e.checks({check});
  e.explained_share(std::numeric_limits<double>::quiet_NaN());
  if (axes == 2) {
    e.set_number(3);
    e.band_high_Hz(20.0);
    e.explained_share(0.9);
    e.compared_models("friction beside linear");
    e.prior("session 1");
    e.mass_kg().known_bias().fill(0.1);
    v1::ModelParameter parameter;
    parameter.name("friction");
    parameter.unit("N");
    e.parameters({parameter});
  }
  return e;
}

/// One whose numbers are not finite, as of a singular fit.
v1::Estimate singular() {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  v1::Estimate e = estimate(2, v1::ESTIMATE_SUSPECT);
  e.condition_number(std::numeric_limits<double>::infinity());
  e.mass_kg().value().fill(kNone);
  e.mass_kg().low95().fill(-std::numeric_limits<double>::infinity());
  e.stiffness_N_per_m().standard_error().fill(kNone);
  e.spring_centre_m().high95().fill(kNone);
  e.sigma_N().fill(kNone);
  e.degrees_of_freedom(kNone);
  e.mass_kg().curl(kNone);
  return e;
}

struct Example {
  std::string topic;
  std::string schema;
  std::vector<std::byte> payload;
};

template <typename T>
Example example(const bus::Topic<T>& topic, const std::string& schema, const T& value) {
  return {std::string(topic.spec.name), schema, bus::encode(value).value()};
}

/// Each topic, with each form that its messages have.
std::vector<Example> examples() {
  v1::TrialVerdict verdict;
  verdict.reasons({v1::REASON_LET_GO, v1::REASON_REJECTED_BY_HAND});
  verdict.muscles({v1::MuscleActivity()});
  verdict.co_contraction(std::numeric_limits<double>::quiet_NaN());
  v1::SessionPlan plan;
  plan.postures({v1::PlannedPosture()});
  plan.subject_facts(contract::unknown_subject());
  v1::SessionState with_trial;
  with_trial.trial_id({1});
  with_trial.conditions({v1::ConditionProgress()});
  v1::SessionNote note;
  note.trial_id({1});
  note.has_rig_clock(true);
  v1::RigDescription rig;
  rig.limits_off({"force"});
  rig.limits({v1::RigLimits()});
  rig.auxiliary_channels({v1::AuxiliaryChannel()});
  v1::TrialOutcome marked;
  marked.is_onset_marked(true);
  v1::RigState armed;
  armed.session_id({1});
  armed.trial_id({2});
  return {example(topics::kEstimateCondition, "Estimate", estimate(2, v1::ESTIMATE_OK)),
          example(topics::kEstimateCondition, "Estimate", estimate(1, v1::ESTIMATE_SUSPECT)),
          example(topics::kEstimateCondition, "Estimate", singular()),
          example(topics::kEstimateLive, "Estimate", estimate(2, v1::ESTIMATE_UNDETERMINED)),
          example(topics::kTrialVerdict, "TrialVerdict", verdict),
          example(topics::kTrialOutcome, "TrialOutcome", v1::TrialOutcome()),
          example(topics::kTrialOutcome, "TrialOutcome", marked),
          example(topics::kTrialReview, "TrialReview", v1::TrialReview()),
          example(topics::kSessionNote, "SessionNote", v1::SessionNote()),
          example(topics::kSessionNote, "SessionNote", note),
          example(topics::kRigDescription, "RigDescription", v1::RigDescription()),
          example(topics::kRigDescription, "RigDescription", rig),
          example(topics::kSessionPlan, "SessionPlan", plan),
          example(topics::kSessionState, "SessionState", v1::SessionState()),
          example(topics::kSessionState, "SessionState", with_trial),
          example(topics::kRigState, "RigState", v1::RigState()),
          example(topics::kRigState, "RigState", armed)};
}

TEST(OpenApi, DescribesEveryFieldOfEveryMessageAndNoOther) {
  std::set<std::string> topics;
  std::map<std::string, std::set<std::string>> seen;
  for (const Example& one : examples()) {
    const auto text = json_message(one.topic, 5, one.payload);
    ASSERT_TRUE(text) << text.error().message;
    const json message = json::parse(*text);
    EXPECT_EQ(violation(document(), schema("Message"), message), "");
    EXPECT_EQ(violation(document(), schema(one.schema), message["message"], one.schema), "");
    topics.insert(one.topic);
    seen[one.schema].merge(keys_of(message["message"]));
  }
  EXPECT_EQ(topics, std::set<std::string>(json_topics().begin(), json_topics().end()));
  for (const auto& [name, keys] : seen) EXPECT_EQ(keys, keys_of(schema(name)["properties"])) << name;
}

TEST(OpenApi, NamesOfFieldsAreThoseOfTheContract) {
  for (const std::string name :
       {"TrialVerdict", "MuscleActivity", "TrialProgram", "TrialOutcome", "TrialReview", "SessionPlan",
        "SubjectFacts", "PlannedPosture", "SessionState", "ConditionProgress", "SessionNote", "RigState",
        "RigDescription", "RigLimits", "AuxiliaryChannel"}) {
    const std::string idl = schema_text("tonus::v1::" + name);
    const auto begin = idl.find("@final struct " + name + " {");
    ASSERT_NE(begin, std::string::npos) << name;
    std::istringstream lines(idl.substr(begin, idl.find("\n};", begin) - begin));
    const std::regex field(R"(^ +(?:@key )?[\w<>, ]+ (\w+)(?:\[\d+\])?;.*$)");
    std::set<std::string> fields;
    std::smatch match;
    for (std::string line; std::getline(lines, line);)
      if (std::regex_match(line, match, field)) fields.insert(match[1]);
    EXPECT_EQ(keys_of(schema(name)["properties"]), fields) << name;
  }
}

/// Names of 0, 1, ... up to the first that is not known.
template <typename Enum>
json names_of(const char* (*name)(Enum)) {
  json names = json::array();
  for (std::uint32_t i = 0; !std::string(name(static_cast<Enum>(i))).starts_with("unknown"); ++i) {
    if (i > 1 && names.back() == name(static_cast<Enum>(i))) break;
    names.push_back(name(static_cast<Enum>(i)));
  }
  return names;
}

TEST(OpenApi, EnumerationsAreThoseOfTheContract) {
  const auto of = [](const std::string& type, const std::string& field) {
    return schema(type)["properties"][field];
  };
  EXPECT_EQ(of("SessionState", "phase")["enum"], names_of(v1::phase_name));
  EXPECT_EQ(of("RigState", "mode")["enum"], names_of(v1::mode_name));
  EXPECT_EQ(of("TrialOutcome", "end")["enum"], names_of(v1::end_name));
  EXPECT_EQ(of("Estimate", "status")["enum"], names_of(v1::status_name));
  EXPECT_EQ(of("Estimate", "checks")["items"]["properties"]["test"]["enum"], names_of(v1::test_name));
  // "unknown rig" is a reason of its own.
  json reasons = json::array();
  for (std::uint32_t i = 0; std::string(v1::reason_name(v1::VerdictReason(i))) != "unknown reason"; ++i)
    reasons.push_back(v1::reason_name(v1::VerdictReason(i)));
  EXPECT_EQ(of("TrialVerdict", "reasons")["items"]["enum"], reasons);
  EXPECT_EQ(schema("Message")["properties"]["topic"]["enum"],
            json(std::vector<std::string>(json_topics().begin(), json_topics().end())));
}

TEST(OpenApi, EveryPathThatIsDescribedIsAnswered) {
  ServerOptions options;
  options.folders.store = std::string(TONUS_SOURCE) + "/tests/acceptance/recorded_session/session.sqlite";
  Gateway gateway(Access({}, {}), options);
  for (const auto& [path, item] : document()["paths"].items()) {
    if (path == "/json" || !item.contains("get")) continue;  // see JsonSocket, Server
    std::string asked = std::regex_replace(path, std::regex(R"(\{id\})"), "last");
    asked = std::regex_replace(asked, std::regex(R"(\{attempt\})"), "1");
    const auto [status, body] = get(gateway.port(), {.target = asked});
    EXPECT_EQ(body.find("there is no such page"), std::string::npos) << path;
    EXPECT_TRUE(item["get"]["responses"].contains(std::to_string(status))) << path << ": " << status << body;
  }
}

TEST(OpenApi, EveryPathInTheCodeIsDescribed) {
  const std::filesystem::path sources = std::filesystem::path(TONUS_SOURCE) / "services/dashboard/gateway";
  const std::regex literal(R"re("(/(?:api/[a-z.]+|json))")re");
  std::set<std::string> found;
  for (const auto& file : std::filesystem::directory_iterator(sources)) {
    std::ifstream stream(file.path());
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    for (auto i = std::sregex_iterator(text.begin(), text.end(), literal); i != std::sregex_iterator(); ++i)
      found.insert((*i)[1]);
  }
  EXPECT_GT(found.size(), 10U);
  for (const std::string& path : found) EXPECT_TRUE(document()["paths"].contains(path)) << path;
}

TEST(OpenApi, IsServed) {
  Gateway gateway;
  EXPECT_EQ(get(gateway.port(), {.target = "/api/openapi.json"}).second, kOpenApi);
}

}  // namespace
}  // namespace tonus::dashboard::testing
