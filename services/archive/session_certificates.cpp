#include "services/archive/session_certificates.hpp"

#include <algorithm>

namespace tonus::archive {

void SessionCertificates::restore(const store::SessionCertificate& certificate) {
  ended_[certificate.session] = {certificate.end, true};
}

bool SessionCertificates::note_end(const Id& session, std::uint32_t end) {
  Ended& ended = ended_[session];
  if (ended.is_certified && ended.end == end) return false;
  ended = {end, false};
  return true;
}

void SessionCertificates::note_change(const Id& session) {
  if (const auto ended = ended_.find(session); ended != ended_.end()) ended->second.is_certified = false;
}

bool SessionCertificates::is_due() const {
  return std::any_of(ended_.begin(), ended_.end(), [](const auto& e) { return !e.second.is_certified; });
}

Result<std::vector<store::SessionCertificate>> SessionCertificates::make(
    store::Store& store, const std::vector<store::TrialRecord>& waiting, const store::SessionRecord& newest,
    std::uint64_t utc_ns) const {
  std::vector<store::SessionCertificate> certificates;
  for (const auto& [session, ended] : ended_) {
    if (ended.is_certified) continue;
    std::map<Id, store::TrialRecord> trials;
    TONUS_TRY_ASSIGN(const auto stored, store.trials(session));
    for (const store::TrialRecord& trial : stored) trials[trial.trial] = trial;
    for (const store::TrialRecord& trial : waiting) {
      if (trial.session == session) trials[trial.trial] = trial;
    }
    store::SessionCertificate certificate;
    certificate.session = session;
    certificate.end = ended.end;
    certificate.rig = session == newest.session ? newest.rig : kNoId;
    certificate.certified_ns = utc_ns;
    for (const auto& [id, trial] : trials) certificate.add(trial);
    certificates.push_back(certificate);
  }
  return certificates;
}

void SessionCertificates::note_committed(const std::vector<store::SessionCertificate>& certificates) {
  for (const store::SessionCertificate& certificate : certificates)
    ended_[certificate.session].is_certified = true;
}

}  // namespace tonus::archive
