#pragma once

#include <memory>
#include <string_view>

namespace tonus::bus {

/// What the in-memory buses of one process share, in place of a network: topics by domain and name, and the
/// clock that watches deadlines and leases. Thread-safe. Buses, writers and readers keep it alive.
class MemoryFabric {
 public:
  MemoryFabric();
  ~MemoryFabric();
  MemoryFabric(const MemoryFabric&) = delete;
  MemoryFabric& operator=(const MemoryFabric&) = delete;

  /// Sudden death of every participant of this name, as kill -9 would: no goodbye, no more liveliness,
  /// readers that never take again, and a place that is kept until the participant's lease is over. Its
  /// objects stay valid; what they write goes nowhere.
  void kill(std::string_view participant_name);

  class State;  ///< Inside memory/ only.
  [[nodiscard]] State& state() { return *state_; }

 private:
  std::unique_ptr<State> state_;
};

}  // namespace tonus::bus
