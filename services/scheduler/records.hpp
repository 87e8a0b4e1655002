#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "services/core/id.hpp"
#include "services/core/result.hpp"
#include "services/protocol/stop_rule.hpp"

#include <idl/session.h>
#include <idl/trial.h>

/// What a session's journal holds: each record is a decision, complete in itself, so that applying the
/// records in order to an empty Ledger gives the session back without deciding anything anew.
namespace tonus::scheduler::record {

struct Started {
  Id session_id = kNoId;
  Id request_id = kNoId;
  std::string protocol_toml;
  std::string subject;
  std::uint64_t seed = 0;
  std::string started_at;  ///< ISO 8601, UTC.
  std::string software_version;
  v1::SubjectFacts subject_facts;
  std::string operator_name;
  std::string study;
  bool is_pilot = false;
};

/// The rig that runs the session, and its handle's home in R, m.
struct Bound {
  Id rig_id = kNoId;
  std::array<double, 2> home{};
};

/// Written before the command is sent.
struct Commanded {
  v1::TrialProgram program;
};

/// Valid and archived. `duration` is experiment time, s.
struct Counted {
  std::uint32_t attempt = 0;
  double duration = 0.0;
};

/// `place` among the remaining trials of its block, or kSetAside.
struct Rejected {
  static constexpr std::int32_t kSetAside = -1;  ///< Not repeated: a recording would give the same again.
  std::uint32_t attempt = 0;
  std::int32_t place = 0;
  bool owes_receipt = false;  ///< The archive has yet to say that its samples are safe.
  double duration = 0.0;
  std::string reason;
  bool is_reviewed = false;       ///< Its verdict is valid, and a review says that it does not count.
  std::uint64_t reviewed_ns = 0;  ///< UTC.
};

/// Never begun by the rig: the next one again, and no rejection.
struct Refused {
  std::uint32_t attempt = 0;
  std::string reason;
};

/// The archive's receipt for a rejected trial.
struct Receipted {
  std::uint32_t attempt = 0;
};

/// Axes of the bias forces at a posture, unit vectors in S, from the stiffness of set one.
struct AxesFixed {
  std::uint32_t posture_index = 0;
  std::array<double, 2> major{};
  std::array<double, 2> minor{};
  std::array<double, 4> stiffness{};  ///< N/m, row by row.
};

struct PostureConfirmed {
  std::uint32_t posture_index = 0;
};

/// The operator goes on although a block has reached its limit of rejections.
struct LimitRaised {
  std::uint32_t block = 0;
};

/// A pause (also one that the scheduler takes by itself; no request id then), a resume or an abort takes
/// effect.
struct Requested {
  Id request_id = kNoId;
  v1::SessionRequest request = v1::SESSION_PAUSE;
};

struct Answered {
  Id request_id = kNoId;
  bool is_done = false;
  std::string message;
};

struct Ended {
  v1::SessionPhase phase = v1::SESSION_COMPLETED;
  std::string message;
};

/// An operator has rejected a trial that had been counted. `place` as in Rejected.
struct Reviewed {
  std::uint32_t attempt = 0;
  std::uint32_t planned_index = 0;
  std::int32_t place = 0;
  std::string reason;
  std::string reviewed_by;
  std::uint64_t reviewed_ns = 0;  ///< UTC.
};

/// What an operator has noted; the fields of v1::SessionNote.
struct Noted {
  Id note_id = kNoId;
  Id trial_id = kNoId;
  std::string kind;
  std::string text;
  std::string written_by;
  std::uint64_t written_ns = 0;
  bool has_rig_clock = false;
  std::int64_t rig_clock_ns = 0;
  std::uint64_t epoch = 0;
};

/// What a condition's estimate said after its newest trial, and what was made of it (`stop_when`). Without an
/// estimate in time the condition goes on, or ends where it may not.
struct Looked {
  std::uint32_t condition = 0;  ///< In the plan.
  std::uint32_t newest = 0;     ///< Attempt; the newest of the condition that counts.
  std::uint32_t counted = 0;    ///< Trials of the condition that count.
  Id estimate_id = kNoId;       ///< kNoId: none came in time.
  std::uint32_t trials = 0;     ///< Behind the estimate.
  double stiffness = 0.0;       ///< Half-widths; not finite: not known.
  double mass = 0.0;
  double damping = 0.0;
  bool is_ok = false;
  bool is_linear = false;
  protocol::LookEnd end = protocol::LookEnd::kGoesOn;
  double needed = 0.0;  ///< Trials that the goals take; not finite: not known.
  std::string because;
  double amplitude = 0.0;  ///< m, of the next trial.
  double rise_time = 0.0;  ///< s
};

}  // namespace tonus::scheduler::record

namespace tonus::scheduler {

/// The order of the alternatives is the file's type number: append only.
using Record = std::variant<record::Started, record::Bound, record::Commanded, record::Counted,
                            record::Rejected, record::Refused, record::Receipted, record::AxesFixed,
                            record::PostureConfirmed, record::LimitRaised, record::Requested,
                            record::Answered, record::Ended, record::Reviewed, record::Noted, record::Looked>;

/// As the stopping rule takes them.
[[nodiscard]] std::vector<protocol::Look> looks_of(const std::vector<record::Looked>& records);

/// Records as one run of octets (plain CDR, little endian), and back. kDataLoss where octets are no records.
[[nodiscard]] Result<std::string> encode_records(const std::vector<Record>& records);
[[nodiscard]] Result<std::vector<Record>> decode_records(std::string_view octets);

}  // namespace tonus::scheduler
