#include "services/store/session_list.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "idl/bounds.hpp"
#include "idl/topics.hpp"
#include "services/bus/typed.hpp"
#include "services/contract/subject.hpp"
#include "services/core/crc32c.hpp"
#include "services/store/memory_store.hpp"
#include "services/store/wire.hpp"

namespace tonus::store {
namespace {

class SessionList : public ::testing::Test {
 protected:
  template <typename T>
  void put(const topics::Topic<T>& topic, const Id& session, const T& value) {
    Message message{std::string(topic.spec.name), session, session, ++time_, 0, nullptr};
    message.payload = std::make_shared<const bus::Payload>(*bus::encode(value));
    message.checksum = crc32c(*message.payload);
    Batch batch;
    batch.messages = {message};
    ASSERT_TRUE(store_.commit(batch));
  }

  v1::SessionPlan plan(const std::string& subject, const std::string& protocol) {
    v1::SessionPlan plan;
    plan.session_id(id_of("session " + std::to_string(++sessions_)));
    plan.subject(subject);
    plan.subject_facts(contract::unknown_subject());
    plan.protocol_name(protocol);
    plan.planned_trials(40);
    plan.started_at("2026-01-0" + std::to_string(sessions_) + "T10:00:00Z");
    return plan;
  }

  void put_session(const v1::SessionPlan& plan, v1::SessionPhase phase, std::uint32_t counted = 40) {
    Batch batch;
    batch.sessions = {to_record(plan)};
    ASSERT_TRUE(store_.commit(batch));
    put(topics::kSessionPlan, plan.session_id(), plan);
    v1::SessionState state;
    state.session_id(plan.session_id());
    state.phase(phase);
    state.counted(counted);
    state.planned(plan.planned_trials());
    put(topics::kSessionState, plan.session_id(), state);
  }

  MemoryStore store_;
  std::uint64_t time_ = 100;
  int sessions_ = 0;
};

TEST_F(SessionList, HasOfEachSubjectTheNewestOfEachFact) {
  auto first = plan("s02", "unloaded");
  first.subject_facts().age_years(30.0);
  first.subject_facts().height_m(1.7);
  put_session(first, v1::SESSION_COMPLETED);
  auto second = plan("s02", "loaded");
  second.subject_facts().age_years(31.0);
  put_session(second, v1::SESSION_ABORTED, 3);
  put_session(plan("s01", "unloaded"), v1::SESSION_COMPLETED);

  const auto subjects = *list_subjects(store_);
  ASSERT_EQ(subjects.size(), 2U);
  EXPECT_EQ(subjects[0].subject, "s01");
  EXPECT_FALSE(contract::is_anything_known(subjects[0].facts));
  EXPECT_EQ(subjects[1].subject, "s02");
  EXPECT_EQ(subjects[1].sessions, 2U);
  EXPECT_EQ(subjects[1].facts.age_years(), 31.0);
  EXPECT_EQ(subjects[1].facts.height_m(), 1.7);
  EXPECT_EQ(subjects[1].last.session, second.session_id());
}

TEST_F(SessionList, CountsPilotsApart) {
  put_session(plan("s01", "unloaded"), v1::SESSION_COMPLETED);
  auto pilot = plan("s01", "unloaded");
  pilot.is_pilot(true);
  put_session(pilot, v1::SESSION_COMPLETED);
  const auto subjects = *list_subjects(store_);
  ASSERT_EQ(subjects.size(), 1U);
  EXPECT_EQ(subjects[0].sessions, 2U);
  EXPECT_EQ(subjects[0].pilot_sessions, 1U);
}

TEST_F(SessionList, TellsWhatEachSubjectOfAStudyHasDone) {
  const auto put_of_study = [&](const std::string& subject, const std::string& protocol,
                                v1::SessionPhase phase, bool is_pilot) {
    auto made = plan(subject, protocol);
    made.study("posture 2026");
    made.is_pilot(is_pilot);
    put_session(made, phase, phase == v1::SESSION_COMPLETED ? 40 : 12);
  };
  put_of_study("s01", "unloaded", v1::SESSION_COMPLETED, true);  // a rehearsal
  put_of_study("s01", "unloaded", v1::SESSION_ABORTED, false);
  put_of_study("s02", "unloaded", v1::SESSION_COMPLETED, false);
  put_session(plan("s03", "unloaded"), v1::SESSION_COMPLETED);  // of no study

  const auto progress = *study_progress(store_, "posture 2026");
  ASSERT_EQ(progress.size(), 2U);
  EXPECT_EQ(progress[0].subject, "s01");
  ASSERT_EQ(progress[0].sessions.size(), 2U);
  EXPECT_EQ(progress[0].done(), 0U);
  EXPECT_FALSE(progress[0].has_done("unloaded"));
  EXPECT_EQ(progress[0].sessions[1].phase, v1::SESSION_ABORTED);
  EXPECT_EQ(progress[0].sessions[1].counted, 12U);
  EXPECT_EQ(progress[1].done(), 1U);
  EXPECT_TRUE(progress[1].has_done("unloaded"));
  EXPECT_FALSE(progress[1].has_done("loaded"));
  EXPECT_EQ(studies_of(*summarise_sessions(store_)), std::vector<std::string>{"posture 2026"});
  EXPECT_TRUE(study_progress(store_, "")->empty());
}

TEST_F(SessionList, KeepsASessionWhosePlanIsDamaged) {
  const auto made = plan("s01", "unloaded");
  put_session(made, v1::SESSION_RUNNING, 2);
  Message damaged{
      std::string(topics::kSessionPlan.spec.name),           made.session_id(), made.session_id(), ++time_, 1,
      std::make_shared<const bus::Payload>(bus::Payload(40))};
  Batch batch;
  batch.messages = {damaged};
  ASSERT_TRUE(store_.commit(batch));
  const auto sessions = *summarise_sessions(store_);
  ASSERT_EQ(sessions.size(), 1U);
  EXPECT_EQ(sessions[0].plan.subject(), "s01");
  EXPECT_FALSE(sessions[0].is_completed());
}

}  // namespace
}  // namespace tonus::store
