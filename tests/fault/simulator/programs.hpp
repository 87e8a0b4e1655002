#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "services/core/result.hpp"
#include "services/store/store.hpp"
#include "tests/fault/simulator/life.hpp"
#include "tests/fault/simulator/network.hpp"
#include "tests/fault/simulator/random.hpp"

namespace tonus::control {
struct LoopState;
}

namespace tonus::simulator {

/// A service of the system as its main() wires it, with its tasks in the life in place of threads.
class Program {
 public:
  virtual ~Program() = default;
  /// An orderly end. What is destroyed without it has died.
  virtual void finish() {}
  /// Of the rig's program.
  [[nodiscard]] virtual const control::LoopState* loop() const { return nullptr; }
  [[nodiscard]] virtual bool is_held() const { return false; }
};

/// What programs share that outlives them.
struct Surroundings {
  Network& network;
  Random& random;
  store::Store& store;
  std::filesystem::path data;  ///< Short and relative: it is in texts that are published.
};

inline constexpr const char* kRig = "rig-agent";
inline constexpr const char* kScheduler = "scheduler";
inline constexpr const char* kIdentification = "identification";
inline constexpr const char* kArchive = "archive";

/// Starts one of the four. The error is what it would have printed at its end.
[[nodiscard]] Result<std::unique_ptr<Program>> start_program(const std::shared_ptr<Life>& life,
                                                             const Surroundings& around);

/// Writes the profile of the simulated rig, once.
void write_profile(const Surroundings& around);

}  // namespace tonus::simulator
