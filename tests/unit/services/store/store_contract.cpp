#include "tests/unit/services/store/store_contract.hpp"

namespace tonus::store::testing {

TEST_P(StoreContract, IsEmptyAtFirst) {
  EXPECT_TRUE(store_->streams()->empty());
  EXPECT_TRUE(store_->sessions()->empty());
  EXPECT_TRUE(store_->trials(kSession)->empty());
  EXPECT_FALSE(store_->find_trial(kSession)->has_value());
  EXPECT_TRUE(store_->newest_messages()->empty());
  EXPECT_TRUE(firsts_in({0, 100}).empty());
}

TEST_P(StoreContract, GivesBlocksBackAsTheyCame) {
  Block block = block_of(40, 20, id_of("trial"), true);
  Batch batch;
  batch.blocks = {block};
  batch.streams = {{kStream, 0, {}, 0, 0}};
  commit(batch);
  int count = 0;
  const auto visited = store_->visit_blocks({kStream, {40, 41}}, [&](const Block& stored) -> Result<void> {
    ++count;
    EXPECT_EQ(stored.stream, block.stream);
    EXPECT_EQ(stored.first_sequence, 40U);
    EXPECT_EQ(stored.count, 20U);
    EXPECT_EQ(stored.session, block.session);
    EXPECT_EQ(stored.trial, block.trial);
    EXPECT_TRUE(stored.is_resent);
    EXPECT_EQ(stored.received_ns, block.received_ns);
    EXPECT_EQ(stored.checksum, block.checksum);
    EXPECT_EQ(*stored.payload, *block.payload);
    return {};
  });
  EXPECT_TRUE(visited);
  EXPECT_EQ(count, 1);
}

TEST_P(StoreContract, KeepsAuxiliaryBlocksBesideThoseOfSamples) {
  Batch batch;
  StreamRecord stream{kStream, 0, {}, 0, 0, 12, {}};
  stream.coverage.add({0, 40});
  stream.auxiliary_coverage.add({0, 20});
  stream.auxiliary_coverage.add({60, 80});
  batch.streams = {stream};
  batch.blocks = {block_of(0, 40), auxiliary_block_of(0, 20),
                  auxiliary_block_of(60, 20, id_of("trial"), true)};
  commit(batch);
  EXPECT_EQ(firsts_in({0, 1000}), (std::vector<std::uint64_t>{0}));
  std::vector<Block> blocks;
  EXPECT_TRUE(
      store_->visit_blocks({kStream, {0, 1000}, false, true}, [&](const Block& block) -> Result<void> {
        blocks.push_back(block);
        return {};
      }));
  ASSERT_EQ(blocks.size(), 2U);
  EXPECT_TRUE(blocks[1].is_auxiliary);
  EXPECT_EQ(*blocks[1].payload, *batch.blocks[2].payload);
  EXPECT_EQ(blocks[1].trial, id_of("trial"));
  EXPECT_TRUE(blocks[1].is_resent);
  const auto streams = store_->streams();
  ASSERT_TRUE(streams);
  EXPECT_EQ(streams->at(0).auxiliary_values, 12U);
  EXPECT_EQ(streams->at(0).auxiliary_coverage, stream.auxiliary_coverage);
  EXPECT_EQ(streams->at(0).whole().ranges(), (std::vector<SequenceRange>{{0, 20}}));
}

TEST_P(StoreContract, FindsBlocksThatReachIntoARangeInTheirOrder) {
  Batch batch;
  batch.streams = {{kStream, 0, {}, 0, 0}, {{kRig, 7}, 0, {}, 0, 0}};
  batch.blocks = {block_of(40, 20), block_of(0, 20),  block_of(20, 20),
                  block_of(60, 20), block_of(10, 20), block_of(30, 20, kNoId, false, {kRig, 7})};
  commit(batch);
  EXPECT_EQ(firsts_in({0, 1000}), (std::vector<std::uint64_t>{0, 10, 20, 40, 60}));
  EXPECT_EQ(firsts_in({20, 40}), (std::vector<std::uint64_t>{10, 20}));
  EXPECT_EQ(firsts_in({59, 60}), (std::vector<std::uint64_t>{40}));
  EXPECT_EQ(firsts_in({80, 90}), (std::vector<std::uint64_t>{}));
  EXPECT_EQ(firsts_in({0, 1000}, {kRig, 7}), (std::vector<std::uint64_t>{30}));
  EXPECT_EQ(firsts_in({0, 1000}, {kRig, 8}), (std::vector<std::uint64_t>{}));
}

TEST_P(StoreContract, EndsAVisitWithTheVisitorsError) {
  Batch batch;
  batch.streams = {{kStream, 0, {}, 0, 0}};
  batch.blocks = {block_of(0, 20), block_of(20, 20)};
  commit(batch);
  int count = 0;
  const auto visited = store_->visit_blocks({kStream, {0, 40}}, [&](const Block&) -> Result<void> {
    ++count;
    return fail(ErrorCode::kInternal, "enough");
  });
  ASSERT_FALSE(visited);
  EXPECT_EQ(visited.error().message, "enough");
  EXPECT_EQ(count, 1);
}

TEST_P(StoreContract, RefusesToGiveOutDamagedPayloads) {
  Batch batch;
  batch.streams = {{kStream, 0, {}, 0, 0}};
  batch.blocks = {block_of(0, 20)};
  batch.blocks[0].checksum ^= 1U;
  batch.messages = {message_of("a", kRig, "text")};
  batch.messages[0].checksum ^= 1U;
  commit(batch);
  const auto blocks =
      store_->visit_blocks({kStream, {0, 20}}, [](const Block&) -> Result<void> { return {}; });
  ASSERT_FALSE(blocks);
  EXPECT_EQ(blocks.error().code, ErrorCode::kDataLoss);
  EXPECT_NE(blocks.error().message.find("samples 0 to 19 of rig " + to_hex(kRig)), std::string::npos)
      << blocks.error().message;
  const auto messages = store_->visit_messages({}, [](const Message&) -> Result<void> { return {}; });
  ASSERT_FALSE(messages);
  EXPECT_EQ(messages.error().code, ErrorCode::kDataLoss);
}

TEST_P(StoreContract, KeepsTheNewestStateOfAStream) {
  Coverage two;
  two.add({0, 10});
  two.add({20, 30});
  Batch batch;
  batch.streams = {{kStream, 0, two, 1, 2}};
  commit(batch);
  Coverage one = two;
  one.add({10, 20});
  batch.streams = {{kStream, 4, one, 3, 4}, {{kRig, 1}, 0, {}, 0, 0}};
  commit(batch);
  const auto streams = store_->streams();
  ASSERT_TRUE(streams);
  ASSERT_EQ(streams->size(), 2U);
  EXPECT_EQ((*streams)[0].key.epoch, 1U);
  EXPECT_EQ((*streams)[1].key, kStream);
  EXPECT_EQ((*streams)[1].coverage, one);
  EXPECT_EQ((*streams)[1].origin, 4U);
  EXPECT_EQ((*streams)[1].resent, 3U);
  EXPECT_EQ((*streams)[1].duplicated, 4U);
}

TEST_P(StoreContract, SelectsMessagesByTopicSessionAndKey) {
  Batch batch;
  batch.messages = {message_of("a", id_of("1"), "first"), message_of("b", id_of("1"), "second"),
                    message_of("a", id_of("2"), "third"), message_of("a", id_of("1"), "fourth")};
  batch.messages[3].session = kSession;
  commit(batch);
  using Texts = std::vector<std::string>;
  EXPECT_EQ(texts_of({}), (Texts{"first", "second", "third", "fourth"}));
  EXPECT_EQ(texts_of({"a", {}, {}}), (Texts{"first", "third", "fourth"}));
  EXPECT_EQ(texts_of({"a", {}, id_of("1")}), (Texts{"first", "fourth"}));
  EXPECT_EQ(texts_of({"", kSession, {}}), (Texts{"fourth"}));
  const auto newest = store_->newest_messages();
  ASSERT_TRUE(newest);
  ASSERT_EQ(newest->size(), 3U);
  for (const MessageDigest& digest : *newest) {
    if (digest.topic != "a" || digest.key != id_of("1")) continue;
    EXPECT_EQ(digest.checksum, batch.messages[3].checksum);
    EXPECT_EQ(digest.bytes, 6U);
  }
}

TEST_P(StoreContract, GivesWhatWasInForceWhenASessionBegan) {
  Batch batch;
  batch.messages = {message_of("a", id_of("1"), "replaced"),         message_of("a", id_of("1"), "in force"),
                    message_of("b", id_of("1"), "of another topic"), message_of("a", id_of("2"), "other key"),
                    message_of("a", id_of("1"), "during"),           message_of("a", id_of("2"), "after")};
  batch.messages[4].session = kSession;
  commit(batch);
  using Texts = std::vector<std::string>;
  EXPECT_EQ(texts_of({"a", {}, {}, false, kSession}), (Texts{"in force", "other key"}));
  EXPECT_EQ(texts_of({"a", {}, id_of("1"), false, kSession}), (Texts{"in force"}));
  EXPECT_EQ(texts_of({"", {}, {}, false, kSession}), (Texts{"in force", "of another topic", "other key"}));
  EXPECT_EQ(texts_of({"a", {}, {}, false, id_of("a session without messages")}), (Texts{"during", "after"}));
}

TEST_P(StoreContract, GivesSessionsByStart) {
  Batch batch;
  batch.sessions = {session_of(id_of("late"), "2026-03-02T10:00:00Z"),
                    session_of(id_of("early"), "2026-03-01T10:00:00Z")};
  commit(batch);
  batch.sessions[0].subject = "renamed";
  commit(batch);
  const auto sessions = store_->sessions();
  ASSERT_TRUE(sessions);
  ASSERT_EQ(sessions->size(), 2U);
  EXPECT_EQ((*sessions)[0].session, id_of("early"));
  EXPECT_EQ((*sessions)[1].subject, "renamed");
  EXPECT_EQ((*sessions)[1].seed, 18'446'744'073'709'551'615U);
  EXPECT_EQ((*sessions)[1].planned_trials, 80U);
  EXPECT_EQ((*sessions)[1].started_at, "2026-03-02T10:00:00Z");
}

TEST_P(StoreContract, ForgetsTheTallyOfATrialThatIsCertified) {
  Batch batch;
  batch.trials = {trial_of(2, 100, 199), trial_of(1, 0, 99)};
  batch.tallies = {{batch.trials[0].trial, 3, 4}, {batch.trials[1].trial, 1, 2}};
  commit(batch);
  EXPECT_EQ(store_->uncertified_trials()->size(), 2U);
  EXPECT_EQ(store_->tallies()->size(), 2U);

  Batch certified;
  certified.trials = {trial_of(1, 0, 99)};
  certified.trials[0].is_certified = true;
  certified.trials[0].certified_ns = 77;
  certified.trials[0].certificate = {100, 100, 1, 2, 0};
  commit(certified);
  const auto tallies = store_->tallies();
  ASSERT_EQ(tallies->size(), 1U);
  EXPECT_EQ((*tallies)[0].trial, trial_id(kSession, 2));
  EXPECT_EQ((*tallies)[0].duplicated, 4U);
  const auto trials = store_->trials(kSession);
  ASSERT_EQ(trials->size(), 2U);
  const TrialRecord& trial = (*trials)[0];
  EXPECT_EQ(trial.attempt, 1U);
  EXPECT_TRUE(trial.is_certified);
  EXPECT_EQ(trial.certified_ns, 77U);
  EXPECT_EQ(trial.certificate, (Certificate{100, 100, 1, 2, 0}));
  EXPECT_EQ(trial.posture, "reference");
  EXPECT_EQ(trial.range(), (SequenceRange{0, 100}));
  EXPECT_EQ(trial.sample_rate, 200.0);
  EXPECT_EQ(trial.stream, kStream);
  ASSERT_TRUE(store_->find_trial(trial.trial)->has_value());
  EXPECT_EQ((*store_->find_trial(trial.trial))->attempt, 1U);
  EXPECT_EQ(store_->uncertified_trials()->size(), 1U);
}

TEST_P(StoreContract, TakesABatchWholeOrNotAtAll) {
  Batch batch;
  batch.streams = {{kStream, 0, {}, 0, 0}};
  batch.blocks = {block_of(0, 20), block_of(20, 20, kNoId, false, {id_of("unknown rig"), 1})};
  batch.messages = {message_of("a", kRig, "text")};
  if (store_->commit(batch)) return;  // a store in memory needs no stream to be known
  EXPECT_TRUE(firsts_in({0, 1000}).empty());
  EXPECT_TRUE(texts_of({}).empty());
  EXPECT_TRUE(store_->streams()->empty());
  batch.blocks.pop_back();
  commit(batch);
  EXPECT_EQ(firsts_in({0, 1000}).size(), 1U);
}

TEST_P(StoreContract, KeepsTheCertificateOfASession) {
  EXPECT_TRUE(store_->session_certificates()->empty());
  Batch batch;
  batch.certificates = {{kSession, kRig, 8, 80, 1, {1000, 990, 5, 6, 10}, 50}};
  commit(batch);
  batch.certificates[0].sums.missing = 0;
  batch.certificates[0].certified_ns = 60;
  batch.certificates.push_back({id_of("earlier"), kRig, 7, 1, 0, {}, 40});
  commit(batch);
  const auto certificates = store_->session_certificates();
  ASSERT_TRUE(certificates);
  ASSERT_EQ(certificates->size(), 2U);
  EXPECT_EQ((*certificates)[0].session, id_of("earlier"));
  const SessionCertificate& newest = (*certificates)[1];
  EXPECT_EQ(newest.session, kSession);
  EXPECT_EQ(newest.rig, kRig);
  EXPECT_EQ(newest.end, 8U);
  EXPECT_EQ(newest.trials, 80U);
  EXPECT_EQ(newest.incomplete_trials, 1U);
  EXPECT_EQ(newest.sums, (Certificate{1000, 990, 5, 6, 0}));
  EXPECT_EQ(newest.certified_ns, 60U);
}

TEST_P(StoreContract, KeepsTextAsItCame) {
  Batch batch;
  batch.sessions = {session_of(kSession, "2026-03-01T10:00:00Z")};
  batch.sessions[0].subject = "J\xC3\xB6rg's \"left\" arm; \\ \t {} %s $1";
  commit(batch);
  EXPECT_EQ(store_->sessions()->front().subject, batch.sessions[0].subject);
}

TEST_P(StoreContract, TakesTextThatIsNoUtf8) {
  Batch batch;
  batch.sessions = {session_of(kSession, "2026-03-01T10:00:00Z")};
  batch.sessions[0].subject = "\xFF\xC0\x80 cut \xE2\x82";
  commit(batch);
  EXPECT_EQ(store_->sessions()->size(), 1U);
}

TEST_P(StoreContract, GivesPayloadsOfAnyOctetsBack) {
  std::vector<std::byte> bytes;
  for (int i = 0; i < 1024; ++i) bytes.push_back(static_cast<std::byte>(i * 7 % 256));
  Batch batch;
  batch.streams = {{kStream, 0, {}, 0, 0}};
  batch.blocks = {block_of(0, 20)};
  batch.blocks[0].payload = std::make_shared<const std::vector<std::byte>>(bytes);
  batch.blocks[0].checksum = crc32c(bytes);
  commit(batch);
  const auto visited = store_->visit_blocks({kStream, {0, 20}}, [&](const Block& block) -> Result<void> {
    EXPECT_EQ(*block.payload, bytes);
    return {};
  });
  EXPECT_TRUE(visited) << visited.error().message;
}

TEST_P(StoreContract, LetsAVisitorUseTheStore) {
  Batch batch;
  batch.streams = {{kStream, 0, {}, 0, 0}};
  for (std::uint64_t i = 0; i < 600; ++i) batch.blocks.push_back(block_of(20 * i, 20));
  commit(batch);
  std::vector<std::uint64_t> firsts;
  const auto visited = store_->visit_blocks({kStream, {0, 12'000}}, [&](const Block& block) -> Result<void> {
    firsts.push_back(block.first_sequence);
    if (firsts.size() % 100 == 0) {
      EXPECT_EQ(firsts_in({block.first_sequence, block.range().end}).size(), 1U);
    }
    return {};
  });
  EXPECT_TRUE(visited) << visited.error().message;
  ASSERT_EQ(firsts.size(), 600U);
  EXPECT_EQ(firsts.back(), 11'980U);
}

TEST_P(StoreContract, SaysHowMuchRoomItTakes) {
  const auto before = store_->space();
  ASSERT_TRUE(before) << before.error().message;
  Batch batch;
  batch.streams = {{kStream, 0, {}, 0, 0}};
  for (std::uint64_t i = 0; i < 100; ++i) {
    batch.blocks.push_back(block_of(20 * i, 20));
    batch.blocks.back().payload = std::make_shared<const std::vector<std::byte>>(10'000);
  }
  commit(batch);
  const auto after = store_->space();
  ASSERT_TRUE(after);
  EXPECT_GE(after->used_bytes, before->used_bytes + 1'000'000);
  EXPECT_LT(after->used_bytes, before->used_bytes + 3'000'000);
}

}  // namespace tonus::store::testing
