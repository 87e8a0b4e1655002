#include "services/store/session_reader.hpp"

#include <gtest/gtest.h>

#include "idl/bounds.hpp"
#include "idl/topics.hpp"
#include "services/bus/typed.hpp"
#include "services/store/archived_trial.hpp"
#include "services/store/memory_store.hpp"
#include "tests/unit/services/store/made_up.hpp"

namespace tonus::store {
namespace {

using testing::kRig;
using testing::kStream;

const Id kFirst = id_of("first session");
const Id kSecond = id_of("second session");

class SessionReader : public ::testing::Test {
 protected:
  SessionReader() {
    put_session(kFirst, "2026-01-01T10:00:00Z");
    put_session(kSecond, "2026-01-02T10:00:00Z");
  }

  void put_session(const Id& session, const std::string& started_at) {
    SessionRecord record = testing::session_of(session, started_at);
    Batch batch;
    batch.sessions = {record};
    ASSERT_TRUE(store_.commit(batch));
  }

  /// A message that came while `during` was the archive's session.
  template <typename T>
  void put(const topics::Topic<T>& topic, const Id& key, const T& value, const Id& during) {
    Message message{std::string(topic.spec.name), key, during, ++time_, 0, nullptr};
    message.payload = std::make_shared<const bus::Payload>(*bus::encode(value));
    message.checksum = crc32c(*message.payload);
    Batch batch;
    batch.messages = {message};
    ASSERT_TRUE(store_.commit(batch));
  }

  void put_plan(const Id& session) {
    v1::SessionPlan plan;
    plan.session_id(session);
    plan.rig_id(kRig);
    plan.protocol_toml("schema = 1\n");
    put(topics::kSessionPlan, session, plan, session);
  }

  void put_description(const std::string& name, const Id& during) {
    v1::RigDescription description;
    description.rig_id(kRig);
    description.name(name);
    put(topics::kRigDescription, kRig, description, during);
  }

  void put_outcome(const Id& session, std::uint32_t attempt, const Id& during) {
    v1::TrialOutcome outcome;
    outcome.trial_id(trial_id(session, attempt));
    outcome.program().session_id(session);
    outcome.program().rig_id(kRig);
    outcome.program().attempt(attempt);
    put(topics::kTrialOutcome, outcome.trial_id(), outcome, during);
  }

  void put_verdict(const Id& session, std::uint32_t attempt, bool is_valid) {
    v1::TrialVerdict verdict;
    verdict.trial_id(trial_id(session, attempt));
    verdict.session_id(session);
    verdict.attempt(attempt);
    verdict.is_valid(is_valid);
    put(topics::kTrialVerdict, verdict.trial_id(), verdict, session);
  }

  void put_estimate(const Id& session, const std::string& posture, std::uint32_t index, double stiffness) {
    v1::Estimate estimate;
    estimate.estimate_id(id_of(to_hex(session) + posture));
    estimate.session_id(session);
    estimate.posture(posture);
    estimate.posture_index(index);
    estimate.stiffness_N_per_m().value({stiffness, 0.0, 0.0, stiffness});
    put(topics::kEstimateCondition, estimate.estimate_id(), estimate, session);
  }

  void put_record(const Id& session, std::uint32_t attempt, const Certificate& certificate) {
    TrialRecord record = testing::trial_of(attempt, 0, certificate.expected - 1);
    record.trial = trial_id(session, attempt);
    record.session = session;
    record.certificate = certificate;
    record.is_certified = certificate.missing == 0;
    Batch batch;
    batch.trials = {record};
    ASSERT_TRUE(store_.commit(batch));
  }

