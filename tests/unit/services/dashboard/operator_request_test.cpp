#include "services/dashboard/gateway/operator_request.hpp"

#include <cmath>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace tonus::dashboard {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

const std::string kRequestId = "000102030405060708090a0b0c0d0e0f";
const std::string kSessionId = "f0f1f2f3f4f5f6f7f8f9fafbfcfdfeff";

struct Parsed {
  Id id{};
  std::string name;
  Result<OperatorRequest> request = fail(ErrorCode::kInternal, "");
};

Parsed parse(const json& object, Role role = Role::kOperate) {
  Parsed parsed;
  parsed.request =
      parse_request(object.dump(), {role, "dashboard test", id_of("rig/rig")}, parsed.id, parsed.name);
  return parsed;
}

TEST(OperatorRequest, StartBecomesASessionCommandWithEveryField) {
  const auto parsed = parse({{"request_id", kRequestId},
                             {"request", "start"},
                             {"session_id", kSessionId},
                             {"protocol_toml", "schema = 1"},
                             {"subject", "sub-02"},
                             {"seed", 7}});
  ASSERT_TRUE(parsed.request) << parsed.request.error().message;
  const auto& command = std::get<v1::SessionCommand>(parsed.request->command);
  EXPECT_EQ(command.request(), v1::SESSION_START);
  EXPECT_EQ(to_hex(command.request_id()), kRequestId);
  EXPECT_EQ(to_hex(command.session_id()), kSessionId);
  EXPECT_EQ(command.protocol_toml(), "schema = 1");
  EXPECT_EQ(command.subject(), "sub-02");
  EXPECT_EQ(command.seed(), 7U);
  EXPECT_EQ(command.requested_by(), "dashboard test");
}

TEST(OperatorRequest, StartCarriesTheSubjectsFactsStudyAndPilotMode) {
  const auto parsed = parse({{"request_id", kRequestId},
                             {"request", "start"},
                             {"study", "cohort"},
                             {"is_pilot", true},
                             {"subject_facts",
                              {{"age_years", 31.5},
                               {"sex", "female"},
                               {"measured_arm", "right"},
                               {"height_m", nullptr},
                               {"link_lengths_m", {0.31, nullptr}}}}});
  ASSERT_TRUE(parsed.request) << parsed.request.error().message;
  const auto& command = std::get<v1::SessionCommand>(parsed.request->command);
  EXPECT_EQ(command.study(), "cohort");
  EXPECT_TRUE(command.is_pilot());
  const auto& facts = command.subject_facts();
  EXPECT_EQ(facts.age_years(), 31.5);
  EXPECT_EQ(facts.sex(), "female");
  EXPECT_EQ(facts.measured_arm(), "right");
  EXPECT_EQ(facts.handedness(), "");
  EXPECT_EQ(facts.link_lengths_m()[0], 0.31);
  for (const double unknown : {facts.height_m(), facts.weight_kg(), facts.link_lengths_m()[1],
                               facts.circumferences_m()[0], facts.shoulder_m()[1]})
    EXPECT_TRUE(std::isnan(unknown)) << "what is not stated is not known";
}

TEST(OperatorRequest, ARejectionNamesItsTrialAndItsReason) {
  const json rejection{
      {"request_id", kRequestId}, {"request", "reject_trial"}, {"trial_id", kSessionId}, {"text", "coughed"}};
  const auto parsed = parse(rejection);
  ASSERT_TRUE(parsed.request) << parsed.request.error().message;
  const auto& command = std::get<v1::SessionCommand>(parsed.request->command);
  EXPECT_EQ(command.request(), v1::SESSION_REJECT_TRIAL);
  EXPECT_EQ(to_hex(command.trial_id()), kSessionId);
  EXPECT_EQ(command.text(), "coughed");
  for (const char* needed : {"trial_id", "text"}) {
    json without = rejection;
    without.erase(needed);
    const auto refused = parse(without);
    ASSERT_FALSE(refused.request) << needed;
    EXPECT_THAT(refused.request.error().message, HasSubstr(needed));
  }
}

