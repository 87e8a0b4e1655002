#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "services/bus/partitions.hpp"
#include "services/bus/typed.hpp"
#include "services/runtime/health.hpp"
#include "tests/support/made_up_trial/made_up_messages.hpp"

#include <idl/archive.h>

namespace tonus::bench {

using Time = std::chrono::steady_clock::time_point;

inline constexpr std::size_t kRowsABlock = 5;               ///< 25 ms at 200 Hz, as the rig's agent has it.
inline constexpr std::chrono::milliseconds kBlockTime{25};  ///< Until the rig's next block.

/// One rig that measures made-up trials one after the other, and its scheduler.
class SimulatedRig {
 public:
  SimulatedRig(bus::Bus& bus, const Clock& clock, const std::string& name, const std::string& dds,
               std::uint32_t trials);

  /// Description, plan and health: what the services wait for.
  void introduce();
  void report_health() { health_.publish_if_due(); }
  [[nodiscard]] int readers() const { return samples_.status().matched_readers; }

  /// The next block, with the trial's command before its first and its outcome behind its last one.
  void send_block();
  [[nodiscard]] bool is_done() const { return attempt_ == trials_; }

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const Id& session() const { return session_; }
  [[nodiscard]] std::uint64_t refused() const { return refused_; }
  [[nodiscard]] std::uint64_t blocks() const { return sent_.size(); }
  /// When the block with this row was handed to the bus.
  [[nodiscard]] const Time* sent(std::uint64_t row) const;
  [[nodiscard]] Time outcome_sent(std::uint32_t attempt) const { return outcomes_sent_.at(attempt - 1); }
  [[nodiscard]] std::uint32_t reported() const { return static_cast<std::uint32_t>(outcomes_sent_.size()); }

 private:
  template <typename T>
  void send(bus::TypedWriter<T>& writer, const T& message) {
    if (!writer.write(message)) ++refused_;
  }

  std::string name_;
  Id session_{};
  std::uint32_t trials_;
  bus::TypedWriter<v1::RigDescription> description_;
  bus::TypedWriter<v1::SessionPlan> plans_;
  bus::TypedWriter<v1::TrialCommand> commands_;
  bus::TypedWriter<v1::SampleBlock> samples_;
  bus::TypedWriter<v1::TrialOutcome> outcomes_;
  bus::TypedReader<v1::ArchiveResend> resends_;
  runtime::HealthReporter health_;
  std::uint32_t attempt_ = 0;  ///< Trials that were measured.
  identification::MeasuredTrial trial_;
  std::vector<v1::SampleBlock> messages_;  ///< Of the trial under way.
  std::size_t next_ = 0;
  std::uint64_t next_sequence_ = 0;
  std::vector<Time> sent_;
  std::vector<Time> outcomes_sent_;
  std::uint64_t refused_ = 0;  ///< Messages that the bus did not take.
};

}  // namespace tonus::bench
