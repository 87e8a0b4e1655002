#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "services/core/result.hpp"

/// What pages have made of the archive: exports and reports, by the command line's own program, one after the
/// other and in the background. A job that has ended stays in the list until the gateway ends.
namespace tonus::dashboard {

struct JobFolders {
  std::filesystem::path tonus;    ///< The program.
  std::string store;              ///< As `tonus --archive`.
  std::filesystem::path exports;  ///< Made where it is missing.
  std::filesystem::path reports;
};

enum class JobState : std::uint8_t { kWaiting, kRunning, kDone, kFailed };

struct Job {
  std::uint64_t number = 0;
  std::string what;     ///< "export", "report"
  std::string subject;  ///< Session and format, or the report's name.
  JobState state = JobState::kWaiting;
  std::uint64_t done = 0;  ///< Of `total`; 0 of 0: not known.
  std::uint64_t total = 0;
  std::string message;  ///< The program's last line.
  std::string path;     ///< What was made: "/exports/NAME", "/reports/NAME/index.html".
};

/// How far a program is, of a line such as "trials: 3 of 40"; nothing of any other line.
[[nodiscard]] std::optional<std::pair<std::uint64_t, std::uint64_t>> progress_in(std::string_view line);

/// All methods from any thread.
class Jobs {
 public:
  explicit Jobs(JobFolders folders);
  /// Ends the job that is under way; what it has written so far is removed.
  ~Jobs();

  /// `session` is its whole id in hexadecimal; `format`: bids and csv become a tar file, hdf5 and xdf are one
  /// file. An older export of the same name is replaced. kInvalidArgument: another format or id;
  /// kUnavailable: too many jobs wait.
  [[nodiscard]] Result<std::uint64_t> order_export(const std::string& session, const std::string& format);

  /// `name` becomes a folder of the reports (fault_of_name()); `cohort` is the text of the subjects' file
  /// that `tonus report --cohort` takes. kAlreadyExists: there is such a report.
  [[nodiscard]] Result<std::uint64_t> order_report(const std::string& name, const std::string& cohort);

  /// The oldest first.
  [[nodiscard]] std::vector<Job> list() const;
  [[nodiscard]] std::string list_json() const;

 private:
  struct Order {
    std::uint64_t number = 0;
    std::vector<std::string> words;  ///< The program and its arguments; writes to `made`.
    std::filesystem::path made;
    std::filesystem::path kept;  ///< Where it is moved to, or packed.
    bool is_packed = false;      ///< `made` is a folder that becomes a tar file.
    std::filesystem::path scratch;
  };

  [[nodiscard]] Result<std::uint64_t> add(Job job, Order order);
  void run();
  [[nodiscard]] Result<void> carry_out(const Order& order);
  [[nodiscard]] Result<void> execute(const Order& order, const std::vector<std::string>& words);
  void note(std::uint64_t number, const std::string& line);
  void finish(std::uint64_t number, const Result<void>& outcome);

  JobFolders folders_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Job> jobs_;
  std::deque<Order> waiting_;
  std::atomic<bool> is_ending_{false};
  std::thread thread_;
};

}  // namespace tonus::dashboard
