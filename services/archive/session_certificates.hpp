#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "services/core/result.hpp"
#include "services/store/store.hpp"

namespace tonus::archive {

/// The certificates of sessions that have ended: the sums over a session's trials. One is due when the
/// session's end is known, and again whenever one of its trials changes. Not for use by several threads.
class SessionCertificates {
 public:
  /// One that the store has already.
  void restore(const store::SessionCertificate& certificate);

  [[nodiscard]] bool knows_end(const Id& session) const { return ended_.contains(session); }

  /// False: this end is known and certified.
  bool note_end(const Id& session, std::uint32_t end);

  /// A trial of the session is about to be stored.
  void note_change(const Id& session);

  [[nodiscard]] bool is_due() const;

  /// Those that are due, from the stored trials and from `waiting`, which replace them. `newest` is the
  /// newest plan: where a session has no trial, its rig is that of its plan. The store's error.
  [[nodiscard]] Result<std::vector<store::SessionCertificate>> make(
      store::Store& store, const std::vector<store::TrialRecord>& waiting, const store::SessionRecord& newest,
      std::uint64_t utc_ns) const;

  /// They are durable.
  void note_committed(const std::vector<store::SessionCertificate>& certificates);

 private:
  struct Ended {
    std::uint32_t end = 0;  ///< v1::SessionPhase
    bool is_certified = false;
  };
  std::map<Id, Ended> ended_;
};

}  // namespace tonus::archive