  MemoryStore store_;
  std::uint64_t time_ = 100;
};

TEST_F(SessionReader, CombinesAVerdictWithWhatAnOperatorSaidAfterIt) {
  put_plan(kFirst);
  put_outcome(kFirst, 1, kFirst);
  put_verdict(kFirst, 1, true);
  put_outcome(kFirst, 2, kFirst);
  put_verdict(kFirst, 2, true);
  v1::TrialReview review;
  review.trial_id(trial_id(kFirst, 2));
  review.session_id(kFirst);
  review.attempt(2);
  review.is_rejected(true);
  review.reason("coughed");
  review.reviewed_by("Ada");
  put(topics::kTrialReview, review.trial_id(), review, kSecond);  // archived when the next session had begun
  const auto session = *read_session(store_, kFirst);
  ASSERT_EQ(session.trials.size(), 2U);
  EXPECT_TRUE(standing_verdict(session.trials[0])->is_valid());
  EXPECT_FALSE(standing_verdict(session.trials[1])->is_valid());
  EXPECT_TRUE(session.trials[1].verdict->value.is_valid());  // as it was published
  EXPECT_EQ(why_not_counted(session.trials[0]), "");
  EXPECT_EQ(why_not_counted(session.trials[1]), "rejected by hand by Ada: coughed");
}

TEST_F(SessionReader, GivesEachNoteOnceInTheOrderOfWriting) {
  put_plan(kFirst);
  put_outcome(kFirst, 1, kFirst);
  const auto put_note = [&](const std::string& text, std::uint64_t written, std::uint32_t attempt) {
    v1::SessionNote note;
    note.note_id(id_of(text));
    note.session_id(kFirst);
    if (attempt > 0) note.trial_id(trial_id(kFirst, attempt));
    note.text(text);
    note.written_ns(written);
    put(topics::kSessionNote, note.note_id(), note, kFirst);
  };
  put_note("second", 20, 1);
  put_note("first", 10, 0);
  put_note("second", 20, 1);  // published anew by a restarted scheduler
  const auto session = *read_session(store_, kFirst);
  ASSERT_EQ(session.notes.size(), 2U);
  EXPECT_EQ(session.notes[0].value.text(), "first");
  EXPECT_EQ(session.notes[1].value.text(), "second");
  EXPECT_EQ(attempt_of(session, session.notes[0].value), 0U);
  EXPECT_EQ(attempt_of(session, session.notes[1].value), 1U);
}

TEST_F(SessionReader, FindsASessionByItsIdAndByTheBeginningOfIt) {
  const std::string hex = to_hex(kFirst);
  EXPECT_EQ(find_session(store_, hex)->session, kFirst);
  EXPECT_EQ(find_session(store_, hex.substr(0, 6))->session, kFirst);
  std::string spaced = hex.substr(0, 8) + "-" + hex.substr(8, 4);
  std::transform(spaced.begin(), spaced.end(), spaced.begin(),
                 [](unsigned char c) { return std::toupper(c); });
  EXPECT_EQ(find_session(store_, spaced)->session, kFirst);
}

TEST_F(SessionReader, TakesTheNewestSessionWhereNoneIsNamed) {
  EXPECT_EQ(find_session(store_, "")->session, kSecond);
  EXPECT_EQ(find_session(store_, "last")->session, kSecond);
}

TEST_F(SessionReader, ListsTheSessionsWhereTheNameFitsNone) {
  const auto found = find_session(store_, "zz");
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, ErrorCode::kNotFound);
  for (const std::string& part : {std::string("'zz'"), to_hex(kFirst), to_hex(kSecond)})
    EXPECT_NE(found.error().message.find(part), std::string::npos) << found.error().message;
  EXPECT_EQ(found.error().message.find('\n'), std::string::npos);
}

TEST_F(SessionReader, RefusesABeginningThatSeveralSessionsHave) {
  Id twin = kFirst;
  twin.back() ^= 1U;
  put_session(twin, "2026-01-03T10:00:00Z");
  const auto found = find_session(store_, to_hex(kFirst).substr(0, 10));
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, ErrorCode::kInvalidArgument);
  EXPECT_NE(found.error().message.find(to_hex(twin)), std::string::npos);
  EXPECT_EQ(found.error().message.find(to_hex(kSecond)), std::string::npos);
}

TEST_F(SessionReader, SaysThatAnEmptyStoreHasNoSession) {
  MemoryStore empty;
  const auto found = find_session(empty, "");
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, ErrorCode::kNotFound);
  EXPECT_NE(found.error().message.find("0 sessions"), std::string::npos) << found.error().message;
}

TEST_F(SessionReader, ReadsTrialsOfItsOwnSessionOnlyByAttempt) {
  put_plan(kFirst);
  put_outcome(kFirst, 2, kFirst);
  put_outcome(kFirst, 1, kFirst);
  put_verdict(kFirst, 1, false);
  put_verdict(kFirst, 1, true);  // judged anew after a restart
  put_record(kFirst, 1, {100, 100, 7, 3, 0});
  put_plan(kSecond);
  put_outcome(kSecond, 1, kSecond);
  put_outcome(kFirst, 3, kSecond);  // late
  const auto session = read_session(store_, kFirst);
  ASSERT_TRUE(session) << session.error().message;
  EXPECT_EQ(session->plan.protocol_toml(), "schema = 1\n");
  ASSERT_EQ(session->trials.size(), 3U);
  for (std::uint32_t i = 0; i < 3; ++i) {
    EXPECT_EQ(session->trials[i].attempt, i + 1);
    EXPECT_EQ(session->trials[i].trial, trial_id(kFirst, i + 1));
    EXPECT_TRUE(session->trials[i].outcome);
  }
  ASSERT_TRUE(session->trials[0].verdict);
  EXPECT_TRUE(session->trials[0].verdict->value.is_valid());
  EXPECT_FALSE(session->trials[1].verdict);
  ASSERT_TRUE(session->trials[0].record);
  EXPECT_EQ(session->trials[0].record->certificate.resent, 7U);
}

