#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "rig_agent/control/rig_loop.hpp"
#include "services/core/id.hpp"
#include "services/store/store.hpp"
#include "tests/fault/simulator/life.hpp"

namespace tonus::simulator {

/// Sees all that is written to the network, and what the rig's loop does, and says which invariants were
/// broken. It knows the messages alone, not how the services work.
class Witness {
 public:
  explicit Witness(store::Store& store) : store_(store) {}

  void written(Time now, const std::string& program, const std::string& topic,
               std::span<const std::byte> payload);

  /// The rig may move after an operator's word, and no more after what takes it back.
  void grant() {
    taken_back_because_.clear();
    scheduler_ended_at_.reset();
  }
  void take_back(const std::string& because) {
    taken_back_because_ = because;
    scheduler_ended_at_.reset();
  }
  /// It takes the word back too; but the rig may begin what it was told before, until it misses the lease.
  void scheduler_ended(Time now);
  /// After each part of the loop's cycles.
  void saw_loop(Time now, const control::LoopState& loop, bool is_held);
  /// The rig's program ends, or begins.
  void rig_ended(bool was_held, bool died) { must_be_held_ = must_be_held_ || was_held || died; }
  void rig_began(Time now, bool is_held);

  /// The rig's disk takes nothing from now on, or does again: what is published meanwhile is kept nowhere.
  void rig_disk(bool is_full) { is_rig_disk_full_ = is_full; }
  /// The rig's program died in a write: what it wrote is torn.
  void rig_lost_a_write() { has_unkept_ = true; }

  /// When all is over. `has_completed`: the session has run all of its trials. Samples that were published
  /// after `since` may still be on their way.
  void check_end(const Id& session, bool has_completed, Time since);

  [[nodiscard]] std::string broken() const;
  [[nodiscard]] std::uint64_t hash() const { return hash_; }
  [[nodiscard]] unsigned counted() const { return counted_; }
  [[nodiscard]] bool has_seen_trial() const { return has_seen_trial_; }

 private:
  void add_to_hash(std::span<const std::byte> bytes);
  void note(Time now, const std::string& what);
  void saw_block(Time now, std::span<const std::byte> payload);
  void saw_receipt(Time now, std::span<const std::byte> payload);
  void saw_state(std::span<const std::byte> payload);
  void check_samples(Time since);
  void check_counts(const Id& session, bool has_completed);
  void check_verification(const Id& session);
  [[nodiscard]] bool was_told_before_the_schedulers_end(Time now) const;
  [[nodiscard]] bool holds(const store::StreamKey& stream, store::SequenceRange range);

  store::Store& store_;
  std::uint64_t hash_ = 0xcbf29ce484222325ULL;
  std::vector<std::string> broken_;
  std::string taken_back_because_ = "nobody has started a session";
  std::optional<Time> scheduler_ended_at_;  ///< Since the last word, and nothing else has taken it back.
  Time commanded_at_{};                     ///< The last trial.
  std::uint64_t trial_ = 0;
  bool has_seen_trial_ = false;
  bool must_be_held_ = false;
  unsigned counted_ = 0;
  struct Published {
    Time at;
    std::uint64_t hash = 0;
    bool is_kept = false;  ///< In the spool.
  };
  /// Each sample that the rig has published, by epoch and number.
  std::map<std::uint64_t, std::map<std::uint64_t, Published>> samples_;
  bool is_rig_disk_full_ = false;
  bool has_unkept_ = false;
  Id rig_{};
  std::set<Id> ended_;  ///< Sessions.
};

}  // namespace tonus::simulator
