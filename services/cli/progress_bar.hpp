#pragma once

#include <cstdint>
#include <string>

namespace tonus::cli {

/// One line on standard error that is drawn over and over: share done, counts, and a remark. Not drawn where
/// standard error is no terminal; there, a line for every tenth of the work. Not shown at all where the log
/// has warnings or errors only (--quiet).
class ProgressBar {
 public:
  explicit ProgressBar(std::string title);
  ~ProgressBar();

  void show(std::uint64_t done, std::uint64_t total, const std::string& remark);

  /// Clears the line, so that something else can be printed.
  void clear();
  /// Writes a line that stays, above the bar.
  void say(const std::string& line);

 private:
  std::string title_;
  bool is_terminal_;
  bool is_drawn_ = false;
  std::uint64_t last_tenth_ = 0;
};

}  // namespace tonus::cli