TEST_F(SessionReader, TakesTheDescriptionInForceAtTheBeginAndTheChangesSince) {
  put_description("long ago", kNoId);
  put_description("before the first", kNoId);
  put_plan(kFirst);
  put_description("changed in the first", kFirst);
  put_plan(kSecond);
  put_description("of the second", kSecond);
  const auto names = [&](const Id& id) {
    std::vector<std::string> all;
    const auto session = read_session(store_, id);
    EXPECT_TRUE(session);
    for (const auto& description : session->descriptions) all.push_back(description.value.name());
    return all;
  };
  EXPECT_EQ(names(kFirst), (std::vector<std::string>{"before the first", "changed in the first"}));
  EXPECT_EQ(names(kSecond), (std::vector<std::string>{"changed in the first", "of the second"}));
}

TEST_F(SessionReader, KeepsEveryEstimateAndGivesTheNewestByPosture) {
  put_plan(kFirst);
  put_estimate(kFirst, "right", 1, 100.0);
  put_estimate(kFirst, "left", 0, 200.0);
  put_estimate(kFirst, "right", 1, 101.0);
  put_estimate(kSecond, "right", 1, 900.0);
  const auto session = read_session(store_, kFirst);
  ASSERT_TRUE(session) << session.error().message;
  EXPECT_EQ(session->estimates.size(), 3U);
  const auto newest = newest_estimates(*session);
  ASSERT_EQ(newest.size(), 2U);
  EXPECT_EQ(newest[0].posture(), "left");
  EXPECT_EQ(newest[1].stiffness_N_per_m().value()[0], 101.0);
}

TEST_F(SessionReader, SumsTheCertificatesAndIsWholeOnlyWithAllOfThem) {
  put_plan(kFirst);
  for (std::uint32_t attempt = 1; attempt <= 2; ++attempt) put_outcome(kFirst, attempt, kFirst);
  put_record(kFirst, 1, {100, 100, 7, 3, 0});
  EXPECT_FALSE(read_session(store_, kFirst)->is_whole());
  put_record(kFirst, 2, {50, 40, 1, 0, 10});
  const auto session = read_session(store_, kFirst);
  EXPECT_EQ(session->certificate(), (Certificate{150, 140, 8, 3, 10}));
  EXPECT_FALSE(session->is_whole());
  put_record(kFirst, 2, {50, 50, 11, 0, 0});
  EXPECT_TRUE(read_session(store_, kFirst)->is_whole());
}

TEST_F(SessionReader, TakesResultsThatArrivedAfterTheNextSessionHadBegun) {
  put_plan(kFirst);
  put_outcome(kFirst, 1, kFirst);
  put_plan(kSecond);
  v1::TrialVerdict verdict;
  verdict.trial_id(trial_id(kFirst, 1));
  verdict.session_id(kFirst);
  verdict.attempt(1);
  put(topics::kTrialVerdict, verdict.trial_id(), verdict, kSecond);
  v1::Estimate estimate;
  estimate.estimate_id(id_of("late"));
  estimate.session_id(kFirst);
  put(topics::kEstimateCondition, estimate.estimate_id(), estimate, kSecond);
  put_estimate(kSecond, "right", 1, 900.0);
  v1::SessionState state;
  state.session_id(kFirst);
  state.phase(v1::SESSION_COMPLETED);
  put(topics::kSessionState, kFirst, state, kSecond);
  const auto session = read_session(store_, kFirst);
  ASSERT_TRUE(session) << session.error().message;
  ASSERT_EQ(session->trials.size(), 1U);
  EXPECT_TRUE(session->trials[0].verdict);
  ASSERT_EQ(session->estimates.size(), 1U);
  EXPECT_EQ(session->estimates[0].value.estimate_id(), id_of("late"));
  ASSERT_TRUE(session->state);
  EXPECT_EQ(session->state->phase(), v1::SESSION_COMPLETED);
}

