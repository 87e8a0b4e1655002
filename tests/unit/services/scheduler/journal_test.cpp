#include "services/scheduler/journal.hpp"

#include <filesystem>
#include <gtest/gtest.h>
#include <limits>

#include "services/scheduler/session_folder.hpp"
#include "tests/support/memory_storage.hpp"
#include "tests/support/scheduler_lab/lab.hpp"

namespace tonus::scheduler {
namespace {

using tonus::testing::MemoryStorage;
using Bytes = MemoryStorage::Bytes;
constexpr std::string_view kContract = "contract";

std::vector<Record> one_of_each() {
  v1::TrialProgram program;
  program.session_id(id_of("s"));
  program.attempt(7);
  program.posture("near");
  program.wait_s(3.25);
  program.bias_N({0.5, -0.5});
  program.recording_event(-1);
  v1::SubjectFacts facts;
  facts.age_years(34.0);
  return {record::Started{id_of("s"), id_of("r"), "schema = 1", "s01", 42, "2026-01-02T03:04:05Z", "0.1.0",
                          facts, "the operator", "study-1", true},
          record::Bound{id_of("rig/test"), {0.3, 0.35}},
          record::Commanded{program},
          record::Counted{7, 10.5},
          record::Rejected{7, -1, true, 9.5, "off target", true, 12},
          record::Refused{7, "busy"},
          record::Receipted{7},
          record::AxesFixed{2, {1.0, 0.0}, {0.0, -1.0}, {300.0, 1.0, 2.0, 100.0}},
          record::PostureConfirmed{2},
          record::LimitRaised{3},
          record::Requested{id_of("q"), v1::SESSION_ABORT},
          record::Answered{id_of("q"), true, "paused"},
          record::Ended{v1::SESSION_ABORTED, "aborted by request"},
          record::Reviewed{7, 3, 1, "coughed", "Ada", 12},
          record::Noted{id_of("n"), kNoId, "marker", "music", "Ada", 13, true, -5, 2},
          record::Looked{1, 9, 8, id_of("e"), 8, 0.04, 0.1, 0.2, true, true, protocol::LookEnd::kReached, 7.5,
                         "narrow enough", 0.006, 0.1}};
}

TEST(Records, SurviveWritingAndReading) {
  const auto octets = encode_records(one_of_each());
  ASSERT_TRUE(octets.has_value());
  const auto back = decode_records(*octets);
  ASSERT_TRUE(back.has_value()) << back.error().message;
  ASSERT_EQ(back->size(), 16u);
  const auto& started = std::get<record::Started>((*back)[0]);
  EXPECT_EQ(started.protocol_toml, "schema = 1");
  EXPECT_EQ(started.seed, 42u);
  const auto& commanded = std::get<record::Commanded>((*back)[2]);
  EXPECT_EQ(commanded.program, std::get<record::Commanded>(one_of_each()[2]).program);
  const auto& rejected = std::get<record::Rejected>((*back)[4]);
  EXPECT_EQ(rejected.place, record::Rejected::kSetAside);
  EXPECT_TRUE(rejected.owes_receipt);
  EXPECT_EQ(rejected.reason, "off target");
  EXPECT_EQ(std::get<record::AxesFixed>((*back)[7]).minor[1], -1.0);
  EXPECT_EQ(std::get<record::Requested>((*back)[10]).request, v1::SESSION_ABORT);
  EXPECT_EQ(std::get<record::Ended>((*back)[12]).phase, v1::SESSION_ABORTED);
  EXPECT_EQ(std::get<record::Reviewed>((*back)[13]).reason, "coughed");
  EXPECT_EQ(std::get<record::Noted>((*back)[14]).rig_clock_ns, -5);
  const auto& looked = std::get<record::Looked>((*back)[15]);
  EXPECT_EQ(looked.end, protocol::LookEnd::kReached);
  EXPECT_EQ(looked.estimate_id, id_of("e"));
  EXPECT_EQ(looked.because, "narrow enough");
  EXPECT_EQ(looked.rise_time, 0.1);
  EXPECT_EQ(*encode_records(*back), *octets);
}

TEST(Records, RefuseWhatIsCutShortOrOfNoKnownType) {
  const auto octets = *encode_records(one_of_each());
  for (std::size_t length = 0; length < octets.size(); ++length) {
    const auto back = decode_records(std::string_view(octets).substr(0, length));
    ASSERT_FALSE(back.has_value()) << length;
    EXPECT_EQ(back.error().code, ErrorCode::kDataLoss);
  }
  std::string unknown = *encode_records({record::Receipted{1}});
  unknown[4] = 99;
  EXPECT_FALSE(decode_records(unknown).has_value());
  EXPECT_FALSE(decode_records(octets + "x").has_value());
}

/// A journal of three appends, and where each ends.
struct Written {
  std::shared_ptr<Bytes> octets = std::make_shared<Bytes>();
  std::vector<std::size_t> ends;

