#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "services/core/result.hpp"
#include "services/store/records.hpp"

namespace tonus::store {

/// Samples of a stream.
struct BlockQuery {
  StreamKey stream;
  SequenceRange range;
  bool with_damaged = false;  ///< Visits damaged ones too, instead of an error: the caller checks them.
  bool is_auxiliary = false;  ///< Blocks of auxiliary values in place of those of samples.
};

/// Messages, in the order of arrival. Empty topic: all; no session or key: any.
struct MessageQuery {
  std::string topic;
  std::optional<Id> session;
  std::optional<Id> key;
  bool with_damaged = false;  ///< As above.

  /// Of each topic and key only the newest message that arrived before this session's first one (of a session
  /// without messages: the newest of all), that is, what was in force when the session began.
  std::optional<Id> in_force_at{};
};

/// Called for each; an error ends the visit and becomes its result.
using BlockVisitor = std::function<Result<void>(const Block&)>;
using MessageVisitor = std::function<Result<void>(const Message&)>;

/// What a store takes, and what is left for it.
struct StoreSpace {
  std::uint64_t used_bytes = 0;
  std::optional<std::uint64_t> free_bytes;  ///< On its disk, for its user; none: cannot be known from here.
};

/// What keeps the archive's data. For one thread. Every implementation passes the same tests.
///
/// Errors are one line that names the store. kIo: the disk or server refused (full, gone, busy); the call may
/// be tried again. kDataLoss: what is stored is damaged; the message says which samples or message.
class Store {
 public:
  virtual ~Store() = default;

  /// Makes the batch durable: on success it survives the death of the program and of the machine, on failure
  /// nothing of it is there. (Where a failed disk leaves the outcome open, it may be there in full;
  /// committing the same batch again is harmless.)
  [[nodiscard]] virtual Result<void> commit(const Batch& batch) = 0;

  /// By rig, then epoch.
  [[nodiscard]] virtual Result<std::vector<StreamRecord>> streams() = 0;

  /// By start.
  [[nodiscard]] virtual Result<std::vector<SessionRecord>> sessions() = 0;

  /// By attempt.
  [[nodiscard]] virtual Result<std::vector<TrialRecord>> trials(const Id& session) = 0;
  [[nodiscard]] virtual Result<std::optional<TrialRecord>> find_trial(const Id& trial) = 0;
  [[nodiscard]] virtual Result<std::vector<TrialRecord>> uncertified_trials() = 0;
  [[nodiscard]] virtual Result<std::vector<TrialTally>> tallies() = 0;

  /// Of the sessions that have ended, by when it was made.
  [[nodiscard]] virtual Result<std::vector<SessionCertificate>> session_certificates() = 0;

  /// The newest message of each topic and key.
  [[nodiscard]] virtual Result<std::vector<MessageDigest>> newest_messages() = 0;

  /// Blocks with a sample in the range, by first sequence, each payload checked against its checksum. Blocks
  /// may overlap (resent samples).
  [[nodiscard]] virtual Result<void> visit_blocks(const BlockQuery& query, const BlockVisitor& visit) = 0;

  /// Payloads checked against their checksums.
  [[nodiscard]] virtual Result<void> visit_messages(const MessageQuery& query,
                                                    const MessageVisitor& visit) = 0;

  [[nodiscard]] virtual Result<StoreSpace> space() = 0;

  /// How people call it: the path, or the URL without its password.
  [[nodiscard]] virtual std::string name() const = 0;
};

/// kDataLoss where the payload is not what the checksum was made of.
[[nodiscard]] Result<void> check(const Block& block, const std::string& store_name);
[[nodiscard]] Result<void> check(const Message& message, const std::string& store_name);

}  // namespace tonus::store
