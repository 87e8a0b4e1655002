#pragma once

#include <gtest/gtest.h>
#include <memory>

#include "services/archive/ingest.hpp"
#include "services/store/memory_store.hpp"
#include "tests/unit/services/store/made_up.hpp"

namespace tonus::archive::testing {

/// A store in memory whose disk can fail: commits are refused while `is_failing`, and counted.
class FaultyStore final : public store::Store {
 public:
  bool is_failing = false;
  int commits = 0;
  int refused = 0;
  store::Batch last;

  Result<void> commit(const store::Batch& batch) override {
    if (is_failing) {
      ++refused;
      return fail(ErrorCode::kIo, "store 'made up': disk is full");
    }
    ++commits;
    last = batch;
    return memory_.commit(batch);
  }
  Result<std::vector<store::StreamRecord>> streams() override { return memory_.streams(); }
  Result<std::vector<store::SessionRecord>> sessions() override { return memory_.sessions(); }
  Result<std::vector<store::TrialRecord>> trials(const Id& session) override {
    return memory_.trials(session);
  }
  Result<std::optional<store::TrialRecord>> find_trial(const Id& trial) override {
    return memory_.find_trial(trial);
  }
  Result<std::vector<store::TrialRecord>> uncertified_trials() override {
    return memory_.uncertified_trials();
  }
  Result<std::vector<store::TrialTally>> tallies() override { return memory_.tallies(); }
  Result<std::vector<store::SessionCertificate>> session_certificates() override {
    return memory_.session_certificates();
  }
  Result<store::StoreSpace> space() override { return memory_.space(); }
  Result<std::vector<store::MessageDigest>> newest_messages() override { return memory_.newest_messages(); }
  Result<void> visit_blocks(const store::BlockQuery& query, const store::BlockVisitor& visit) override {
    return memory_.visit_blocks(query, visit);
  }
  Result<void> visit_messages(const store::MessageQuery& query, const store::MessageVisitor& visit) override {
    return memory_.visit_messages(query, visit);
  }
  [[nodiscard]] std::string name() const override { return "made up"; }

 private:
  store::MemoryStore memory_;
};

/// An ingest over a faulty store, with a clock advanced by hand.
class IngestFixture : public ::testing::Test {
 protected:
  using milliseconds = std::chrono::milliseconds;

  void SetUp() override {
    clock_.advance(std::chrono::hours(24 * 365 * 57));  // 2026: the plans of the tests have started
    restart();
  }

  /// The archive's death and new start with what its store has.
  void restart() {
    ingest_ = std::make_unique<Ingest>(store_, clock_, options_);
    const auto recovered = ingest_->recover();
    ASSERT_TRUE(recovered) << recovered.error().message;
  }

  /// Blocks of 20 samples that fill a range.
  void take_samples(std::uint64_t first, std::uint64_t end, const Id& trial = kNoId, bool is_resent = false) {
    for (; first < end; first += 20) ingest_->take(store::testing::block_of(first, 20, trial, is_resent));
  }

  Decisions step_after(Clock::Duration duration) {
    clock_.advance(duration);
    return ingest_->step();
  }

  void hear_rig(std::uint64_t next_sequence, std::uint64_t received_through = 0) {
    ingest_->note_rig({store::testing::kStream, next_sequence, received_through});
  }

  /// Lets time pass in small steps with a rig that reports; collects what is decided.
  Decisions pass(Clock::Duration duration, std::uint64_t next_sequence, std::uint64_t received_through = 0) {
    Decisions all;
    for (Clock::Duration passed{}; passed < duration; passed += milliseconds(50)) {
      hear_rig(next_sequence, received_through);
      const Decisions decisions = step_after(milliseconds(50));
      all.resends.insert(all.resends.end(), decisions.resends.begin(), decisions.resends.end());
      all.trial_receipts.insert(all.trial_receipts.end(), decisions.trial_receipts.begin(),
                                decisions.trial_receipts.end());
      all.stream_receipts.insert(all.stream_receipts.end(), decisions.stream_receipts.begin(),
                                 decisions.stream_receipts.end());
    }
    return all;
  }

  FaultyStore store_;
  ManualClock clock_;
  Ingest::Options options_;
  std::unique_ptr<Ingest> ingest_;
};

}  // namespace tonus::archive::testing
