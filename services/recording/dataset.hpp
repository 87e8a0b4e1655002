#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "services/recording/recording.hpp"

/// BIDS Motion datasets (BIDS 1.9), the interchange format of recordings.
namespace tonus::recording {

class InheritedFiles;

/// A dataset whose runs are read one by one, so that no more of them than are used are in memory. Runs are
/// sorted by participant, session, task, acquisition and run.
///
/// Channels are known by name: q1 q2 f1 f2 (raw, counts and V; with "Rig" in `_channels.json`), x y fx fy (m
/// and N in S), or one JNTANG or POS channel and one MISC channel in N or N m (one-axis rigs); raw wins where
/// both are complete. A record without `_events.tsv` is one continuous perturbation over its whole length,
/// with the next free trial number of its session. Rows of another `trial_type` than `perturbation` are not
/// ours and are left out. What a run's files do not say is inherited from those of the folders above, as BIDS
/// has it. Trials without a number have the next free ones of their session. Auxiliary channels lie in files
/// of their own (auxiliary_files.hpp), which are no runs.
///
/// Every error is one line that names the file, the line and column where there is one, the value, and what
/// is allowed. kNotFound: a file that must be there is not. kInvalidArgument: its content is not allowed.
class Dataset {
 public:
  /// Reads everything but the samples. Where imperfect items are left out, the dataset is refused only if no
  /// run remains, by the reason of the first one; and trials of different runs may have the same number.
  [[nodiscard]] static Result<Dataset> open(const std::filesystem::path& root,
                                            Imperfect imperfect = Imperfect::kRefused);
  Dataset(Dataset&&) noexcept;
  Dataset& operator=(Dataset&&) noexcept;
  ~Dataset();

  [[nodiscard]] std::size_t runs() const;

  /// What was left out, an item a line, with the reason.
  [[nodiscard]] const std::vector<std::string>& left_out() const { return left_out_; }

  /// Run `index`, complete. Several threads may read at once.
  [[nodiscard]] Result<Recording> read(std::size_t index) const;

 private:
  struct Run;
  Dataset(std::vector<Run> runs, std::vector<std::string> left_out, Imperfect imperfect);
  [[nodiscard]] static Result<Run> open_run(const std::filesystem::path& motion_file,
                                            InheritedFiles& inherited);
  [[nodiscard]] static Result<void> take_participants(const std::filesystem::path& file,
                                                      std::vector<Run>& runs,
                                                      std::vector<std::string>* left_out);
  [[nodiscard]] static Result<void> take_sessions(const std::filesystem::path& root, std::vector<Run>& runs,
                                                  std::vector<std::string>* left_out);
  [[nodiscard]] static Result<void> number_trials(std::vector<Run>& runs, Imperfect imperfect);

  std::vector<Run> runs_;
  std::vector<std::string> left_out_;
  Imperfect imperfect_ = Imperfect::kRefused;
};

/// Every run of the dataset at `root`, read on all processors. The dataset is refused for one imperfect item.
[[nodiscard]] Result<std::vector<Recording>> read_dataset(const std::filesystem::path& root);

/// What can be used of a dataset, and what cannot, an item a line with the reason.
struct UsableRecordings {
  std::vector<Recording> recordings;  ///< At least one.
  std::vector<std::string> left_out;
};

/// Every run that can be read, on all processors; what off-line identification, import and replay take. An
/// error, by the first run's reason, only where none can.
[[nodiscard]] Result<UsableRecordings> read_usable(const std::filesystem::path& root);

/// state_force_sign() of every recording; those that refuse it are left out. An error where all do.
[[nodiscard]] Result<void> state_force_sign(UsableRecordings& usable, int sign);

/// For a replay, which plays what there is: events that do not count are left out, and so are recordings
/// without any other; a continuous record is cut to its events, what lies between them being missing.
[[nodiscard]] Result<void> keep_what_counts(UsableRecordings& usable);

struct WriteOptions {
  std::string name = "Arm impedance measurement";
  std::string license;               ///< Left out where empty.
  std::vector<std::string> authors;  ///< Left out where empty.
  std::string software_version;      ///< Of the program that writes; left out where empty.
  /// Further files: path below the dataset's root, and content. For folders that BIDS tools leave alone
  /// (sourcedata/, code/).
  std::vector<std::pair<std::string, std::string>> further_files;
  bool with_converted = true;  ///< Beside raw two-axis channels also x, y, fx, fy, for other programs.
};

/// Writes a dataset that read_dataset() reads back with identical numbers, and that bids-validator accepts.
/// It is made under a temporary name beside `root` and renamed when it is complete and on the disk: a failure
/// leaves nothing. Converted channels with scales or offsets of their own are written as convert() gives
/// them.
///
/// kAlreadyExists: `root` already exists. kInvalidArgument: two recordings share their labels, a label is
/// empty or has other than letters and digits, or rows and commanded displacements differ in number. kIo: the
/// disk.
[[nodiscard]] Result<void> write_dataset(const std::filesystem::path& root,
                                         const std::vector<Recording>& recordings,
                                         const WriteOptions& options = {});

}  // namespace tonus::recording
