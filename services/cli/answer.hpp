#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "services/core/file_descriptor.hpp"
#include "services/core/result.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace tonus::cli {

/// Adds --json, "for programs", to a command that says what it did.
void add_json_flag(CLI::App& command, bool& is_json);

/// Prints what a command did: `text` for a person, which ends with a line, or `json` with its "schema".
void print_answer(bool is_json, nlohmann::json json, const std::string& text);

/// Where the results of --json FILE go. With "-" they go to standard output, and everything else that is
/// printed from now on to standard error, so that a program gets JSON alone.
class ResultsFile {
 public:
  /// kIo: standard output cannot be kept.
  [[nodiscard]] static Result<ResultsFile> create(std::string file);

  /// Does nothing where no file was named. kIo: it cannot be written.
  [[nodiscard]] Result<void> write(const std::string& text) const;

 private:
  ResultsFile(std::string file, FileDescriptor output) : file_(std::move(file)), output_(std::move(output)) {}

  std::string file_;
  FileDescriptor output_;  ///< Standard output, where "-" is the file.
};

}  // namespace tonus::cli