  Written() {
    auto journal = Journal::create(std::make_unique<MemoryStorage>(octets), kContract);
    EXPECT_TRUE(journal.has_value());
    ends.push_back(octets->size());
    for (std::uint32_t i = 1; i <= 3; ++i) {
      EXPECT_TRUE(journal->append({record::Receipted{i}, record::LimitRaised{i}}).has_value());
      ends.push_back(octets->size());
    }
  }
};

Result<Journal::Opened> open(Bytes octets) {
  return Journal::open(std::make_unique<MemoryStorage>(std::make_shared<Bytes>(std::move(octets))),
                       kContract);
}

TEST(Journal, GivesBackWhatWasAppended) {
  const auto opened = open(*Written().octets);
  ASSERT_TRUE(opened.has_value()) << opened.error().message;
  ASSERT_EQ(opened->records.size(), 6u);
  EXPECT_EQ(std::get<record::Receipted>(opened->records[4]).attempt, 3u);
  EXPECT_EQ(opened->cut_bytes, 0u);
}

TEST(Journal, CutsATornTailAtEveryByteAndGoesOn) {
  const Written written;
  for (std::size_t length = 0; length <= written.octets->size(); ++length) {
    const auto octets = std::make_shared<Bytes>(
        written.octets->begin(), written.octets->begin() + static_cast<std::ptrdiff_t>(length));
    std::size_t whole = 0;
    while (whole < written.ends.size() && written.ends[whole] <= length) ++whole;
    {
      auto opened = Journal::open(std::make_unique<MemoryStorage>(octets), kContract);
      ASSERT_TRUE(opened.has_value()) << length << ": " << opened.error().message;
      ASSERT_EQ(opened->records.size(), whole == 0 ? 0 : 2 * (whole - 1)) << length;
      ASSERT_TRUE(opened->journal.append({record::PostureConfirmed{9}}).has_value());
    }
    const auto again = open(*octets);
    ASSERT_TRUE(again.has_value()) << length << ": " << again.error().message;
    EXPECT_EQ(std::get<record::PostureConfirmed>(again->records.back()).posture_index, 9u);
  }
}

TEST(Journal, CutsATailOfWhichOneByteIsWrong) {
  const Written written;
  for (std::size_t at = written.ends[2]; at < written.ends[3]; ++at) {
    Bytes octets = *written.octets;
    octets[at] ^= std::byte{0x40};
    const auto opened = open(octets);
    ASSERT_TRUE(opened.has_value()) << at << ": " << opened.error().message;
    EXPECT_EQ(opened->records.size(), 4u) << at;
    EXPECT_EQ(opened->cut_bytes, written.ends[3] - written.ends[2]);
  }
}

TEST(Journal, RefusesDamageBeforeItsLastFrame) {
  const Written written;
  for (std::size_t at = 0; at < written.ends[2]; ++at) {
    Bytes octets = *written.octets;
    octets[at] ^= std::byte{0x40};
    const auto opened = open(octets);
    ASSERT_FALSE(opened.has_value()) << at;
    EXPECT_EQ(opened.error().code, ErrorCode::kDataLoss) << at;
  }
}

TEST(Journal, RefusesAnotherContract) {
  const auto opened = Journal::open(std::make_unique<MemoryStorage>(Written().octets), "another");
  ASSERT_FALSE(opened.has_value());
  EXPECT_EQ(opened.error().message, "journal: written with contract contract, this program has another");
}

TEST(Journal, AppendsNothingMoreAfterAFailedWrite) {
  const auto octets = std::make_shared<Bytes>();
  auto journal = Journal::create(std::make_unique<MemoryStorage>(octets, 2, 10), kContract);
  ASSERT_TRUE(journal.has_value());
  ASSERT_TRUE(journal->append({record::Receipted{1}}).has_value());
  EXPECT_FALSE(journal->append({record::Receipted{2}}).has_value());
  const auto size = octets->size();
  EXPECT_FALSE(journal->append({record::Receipted{3}}).has_value());
  EXPECT_EQ(octets->size(), size);

  const auto opened = open(*octets);
  ASSERT_TRUE(opened.has_value());
  EXPECT_EQ(opened->records.size(), 1u);
  EXPECT_EQ(opened->cut_bytes, 10u);
}

class SessionFolderTest : public ::testing::Test {
 protected:
  void SetUp() override { std::filesystem::remove_all(path_); }
  void TearDown() override { std::filesystem::remove_all(path_); }