TEST(OperatorRequest, ANoteMayBeOfATrialOrOfNoneAndIsANoteOrAMarker) {
  json note{{"request_id", kRequestId}, {"request", "note"}, {"text", "subject yawns"}};
  auto parsed = parse(note);
  ASSERT_TRUE(parsed.request) << parsed.request.error().message;
  auto command = std::get<v1::SessionCommand>(parsed.request->command);
  EXPECT_EQ(command.request(), v1::SESSION_NOTE);
  EXPECT_EQ(Id(command.trial_id()), kNoId);
  EXPECT_EQ(command.text(), "subject yawns");
  EXPECT_EQ(command.note_kind(), "note");
  note["note_kind"] = "marker";
  note["trial_id"] = kSessionId;
  parsed = parse(note);
  ASSERT_TRUE(parsed.request) << parsed.request.error().message;
  command = std::get<v1::SessionCommand>(parsed.request->command);
  EXPECT_EQ(command.note_kind(), "marker");
  EXPECT_EQ(to_hex(command.trial_id()), kSessionId);
}

TEST(OperatorRequest, WhatIsWrongWithAStartARejectionOrANoteIsNamed) {
  const auto message = [](json object) {
    object["request_id"] = kRequestId;
    const auto parsed = parse(object);
    return parsed.request ? std::string("accepted") : parsed.request.error().message;
  };
  const auto facts = [&](const json& value) {
    return message({{"request", "start"}, {"subject_facts", value}});
  };
  EXPECT_THAT(facts(7), HasSubstr("subject_facts"));
  EXPECT_THAT(facts({{"age_years", "old"}}), HasSubstr("age_years"));
  EXPECT_THAT(facts({{"sex", 1}}), HasSubstr("sex"));
  EXPECT_THAT(facts({{"shoulder_m", {1}}}), HasSubstr("shoulder_m"));
  EXPECT_THAT(facts({{"name", "Anna"}}), HasSubstr("name"));
  EXPECT_THAT(message({{"request", "start"}, {"is_pilot", "yes"}}), HasSubstr("is_pilot"));
  EXPECT_THAT(message({{"request", "start"}, {"study", 1}}), HasSubstr("study"));
  EXPECT_THAT(message({{"request", "note"}, {"text", " "}}), HasSubstr("text"));
  EXPECT_THAT(message({{"request", "note"}, {"text", "a\nb"}}), HasSubstr("one line"));
  EXPECT_THAT(message({{"request", "note"}, {"text", std::string(1001, 'x')}}), HasSubstr("1001 bytes"));
  EXPECT_THAT(message({{"request", "note"}, {"text", "x"}, {"note_kind", "essay"}}), HasSubstr("essay"));
}

TEST(OperatorRequest, WhoAskedOnWhichPageIsRecordedAndAStopsTimeToo) {
  const Asker asker{Role::kOperate, "dashboard test", id_of("rig/rig"), 1'772'450'372'000'000'000U};
  Id id{};
  std::string name;
  json asked{{"request_id", kRequestId}, {"request", "pause"}, {"by", "Anna Ö."}, {"page", "results"}};
  auto request = parse_request(asked.dump(), asker, id, name);
  ASSERT_TRUE(request) << request.error().message;
  EXPECT_EQ(std::get<v1::SessionCommand>(request->command).requested_by(),
            "Anna Ö., dashboard test on results");
  asked["request"] = "emergency_stop";
  request = parse_request(asked.dump(), asker, id, name);
  ASSERT_TRUE(request) << request.error().message;
  EXPECT_EQ(std::get<v1::RigCommand>(request->command).requested_by(),
            "Anna Ö., dashboard test on results at 11:19:32 UTC");
}

