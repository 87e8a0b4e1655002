#include "services/dashboard/gateway/operator_desk.hpp"

#include <gmock/gmock.h>

namespace tonus::dashboard {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

OperatorRequest session_request(const std::string& id, v1::SessionRequest kind) {
  v1::SessionCommand command;
  command.request_id(id_of(id));
  command.request(kind);
  return {id_of(id), "session request", "tester", command};
}

OperatorRequest stop_request(const std::string& id) {
  v1::RigCommand command;
  command.request_id(id_of(id));
  command.request(v1::RIG_EMERGENCY_STOP);
  return {id_of(id), "emergency_stop", "tester", command};
}

class OperatorDeskTest : public ::testing::Test {
 protected:
  ManualClock clock_;
  OperatorDesk desk_{{}, clock_};
};

TEST_F(OperatorDeskTest, SendsARequestAtOnceAndAgainUntilItsReplyComes) {
  EXPECT_THAT(desk_.ask(session_request("a", v1::SESSION_START)).commands, SizeIs(1));
  EXPECT_THAT(desk_.tick().commands, IsEmpty());
  clock_.advance(milliseconds(500));
  EXPECT_THAT(desk_.tick().commands, SizeIs(1));
  const auto effects = desk_.on_reply(id_of("a"), true, "begun");
  ASSERT_THAT(effects.replies, SizeIs(1));
  EXPECT_TRUE(effects.replies[0].is_done);
  EXPECT_EQ(effects.replies[0].message, "begun");
  clock_.advance(milliseconds(5000));
  EXPECT_THAT(desk_.tick().commands, IsEmpty());
  EXPECT_EQ(desk_.waiting(), 0U);
}

TEST_F(OperatorDeskTest, ARequestThatComesAgainIsSentOnceAndAnsweredAgain) {
  (void)desk_.ask(session_request("a", v1::SESSION_START));
  EXPECT_THAT(desk_.ask(session_request("a", v1::SESSION_START)).commands, IsEmpty());
  (void)desk_.on_reply(id_of("a"), false, "no");
  const auto again = desk_.ask(session_request("a", v1::SESSION_START));
  EXPECT_THAT(again.commands, IsEmpty());
  ASSERT_THAT(again.replies, SizeIs(1));
  EXPECT_EQ(again.replies[0].message, "no");
}

TEST_F(OperatorDeskTest, RepliesToOthersRequestsAreNotItsBusiness) {
  EXPECT_THAT(desk_.on_reply(id_of("other"), true, "done").replies, IsEmpty());
}

TEST_F(OperatorDeskTest, GivesUpWhenNobodyAnswersAndSaysWho) {
  (void)desk_.ask(session_request("a", v1::SESSION_START));
  clock_.advance(milliseconds(15000));
  const auto effects = desk_.tick();
  ASSERT_THAT(effects.replies, SizeIs(1));
  EXPECT_FALSE(effects.replies[0].is_done);
  EXPECT_THAT(effects.replies[0].message, HasSubstr("scheduler"));
}

TEST_F(OperatorDeskTest, WaitsLongerForAPauseAsTheTrialIsFinishedFirst) {
  (void)desk_.ask(session_request("a", v1::SESSION_PAUSE));
  clock_.advance(milliseconds(60000));
  EXPECT_THAT(desk_.tick().replies, IsEmpty());
}

TEST_F(OperatorDeskTest, AnEmergencyStopGoesFirstAndIsRepeatedSooner) {
  (void)desk_.ask(session_request("a", v1::SESSION_PAUSE));
  EXPECT_THAT(desk_.ask(stop_request("s")).commands, SizeIs(1));
  clock_.advance(milliseconds(100));
  EXPECT_THAT(desk_.tick().commands, SizeIs(1));
  clock_.advance(milliseconds(400));
  const auto both = desk_.tick().commands;
  ASSERT_THAT(both, SizeIs(2));
  EXPECT_TRUE(std::holds_alternative<v1::RigCommand>(both[0]));
}

TEST_F(OperatorDeskTest, IsBoundedButAlwaysTakesAnEmergencyStop) {
  for (int i = 0; i < 256; ++i) (void)desk_.ask(session_request(std::to_string(i), v1::SESSION_PAUSE));
  const auto refused = desk_.ask(session_request("one more", v1::SESSION_PAUSE));
  EXPECT_THAT(refused.commands, IsEmpty());
  ASSERT_THAT(refused.replies, SizeIs(1));
  EXPECT_FALSE(refused.replies[0].is_done);
  EXPECT_THAT(desk_.ask(stop_request("s")).commands, SizeIs(1));
}

TEST_F(OperatorDeskTest, SaysWhenItHasSomethingToDoNext) {
  (void)desk_.ask(session_request("a", v1::SESSION_START));
  EXPECT_EQ(desk_.due(), clock_.now() + milliseconds(500));
}

}  // namespace
}  // namespace tonus::dashboard