  SessionFolder open() {
    auto folder = SessionFolder::open(path_, std::string(kContract));
    EXPECT_TRUE(folder.has_value()) << (folder ? "" : folder.error().message);
    return std::move(*folder);
  }

  const std::filesystem::path path_ =
      std::filesystem::path(::testing::TempDir()) /
      (std::string("tonus_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(SessionFolderTest, GivesBackTheSessionThatLasts) {
  {
    auto folder = open();
    auto lasting = folder.begin(id_of("lasting"));
    ASSERT_TRUE(lasting->append({one_of_each()[0]}).has_value());
    auto empty = folder.begin(id_of("empty"));
    ASSERT_TRUE(empty.has_value());
  }
  auto folder = open();
  const auto reopened = folder.reopen();
  ASSERT_TRUE(reopened.has_value()) << reopened.error().message;
  ASSERT_TRUE(reopened->has_value());
  EXPECT_EQ((*reopened)->records.size(), 1u);
  EXPECT_TRUE(folder.knows(id_of("lasting")));
  EXPECT_FALSE(folder.knows(id_of("empty")));
  EXPECT_FALSE(folder.begin(id_of("lasting")).has_value());
}

TEST_F(SessionFolderTest, PutsAFinishedSessionAway) {
  auto folder = open();
  auto journal = folder.begin(id_of("s"));
  ASSERT_TRUE(journal->append({one_of_each()[0], record::Ended{}}).has_value());
  ASSERT_TRUE(folder.finish(id_of("s")).has_value());
  EXPECT_TRUE(folder.knows(id_of("s")));
  EXPECT_FALSE(folder.reopen()->has_value());
}

TEST_F(SessionFolderTest, RefusesASecondSchedulerAndTwoOpenSessions) {
  auto folder = open();
  const auto second = SessionFolder::open(path_, std::string(kContract));
  ASSERT_FALSE(second.has_value());
  EXPECT_EQ(second.error().message, (path_ / "lock").string() + ": another scheduler has it open");
  {
    auto a = folder.begin(id_of("a"));
    auto b = folder.begin(id_of("b"));
    ASSERT_TRUE(a->append({one_of_each()[0]}).has_value());
    ASSERT_TRUE(b->append({one_of_each()[0]}).has_value());
  }
  EXPECT_EQ(folder.reopen().error().code, ErrorCode::kDataLoss);
}

}  // namespace
}  // namespace tonus::scheduler
