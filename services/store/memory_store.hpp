#pragma once

#include <map>
#include <set>

#include "services/store/store.hpp"

namespace tonus::store {

/// The archive's simulated counterpart: keeps everything in memory until the program ends, for tests and for
/// systems that are only tried out.
class MemoryStore final : public Store {
 public:
  [[nodiscard]] Result<void> commit(const Batch& batch) override;
  [[nodiscard]] Result<std::vector<StreamRecord>> streams() override;
  [[nodiscard]] Result<std::vector<SessionRecord>> sessions() override;
  [[nodiscard]] Result<std::vector<TrialRecord>> trials(const Id& session) override;
  [[nodiscard]] Result<std::optional<TrialRecord>> find_trial(const Id& trial) override;
  [[nodiscard]] Result<std::vector<TrialRecord>> uncertified_trials() override;
  [[nodiscard]] Result<std::vector<TrialTally>> tallies() override;
  [[nodiscard]] Result<std::vector<SessionCertificate>> session_certificates() override;
  [[nodiscard]] Result<std::vector<MessageDigest>> newest_messages() override;
  [[nodiscard]] Result<void> visit_blocks(const BlockQuery& query, const BlockVisitor& visit) override;
  [[nodiscard]] Result<void> visit_messages(const MessageQuery& query, const MessageVisitor& visit) override;
  [[nodiscard]] Result<StoreSpace> space() override;
  [[nodiscard]] std::string name() const override { return ":memory:"; }

 private:
  /// Of each topic and key the newest message that arrived before the session's first one.
  [[nodiscard]] std::set<const Message*> in_force_at(const Id& session) const;

  std::map<StreamKey, StreamRecord> streams_;
  std::map<StreamKey, std::multimap<std::uint64_t, Block>> blocks_;  ///< By first sequence.
  std::map<Id, SessionRecord> sessions_;
  std::map<Id, TrialRecord> trials_;
  std::map<Id, TrialTally> tallies_;
  std::map<Id, SessionCertificate> certificates_;
  std::vector<Message> messages_;
  std::uint64_t bytes_ = 0;  ///< Of all payloads.
};

}  // namespace tonus::store
