#pragma once

#include "services/store/memory_store.hpp"
#include "tests/fault/simulator/disk.hpp"
#include "tests/fault/simulator/random.hpp"

namespace tonus::simulator {

/// The archive's disk: outlives the archive's lives. A commit can fail because the disk is full, and a life
/// can die before or after it.
class LastingStore final : public store::Store {
 public:
  LastingStore(Random& random, const Disk& disk) : random_(random), disk_(disk) {}

  /// Whose commits these are from now on; null: nobody's.
  void belong_to(Life* life) { life_ = life; }

  Result<void> commit(const store::Batch& batch) override {
    if (life_ != nullptr && life_->is_dead) return fail(ErrorCode::kIo, "the archive is dead");
    const bool is_last = life_ != nullptr && life_->dies_now();
    if (is_last && random_.chance(0.5)) throw Died{};
    if (disk_.is_full) return fail(ErrorCode::kIo, "the archive's disk is full");
    const auto done = kept_.commit(batch);
    if (is_last) throw Died{};
    return done;
  }
  Result<std::vector<store::StreamRecord>> streams() override { return kept_.streams(); }
  Result<std::vector<store::SessionRecord>> sessions() override { return kept_.sessions(); }
  Result<std::vector<store::TrialRecord>> trials(const Id& session) override { return kept_.trials(session); }
  Result<std::optional<store::TrialRecord>> find_trial(const Id& trial) override {
    return kept_.find_trial(trial);
  }
  Result<std::vector<store::TrialRecord>> uncertified_trials() override { return kept_.uncertified_trials(); }
  Result<std::vector<store::TrialTally>> tallies() override { return kept_.tallies(); }
  Result<std::vector<store::SessionCertificate>> session_certificates() override {
    return kept_.session_certificates();
  }
  Result<std::vector<store::MessageDigest>> newest_messages() override { return kept_.newest_messages(); }
  Result<void> visit_blocks(const store::BlockQuery& query, const store::BlockVisitor& visit) override {
    return kept_.visit_blocks(query, visit);
  }
  Result<void> visit_messages(const store::MessageQuery& query, const store::MessageVisitor& visit) override {
    return kept_.visit_messages(query, visit);
  }
  Result<store::StoreSpace> space() override { return kept_.space(); }
  std::string name() const override { return kept_.name(); }

 private:
  store::MemoryStore kept_;
  Random& random_;
  const Disk& disk_;
  Life* life_ = nullptr;
};

}  // namespace tonus::simulator