// A store refuses to give out a damaged message, so one that is read without an error has not been visited.
TEST_F(SessionReader, DoesNotReadTheMessagesOfOtherSessions) {
  const Id third = id_of("third session");
  put_session(third, "2026-01-03T10:00:00Z");
  put_session(id_of("began next"), "2026-01-02T12:00:00Z");  // its results may be late ones of the second
  const auto put_damaged = [&](const bus::TopicSpec& topic, const Id& key, const Id& during) {
    Message message = testing::message_of(std::string(topic.name), key, "damaged");
    message.session = during;
    message.checksum ^= 1U;
    Batch batch;
    batch.messages = {message};
    ASSERT_TRUE(store_.commit(batch));
  };
  put_damaged(topics::kRigDescription.spec, kRig, kNoId);  // replaced before the session began
  put_plan(kFirst);
  put_damaged(topics::kTrialOutcome.spec, trial_id(kFirst, 1), kFirst);
  put_description("in force", kFirst);
  put_plan(kSecond);
  put_outcome(kSecond, 1, kSecond);
  put_plan(third);
  for (const bus::TopicSpec* topic :
       {&topics::kRigState.spec, &topics::kRigDescription.spec, &topics::kSessionState.spec,
        &topics::kTrialOutcome.spec, &topics::kTrialVerdict.spec, &topics::kEstimateCondition.spec,
        &topics::kServiceConfiguration.spec, &topics::kClockOffset.spec}) {
    put_damaged(*topic, id_of("of the third"), third);
  }
  const auto second = read_session(store_, kSecond);
  ASSERT_TRUE(second) << second.error().message;
  ASSERT_EQ(second->descriptions.size(), 1U);
  EXPECT_EQ(second->descriptions[0].value.name(), "in force");
  EXPECT_FALSE(read_session(store_, kFirst)) << "its own message is damaged";
}

TEST_F(SessionReader, RefusesASessionWithoutPlan) {
  const auto session = read_session(store_, kFirst);
  ASSERT_FALSE(session);
  EXPECT_EQ(session.error().code, ErrorCode::kNotFound);
  EXPECT_NE(session.error().message.find(to_hex(kFirst)), std::string::npos);
}

TEST_F(SessionReader, NamesMessagesThatItCannotDecode) {
  put_plan(kFirst);
  Message message = testing::message_of("trial/verdict", id_of("trial"), "of another version");
  message.session = kFirst;
  Batch batch;
  batch.messages = {message};
  ASSERT_TRUE(store_.commit(batch));
  const auto session = read_session(store_, kFirst);
  ASSERT_TRUE(session) << session.error().message;
  ASSERT_EQ(session->undecodable.size(), 1U);
  EXPECT_EQ(session->undecodable[0].rfind("trial/verdict: ", 0), 0U) << session->undecodable[0];
}

TEST_F(SessionReader, ReadsATrialsSamplesSortedAndOnce) {
  put_plan(kFirst);
  put_outcome(kFirst, 1, kFirst);
  put_record(kFirst, 1, {30, 30, 0, 0, 0});
  Batch batch;
  batch.streams = {{kStream, 0, {}, 0, 0}};
  for (const SequenceRange range : {SequenceRange{10, 30}, SequenceRange{0, 20}}) {
    v1::SampleBlock wire;
    wire.rig_id(kStream.rig);
    wire.epoch(kStream.epoch);
    wire.first_sequence(range.first);
    for (auto i = range.first; i < range.end; ++i) {
      wire.samples().emplace_back();
      wire.samples().back().acquisition_ns(static_cast<std::int64_t>(i));
    }
    Block block = testing::block_of(range.first, static_cast<std::uint32_t>(range.count()));
    block.payload = std::make_shared<const bus::Payload>(*bus::encode(wire));
    block.checksum = crc32c(*block.payload);
    batch.blocks.push_back(block);
  }
  ASSERT_TRUE(store_.commit(batch));
  const auto session = read_session(store_, kFirst);
  ASSERT_TRUE(session) << session.error().message;
  const auto samples = read_trial_samples(store_, session->trials.at(0));
  ASSERT_TRUE(samples) << samples.error().message;
  ASSERT_EQ(samples->samples.size(), 30U);
  for (std::size_t i = 0; i < samples->samples.size(); ++i)
    EXPECT_EQ(samples->samples[i].acquisition_ns(), static_cast<std::int64_t>(i));
}

TEST_F(SessionReader, HasNoSamplesOfATrialThatRuns) {
  SessionTrial trial;
  trial.attempt = 4;
  const auto samples = read_trial_samples(store_, trial);
  ASSERT_FALSE(samples);
  EXPECT_EQ(samples.error().code, ErrorCode::kNotFound);
  EXPECT_NE(samples.error().message.find("trial 4"), std::string::npos);
}

}  // namespace
}  // namespace tonus::store
