#include "services/store/memory_store.hpp"

#include <algorithm>

namespace tonus::store {

Result<void> MemoryStore::commit(const Batch& batch) {
  for (const Block& block : batch.blocks) {
    blocks_[block.stream].emplace(block.first_sequence, block);
    bytes_ += block.payload->size();
  }
  for (const Message& message : batch.messages) bytes_ += message.payload->size();
  messages_.insert(messages_.end(), batch.messages.begin(), batch.messages.end());
  for (const SessionRecord& session : batch.sessions) sessions_[session.session] = session;
  for (const StreamRecord& stream : batch.streams) streams_[stream.key] = stream;
  for (const TrialTally& tally : batch.tallies) tallies_[tally.trial] = tally;
  for (const TrialRecord& trial : batch.trials) {
    trials_[trial.trial] = trial;
    if (trial.is_certified) tallies_.erase(trial.trial);
  }
  for (const SessionCertificate& certificate : batch.certificates)
    certificates_[certificate.session] = certificate;
  return {};
}

Result<std::vector<StreamRecord>> MemoryStore::streams() {
  std::vector<StreamRecord> all;
  for (const auto& [key, stream] : streams_) all.push_back(stream);
  return all;
}

Result<std::vector<SessionRecord>> MemoryStore::sessions() {
  std::vector<SessionRecord> all;
  for (const auto& [id, session] : sessions_) all.push_back(session);
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.started_at < b.started_at; });
  return all;
}

Result<std::vector<TrialRecord>> MemoryStore::trials(const Id& session) {
  std::vector<TrialRecord> all;
  for (const auto& [id, trial] : trials_) {
    if (trial.session == session) all.push_back(trial);
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.attempt < b.attempt; });
  return all;
}

Result<std::optional<TrialRecord>> MemoryStore::find_trial(const Id& trial) {
  const auto found = trials_.find(trial);
  return found == trials_.end() ? std::optional<TrialRecord>() : found->second;
}

Result<std::vector<TrialRecord>> MemoryStore::uncertified_trials() {
  std::vector<TrialRecord> all;
  for (const auto& [id, trial] : trials_) {
    if (!trial.is_certified) all.push_back(trial);
  }
  return all;
}

Result<std::vector<TrialTally>> MemoryStore::tallies() {
  std::vector<TrialTally> all;
  for (const auto& [id, tally] : tallies_) all.push_back(tally);
  return all;
}

Result<std::vector<SessionCertificate>> MemoryStore::session_certificates() {
  std::vector<SessionCertificate> all;
  for (const auto& [id, certificate] : certificates_) all.push_back(certificate);
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.certified_ns < b.certified_ns; });
  return all;
}

Result<StoreSpace> MemoryStore::space() { return StoreSpace{bytes_, std::nullopt}; }

Result<std::vector<MessageDigest>> MemoryStore::newest_messages() {
  std::map<std::pair<std::string, Id>, MessageDigest> newest;
  for (const Message& message : messages_) {
    newest[{message.topic, message.key}] = {message.topic, message.key, message.checksum,
                                            message.payload->size()};
  }
  std::vector<MessageDigest> all;
  all.reserve(newest.size());
  for (const auto& [key, digest] : newest) all.push_back(digest);
  return all;
}

Result<void> MemoryStore::visit_blocks(const BlockQuery& query, const BlockVisitor& visit) {
  const auto stream = blocks_.find(query.stream);
  if (stream == blocks_.end()) return {};
  for (const auto& [first, block] : stream->second) {
    if (block.range().end <= query.range.first || first >= query.range.end) continue;
    if (block.is_auxiliary != query.is_auxiliary) continue;
    if (auto good = check(block, name()); !good && !query.with_damaged) return good;
    TONUS_TRY(visit(block));
  }
  return {};
}

std::set<const Message*> MemoryStore::in_force_at(const Id& session) const {
  std::map<std::pair<std::string_view, Id>, const Message*> newest;
  for (const Message& message : messages_) {
    if (message.session == session) break;
    newest[{message.topic, message.key}] = &message;
  }
  std::set<const Message*> all;
  for (const auto& [key, message] : newest) all.insert(message);
  return all;
}

Result<void> MemoryStore::visit_messages(const MessageQuery& query, const MessageVisitor& visit) {
  std::set<const Message*> in_force;
  if (query.in_force_at) in_force = in_force_at(*query.in_force_at);
  for (const Message& message : messages_) {
    if (query.in_force_at && !in_force.contains(&message)) continue;
    if (!query.topic.empty() && message.topic != query.topic) continue;
    if (query.session && message.session != *query.session) continue;
    if (query.key && message.key != *query.key) continue;
    if (auto good = check(message, name()); !good && !query.with_damaged) return good;
    TONUS_TRY(visit(message));
  }
  return {};
}

}  // namespace tonus::store
