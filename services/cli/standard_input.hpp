#pragma once

#include <string>

#include "services/core/file_descriptor.hpp"
#include "services/core/result.hpp"

namespace tonus::cli {

/// Standard input in place of a file. A file that is named "-" becomes a file without a name, which has what
/// standard input holds and lives as long as this object; any other name is left as it is.
class StandardInput {
 public:
  /// `what` is expected, "a protocol". kInvalidArgument: standard input is empty, or has more than 1 MB.
  [[nodiscard]] static Result<StandardInput> take(std::string& file, const std::string& what);

  /// The error with "standard input" where the file without a name stands.
  [[nodiscard]] Error told(Error error) const;

 private:
  explicit StandardInput(FileDescriptor file) : file_(std::move(file)) {}
  [[nodiscard]] std::string path() const { return "/proc/self/fd/" + std::to_string(file_.get()); }

  FileDescriptor file_;
};

}  // namespace tonus::cli
