#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "services/core/result.hpp"
#include "tests/fuzz/damage.hpp"

namespace tonus::fuzz {

/// Something that reads what others wrote. A crash is found by the process's end, and best by the sanitizers.
class Target {
 public:
  virtual ~Target() = default;
  [[nodiscard]] virtual std::string name() const = 0;

  /// Makes one damaged input and has it read. True where it was refused. The error is a broken promise: a
  /// message that is empty or longer than a line, or a reader that takes what another one refuses.
  [[nodiscard]] virtual Result<bool> run(Damage& damage) = 0;
};

/// Every kept topic's messages, into the archive's core; blocks of samples beside their full decoding.
[[nodiscard]] std::unique_ptr<Target> make_message_target();

/// An archive's file: opened, read whole, taken up by an archive that goes on with it.
[[nodiscard]] std::unique_ptr<Target> make_store_target(const std::filesystem::path& folder);

/// A BIDS dataset with one of its files damaged.
[[nodiscard]] std::unique_ptr<Target> make_dataset_target(const std::filesystem::path& folder);

/// `tonus recover` and `tonus import` as programs, where this `tonus` has them: they may refuse, with a
/// message, and not die of a signal. Null where it has neither.
[[nodiscard]] std::unique_ptr<Target> make_program_target(const std::filesystem::path& folder,
                                                          const std::filesystem::path& tonus);

/// An archive's file with two trials, and a dataset of two recordings, undamaged.
[[nodiscard]] Result<void> make_store(const std::string& path);
[[nodiscard]] Result<void> make_dataset(const std::filesystem::path& root);

/// kInternal unless the message is one line that is not empty.
[[nodiscard]] Result<void> check_message(const std::string& message);

}  // namespace tonus::fuzz