TEST(OperatorRequest, ANameThatCouldForgeTheRecordIsRefusedButStopsNoStop) {
  for (const json& wrong : {json("Anna; fault: none"), json("Anna, dashboard other"), json("a\nb"), json(7),
                            json(std::string(200, 'a'))}) {
    EXPECT_FALSE(parse({{"request_id", kRequestId}, {"request", "pause"}, {"by", wrong}}).request) << wrong;
    const auto stop = parse({{"request_id", kRequestId}, {"request", "emergency_stop"}, {"by", wrong}});
    ASSERT_TRUE(stop.request) << wrong;
    EXPECT_EQ(stop.request->requested_by, "dashboard test");
  }
  EXPECT_FALSE(parse({{"request_id", kRequestId}, {"request", "pause"}, {"page", "results; x"}}).request);
}

TEST(OperatorRequest, EmergencyStopBecomesACommandToTheGatewaysRig) {
  const auto parsed = parse({{"request_id", kRequestId}, {"request", "emergency_stop"}});
  ASSERT_TRUE(parsed.request);
  const auto& command = std::get<v1::RigCommand>(parsed.request->command);
  EXPECT_EQ(command.request(), v1::RIG_EMERGENCY_STOP);
  EXPECT_EQ(Id(command.rig_id()), id_of("rig/rig"));
}

TEST(OperatorRequest, AViewerMayStopTheRigAndNothingElse) {
  EXPECT_TRUE(parse({{"request_id", kRequestId}, {"request", "emergency_stop"}}, Role::kView).request);
  for (const char* name :
       {"start", "pause", "resume", "abort", "reject_trial", "note", "clear_fault", "abort_trial"}) {
    const auto parsed = parse({{"request_id", kRequestId}, {"request", name}}, Role::kView);
    ASSERT_FALSE(parsed.request) << name;
    EXPECT_THAT(parsed.request.error().message, HasSubstr("view"));
    EXPECT_EQ(to_hex(parsed.id), kRequestId) << "the refusal can be answered";
  }
}

TEST(OperatorRequest, MalformedOnesAreRefusedWithTheFieldsName) {
  const auto message = [](const json& object) {
    const auto parsed = parse(object);
    return parsed.request ? std::string("accepted") : parsed.request.error().message;
  };
  EXPECT_THAT(message({{"request", "pause"}}), HasSubstr("request_id"));
  EXPECT_THAT(message({{"request_id", std::string(32, '0')}, {"request", "pause"}}), HasSubstr("request_id"));
  EXPECT_THAT(message({{"request_id", "12"}, {"request", "pause"}}), HasSubstr("request_id"));
  EXPECT_THAT(message({{"request_id", 12}, {"request", "pause"}}), HasSubstr("request_id"));
  EXPECT_THAT(message({{"request_id", kRequestId}, {"request", "explode"}}), HasSubstr("explode"));
  EXPECT_THAT(message({{"request_id", kRequestId}, {"request", "start"}, {"seed", -1}}), HasSubstr("seed"));
  EXPECT_THAT(message({{"request_id", kRequestId}, {"request", "start"}, {"subject", std::string(129, 'x')}}),
              HasSubstr("subject"));
  EXPECT_THAT(
      message({{"request_id", kRequestId}, {"request", "start"}, {"protocol_toml", std::string(50001, 'x')}}),
      HasSubstr("protocol_toml"));
  EXPECT_THAT(
      message({{"request_id", kRequestId}, {"request", "start"}, {"subject", std::string("a\0b", 3)}}),
      HasSubstr("subject"));
  EXPECT_THAT(message(json::array()), HasSubstr("object"));
}

TEST(OperatorRequest, ReplyIsJsonWithTheRequestsId) {
  const auto reply =
      json::parse(reply_text({*id_from_hex(kRequestId), "pause", true, "paused", "dashboard x"}));
  EXPECT_EQ(reply["request_id"], kRequestId);
  EXPECT_EQ(reply["is_done"], true);
  EXPECT_EQ(reply["message"], "paused");
}

}  // namespace
}  // namespace tonus::dashboard
